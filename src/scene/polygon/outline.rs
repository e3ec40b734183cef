//! The outline of a polygon: its corners one after the other, where none repeats the one before it.

use glam::DVec3;
use std::cmp::Ordering;

/// The corners of a polygon, by their indices, without those that repeat the one before them.
pub fn distinct(corners: &[DVec3]) -> Vec<usize> {
    let mut ring: Vec<usize> = (0..corners.len()).collect();
    ring.dedup_by_key(|corner| corners[*corner].to_array());
    while let [first, .., last] = ring[..]
        && corners[first] == corners[last]
    {
        ring.pop();
    }
    ring
}

/// The same corners in an order that depends neither on the first one nor on the direction, and whether it goes the
/// other way round.
pub fn in_own_order(ring: &[usize], corners: &[DVec3]) -> (Vec<usize>, bool) {
    let position = |corner: &usize| corners[*corner].to_array();
    let least_rotation = |mut ring: Vec<usize>| {
        let from = |start: usize| ring[start..].iter().chain(&ring[..start]);
        let start = (0..ring.len())
            .min_by(|&one, &other| in_order(from(one).map(position), from(other).map(position)));
        ring.rotate_left(start.unwrap_or(0));
        ring
    };
    let forwards = least_rotation(ring.to_vec());
    let backwards = least_rotation(ring.iter().rev().copied().collect());
    match in_order(forwards.iter().map(position), backwards.iter().map(position)) {
        Ordering::Greater => (backwards, true),
        _ => (forwards, false),
    }
}

/// The order of two lists of finite points, coordinate by coordinate.
fn in_order(one: impl Iterator<Item = [f64; 3]>, other: impl Iterator<Item = [f64; 3]>) -> Ordering {
    one.partial_cmp(other).unwrap_or(Ordering::Equal)
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
                let (ring, _) = in_own_order(&distinct(points), points);
                ring.into_iter().map(|corner| points[corner]).collect::<Vec<_>>()
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
        assert_eq!(distinct(&[a, a, b, c, c, c, a, a]), [0, 2, 3]);
        assert_eq!(distinct(&[a, b, a, c]), [0, 1, 2, 3]);
        assert_eq!((distinct(&[a, a, a]), distinct(&[a, b, b, a])), (vec![0], vec![0, 1]));
    }
}
