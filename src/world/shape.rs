//! Shapes: the primitives other than triangles and planes. [`Form`] is their interface, which each shape implements in
//! its own file. [`Shape`] lists them.

use super::ellipsoid::Ellipsoid;
use super::sphere::Sphere;
use crate::math::aabb::Aabb;
use crate::math::double_double::Dd;
use crate::math::ray::Ray;
use glam::{DMat3, DVec3};

/// The interface of a shape, in world space.
pub trait Form {
    /// Returns the tight bounding box.
    fn bounds(&self) -> Aabb;

    /// Returns the nearest t on the ray.
    fn intersect(&self, ray: &Ray) -> Option<f64>;

    /// Returns the outward unit normal and the point of the surface where `ray` hits it at `t`, which must be the
    /// result of [`intersect`](Self::intersect).
    fn surface(&self, ray: &Ray, t: f64) -> (DVec3, DVec3);

    /// Returns an upper bound on the absolute coordinates of all points of the shape.
    fn extent(&self) -> f64;

    /// Returns the error bound of a point of the surface along each axis, in roundings (2^-53).
    fn point_roundings(&self) -> DVec3;

    /// Evaluates a function that is zero on the surface, at a point near it. Returns the value and its slope along a
    /// direction.
    fn height_and_slope(&self, point: [Dd; 3], direction: [Dd; 3]) -> [Dd; 2];

    /// Returns both t at which the line of a ray crosses the shape, in order.
    fn roots(&self, ray: &Ray) -> Option<[f64; 2]>;

    /// Returns the maps between the unit sphere and the shape.
    fn unit_sphere_maps(&self) -> UnitSphereMaps;
}

/// The maps between the unit sphere and a shape, which is its image.
#[derive(Clone, Copy, Debug)]
pub struct UnitSphereMaps {
    /// The centre of the shape.
    pub center: DVec3,
    /// The map to the shape, about its centre.
    pub linear: DMat3,
    /// The map back.
    pub inverse: DMat3,
}

/// A point of a surface without a material.
#[derive(Clone, Copy, Debug)]
pub struct PlaceOnSurface {
    /// The outward unit normal.
    pub normal: DVec3,
    /// The point.
    pub position: DVec3,
    /// The largest absolute coordinate from which the position was computed.
    pub extent: f64,
}

/// A primitive that is neither a triangle nor a plane. Large variants are boxed, so that many spheres take little
/// memory.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A sphere.
    Sphere(Sphere),
    /// The image of a sphere under a transform that is not a similarity.
    Ellipsoid(Box<Ellipsoid>),
}

impl Shape {
    /// Returns the interface of the shape. Its calls are not inlined.
    pub fn form(&self) -> &dyn Form {
        match self {
            Self::Sphere(sphere) => sphere,
            Self::Ellipsoid(ellipsoid) => &**ellipsoid,
        }
    }

    /// Returns the nearest t on the ray.
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray) -> Option<f64> {
        match self {
            Self::Sphere(sphere) => sphere.intersect(ray),
            Self::Ellipsoid(ellipsoid) => ellipsoid.intersect(ray),
        }
    }

    /// Returns the surface at `t`, with the [extent](Form::extent) of the shape.
    #[inline(always)]
    pub fn surface(&self, ray: &Ray, t: f64) -> PlaceOnSurface {
        let ((normal, position), extent) = match self {
            Self::Sphere(sphere) => (sphere.surface(ray, t), sphere.extent()),
            Self::Ellipsoid(ellipsoid) => (ellipsoid.surface(ray, t), ellipsoid.extent()),
        };
        PlaceOnSurface { normal, position, extent }
    }
}
