//! Where a ray hits one primitive.

use super::{Primitive, World};
use crate::math::ray::Ray;
use crate::primitive::shape::Form;
use crate::primitive::triangle::Shear;

impl World {
    /// The nearest t on a ray at which it hits a primitive.
    #[inline(always)]
    pub fn crossing(&self, ray: &Ray, primitive: u32) -> Option<f64> {
        match self.primitive(primitive) {
            Primitive::Triangle(i) => {
                Shear::new(ray).intersect(self.corners_in_place(i)).filter(|&t| ray.covers(t))
            }
            Primitive::Shape(i) => self.shapes[i].intersect(ray),
            Primitive::Plane(i) => self.planes[i].intersect(ray),
        }
    }
}
