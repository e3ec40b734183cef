//! Infinite planes. They have no bounds, so every ray is tested against each of them.

use super::PlaceInScene;
use super::coincidence::WRITTEN_ROUNDINGS;
use super::coplanar::WrittenPlanes;
use super::placement::Placement;
use crate::base::patience::Steps;
use crate::diagnostic::Diagnostic;
use crate::math::double_double::{Dd, dot};
use crate::math::ray::Ray;
use crate::math::robust::{self, UNIT_ROUNDOFF};
use crate::math::rounded::absolute;
use glam::DVec3;

/// The points p with `normal . p = offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A unit vector.
    pub normal: DVec3,
    /// The distance from the origin along the normal.
    pub offset: f64,
}

impl Plane {
    /// Returns the t at which the ray crosses the plane; `None` if the ray is parallel to it, or if the direction is
    /// too long for its product with the normal to be finite.
    pub fn intersect(&self, ray: &Ray) -> Option<f64> {
        let rate = self.normal.dot(ray.direction);
        let t = self.ahead_of(ray.origin) / rate;
        (ray.covers(t) && rate.is_finite()).then_some(t)
    }

    /// Returns the signed distance from a point to the plane, positive if the normal points from the point to the
    /// plane.
    #[inline]
    pub fn ahead_of(&self, point: DVec3) -> f64 {
        self.offset - self.normal.dot(point)
    }

    /// Returns the plane with its normal reversed.
    pub fn reversed(self) -> Self {
        Self { normal: -self.normal, offset: -self.offset }
    }

    /// Returns the point of the plane nearest to `point`. This removes the rounding error of `origin + t * direction`
    /// across the plane, so that a solid texture with a boundary in the plane does not flicker.
    pub fn project(&self, point: DVec3) -> DVec3 {
        point - (self.normal.dot(point) - self.offset) * self.normal
    }
}

/// The largest distance between a plane and the exact one: `at_origin` at the origin, plus the tilt times the distance
/// from it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PlaneError {
    pub at_origin: f64,
    /// An angle in radians.
    pub tilt: f64,
}

impl PlaneError {
    /// The error bound of a unit normal, in roundings.
    const NORMAL_ROUNDINGS: f64 = 4.0;

    /// Returns the error of a plane without a transform. It is zero if the normal is along an axis.
    pub fn as_written(normal: DVec3) -> Self {
        let is_along_axis = normal.to_array().into_iter().filter(|&x| x != 0.0).count() == 1;
        let roundings = if is_along_axis { 0.0 } else { Self::NORMAL_ROUNDINGS };
        Self { at_origin: 0.0, tilt: roundings * UNIT_ROUNDOFF }
    }

    /// Returns the error of a plane that is placed by its normal and by its point nearest to the origin. This point is
    /// `offset` away from the origin in object space, and at `foot` in world space, where the unit normal is
    /// `world_normal`.
    pub fn transformed(
        placement: &Placement,
        (normal, offset): (DVec3, f64),
        (world_normal, foot): (DVec3, DVec3),
    ) -> Self {
        let Placement { matrix, error, .. } = placement;
        let of_normals = 2.0 * Self::NORMAL_ROUNDINGS * UNIT_ROUNDOFF;
        let tilt = robust::transformed_normal_error(matrix.matrix3, error.matrix3, normal) + of_normals;
        let reach = offset.abs() * robust::unit(normal).abs() * (1.0 + of_normals);
        let of_unit_normal = of_normals * absolute(*matrix).transform_vector3(reach);
        // Only a displacement of the foot along the normal moves the plane.
        let of_placement = placement.point_error().transform_point3(reach);
        let of_foot = world_normal.abs().dot(of_placement + of_unit_normal);
        Self { at_origin: of_foot + tilt * foot.abs().element_sum(), tilt }
    }

    /// Returns the distance from the exact plane at a point of either plane.
    pub fn at(self, point: DVec3) -> f64 {
        self.at_origin + self.tilt * point.abs().element_sum()
    }
}

/// A plane that a scene placed in world space.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedPlane {
    pub plane: Plane,
    /// A vector along the normal, before it is rounded to unit length.
    pub direction: DVec3,
    pub error: PlaneError,
    pub place: PlaceInScene,
}

impl PlacedPlane {
    /// Places the next plane after the `earlier` ones, which are `written`. Returns an error if the transforms flatten
    /// it.
    pub fn new(
        placement: &Placement,
        (normal, offset): (DVec3, f64),
        place: PlaceInScene,
        earlier: &[Self],
        written: &mut WrittenPlanes,
        steps: &mut Steps,
    ) -> Result<Self, Diagnostic> {
        let matrix = placement.transform.map(|_| placement.matrix);
        let own = Plane { normal: robust::unit(normal), offset };
        let (own, same) = written.add(matrix, own, steps)?;
        let mut placed = Self::placed(own, placement, normal, place)?;
        if let Some(same) = same {
            // The rounding of the written normal's length changes the error a little.
            placed.error = earlier[same].error;
        }
        Ok(placed)
    }

    /// Returns a plane under the transforms around it. `normal` is the normal in the text, of any length.
    fn placed(
        written: Plane,
        placement: &Placement,
        normal: DVec3,
        place: PlaceInScene,
    ) -> Result<Self, Diagnostic> {
        if placement.transform.is_none() {
            let error = PlaneError::as_written(normal);
            return Ok(Self { plane: written, direction: robust::rescaled(normal), error, place });
        }
        placement.check_regular()?;
        let in_world =
            |normal| robust::transformed_normal(placement.matrix.matrix3, placement.orientation, normal);
        let world_normal = robust::unit(in_world(written.normal));
        // The terms of the offset may be far larger than the offset itself.
        let offset = Dd::from(written.offset);
        let foot = written.normal.to_array().map(|x| offset * Dd::from(x));
        let foot = robust::transformed_precisely(&placement.matrix, foot);
        let world_offset = dot(world_normal.to_array().map(Dd::from), foot).value();
        let foot = DVec3::from_array(foot.map(Dd::value));
        let error = PlaneError::transformed(placement, (normal, written.offset), (world_normal, foot));
        let plane = Plane { normal: world_normal, offset: world_offset };
        Ok(Self { plane, direction: robust::rescaled(in_world(normal)), error, place })
    }

    /// Returns true if two planes agree within their errors, both in their directions and at the point nearest to the
    /// origin.
    pub fn coincides(&self, earlier: &Self) -> bool {
        let rounding = WRITTEN_ROUNDINGS * UNIT_ROUNDOFF;
        let tilt = earlier.plane.normal.cross(self.plane.normal).length();
        let foot = earlier.plane.offset * earlier.plane.normal;
        let apart = self.plane.ahead_of(foot).abs();
        tilt <= earlier.error.tilt + self.error.tilt + rounding
            && apart <= earlier.error.at(foot) + self.error.at(foot) + rounding * earlier.plane.offset.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_projected_along_the_normal() {
        let plane = Plane { normal: DVec3::new(0.0, 0.6, 0.8), offset: -1.0 };
        let projected = plane.project(DVec3::new(7.0, 5.0, 2.5));
        assert!((projected - DVec3::new(7.0, 1.4, -2.3)).length() < 1e-15, "{projected}");
    }
}
