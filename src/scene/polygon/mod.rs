//! Triangulates mesh polygons with any number of corners in space. They need be neither convex nor exactly flat.
//!
//! The area that a polygon covers is decided in the coordinate plane that it faces most. The result depends on neither
//! its size, position, first corner nor direction. A convex polygon becomes a fan. `earcut` cuts all others, in an
//! order independent of the first corner. Because `earcut` rounds, its area is compared with the outline's. Edges meet
//! whole: a corner on the line between its neighbours opens no gap towards the adjacent polygon.

mod projection;
mod seams;

#[cfg(test)]
mod tests;

use crate::math::exact::ExactSum;
use crate::math::exact::area_vector;
use crate::math::robust::UNIT_ROUNDOFF;
use earcut::Earcut;
use glam::DVec3;
use projection::DroppedAxis;
use std::cmp::Ordering;

/// The triangles of a polygon, with its orientation.
#[derive(Debug, PartialEq)]
pub struct Triangulation {
    /// The indices of the corners.
    pub triangles: Vec<[usize; 3]>,
    /// The fault in the outline, if any.
    pub fault: Option<OutlineFault>,
}

/// A fault in the outline of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutlineFault {
    /// The area of the triangles differs from the area of the outline by more than the rounding of the corners
    /// explains.
    Crosses,
    /// The outline retraces itself, so there are no triangles.
    EnclosesNothing,
}

/// The largest number of corners of a polygon in a file. The time of `earcut`, of closing gaps along edges, and of
/// comparing orders of corners may grow with the square of the number.
pub const MOST_CORNERS: usize = 1000;

/// Triangulates a polygon of at least three finite corners.
///
/// A polygon with all corners on one line, or one for which `earcut` finds nothing, becomes a fan.
pub fn triangulate(corners: &[DVec3]) -> Triangulation {
    let whole_fan = || (1..corners.len().max(2) - 1).map(|k| [0, k, k + 1]).collect();
    // Choose an order of the corners that does not depend on the file, and the axis to drop.
    let file_ring = distinct(corners);
    let (mut canonical_ring, is_backwards) = in_canonical_order(&file_ring, corners);
    let Some(projection) = DroppedAxis::facing(&points_of(&canonical_ring, corners)) else {
        return Triangulation { triangles: whole_fan(), fault: None };
    };
    // Return a fan if the polygon is convex.
    let points = points_of(&file_ring, corners);
    if let Some(fan) = fan(&points, projection) {
        let places = seams::closed(fan, &projection.flattened(&points));
        return Triangulation { triangles: corners_of(&places, &file_ring), fault: None };
    }
    // Cut the outline, turned to the left.
    let turn = projection.turn(&points_of(&canonical_ring, corners));
    if turn < 0 {
        canonical_ring.reverse();
    }
    let mut cut = Cut::new(canonical_ring, corners, projection);
    // If the area differs, cut it again with edges through the corners on them: rounding may have moved a corner off its
    // edge, to the wrong side.
    if !cut.has_area_of_outline()
        && let Some(through) = seams::through_corners(&cut.outline)
    {
        let longer_ring = through.into_iter().map(|place| cut.ring[place]).collect();
        let longer = Cut::new(longer_ring, corners, projection);
        if longer.has_area_of_outline() {
            cut = longer;
        }
    }
    let fault = match cut.triangles.is_empty() {
        true if turn == 0 => Some(OutlineFault::EnclosesNothing),
        true => return Triangulation { triangles: whole_fan(), fault: None },
        false => (!cut.has_area_of_outline()).then_some(OutlineFault::Crosses),
    };
    // Restore the direction of the file.
    if (turn < 0) != is_backwards {
        cut.triangles.iter_mut().for_each(|triangle| triangle.reverse());
    }
    Triangulation { triangles: corners_of(&cut.triangles, &cut.ring), fault }
}

/// Returns the points of a ring of corners.
fn points_of(ring: &[usize], corners: &[DVec3]) -> Vec<DVec3> {
    ring.iter().map(|&corner| corners[corner]).collect()
}

/// Returns the corners of triangles that are given as places in a ring.
fn corners_of(triangles: &[[usize; 3]], ring: &[usize]) -> Vec<[usize; 3]> {
    triangles.iter().map(|triangle| triangle.map(|place| ring[place])).collect()
}

/// A ring of corners that turns to the left, cut into triangles.
struct Cut {
    ring: Vec<usize>,
    /// The flattened ring.
    outline: Vec<[f64; 2]>,
    /// The triangles, as places in the ring.
    triangles: Vec<[usize; 3]>,
}

impl Cut {
    fn new(ring: Vec<usize>, corners: &[DVec3], projection: DroppedAxis) -> Self {
        let outline = projection.flattened(&points_of(&ring, corners));
        let mut found: Vec<u32> = vec![];
        Earcut::new().earcut_slice(&outline, &[], &mut found);
        let found = found.as_chunks().0.iter().map(|&[a, b, c]| [a, b, c].map(|place| place as usize));
        let triangles = seams::closed(found.collect(), &outline);
        Self { ring, outline, triangles }
    }

    /// Returns true if the absolute areas of the triangles sum to the area of the outline, except for the rounding of
    /// its corners. All coordinates are below 1.
    fn has_area_of_outline(&self) -> bool {
        let outline = &self.outline;
        let doubled_area = |corners: &[usize], sum: &mut ExactSum, sign: f64| {
            for (k, &from) in corners.iter().enumerate() {
                let [[ax, ay], [bx, by]] =
                    [from, corners[(k + 1) % corners.len()]].map(|place| outline[place]);
                sum.add_product([sign, ax, by]);
                sum.add_product([-sign, ay, bx]);
            }
        };
        let all: Vec<usize> = (0..outline.len()).collect();
        let mut excess = ExactSum::default();
        doubled_area(&all, &mut excess, -1.0);
        for triangle in &self.triangles {
            let mut area = ExactSum::default();
            doubled_area(triangle, &mut area, 1.0);
            doubled_area(triangle, &mut excess, f64::from(area.value().sign()));
        }
        let lengths = outline.iter().zip(outline.iter().cycle().skip(1));
        let length: f64 = lengths.map(|(a, b)| (a[0] - b[0]).abs() + (a[1] - b[1]).abs()).sum();
        let excess = excess.value();
        libm::ldexp(excess.significand, excess.exponent).abs() <= 2.0 * UNIT_ROUNDOFF * length
    }
}

/// Returns the indices of the corners, without consecutive duplicates.
fn distinct(corners: &[DVec3]) -> Vec<usize> {
    let mut ring: Vec<usize> = (0..corners.len()).collect();
    ring.dedup_by_key(|corner| corners[*corner].to_array());
    while let [first, .., last] = ring[..]
        && corners[first] == corners[last]
    {
        ring.pop();
    }
    ring
}

/// Returns the corners in an order independent of the first corner and the direction, and true if the direction was
/// reversed. The order is the lexicographically least of all.
fn in_canonical_order(ring: &[usize], corners: &[DVec3]) -> (Vec<usize>, bool) {
    let reversed: Vec<usize> = ring.iter().rev().copied().collect();
    // An order is a direction and a start.
    let ordered = |&(is_reversed, start): &(bool, usize)| {
        let ring = if is_reversed { &reversed } else { ring };
        ring[start..].iter().chain(&ring[..start]).copied()
    };
    let positions = |order: &(bool, usize)| ordered(order).map(|corner| corners[corner].to_array());
    let compare =
        |one: &_, other: &_| positions(one).partial_cmp(positions(other)).unwrap_or(Ordering::Equal);
    let starts = |is_reversed: bool| (0..ring.len()).map(move |start| (is_reversed, start));
    let least = starts(false).chain(starts(true)).min_by(compare).unwrap_or_default();
    (ordered(&least).collect(), least.0)
}

/// Returns the triangles around the first corner as indices, except triangles without area. `None` if the polygon spans
/// more than half a turn seen from this corner; a convex one does not.
fn fan(corners: &[DVec3], projection: DroppedAxis) -> Option<Vec<[usize; 3]>> {
    let &[first, second, ..] = corners else { return None };
    let is_first = |corner: DVec3| projection.of(corner) == projection.of(first);
    let turns = |from: DVec3, to: DVec3| projection.orientation([first, from, to]);
    let mut direction = 0;
    for edge in corners[1..].windows(2) {
        let turn = turns(edge[0], edge[1]);
        direction = if direction == 0 { turn } else { direction };
        if turn * direction < 0 || turns(second, edge[1]) * direction < 0 || is_first(edge[1]) {
            return None;
        }
    }
    // A triangle projected to a line may have an area in space. It then closes a gap.
    let has_area = |triangle: &[usize; 3]| {
        let triangle = triangle.map(|place| corners[place]);
        projection.orientation(triangle) != 0 || area_vector(triangle).iter().any(|area| area.sign() != 0)
    };
    let all = (1..corners.len() - 1).map(|place| [0, place, place + 1]);
    (direction != 0 && !is_first(second)).then(|| all.filter(has_area).collect())
}
