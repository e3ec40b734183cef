//! Axis-aligned boxes.

use glam::DVec3;

/// A closed axis-aligned box. [`Aabb::EMPTY`] is the identity of [`Aabb::union`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The corner of the least coordinates.
    pub min: DVec3,
    /// The corner of the greatest coordinates.
    pub max: DVec3,
}

impl Aabb {
    /// The box that holds no point.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The smallest box around `points`.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether the box holds no point.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Edge lengths.
    pub fn extent(&self) -> DVec3 {
        self.max - self.min
    }

    /// The eight corners.
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

    fn long() -> Aabb {
        Aabb { min: DVec3::new(-1.0, 2.0, -3.0), max: DVec3::new(0.5, 4.0, 5.0) }
    }

    #[test]
    fn a_box_around_points_and_boxes_is_the_smallest() {
        let points = [DVec3::new(0.5, 2.0, 5.0), DVec3::new(-1.0, 4.0, 1.0), DVec3::new(0.0, 3.0, -3.0)];
        assert_eq!(Aabb::around(points), long());
        assert_eq!(Aabb::around(points[..1].to_vec()).union(Aabb::around(points[1..].to_vec())), long());
        assert_eq!(Aabb::EMPTY.union(long()), long());
        assert_eq!(long().union(Aabb::EMPTY), long());
    }

    #[test]
    fn only_a_box_without_points_is_empty() {
        assert!(Aabb::EMPTY.is_empty() && !long().is_empty());
        assert!(!Aabb::around([DVec3::ONE]).is_empty());
        assert!(Aabb { min: DVec3::new(-1.0, 4.5, -3.0), ..long() }.is_empty());
    }

    #[test]
    fn corners_run_along_x_first() {
        assert_eq!(long().extent(), DVec3::new(1.5, 2.0, 8.0));
        let corners = long().corners();
        assert_eq!(corners[0], long().min);
        assert_eq!(corners[1], DVec3::new(0.5, 2.0, -3.0));
        assert_eq!(corners[2], DVec3::new(-1.0, 4.0, -3.0));
        assert_eq!(corners[4], DVec3::new(-1.0, 2.0, 5.0));
        assert_eq!(corners[7], long().max);
        assert_eq!(Aabb::around(corners), long());
    }
}
