//! Makes the triangles of a polygon meet along whole edges.

use crate::math::robust::UNIT_ROUNDOFF;
use std::collections::BTreeSet;

/// Splits triangles at the corners that lie on their edges. They go around as the outline does.
///
/// A triangulation may leave out a corner on a line between two others. Then an edge of one triangle lies beside two of
/// others, or of the polygon's neighbour, from which it parts where it is rounded.
pub fn closed(triangles: Vec<[usize; 3]>, outline: &[[f64; 2]]) -> Vec<[usize; 3]> {
    let count = outline.len();
    if triangles.len() + 2 >= count {
        return triangles;
    }
    let edges = |[a, b, c]: [usize; 3]| [[a, b], [b, c], [c, a]];
    let of_outside = (0..count).map(|place| [(place + 1) % count, place]);
    let all: BTreeSet<[usize; 2]> = of_outside.chain(triangles.iter().copied().flat_map(edges)).collect();
    let is_loose = |&[from, to]: &[usize; 2]| !all.contains(&[to, from]);
    let loose: BTreeSet<usize> = all.iter().copied().filter(is_loose).flatten().collect();
    let mut closed = Vec::with_capacity(count);
    for triangle in triangles {
        // A triangle, and which of its edges may have a corner on them.
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

/// The outline by its places, where each edge goes through the corners that lie on it.
pub fn through_corners(outline: &[[f64; 2]]) -> Vec<usize> {
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
    }
    all
}

/// Whether a corner lies between the ends of an edge, on the line through them but for rounding.
fn is_within(corner: usize, edge: [usize; 2], outline: &[[f64; 2]]) -> bool {
    let [[px, py], [ax, ay], [bx, by]] = [corner, edge[0], edge[1]].map(|place| outline[place]);
    let is_in_box = (ax.min(bx)..=ax.max(bx)).contains(&px) && (ay.min(by)..=ay.max(by)).contains(&py);
    let is_end = [px, py] == [ax, ay] || [px, py] == [bx, by];
    let (left, right) = ((bx - ax) * (py - ay), (by - ay) * (px - ax));
    let rounding = 8.0 * UNIT_ROUNDOFF * (left.abs() + right.abs());
    is_in_box && !is_end && (left - right).abs() <= rounding
}
