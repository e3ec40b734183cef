//! The outline of a polygon: its corners one after the other, where none repeats the one before it.

use glam::DVec3;
use std::cmp::Ordering;

/// A corner of a polygon.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// Its index in the polygon.
    pub index: usize,
    /// Its position.
    pub point: DVec3,
}

/// The corners of a polygon, in the order of the file. It also has an order of its own, which is the same wherever
/// the file's order starts and in whichever direction it goes.
pub struct Outline {
    corners: Vec<Corner>,
    start: usize,
    is_backwards: bool,
}

/// The corners in the outline's own order.
pub struct Ring {
    /// The corners.
    pub corners: Vec<Corner>,
    /// Whether the file's order goes the other way round.
    pub is_backwards: bool,
}

impl Outline {
    pub fn new(polygon: &[DVec3]) -> Self {
        let mut corners: Vec<Corner> = Vec::with_capacity(polygon.len());
        for (index, &point) in polygon.iter().enumerate() {
            if corners.last().is_none_or(|last| last.point != point) {
                corners.push(Corner { index, point });
            }
        }
        while let [first, .., last] = corners[..]
            && first.point == last.point
        {
            corners.pop();
        }
        let count = corners.len();
        let at = |start: usize, is_backwards: bool, k: usize| {
            let place = if is_backwards { start + count - k } else { start + k };
            corners[place % count].point
        };
        let forwards = least_start(count, |k| at(0, false, k));
        let backwards = (count - least_start(count, |k| at(0, true, k))) % count;
        let orders = (0..count).map(|k| in_order(at(forwards, false, k), at(backwards, true, k)));
        let is_backwards = orders.fold(Ordering::Equal, Ordering::then) == Ordering::Greater;
        Self { start: if is_backwards { backwards } else { forwards }, is_backwards, corners }
    }

    /// The corners in the order of the file.
    pub fn in_file_order(&self) -> &[Corner] {
        &self.corners
    }

    /// The corner at this place of the outline's own order.
    pub fn at(&self, place: usize) -> Corner {
        let count = self.corners.len();
        let place = if self.is_backwards { self.start + count - place } else { self.start + place };
        self.corners[place % count]
    }

    /// The corners in the outline's own order.
    pub fn ring(&self) -> Ring {
        let corners = (0..self.corners.len()).map(|k| self.at(k)).collect();
        Ring { corners, is_backwards: self.is_backwards }
    }
}

/// Where the lexicographically least rotation of a cyclic sequence starts, in linear time (Shiloach, "Fast
/// canonization of circular strings", Journal of Algorithms 2(2), 1981).
fn least_start(count: usize, at: impl Fn(usize) -> DVec3) -> usize {
    let (mut one, mut other, mut same) = (0, 1, 0);
    while one.max(other) < count && same < count {
        match in_order(at((one + same) % count), at((other + same) % count)) {
            Ordering::Equal => {
                same += 1;
                continue;
            }
            Ordering::Less => other += same + 1,
            Ordering::Greater => one += same + 1,
        }
        other += usize::from(one == other);
        same = 0;
    }
    one.min(other)
}

/// The order of two finite points, coordinate by coordinate.
fn in_order(a: DVec3, b: DVec3) -> Ordering {
    a.to_array().partial_cmp(&b.to_array()).unwrap_or(Ordering::Equal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::worst_case::Rng;

    #[test]
    fn the_own_order_depends_neither_on_the_start_nor_on_the_direction() {
        let rng = &mut Rng(1);
        for _ in 0..2000 {
            let count = 1 + rng.below(9);
            // Two positions only, so that many rotations start alike.
            let mut points: Vec<DVec3> = (0..count).map(|_| DVec3::splat(rng.below(2) as f64)).collect();
            points.dedup();
            let own = |points: &[DVec3]| {
                let ring = Outline::new(points).ring();
                ring.corners.iter().map(|corner| corner.point).collect::<Vec<_>>()
            };
            let expected = own(&points);
            for _ in 0..points.len() {
                points.rotate_left(1);
                assert_eq!(own(&points), expected);
                points.reverse();
                assert_eq!(own(&points), expected);
            }
        }
    }

    #[test]
    fn repeated_corners_are_one() {
        let [a, b, c] = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let kept = |points: &[DVec3]| {
            let outline = Outline::new(points);
            outline.in_file_order().iter().map(|corner| corner.index).collect::<Vec<_>>()
        };
        assert_eq!(kept(&[a, a, b, c, c, c, a, a]), [0, 2, 3]);
        assert_eq!(kept(&[a, b, a, c]), [0, 1, 2, 3]);
        assert_eq!((kept(&[a, a, a]), kept(&[a, b, b, a])), (vec![0], vec![0, 2 - 1]));
    }
}
