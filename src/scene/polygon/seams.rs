//! Makes the triangles of a polygon meet along whole edges.

use crate::math::robust::UNIT_ROUNDOFF;
use std::collections::BTreeSet;

/// Splits triangles at the corners that lie on their edges. The triangles are oriented like the outline.
///
/// A triangulation may leave out a corner on the line between two others. One edge then faces two edges of other
/// triangles or of the adjacent polygon, and rounding opens a gap between them.
pub fn closed(triangles: Vec<[usize; 3]>, outline: &[[f64; 2]]) -> Vec<[usize; 3]> {
    let count = outline.len();
    if triangles.len() + 2 >= count {
        return triangles;
    }
    let edges = |[a, b, c]: [usize; 3]| [[a, b], [b, c], [c, a]];
    let of_outside = (0..count).map(|place| [(place + 1) % count, place]);
    let all: BTreeSet<[usize; 2]> = of_outside.chain(triangles.iter().copied().flat_map(edges)).collect();
    let is_loose = |&[from, to]: &[usize; 2]| !all.contains(&[to, from]);
    let mut loose: Vec<usize> = all.iter().copied().filter(is_loose).flatten().collect();
    loose.sort_unstable();
    loose.dedup();
    let mut closed = Vec::with_capacity(count);
    for triangle in triangles {
        // A triangle, and a flag for each edge that may have a corner on it.
        let mut waiting = vec![(triangle, edges(triangle).map(|edge| is_loose(&edge)))];
        while let Some(([a, b, c], [ab, bc, ca])) = waiting.pop() {
            let on_edge = || loose.iter().copied().find(|&corner| is_within(corner, [a, b], outline));
            match if ab { on_edge() } else { None } {
                Some(corner) => {
                    waiting.push(([corner, b, c], [is_loose(&[corner, b]), bc, false]));
                    waiting.push(([a, corner, c], [is_loose(&[a, corner]), false, ca]));
                }
                None if bc || ca => waiting.push(([b, c, a], [bc, ca, false])),
                None => closed.push([a, b, c]),
            }
        }
    }
    closed
}

/// Returns the indices of the outline, with each edge passing through the corners that lie on it. `None` if that makes it
/// more than twice as long: an outline that touches itself at some corners grows little, while one that goes to and fro
/// on one line could grow with the square of its length.
pub fn through_corners(outline: &[[f64; 2]]) -> Option<Vec<usize>> {
    let count = outline.len();
    let mut all = vec![];
    for from in 0..count {
        let edge = [from, (from + 1) % count];
        let mut on_edge: Vec<usize> = (0..count).filter(|&corner| is_within(corner, edge, outline)).collect();
        let distance =
            |corner: usize| (0..2).map(|k| (outline[corner][k] - outline[from][k]).abs()).sum::<f64>();
        on_edge.sort_by(|&one, &other| distance(one).total_cmp(&distance(other)));
        all.push(from);
        all.extend(on_edge);
        if all.len() > 2 * count {
            return None;
        }
    }
    Some(all)
}

/// Returns true if a corner lies strictly between the ends of an edge, on its line up to rounding.
fn is_within(corner: usize, edge: [usize; 2], outline: &[[f64; 2]]) -> bool {
    let [[px, py], [ax, ay], [bx, by]] = [corner, edge[0], edge[1]].map(|place| outline[place]);
    let is_between = |p: f64, a: f64, b: f64| a.min(b) <= p && p <= a.max(b);
    if !(is_between(px, ax, bx) && is_between(py, ay, by)) {
        return false;
    }
    let is_end = [px, py] == [ax, ay] || [px, py] == [bx, by];
    let (left, right) = ((bx - ax) * (py - ay), (by - ay) * (px - ax));
    let rounding = 8.0 * UNIT_ROUNDOFF * (left.abs() + right.abs());
    !is_end && (left - right).abs() <= rounding
}
