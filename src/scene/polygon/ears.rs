//! Cuts ears off an outline: triangles of three corners in a row that no other part of the outline enters (Meisters,
//! "Polygons Have Ears", American Mathematical Monthly 82(6), 1975).
//!
//! An edge keeps every triangle from being cut off that has an edge which it crosses. So an outline that crosses itself
//! is never used up, and one that is used up is covered. Corners may touch other corners and edges, and an edge may lie
//! on one in the other direction, as where a hole is joined to the outside.

use super::box_tree::{BoxTree, Rectangle, Triangle};
use super::outline::{Corner, Ring};
use super::projection::DroppedAxis;
use glam::DVec3;
use std::collections::VecDeque;

/// The ears, all with an area in the projection. None if the outline crosses itself.
pub fn triangles(ring: &Ring, projection: DroppedAxis) -> Option<Vec<[usize; 3]>> {
    let turn = projection.turn(&ring.corners);
    if turn == 0 {
        return None;
    }
    let mut corners = ring.corners.clone();
    if turn < 0 {
        corners.reverse();
    }
    let mut triangles = Clipping::new(corners, projection).ears()?;
    if (turn < 0) != ring.is_backwards {
        triangles.iter_mut().for_each(|triangle| triangle.reverse());
    }
    Some(triangles)
}

/// An outline that turns to the left, from which ears are cut.
struct Clipping {
    projection: DroppedAxis,
    corners: Vec<Corner>,
    /// The neighbours of each corner that is left.
    before: Vec<usize>,
    after: Vec<usize>,
    is_left: Vec<bool>,
    left: usize,
    edges: BoxTree,
    /// Corners to look at. Each is in it at most once.
    waiting: VecDeque<usize>,
    is_waiting: Vec<bool>,
}

/// What is to be done with a corner.
enum Fate {
    /// It stays for now.
    Stays,
    /// It goes with the triangle of its neighbours.
    Ear,
    /// It goes alone: there the outline turns back on itself.
    Spike,
}

impl Clipping {
    fn new(corners: Vec<Corner>, projection: DroppedAxis) -> Self {
        let count = corners.len();
        let mut clipping = Self {
            projection,
            before: (0..count).map(|k| (k + count - 1) % count).collect(),
            after: (0..count).map(|k| (k + 1) % count).collect(),
            is_left: vec![true; count],
            left: count,
            edges: BoxTree::new(count),
            waiting: VecDeque::with_capacity(count),
            is_waiting: vec![false; count],
            corners,
        };
        (0..count).for_each(|corner| clipping.put_edge(corner));
        clipping
    }

    fn point(&self, corner: usize) -> DVec3 {
        self.corners[corner].point
    }

    /// Puts the edge that starts at this corner into the tree.
    fn put_edge(&mut self, corner: usize) {
        let ends = [corner, self.after[corner]].map(|end| self.projection.of(self.point(end)));
        self.edges.put(corner, Rectangle::around(ends));
    }

    fn wait(&mut self, corner: usize) {
        if !std::mem::replace(&mut self.is_waiting[corner], true) {
            self.waiting.push_back(corner);
        }
    }

    /// All ears, if they use up the outline.
    fn ears(&mut self) -> Option<Vec<[usize; 3]>> {
        let mut ears = Vec::with_capacity(self.corners.len());
        (0..self.corners.len()).for_each(|corner| self.wait(corner));
        // Whether a triangle can be cut off changes only when a neighbour goes.
        while let Some(corner) = self.waiting.pop_front()
            && self.left > 2
        {
            self.is_waiting[corner] = false;
            let fate = if self.is_left[corner] { self.fate(corner) } else { Fate::Stays };
            if let Fate::Ear = fate {
                let triangle = [self.before[corner], corner, self.after[corner]];
                ears.push(triangle.map(|corner| self.corners[corner].index));
            }
            if let Fate::Ear | Fate::Spike = fate {
                self.remove(corner);
            }
        }
        (self.left <= 2).then_some(ears)
    }

    fn fate(&self, corner: usize) -> Fate {
        let around = [self.before[corner], corner, self.after[corner]];
        let triangle = around.map(|corner| self.point(corner));
        let [a, b, c] = triangle;
        match self.projection.orientation(triangle) {
            0 if !self.projection.is_between(b, [a, c]) => Fate::Spike,
            1 if !self.is_entered(around) => Fate::Ear,
            _ => Fate::Stays,
        }
    }

    fn remove(&mut self, corner: usize) {
        let (before, after) = (self.before[corner], self.after[corner]);
        self.after[before] = after;
        self.before[after] = before;
        self.is_left[corner] = false;
        self.left -= 1;
        self.edges.remove(corner);
        self.put_edge(before);
        self.wait(before);
        self.wait(after);
    }

    /// Whether any edge enters the inside of the triangle of three corners in a row, lies on one of its sides in the same
    /// direction, or has a corner on its third side, which is to become an edge.
    fn is_entered(&self, around: [usize; 3]) -> bool {
        let triangle = around.map(|corner| self.point(corner));
        let shape = Triangle::new(triangle.map(|corner| self.projection.of(corner)));
        self.edges.any(&shape, &|corner| {
            let edge = [corner, self.after[corner]].map(|end| self.point(end));
            let side = [triangle[0], triangle[2]];
            let goes_along = |place: usize| self.goes_along(corner, [around[place], around[(place + 1) % 3]]);
            let is_on_side = self.projection.orientation([side[0], side[1], edge[0]]) == 0
                && self.projection.is_between(edge[0], side);
            is_on_side || self.enters(edge, triangle) || (0..3).any(goes_along)
        })
    }

    /// Whether the edge from a corner lies on another edge, in the same direction. Then the outline goes around what is
    /// beside them twice.
    fn goes_along(&self, corner: usize, other: [usize; 2]) -> bool {
        let [p, q] = [corner, self.after[corner]].map(|end| self.point(end));
        let [s, t] = other.map(|end| self.point(end));
        let [edge, along] = [[p, q], [s, t]].map(|[from, to]| self.projection.directions([from, to]));
        corner != other[0]
            && edge == along
            && self.projection.orientation([s, t, p]) == 0
            && self.projection.orientation([s, t, q]) == 0
            && self.projection.overlap([p, q], [s, t])
    }

    /// Whether an edge has a point inside of a triangle, that is, whether no line separates them: neither one along a
    /// side of the triangle nor one along the edge.
    fn enters(&self, [p, q]: [DVec3; 2], triangle: [DVec3; 3]) -> bool {
        let [a, b, c] = triangle;
        let orientation = |corners| self.projection.orientation(corners);
        let is_outside = |[s, t]: [DVec3; 2]| orientation([s, t, p]) <= 0 && orientation([s, t, q]) <= 0;
        if [[a, b], [b, c], [c, a]].into_iter().any(is_outside) {
            return false;
        }
        let sides = triangle.map(|corner| orientation([p, q, corner]));
        sides.contains(&1) && sides.contains(&-1)
    }
}
