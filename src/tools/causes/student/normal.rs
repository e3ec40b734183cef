//! The surface at a hit, whose normal may be wrong.

use super::Student;
use crate::math::ray::{Ray, Visible};
use crate::math::robust::unit;
use crate::scene::Object;
use crate::tools::causes::rules::Rule;
use crate::world::{Primitive, SurfacePoint};
use glam::{DMat3, DVec3};

impl Student<'_> {
    /// Returns the surface at a hit, with the normal that the rules give it.
    pub(super) fn surface(&self, ray: &Ray, visible: Visible) -> SurfacePoint {
        let surface = self.hits.surface(ray, visible);
        let Some(objects) = self.objects.filter(|_| !self.rules.is_empty()) else { return surface };
        let matrix = objects.of(visible.primitive).matrix.matrix3;
        let normal = self.wrong_normal(surface.normal, visible.primitive, matrix);
        if normal.is_finite() { SurfacePoint { normal, ..surface } } else { surface }
    }

    /// Returns the normal that broken rules give a primitive with this unit normal and this transform.
    fn wrong_normal(&self, normal: DVec3, primitive: u32, matrix: DMat3) -> DVec3 {
        // The inverse transpose transforms normals to world space.
        let of_object = matrix.transpose() * normal;
        let is_placed_as_written = matrix == DMat3::IDENTITY;
        if self.breaks(Rule::NormalsNeverNormalised) {
            let object = self.objects.map(|objects| &self.renderer.scene.objects[objects.of(primitive).id]);
            // In the sphere's own space.
            let radius = if let Some(&Object::Sphere { radius, .. }) = object { radius } else { 1.0 };
            return radius * normal / of_object.length();
        }
        let (is_sphere, is_triangle) =
            (self.world().is_shape(primitive), self.world().is_triangle(primitive));
        let is_reversed = self.breaks(Rule::SphereNormalsInward) && is_sphere
            || self.breaks(Rule::WindingReversed) && is_triangle;
        if self.breaks(Rule::NormalsByMatrix) {
            unit(matrix * of_object)
        } else if self.breaks(Rule::NormalsByInverse) {
            unit(matrix.inverse() * of_object)
        } else if self.breaks(Rule::NormalsOfObjectSpace) {
            unit(of_object)
        } else if self.breaks(Rule::NormalsNotNormalised) {
            normal / of_object.length()
        } else if self.breaks(Rule::SphereNormalsNotNormalised) && is_sphere && is_placed_as_written {
            0.5 * self.world().box_of(primitive).extent().x * normal
        } else if is_reversed {
            -normal
        } else if self.breaks(Rule::TriangleNormalsNotNormalised)
            && is_placed_as_written
            && let Primitive::Triangle(triangle) = self.world().primitive(primitive)
        {
            let [a, b, c] = self.world().corners(triangle);
            (b - a).cross(c - a).length() * normal
        } else {
            normal
        }
    }
}
