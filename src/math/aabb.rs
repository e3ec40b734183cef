//! Axis-aligned boxes.

use glam::DVec3;
use serde::Serialize;

/// A closed axis-aligned box. [`Aabb::EMPTY`] is the identity of [`Aabb::union`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Aabb {
    /// The corner with the smallest coordinates.
    pub min: DVec3,
    /// The corner with the largest coordinates.
    pub max: DVec3,
}

impl Default for Aabb {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Aabb {
    /// The box that contains no point.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// Returns the smallest box that contains all `points`.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// Returns the smallest box that contains both boxes.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Returns true if the box contains no point, or if a corner is NaN.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Returns the edge lengths along the axes.
    pub fn extent(&self) -> DVec3 {
        self.max - self.min
    }

    /// Returns the eight corners; x varies fastest, z slowest.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, axis: usize| if i & bit == 0 { self.min[axis] } else { self.max[axis] };
            DVec3::new(pick(1, 0), pick(2, 1), pick(4, 2))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample_box() -> Aabb {
        Aabb { min: DVec3::new(-1.0, 2.0, -3.0), max: DVec3::new(0.5, 4.0, 5.0) }
    }

    #[test]
    fn around_and_union_give_the_smallest_box() {
        let points = [DVec3::new(0.5, 2.0, 5.0), DVec3::new(-1.0, 4.0, 1.0), DVec3::new(0.0, 3.0, -3.0)];
        assert_eq!(Aabb::around(points), sample_box());
        assert_eq!(
            Aabb::around(points[..1].to_vec()).union(Aabb::around(points[1..].to_vec())),
            sample_box()
        );
        assert_eq!(Aabb::EMPTY.union(sample_box()), sample_box());
        assert_eq!(sample_box().union(Aabb::EMPTY), sample_box());
    }

    #[test]
    fn only_a_box_that_contains_no_point_is_empty() {
        assert!(Aabb::EMPTY.is_empty() && !sample_box().is_empty());
        assert!(!Aabb::around([DVec3::ONE]).is_empty());
        assert!(Aabb { min: DVec3::new(-1.0, 4.5, -3.0), ..sample_box() }.is_empty());
    }

    #[test]
    fn the_x_coordinate_of_the_corners_varies_fastest() {
        assert_eq!(sample_box().extent(), DVec3::new(1.5, 2.0, 8.0));
        let corners = sample_box().corners();
        assert_eq!(corners[0], sample_box().min);
        assert_eq!(corners[1], DVec3::new(0.5, 2.0, -3.0));
        assert_eq!(corners[2], DVec3::new(-1.0, 4.0, -3.0));
        assert_eq!(corners[4], DVec3::new(-1.0, 2.0, 5.0));
        assert_eq!(corners[7], sample_box().max);
        assert_eq!(Aabb::around(corners), sample_box());
    }
}
