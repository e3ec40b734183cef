//! The surface at a hit.

use super::{Primitive, World};
use crate::math::double_double::{Dd, SquaredSine, cross, difference};
use crate::math::ray::{Hit, Ray, Visible};
use crate::scene::MaterialId;
use crate::world::shape::{PlaceOnSurface, Shape};
use crate::world::triangle;
use glam::DVec3;
use serde::Serialize;

/// If the coordinates of a position are less than this part of the coordinates from which it is computed, it is
/// computed along the ray instead.
pub(crate) const LEAST_PART: f64 = 1.0 / (1 << 20) as f64;

/// The surface at a hit.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SurfacePoint {
    /// The point, which is on the surface to within a few rounding errors of its coordinates and the coordinates of the
    /// primitive.
    pub position: DVec3,
    /// The outward unit normal. It is not turned towards the ray.
    pub normal: DVec3,
    /// The largest absolute coordinate from which the position was computed. It bounds the error of the position:
    /// [`offset_origin`](crate::math::robust::offset_origin) counts in roundings of it.
    #[serde(skip)]
    pub extent: f64,
    /// The material of the surface.
    pub material: MaterialId,
    /// The id of the primitive; `None` if the point is on a surface that is not in a world.
    #[serde(skip)]
    pub primitive: Option<u32>,
    /// The id of the primitive if it is a triangle.
    #[serde(skip)]
    pub triangle: Option<u32>,
}

impl World {
    /// Returns the surface that a ray hits first. The t of a triangle is not computed, because the barycentric weights
    /// suffice for its surface.
    #[inline(always)]
    pub fn visible_surface(&self, ray: &Ray, Visible { primitive, t_bound: t }: Visible) -> SurfacePoint {
        let place = match self.primitive(primitive) {
            Primitive::Triangle(i) => {
                let corners = self.corners(i);
                // Interpolated from the vertices, because a position along the ray has a rounding error that grows with
                // the distance from the ray's origin. The match is no closure, which would not be compiled for the
                // caller's instructions.
                let position = match triangle::Shear::new(ray).weights(self.corners_in_place(i)) {
                    Some(weights) => triangle::point(corners, weights),
                    None => ray.at(t),
                };
                let (normal, extent) = (triangle::normal(corners), triangle::extent(corners));
                PlaceOnSurface { normal, position, extent }
            }
            Primitive::Shape(i) => self.shapes[i].surface(ray, t),
            Primitive::Plane(i) => {
                let plane = &self.planes[i];
                let (normal, position) = (plane.normal, plane.project(ray.at(t)));
                PlaceOnSurface { normal, position, extent: plane.offset.abs() }
            }
        };
        let triangle = self.is_triangle(primitive).then_some(primitive);
        let material = self.material_of(primitive);
        // Separate variables stay in registers. The result of a cold function lies in memory, and the processor stalls
        // on numbers that are stored one by one and loaded as a vector.
        let PlaceOnSurface { mut normal, mut position, mut extent } = place;
        if position.abs().max_element() < LEAST_PART * extent {
            PlaceOnSurface { normal, position, extent } = self.precise_surface(ray, t, primitive, place);
        }
        SurfacePoint { position, normal, extent, material, primitive: Some(primitive), triangle }
    }

    /// Returns the surface at a hit of `ray`.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.visible_surface(ray, Visible { primitive: hit.primitive, t_bound: hit.t })
    }

    /// Returns the sine of the angle between a ray, given by its origin and direction, and the normal of a primitive's
    /// surface that it meets. Its rounding error is smaller than with the unit normal. A triangle's normal is computed
    /// from its corners. A plane's normal is used before it is scaled to unit length. For a sphere, the sine is the
    /// distance of the ray's line from the centre over the radius.
    #[cold]
    pub(crate) fn precise_sine(
        &self,
        (origin, direction): (DVec3, DVec3),
        primitive: Option<u32>,
        unit_normal: DVec3,
    ) -> SquaredSine {
        let normal = match primitive.map(|primitive| self.primitive(primitive)) {
            Some(Primitive::Triangle(i)) => return SquaredSine::of(direction, self.precise_normal(i)),
            Some(Primitive::Plane(i)) => {
                self.placed_planes.get(i).map_or(unit_normal, |plane| plane.direction)
            }
            Some(Primitive::Shape(i)) => match &self.shapes[i] {
                Shape::Sphere(sphere) => return sphere.sine(origin, direction),
                _ => unit_normal,
            },
            None => unit_normal,
        };
        SquaredSine::of(direction, normal.to_array().map(Dd::from))
    }

    /// Returns a vector along a triangle's normal, of any length, with less rounding than the unit normal.
    pub(crate) fn precise_normal(&self, triangle: usize) -> [Dd; 3] {
        let [a, b, c] = self.corners(triangle);
        cross(rescaled(difference(b, a)), rescaled(difference(c, a)))
    }

    /// Returns a place on a surface with its position computed along the ray. Computed from the primitive, the position
    /// would lose digits to the coordinates of distant parts.
    #[cold]
    fn precise_surface(&self, ray: &Ray, t: f64, primitive: u32, place: PlaceOnSurface) -> PlaceOnSurface {
        let found = match self.primitive(primitive) {
            Primitive::Triangle(i) => {
                let point = triangle::Shear::new(ray).precise_point(self.corners_in_place(i), place.normal);
                point.map(|position| (place.normal, position))
            }
            Primitive::Shape(i) => match &self.shapes[i] {
                Shape::Sphere(sphere) => Some(sphere.precise_surface(ray, t)),
                _ => None,
            },
            Primitive::Plane(_) => None,
        };
        let Some((normal, position)) = found else { return place };
        // The offset along the normal, which is rounded itself, covers the roundings along the ray. In double-double
        // numbers, distant coordinates contribute less than a rounding of the square of the least part.
        let way = ray.origin.abs().max_element() + (position - ray.origin).abs().max_element();
        let own = position.abs().max_element() + LEAST_PART * (way + LEAST_PART * place.extent);
        PlaceOnSurface { normal, position, extent: own.min(place.extent) }
    }
}

/// Returns a vector times a power of two such that its largest coordinate is from 0.5 to 1.
fn rescaled(v: [Dd; 3]) -> [Dd; 3] {
    let largest = v.iter().map(|x| x.value().abs()).fold(0.0, f64::max);
    let exponent = libm::frexp(largest).1;
    v.map(|x| x.times_exp2(-exponent))
}
