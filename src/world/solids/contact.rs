//! Whether two triangles of a mesh meet only at the vertices and the edges that they share, decided exactly.

use super::orientation::{side, turn};
use glam::DVec3;

/// A triangle of a mesh.
#[derive(Clone, Copy)]
pub struct MeshFace {
    /// The indices of its vertices.
    pub ids: [u32; 3],
    /// Its vertices.
    pub corners: [DVec3; 3],
}

impl MeshFace {
    /// An axis along which the triangle's projection has an area; none if the largest projection has none.
    pub fn axis(&self) -> Option<usize> {
        let axis = self.widest_axis();
        (turn(axis, self.corners) != 0).then_some(axis)
    }

    /// The axis along which the triangle's projection is the largest.
    fn widest_axis(&self) -> usize {
        let [a, b, c] = self.corners;
        let area = (b - a).cross(c - a).abs();
        let widest = if area.x >= area.y { 0 } else { 1 };
        if area[widest] >= area.z { widest } else { 2 }
    }

    /// The sides of this triangle's plane on which points are.
    fn sides<const N: usize>(&self, points: [DVec3; N]) -> [i32; N] {
        points.map(|p| side(self.corners, p))
    }

    /// The same triangle from another vertex on.
    fn from(&self, first: usize) -> Self {
        let turned = |i| (first + i) % 3;
        Self {
            ids: [0, 1, 2].map(|i| self.ids[turned(i)]),
            corners: [0, 1, 2].map(|i| self.corners[turned(i)]),
        }
    }
}

/// Whether two triangles with areas meet only at the vertices and the edges that they share.
pub fn meet_properly(one: &MeshFace, other: &MeshFace) -> bool {
    let is_shared = [0, 1, 2].map(|i| other.ids.contains(&one.ids[i]));
    let is_shared_too = [0, 1, 2].map(|i| one.ids.contains(&other.ids[i]));
    // The one vertex that is shared, or that is not.
    let odd = |flags: [bool; 3], flag| flags.iter().position(|&f| f == flag).unwrap_or(0);
    match is_shared.iter().filter(|&&shared| shared).count() {
        0 => are_apart(one, other),
        1 => meet_at_first_vertex(&one.from(odd(is_shared, true)), &other.from(odd(is_shared_too, true))),
        2 => meet_at_an_edge(&one.from(odd(is_shared, false)), other.corners[odd(is_shared_too, false)]),
        _ => false,
    }
}

/// Whether all of these are on the same side.
fn agree(sides: &[i32]) -> bool {
    sides[0] != 0 && sides.iter().all(|&side| side == sides[0])
}

/// Whether two triangles have no point in common.
fn are_apart(one: &MeshFace, other: &MeshFace) -> bool {
    let others = one.sides(other.corners);
    if agree(&others) {
        return true;
    }
    if others == [0; 3] {
        return are_apart_in_plane(one.widest_axis(), &one.corners, &other.corners);
    }
    // If triangles in two planes meet, then an edge of one of them meets the other one.
    let ones = other.sides(one.corners);
    agree(&ones) || edges_miss(&other.corners, others, one) && edges_miss(&one.corners, ones, other)
}

/// Whether no edge of a triangle, whose vertices are on these sides of a face, meets the face.
fn edges_miss(corners: &[DVec3; 3], sides: [i32; 3], face: &MeshFace) -> bool {
    [(0, 1), (1, 2), (2, 0)]
        .iter()
        .all(|&(i, j)| segment_misses([corners[i], corners[j]], [sides[i], sides[j]], face))
}

/// Whether a segment, whose ends are on these sides of a face, does not meet it.
pub fn segment_misses([p, q]: [DVec3; 2], sides: [i32; 2], face: &MeshFace) -> bool {
    if sides == [0; 2] {
        return are_apart_in_plane(face.widest_axis(), &[p, q], &face.corners);
    }
    agree(&sides) || {
        let [a, b, c] = face.corners;
        let passes = [[a, b], [b, c], [c, a]].map(|[from, to]| side([p, q, from], to));
        passes.contains(&1) && passes.contains(&-1)
    }
}

/// Whether two convex polygons of a plane, of two or three vertices each, have no point in common. If so, the line of
/// an edge separates them.
fn are_apart_in_plane(axis: usize, one: &[DVec3], other: &[DVec3]) -> bool {
    let separates = |from: &[DVec3], to: &[DVec3]| {
        (0..from.len()).any(|i| {
            let turns_to = |p| turn(axis, [from[i], from[(i + 1) % from.len()], p]);
            let outside = turns_to(to[0]);
            outside != 0
                && to[1..].iter().all(|&p| turns_to(p) == outside)
                && from.get((i + 2) % 3).is_none_or(|&p| from.len() < 3 || turns_to(p) == -outside)
        })
    };
    separates(one, other) || separates(other, one)
}

/// Whether two triangles with the same first vertex have only this in common. They do so if and only if the cones that
/// they span there do.
fn meet_at_first_vertex(one: &MeshFace, other: &MeshFace) -> bool {
    let ([v, a, b], [_, c, d]) = (one.corners, other.corners);
    let [of_c, of_d] = one.sides([c, d]);
    if of_c * of_d > 0 {
        return true;
    }
    let [of_a, of_b] = other.sides([a, b]);
    match ([of_c, of_d], [of_a, of_b]) {
        (_, [a, b]) if a * b > 0 => true,
        ([0, 0], _) => are_cones_apart(one.widest_axis(), v, [a, b], [c, d]),
        // The planes meet along one edge, or along the line of one.
        ([0, _], _) => is_beside(one.widest_axis(), v, [a, b], c),
        ([_, 0], _) => is_beside(one.widest_axis(), v, [a, b], d),
        (_, [0, _]) => is_beside(other.widest_axis(), v, [c, d], a),
        (_, [_, 0]) => is_beside(other.widest_axis(), v, [c, d], b),
        // Each cone meets the line of both planes on one side of the vertex. With all vectors from v, Cramer's rule
        // says that a [bcd] - b [acd] + c [abd] - d [abc] = 0. They meet it on the same side where [bcd] and [abd]
        // differ.
        ([_, of_d], [_, of_b]) => of_d == of_b,
    }
}

/// Whether the ray from v through p is outside of the cone that a and b span there, in one plane.
fn is_beside(axis: usize, v: DVec3, [a, b]: [DVec3; 2], p: DVec3) -> bool {
    let inside = turn(axis, [v, a, b]);
    turn(axis, [v, a, p]) == -inside || turn(axis, [v, p, b]) == -inside
}

/// Whether two cones of a plane have only their vertex in common. If so, the line of one of their rays separates them,
/// except that a ray of the other may be opposite to this one.
fn are_cones_apart(axis: usize, v: DVec3, one: [DVec3; 2], other: [DVec3; 2]) -> bool {
    let separates = |[ray, inner]: [DVec3; 2], cone: [DVec3; 2]| {
        let inside = turn(axis, [v, ray, inner]);
        cone.iter().all(|&p| match turn(axis, [v, ray, p]) {
            0 => is_opposite(v, ray, p),
            side => side == -inside,
        })
    };
    let swapped = |[a, b]: [DVec3; 2]| [b, a];
    separates(one, other)
        || separates(swapped(one), other)
        || separates(other, one)
        || separates(swapped(other), one)
}

/// Whether two points on a line with v are on opposite sides of it.
fn is_opposite(v: DVec3, a: DVec3, b: DVec3) -> bool {
    (0..3).any(|i| a[i] > v[i] && b[i] < v[i] || a[i] < v[i] && b[i] > v[i])
}

/// Whether a triangle whose last two vertices are an edge of another one, with this vertex beside, has only the edge in
/// common with it.
fn meet_at_an_edge(one: &MeshFace, beside: DVec3) -> bool {
    let [opposite, p, q] = one.corners;
    let axis = one.widest_axis();
    side(one.corners, beside) != 0 || turn(axis, [p, q, opposite]) != turn(axis, [p, q, beside])
}

#[cfg(test)]
mod tests;
