//! Shapes: the primitives other than triangles and planes. [`Form`] is their interface, which each shape implements in
//! its own file. [`Shape`] lists them.

use super::ellipsoid::Ellipsoid;
use super::sphere::Sphere;
use crate::math::aabb::Aabb;
use crate::math::double_double::Dd;
use crate::math::ray::Ray;
use glam::{DMat3, DVec3};

/// The interface of a shape, in world space. Every method after the first six has a default that is right for any form,
/// except [`height_and_slope`](Self::height_and_slope).
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

    /// Returns half of the smallest and half of the largest extent.
    fn half_extents(&self) -> [f64; 2];

    /// Returns the surface or the box that decides which cells of a grid list the shape.
    fn in_cells(&self) -> InCells {
        InCells::Box(self.bounds())
    }

    /// Returns both t at which the line of a ray crosses the shape, in order; `None` unless there are two.
    fn roots(&self, _ray: &Ray) -> Option<[f64; 2]> {
        None
    }

    /// Returns the t at which the line of a ray with a unit direction is tangent to the shape within roundings.
    fn tangent_at(&self, _ray: &Ray) -> Option<f64> {
        None
    }

    /// Evaluates a function that is zero on the surface, at a point near it. Returns the value and its slope along a
    /// direction.
    fn height_and_slope(&self, point: [Dd; 3], direction: [Dd; 3]) -> [Dd; 2];

    /// Returns the centre, and the maps from the unit sphere and back, if the shape is the image of the unit sphere.
    fn unit_sphere_maps(&self) -> Option<(DVec3, DMat3, DMat3)> {
        None
    }
}

/// The geometry that decides which cells of a grid list a shape.
#[derive(Clone, Copy, Debug)]
pub enum InCells {
    /// The bounding box of the shape.
    Box(Aabb),
    /// The surface of this sphere.
    Sphere(Sphere),
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

/// Calls a method of the shape inside.
macro_rules! of_form {
    ($shape:expr, $form:ident => $call:expr) => {
        match $shape {
            Shape::Sphere($form) => $call,
            Shape::Ellipsoid($form) => $call,
        }
    };
}

impl Form for Shape {
    fn bounds(&self) -> Aabb {
        of_form!(self, form => form.bounds())
    }

    #[inline(always)]
    fn intersect(&self, ray: &Ray) -> Option<f64> {
        of_form!(self, form => form.intersect(ray))
    }

    #[inline(always)]
    fn surface(&self, ray: &Ray, t: f64) -> (DVec3, DVec3) {
        of_form!(self, form => form.surface(ray, t))
    }

    #[inline(always)]
    fn extent(&self) -> f64 {
        of_form!(self, form => form.extent())
    }

    fn point_roundings(&self) -> DVec3 {
        of_form!(self, form => form.point_roundings())
    }

    fn half_extents(&self) -> [f64; 2] {
        of_form!(self, form => form.half_extents())
    }

    fn in_cells(&self) -> InCells {
        of_form!(self, form => form.in_cells())
    }

    fn roots(&self, ray: &Ray) -> Option<[f64; 2]> {
        of_form!(self, form => form.roots(ray))
    }

    fn tangent_at(&self, ray: &Ray) -> Option<f64> {
        of_form!(self, form => form.tangent_at(ray))
    }

    fn height_and_slope(&self, point: [Dd; 3], direction: [Dd; 3]) -> [Dd; 2] {
        of_form!(self, form => form.height_and_slope(point, direction))
    }

    fn unit_sphere_maps(&self) -> Option<(DVec3, DMat3, DMat3)> {
        of_form!(self, form => form.unit_sphere_maps())
    }
}
