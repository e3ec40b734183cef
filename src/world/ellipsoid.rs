//! Ellipsoids: the images of spheres under transforms that are not similarities. They are the only primitive
//! that keeps a matrix while rays are traced.

use super::shape::{Form, UnitSphereMaps};
use super::sphere::first_on_ray;
use crate::math::double_double::{Dd, dot, minus};
use crate::math::robust::{UNIT_ROUNDOFF, unit};
use crate::math::{aabb::Aabb, ray::Ray};
use glam::{DMat3, DVec3};

/// The image of the unit sphere under `p -> center + linear * p`. The columns of `linear` are the semi-axes,
/// which are orthogonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    center: DVec3,
    linear: DMat3,
    inverse: DMat3,
    /// The largest coordinate of the centre plus the longest semi-axis.
    extent: f64,
}

/// The error bound of a point of an ellipsoid, in roundings of its centre and its semi-axes.
const POINT_ROUNDINGS: f64 = 64.0;

/// The crossings of a line with the ellipsoid, in order: the t, and the points in the space of the unit sphere.
struct Crossings {
    t: [f64; 2],
    points: [DVec3; 2],
}

impl Ellipsoid {
    /// Returns the image of the unit sphere under `linear`, moved to `center`. `linear` must not be singular.
    pub fn new(center: DVec3, linear: DMat3) -> Self {
        let linear = half_axes(linear);
        let row = |axis: DVec3| axis / axis.length() / axis.length();
        let rows = DMat3::from_cols(row(linear.x_axis), row(linear.y_axis), row(linear.z_axis));
        let longest = linear.x_axis.length().max(linear.y_axis.length()).max(linear.z_axis.length());
        let extent = center.abs().max_element() + longest;
        Self { center, linear, inverse: rows.transpose(), extent }
    }

    /// Returns the lengths of the semi-axes.
    pub fn half_lengths(&self) -> [f64; 3] {
        let DMat3 { x_axis, y_axis, z_axis } = self.linear;
        [x_axis, y_axis, z_axis].map(DVec3::length)
    }

    /// Returns both crossings of the ray's line.
    ///
    /// They are computed from the line's moment `o x d`, in which each component has its own cancellation and no
    /// component is computed from a sum over all axes. So however flat the ellipsoid is, and however long the ray is
    /// along one axis in the space of the unit sphere, the other two axes keep their accuracy.
    fn crossings(&self, ray: &Ray) -> Option<Crossings> {
        let (o, d) = (self.inverse * (ray.origin - self.center), self.inverse * ray.direction);
        let (a, b, moment) = (d.length_squared(), -o.dot(d), o.cross(d));
        let discriminant = a - moment.length_squared();
        // False also for a NaN, and for a direction whose squared length is zero or overflows.
        let crosses = discriminant >= 0.0 && a > 0.0 && a < f64::INFINITY;
        if !crosses {
            return None;
        }
        let root = discriminant.sqrt();
        let q = b + f64::copysign(root, b);
        let c = o.length_squared() - 1.0;
        let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (c / q, q / a) };
        let (middle, half) = (d.cross(moment) / a, (root / a) * d);
        let t = if t0 < t1 { [t0, t1] } else { [t1, t0] };
        Some(Crossings { t, points: [unit(middle - half), unit(middle + half)] })
    }
}

impl Form for Ellipsoid {
    /// Along each axis the half extent is the length of the matrix's row.
    fn bounds(&self) -> Aabb {
        let rows = self.linear.transpose();
        let half_extents = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        Aabb { min: self.center - half_extents, max: self.center + half_extents }
    }

    /// The direction is not renormalised in the space of the unit sphere, so t is the same as in world space.
    fn intersect(&self, ray: &Ray) -> Option<f64> {
        first_on_ray(self.crossings(ray)?.t, ray)
    }

    fn surface(&self, ray: &Ray, t: f64) -> (DVec3, DVec3) {
        // `t` exactly equals the t of one of the crossings. If both have the same t, the first was found.
        let on_sphere = match self.crossings(ray) {
            Some(Crossings { t: [near, far], points }) => points[usize::from(t != near && t == far)],
            None => unit(self.inverse * (ray.at(t) - self.center)),
        };
        let normal = unit(self.inverse.transpose() * on_sphere);
        (normal, self.center + self.linear * on_sphere)
    }

    fn extent(&self) -> f64 {
        self.extent
    }

    /// Most of the bound is for the rotations that make the semi-axes orthogonal, of which there are fewer than a
    /// dozen.
    fn point_roundings(&self) -> DVec3 {
        POINT_ROUNDINGS * (self.center.abs() + self.half_lengths().into_iter().sum::<f64>())
    }

    fn roots(&self, ray: &Ray) -> Option<[f64; 2]> {
        self.crossings(ray).map(|crossings| crossings.t)
    }

    fn height_and_slope(&self, point: [Dd; 3], direction: [Dd; 3]) -> [Dd; 2] {
        let rows = self.inverse.transpose();
        let rows = [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| row.to_array().map(Dd::from));
        let from_center = minus(point, self.center);
        let on_sphere = rows.map(|row| dot(row, from_center));
        let slope = dot(on_sphere, rows.map(|row| dot(row, direction)));
        [dot(on_sphere, on_sphere) - Dd::from(1.0), slope + slope]
    }

    fn unit_sphere_maps(&self) -> UnitSphereMaps {
        UnitSphereMaps { center: self.center, linear: self.linear, inverse: self.inverse }
    }
}

/// Returns the semi-axes of the image of the unit sphere: the matrix times rotations of the unit sphere that make its
/// columns orthogonal (one-sided Jacobi: Hestenes, "Inversion of Matrices by Biorthogonalization and Related Results",
/// J. SIAM 6(1), 1958). This keeps each axis accurate, however short it is. An inverse of the original matrix would
/// lose the short axes.
fn half_axes(linear: DMat3) -> DMat3 {
    // Three or four sweeps are enough, except for numbers close to overflow or underflow.
    const MAX_SWEEPS: usize = 30;
    let mut axes = [linear.x_axis, linear.y_axis, linear.z_axis];
    for _ in 0..MAX_SWEEPS {
        let rotated = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| {
            let rotated = orthogonalized(axes[i], axes[j]);
            rotated.inspect(|&(p, q)| (axes[i], axes[j]) = (p, q)).is_some()
        });
        if rotated == [false; 3] {
            break;
        }
    }
    DMat3::from_cols(axes[0], axes[1], axes[2])
}

/// Two columns count as orthogonal if their product is at most this many roundings of their lengths.
const ORTHOGONAL_ROUNDINGS: f64 = 4.0;

/// Returns two columns after the Jacobi rotation that makes them orthogonal; `None` if they already are.
fn orthogonalized(p: DVec3, q: DVec3) -> Option<(DVec3, DVec3)> {
    let product = p.dot(q);
    if product.abs() <= ORTHOGONAL_ROUNDINGS * UNIT_ROUNDOFF * (p.length() * q.length()) {
        return None;
    }
    let slope = (q.length_squared() - p.length_squared()) / (2.0 * product);
    let tangent = f64::copysign(1.0, slope) / (slope.abs() + (1.0 + slope * slope).sqrt());
    let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
    Some((cosine * (p - tangent * q), cosine * (q + tangent * p)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn squashed() -> Ellipsoid {
        Ellipsoid::new(DVec3::new(1.0, 2.0, 3.0), DMat3::from_diagonal(DVec3::new(2.0, 0.5, 1.0)))
    }

    #[test]
    fn a_disc_is_hit_on_the_side_it_is_seen_from() {
        for thickness in [1e-3, 1e-9, 1e-16, 1e-30, 1e-100] {
            let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0);
            let flat = DMat3::from_diagonal(DVec3::new(1.0, 1.0, thickness));
            let disc = Ellipsoid::new(DVec3::ZERO, turn * flat);
            for side in [1.0, -1.0] {
                let face = side * turn.z_axis;
                let from = 3.0 * (face + 0.1 * turn.x_axis);
                let ray = Ray::new(from, 0.4 * turn.x_axis - from);
                let t = disc.intersect(&ray).unwrap();
                let (normal, point) = disc.surface(&ray, t);
                assert!((t - 1.0).abs() <= thickness + 1e-15, "{thickness}: {t}");
                assert!((normal - face).length() <= thickness + 1e-15, "{thickness}: {normal}");
                assert!((point - 0.4 * turn.x_axis).length() <= 2.0 * thickness + 1e-15);
            }
        }
    }

    #[test]
    fn half_axes_are_orthogonal_and_span_the_same_ellipsoid() {
        let m = DMat3::from_cols(DVec3::X, DVec3::new(1e3, 1.0, 0.0), DVec3::new(0.0, 2.0, 1.0));
        let axes = half_axes(m);
        for (p, q) in [(axes.x_axis, axes.y_axis), (axes.y_axis, axes.z_axis), (axes.z_axis, axes.x_axis)] {
            assert!(p.dot(q).abs() <= 1e-15 * p.length() * q.length());
        }
        // Turning the unit sphere changes no product of the matrix with its transpose.
        let (before, after) = (m * m.transpose(), axes * axes.transpose());
        assert!(before.abs_diff_eq(after, 1e-14 * 1e6));
    }

    #[test]
    fn a_ray_beside_the_middle_meets_the_slope_of_the_side() {
        let e = squashed();
        // A quarter of the way to the end of the longest axis.
        let (x, y) = (0.25, (1.0 - 0.25f64 * 0.25).sqrt());
        for speed in [1.0, 4.0] {
            let ray = Ray::new(DVec3::new(1.5, 12.0, 3.0), DVec3::NEG_Y * speed);
            let t = e.intersect(&ray).unwrap();
            assert!((t * speed - (10.0 - 0.5 * y)).abs() < 1e-14);
            let (normal, point) = e.surface(&ray, t);
            assert!((normal - DVec3::new(x / 2.0, y / 0.5, 0.0).normalize()).length() < 1e-15);
            assert!((point - DVec3::new(1.5, 2.0 + 0.5 * y, 3.0)).length() < 1e-15);
        }
    }

    #[test]
    fn rays_of_zero_or_excessive_length_miss() {
        let e = squashed();
        for (origin, direction) in [
            (DVec3::new(1.0, 12.0, 3.0), DVec3::ZERO),
            (DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO),
            (DVec3::new(1.0, 2.0, 3.0), DVec3::X * 1e200),
            (DVec3::new(1.0, 12.0, 3.0), DVec3::X),
        ] {
            assert_eq!(e.intersect(&Ray::new(origin, direction)), None, "{direction}");
            assert!(e.crossings(&Ray::new(origin, direction)).is_none(), "{direction}");
        }
    }

    #[test]
    fn a_line_that_misses_by_rounding_gets_the_surface_nearby() {
        let ray = Ray::new(DVec3::new(1.0, 12.0, 4.0 + 1e-12), DVec3::NEG_Y);
        let (normal, point) = squashed().surface(&ray, 10.0);
        assert!((normal - DVec3::Z).length() < 1e-11 && (point - DVec3::new(1.0, 2.0, 4.0)).length() < 1e-11);
    }

    #[test]
    fn a_ray_from_close_to_the_surface_meets_the_far_side_exactly() {
        let e = squashed();
        for depth in [1e-3, 1e-6, 1e-9] {
            let from = DVec3::new(1.0 + 2.0 * (1.0 - depth), 2.0, 3.0);
            let t = e.intersect(&Ray::new(from, DVec3::NEG_X)).unwrap();
            assert!((t - (from.x + 1.0)).abs() < 1e-15 * t, "{depth}: {t}");
        }
    }

    #[test]
    fn half_axes_are_found_at_every_scale_and_between_equal_lengths() {
        for scale in [1e-100, 1e-8, 1.0, 1e8, 1e100] {
            let (p, q) = (DVec3::new(scale, 0.0, 0.0), DVec3::new(0.6 * scale, 0.8 * scale, 0.0));
            let axes = half_axes(DMat3::from_cols(p, q, DVec3::Z * scale));
            let cosine = axes.x_axis.normalize().dot(axes.y_axis.normalize());
            assert!(cosine.abs() < 1e-15, "{scale}: {cosine}");
            // The lengths are the roots of 1 + 0.6 and 1 - 0.6.
            let lengths = [axes.x_axis, axes.y_axis].map(|axis| axis.length() / scale);
            let (short, long) = (lengths[0].min(lengths[1]), lengths[0].max(lengths[1]));
            assert!((short - 0.4f64.sqrt()).abs() < 1e-15 && (long - 1.6f64.sqrt()).abs() < 1e-15);
        }
    }

    #[test]
    fn half_lengths_are_those_of_the_semi_axes() {
        let turn = DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 1.0);
        let ellipsoid = Ellipsoid::new(DVec3::ONE, turn * DMat3::from_diagonal(DVec3::new(2.0, 0.5, 7.0)));
        let mut half_lengths = ellipsoid.half_lengths();
        half_lengths.sort_by(f64::total_cmp);
        assert!(half_lengths.iter().zip([0.5, 2.0, 7.0]).all(|(x, y)| (x / y - 1.0).abs() < 1e-14));
    }
}
