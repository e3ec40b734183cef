//! The camera: generates the primary ray of each sample.

use crate::math::ray::Ray;
use crate::math::robust::{rescaled, unit};
use crate::math::simd::Number;
use crate::math::vector::Vector;
use crate::scene;
use crate::scene::model::Screen;
use fearless_simd::{Simd, SimdFrom, f64x4};
use glam::{DVec2, DVec3};

/// A camera for a picture of a given size.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    center: DVec3,
    direction: DVec3,
    /// The vector to the right across the whole screen.
    horizontal: DVec3,
    /// The vector up across the whole screen.
    vertical: DVec3,
    is_perspective: bool,
    /// The picture's width and height in pixels.
    size: DVec2,
    /// The number of pixels along each axis that the whole screen spans.
    span: DVec2,
    /// True if the up vector is not at right angles to the direction.
    is_skew: bool,
}

/// The rays through the pixels' centres, as functions of the pixel. The offset of the pixel in column i of row j is
/// `(i - middle.x) right + (j - middle.y) up`.
#[derive(Clone, Copy, Debug)]
pub enum Projection {
    /// All rays start at the eye. Their directions are the eye's direction plus the offset, normalised.
    Perspective(Eye),
    /// All rays have the same direction. Their origins are the eye's center plus the offset.
    Orthographic(Eye),
}

/// The ray at right angles to the picture, and the steps from it to the other rays.
#[derive(Clone, Copy, Debug)]
pub struct Eye {
    /// The origin of the ray.
    pub center: DVec3,
    /// Its direction, a unit vector.
    pub direction: DVec3,
    /// The step from one pixel's centre to the next in the row.
    pub right: DVec3,
    /// The step from one row of pixel centres to the next.
    pub up: DVec3,
    /// The point where the ray meets the picture, in pixels from the centre of the lower left pixel. It is the
    /// picture's middle unless the eye is turned.
    pub middle: DVec2,
    /// True if the camera's up vector is not at right angles to its direction, so that the direction of the eye
    /// differs from the camera's. The eye's vectors are then off by a few more roundings: less than [`TURN_ROUNDINGS`]
    /// of the longest ray's direction.
    pub is_turned: bool,
}

impl Projection {
    /// Returns the place at which a point is seen, in pixels from the picture's lower left corner; NaN if the point is not
    /// ahead of the eye.
    #[inline]
    pub fn place(&self, point: DVec3) -> DVec2 {
        let (Self::Perspective(eye) | Self::Orthographic(eye)) = self;
        let from_eye = point - eye.center;
        let along = |axis: DVec3| from_eye.dot(axis / axis.length_squared());
        let across = DVec2::new(along(eye.right), along(eye.up));
        let across = match self {
            Self::Orthographic(_) => across,
            Self::Perspective(_) => match from_eye.dot(eye.direction) {
                depth if depth > 0.0 => across / depth,
                _ => DVec2::NAN,
            },
        };
        across + eye.middle + 0.5
    }
}

/// The error of a ray's direction from a turned eye, in units of u times the sum of the lengths of the eye's direction
/// and of the offsets along both axes: 10 of the cosine, 7 of the direction, 8 of the point where the eye's ray meets
/// the picture, and 4 of the offsets.
pub const TURN_ROUNDINGS: f64 = 29.0;

impl Eye {
    /// Returns an eye with the same rays, up to their lengths, whose vectors are at right angles. The steps must be at
    /// right angles to each other, and `right` to the direction.
    fn turned(self) -> Self {
        let Self { direction, right, up, middle, .. } = self;
        let ahead = unit(up.cross(right));
        let distance = ahead.dot(direction);
        let foot = -direction.dot(up) / up.length_squared();
        Self {
            direction: ahead,
            right: right / distance,
            up: up / distance,
            middle: DVec2::new(middle.x, middle.y + foot),
            is_turned: true,
            ..self
        }
    }
}

impl Camera {
    /// Returns the camera's rays as a function of the pixel.
    pub fn projection(&self) -> Projection {
        let Self { center, direction, .. } = *self;
        let (right, up) = (self.horizontal / self.span.x, self.vertical / self.span.y);
        let middle = 0.5 * self.size - 0.5;
        let eye = Eye { center, direction, right, up, middle, is_turned: false };
        match self.is_perspective {
            true => Projection::Perspective(if self.is_skew { eye.turned() } else { eye }),
            false => Projection::Orthographic(eye),
        }
    }

    /// Returns the camera for a picture with this width and height in pixels. The longer side spans the square screen.
    /// The shorter side crops the screen around its middle.
    pub fn new(camera: &scene::Camera, size: [usize; 2]) -> Self {
        Self::with_screen(camera, size, Screen::LongerSide)
    }

    /// Returns the camera like [`Camera::new`], but a perspective camera spreads its screen over the pixels as
    /// `spread` says.
    pub fn with_screen(camera: &scene::Camera, size: [usize; 2], spread: Screen) -> Self {
        let (center, direction, up, screen, is_perspective) = match *camera {
            scene::Camera::Orthographic { center, direction, up, size } => {
                (center, direction, up, size, false)
            }
            scene::Camera::Perspective { center, direction, up, angle } => {
                (center, direction, up, 2.0 * libm::tan(angle.to_radians() / 2.0), true)
            }
        };
        let direction = unit(direction);
        let right = unit(direction.cross(rescaled(up)));
        let size = DVec2::new(size[0] as f64, size[1] as f64);
        let upright = right.cross(direction);
        let (span, vertical) = match spread {
            Screen::BothSides { up_as_written } if is_perspective => {
                // The only pixel of a row or column is in its middle.
                ((size - 1.0).max(DVec2::ONE), if up_as_written { up } else { upright })
            }
            _ => (DVec2::splat(size.max_element()), upright),
        };
        let is_skew = vertical != upright && vertical.dot(direction) != 0.0;
        let (horizontal, vertical) = (screen * right, screen * vertical);
        Self { center, direction, horizontal, vertical, is_perspective, size, span, is_skew }
    }

    /// Returns the ray through the point at `offset` from the centre of a pixel. The pixel's integer coordinates start
    /// with 0 at the lower left of the picture. The ray's direction is a unit vector.
    #[inline(always)]
    pub fn ray(&self, pixel: DVec2, offset: DVec2) -> Ray {
        let [origin, direction] = self.origin_and_direction(pixel.to_array(), offset.to_array());
        Ray { t_min: self.t_min(), ..Ray::new(origin.into(), direction.into()) }
    }

    /// Returns the rays of four samples in these columns of a row, at these offsets from the pixels' centres.
    #[inline(always)]
    pub(crate) fn rays<S: Simd>(
        &self,
        simd: S,
        columns: [usize; 4],
        row: usize,
        offsets: [DVec2; 4],
    ) -> [Ray; 4] {
        // Each lane is named, since an array's `map` is not always inlined.
        let ([i, j, k, l], [o, p, q, r]) = (columns, offsets);
        let columns = f64x4::simd_from(simd, [i as f64, j as f64, k as f64, l as f64]);
        let pixels = [columns, f64x4::splat(simd, row as f64)];
        let offsets =
            [f64x4::simd_from(simd, [o.x, p.x, q.x, r.x]), f64x4::simd_from(simd, [o.y, p.y, q.y, r.y])];
        let [origins, directions] = self.origin_and_direction(pixels, offsets);
        let ([e, f, g, h], [a, b, c, d]) = (origins.to_array(), directions.to_array());
        let ray = |origin, direction| Ray { t_min: self.t_min(), ..Ray::new(origin, direction) };
        [ray(e, a), ray(f, b), ray(g, c), ray(h, d)]
    }

    /// Returns the least parameter of a hit. As in the course, an orthographic camera also sees objects behind its
    /// plane.
    #[inline(always)]
    fn t_min(&self) -> f64 {
        if self.is_perspective { 0.0 } else { f64::NEG_INFINITY }
    }

    /// Returns the origins and directions of rays through the points at these offsets from the centres of pixels.
    #[inline(always)]
    fn origin_and_direction<N: Number>(&self, [column, row]: [N; 2], offset: [N; 2]) -> [Vector<N>; 2] {
        let splat = |v: DVec3| Vector::splat(column.proof(), v);
        let (half, middle) = (column.broadcast(0.5), 0.5 * self.size);
        let span = self.span;
        // The distance between a centre and the picture's middle is exact, so the rays of mirrored samples are exact
        // mirror images.
        let on_screen = |pixel: N, offset: N, middle: f64, span: f64| {
            (pixel + half - pixel.broadcast(middle) + offset) / pixel.broadcast(span)
        };
        let (x, y) =
            (on_screen(column, offset[0], middle.x, span.x), on_screen(row, offset[1], middle.y, span.y));
        let across = splat(self.horizontal) * x + splat(self.vertical) * y;
        if self.is_perspective {
            [splat(self.center), (splat(self.direction) + across).normalized()]
        } else {
            [splat(self.center) + across, splat(self.direction)]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a camera of each kind at the same point with the same direction.
    fn oblique() -> [scene::Camera; 2] {
        let (center, direction, up) =
            (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, 3.0, -4.0), DVec3::new(0.0, 1.0, 0.0));
        let orthographic = scene::Camera::Orthographic { center, direction, up, size: 6.0 };
        [orthographic, scene::Camera::Perspective { center, direction, up, angle: 90.0 }]
    }

    #[test]
    fn rays_through_known_points() {
        // The axes are +x to the right, and (0, 4, 3) / 5 up.
        let [orthographic, perspective] = oblique().map(|camera| Camera::new(&camera, [6, 3]));
        let (pixel, offset) = (DVec2::new(5.0, 0.0), DVec2::new(0.25, -0.25));
        let (right, up) = (DVec3::X, DVec3::new(0.0, 0.8, 0.6));
        // 2.75 pixels to the right of the middle and 1.25 below it, where 6 pixels span the screen.
        let (x, y) = (2.75 / 6.0, -1.25 / 6.0);
        let near = |a: DVec3, b: DVec3| (a - b).length() < 1e-15;
        let ray = orthographic.ray(pixel, offset);
        assert!((ray.origin - (DVec3::new(1.0, 2.0, 3.0) + 6.0 * (x * right + y * up))).length() < 1e-14);
        assert!(near(ray.direction, DVec3::new(0.0, 0.6, -0.8)));
        assert_eq!((ray.t_min, ray.t_max), (f64::NEG_INFINITY, f64::INFINITY));
        let ray = perspective.ray(pixel, offset);
        let expected = DVec3::new(0.0, 0.6, -0.8) + 2.0 * (x * right + y * up);
        assert!(near(ray.direction, expected.normalize()));
        assert_eq!((ray.origin, ray.t_min), (DVec3::new(1.0, 2.0, 3.0), 0.0));
    }

    /// The outermost pixels' centres are on the edges of the view, at 45 degrees to the middle.
    #[test]
    fn both_sides_span_the_screen_from_centre_to_centre() {
        let camera = scene::Camera::Perspective {
            center: DVec3::ZERO,
            direction: DVec3::NEG_Z,
            up: DVec3::new(0.0, 2.0, 1.0),
            angle: 90.0,
        };
        for (up_as_written, up) in [(false, DVec3::Y), (true, DVec3::new(0.0, 2.0, 1.0))] {
            let camera = Camera::with_screen(&camera, [5, 3], Screen::BothSides { up_as_written });
            let ray = camera.ray(DVec2::new(4.0, 0.0), DVec2::ZERO);
            assert!((ray.direction - (DVec3::NEG_Z + DVec3::X - up).normalize()).length() < 1e-15);
        }
    }
}
