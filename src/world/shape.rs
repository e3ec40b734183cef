//! Shapes: the primitives of any form but triangles and planes. What a shape can do is listed in [`Form`], and is
//! written in its own file; [`Shape`] lists them.

use super::ellipsoid::Ellipsoid;
use super::sphere::Sphere;
use crate::math::aabb::Aabb;
use crate::math::double_double::Dd;
use crate::math::ray::Ray;
use glam::{DMat3, DVec3};

/// What a shape can do, in world space. All but the first six have an answer that is right for any form.
pub trait Form {
    /// The tight bounding box.
    fn bounds(&self) -> Aabb;

    /// The nearest t on the ray.
    fn intersect(&self, ray: &Ray) -> Option<f64>;

    /// The outward unit normal and the point of the surface where `ray` hits it at `t`, as found by
    /// [`intersect`](Self::intersect).
    fn surface(&self, ray: &Ray, t: f64) -> (DVec3, DVec3);

    /// At least the largest absolute coordinate of any of its points.
    fn extent(&self) -> f64;

    /// The error bound of a point of the surface along each axis, in roundings (2^-53).
    fn point_roundings(&self) -> DVec3;

    /// Half of the smallest and half of the largest extent.
    fn half_extents(&self) -> [f64; 2];

    /// What decides which cells of a grid it is in.
    fn in_cells(&self) -> InCells {
        InCells::Box(self.bounds())
    }

    /// All t at which the line of a ray crosses it, in order, if there are two.
    fn roots(&self, _ray: &Ray) -> Option<[f64; 2]> {
        None
    }

    /// The t where the line of a ray with a unit direction is tangent to it within roundings.
    fn tangent_at(&self, _ray: &Ray) -> Option<f64> {
        None
    }

    /// A function of a point near the surface that is zero on it, and its slope along a direction.
    fn height_and_slope(&self, point: [Dd; 3], direction: [Dd; 3]) -> [Dd; 2];

    /// Its centre, and the maps from the unit sphere and back, if it is the image of that.
    fn unit_sphere_maps(&self) -> Option<(DVec3, DMat3, DMat3)> {
        None
    }
}

/// What decides which cells of a grid a shape is in.
#[derive(Clone, Copy, Debug)]
pub enum InCells {
    /// Its bounding box.
    Box(Aabb),
    /// The surface of this sphere.
    Sphere(Sphere),
}

/// A primitive that is neither a triangle nor a plane. Large ones are kept apart, so that many spheres take little memory.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A sphere.
    Sphere(Sphere),
    /// The image of a sphere under a transform that is not a similarity.
    Ellipsoid(Box<Ellipsoid>),
}

/// Calls a method of whichever shape it is.
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
