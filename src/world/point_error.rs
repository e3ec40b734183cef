//! Error bounds: the largest distances between the points of the world's surfaces and the surfaces that the scene
//! describes.
//!
//! The matrices of nested transforms, the vertices and planes that they map, and the points of hits are rounded. If a
//! decision depends on the side on which a surface lies, these bounds tell which distances are too small to decide it.

use super::placement::Placement;
use super::plane::PlaneError;
use super::{Primitive, SurfacePoint, World};
use crate::math::robust::UNIT_ROUNDOFF;
use crate::math::rounded::{RoundedPoint, absolute};
use crate::scene::material::{Material, Pattern, Texture};
use glam::{DAffine3, DVec3};

/// The error bound of a point between three vertices, in roundings of their largest coordinate: one for each product,
/// two for each of two sums, and one for the quotient (`proofs/checkerboard.g`).
const BETWEEN_VERTICES_ROUNDINGS: f64 = 7.0;

/// The error bound of a point of any triangle, in roundings of the world's largest coordinate. It has room for the
/// weights of thin triangles.
const OF_COORDINATES_ROUNDINGS: f64 = 448.0;

/// The error bound of a point that is projected on a plane, in roundings of the point and the offset
/// (`proofs/checkerboard.g`).
const ON_PLANE_ROUNDINGS: f64 = 6.0;

/// The largest distances along each axis between the points of a placed object and the exact ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PlacementError {
    /// The error bound of any point of the object.
    largest: DVec3,
    /// Maps the absolute values of a point's coordinates in object space to the error bound of the point.
    point_error: DAffine3,
    matrix: DAffine3,
    /// The inverse of `matrix`; not finite if there is none.
    inverse: DAffine3,
}

impl PlacementError {
    /// Returns the error of an object whose coordinates in object space are nowhere larger than in some of these points.
    pub fn new(placement: &Placement, points: &[DVec3]) -> Self {
        if placement.transform.is_none() {
            return Self::default();
        }
        let (matrix, point_error) = (placement.matrix, placement.point_error());
        let reach = points.iter().fold(DVec3::ZERO, |reach, point| reach.max(point.abs()));
        let largest = point_error.transform_point3(reach);
        Self { largest, point_error, matrix, inverse: matrix.inverse() }
    }

    /// Returns the error of the point with these coordinates in world space. It may be far less than the largest error
    /// if other points are far away.
    fn at(&self, point: DVec3) -> DVec3 {
        let local = self.inverse.transform_point3(point);
        // The part of the point that the rounded inverse does not reproduce.
        let rest = (point - self.matrix.transform_point3(local)).abs()
            + 4.0 * UNIT_ROUNDOFF * absolute(self.matrix).transform_point3(local.abs());
        let reach = local.abs() + 2.0 * (absolute(self.inverse).matrix3 * rest);
        let error = self.point_error.transform_point3(reach);
        // The map may have no inverse.
        if error.is_finite() { error.min(self.largest) } else { self.largest }
    }
}

impl World {
    /// Calls a function with the point of a surface and its error bound.
    #[inline(always)]
    pub fn with_rounded_point<T>(&self, surface: &SurfacePoint, f: impl FnOnce(&RoundedPoint) -> T) -> T {
        let position = surface.position;
        let error = || self.point_error(surface);
        f(&RoundedPoint { position, error: &error, boundary_width: self.boundary_width.at(position) })
    }

    /// Returns the error bound of a point of a surface, along each axis.
    fn point_error(&self, surface: &SurfacePoint) -> DVec3 {
        let Some(id) = surface.primitive else { return DVec3::ZERO };
        let roundings = match self.primitive(id) {
            Primitive::Triangle(i) => {
                // Each corner's error is weighted, since a distant corner has little influence on points near the
                // others.
                let (corners, weights) = (self.corners(i), weights(surface.position, self.corners(i)));
                let of_corner = |k: usize| {
                    let rounding = BETWEEN_VERTICES_ROUNDINGS * UNIT_ROUNDOFF * corners[k].abs();
                    weights[k] * (self.flattening_error(id, corners[k]) + rounding)
                };
                return of_corner(0) + of_corner(1) + of_corner(2);
            }
            Primitive::Shape(i) => self.shapes[i].form().point_roundings(),
            // The point may be anywhere along the plane.
            Primitive::Plane(i) => {
                let plane = &self.planes[i];
                ON_PLANE_ROUNDINGS
                    * (surface.position.abs().element_sum() + plane.offset.abs())
                    * plane.normal.abs()
            }
        };
        self.flattening_error(id, surface.position) + roundings * UNIT_ROUNDOFF
    }

    /// Returns the flattening error along each axis of this point of a primitive: a corner of a triangle, the centre of
    /// a sphere or an ellipsoid, or any point of a plane.
    pub(super) fn flattening_error(&self, id: u32, point: DVec3) -> DVec3 {
        match self.primitive(id) {
            Primitive::Triangle(_) => self.placement_errors.around(id).1.at(point),
            Primitive::Shape(_) => self.placement_errors.around(id).1.largest,
            Primitive::Plane(i) => self.plane_error(i).at(point) * self.planes[i].normal.abs(),
        }
    }

    /// Returns the error of a plane; zero for a plane that was not placed by a scene.
    pub(super) fn plane_error(&self, index: usize) -> PlaneError {
        self.placed_planes.get(index).map_or(PlaneError::default(), |plane| plane.error)
    }

    /// Returns the largest flattening error of any finite primitive, or of any plane at the origin.
    pub(super) fn largest_flattening_error(&self) -> f64 {
        let finite = self.placement_errors.values().map(|error| error.largest.max_element());
        finite.chain(self.placed_planes.iter().map(|plane| plane.error.at_origin)).fold(0.0, f64::max)
    }
}

/// Returns the absolute values of a point's barycentric weights in a triangle, with an allowance for their rounding.
pub(super) fn weights(point: DVec3, triangle: [DVec3; 3]) -> [f64; 3] {
    let corners = triangle.map(|corner| corner - point);
    // Scaled so that no product overflows.
    let size = corners.iter().map(|corner| corner.abs().max_element()).fold(f64::MIN_POSITIVE, f64::max);
    let [a, b, c] = corners.map(|corner| corner / size);
    let (p, q) = ((triangle[1] - triangle[0]) / size, (triangle[2] - triangle[0]) / size);
    let normal = p.cross(q);
    let length = normal.length();
    // The roundings of the areas, relative to the lengths of their sides, and of the normal.
    let rounding = 32.0 * UNIT_ROUNDOFF;
    let of_normal = 1.0 + rounding * (p.length() * q.length() / length);
    [[b, c], [c, a], [a, b]].map(|[p, q]| {
        let area = p.cross(q).dot(normal / length).abs() + rounding * p.length() * q.length();
        area / length * of_normal
    })
}

/// The width of the boundaries of checkerboards. A point of any surface that is farther away from a boundary, in the
/// space of any of the world's checkerboards, is certainly on its side of the boundary.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BoundaryWidth {
    at_origin: f64,
    per_distance: f64,
}

impl BoundaryWidth {
    pub fn of(world: &World) -> Self {
        let largest = |numbers: &mut dyn Iterator<Item = f64>| numbers.fold(0.0, f64::max);
        let tilt = largest(&mut world.placed_planes.iter().map(|plane| plane.error.tilt));
        let offset = largest(&mut world.planes.iter().map(|plane| plane.offset.abs()));
        let shapes =
            largest(&mut world.shapes.iter().map(|shape| shape.form().point_roundings().max_element()));
        let finite = shapes.max(OF_COORDINATES_ROUNDINGS * world.max_abs_coord);
        let rounding = finite + ON_PLANE_ROUNDINGS * offset;
        let point = [
            world.largest_flattening_error() + rounding * UNIT_ROUNDOFF,
            tilt + ON_PLANE_ROUNDINGS * UNIT_ROUNDOFF,
        ];
        let widths = world.materials.iter().filter_map(|material| match material {
            Material::Texture(Texture { pattern: Pattern::Checkerboard, world_to_texture, .. }) => {
                Some(world_to_texture.image_error(point))
            }
            _ => None,
        });
        widths.fold(Self::default(), |one, [at_origin, per_distance]| Self {
            at_origin: one.at_origin.max(at_origin),
            per_distance: one.per_distance.max(per_distance),
        })
    }

    #[inline(always)]
    fn at(self, point: DVec3) -> f64 {
        self.at_origin + self.per_distance * point.abs().element_sum()
    }
}
