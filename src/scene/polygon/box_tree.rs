//! The edges of an outline in a binary tree of boxes, to find those near a triangle. Neighbouring edges are close to
//! each other, so that the order along the outline serves as the tree's.

use crate::math::robust::UNIT_ROUNDOFF;

/// A rectangle: its smallest and its largest coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    min: [f64; 2],
    max: [f64; 2],
}

impl Rectangle {
    const EMPTY: Self = Self { min: [f64::INFINITY; 2], max: [f64::NEG_INFINITY; 2] };

    /// Around some points.
    pub fn around<const N: usize>(points: [[f64; 2]; N]) -> Self {
        let point = |point| Self { min: point, max: point };
        points.into_iter().map(point).fold(Self::EMPTY, Self::joined)
    }

    fn joined(self, other: Self) -> Self {
        Self {
            min: [0, 1].map(|axis| self.min[axis].min(other.min[axis])),
            max: [0, 1].map(|axis| self.max[axis].max(other.max[axis])),
        }
    }

    /// Whether every point is certainly to the right of the line from one point to another.
    fn is_beyond(self, [from, to]: [[f64; 2]; 2]) -> bool {
        let along = [to[0] - from[0], to[1] - from[1]];
        // The corner that is the farthest to the left.
        let x = if along[1] > 0.0 { self.min[0] } else { self.max[0] };
        let y = if along[0] > 0.0 { self.max[1] } else { self.min[1] };
        let (left, right) = (along[0] * (y - from[1]), along[1] * (x - from[0]));
        // Three roundings for each product and one for their difference, without underflow.
        const ROUNDINGS: f64 = 8.0 * UNIT_ROUNDOFF;
        let size = left.abs() + right.abs();
        size > 1e-290 && left - right < -ROUNDINGS * size
    }

    fn meets(self, other: Self) -> bool {
        (0..2).all(|axis| self.min[axis] <= other.max[axis] && other.min[axis] <= self.max[axis])
    }
}

/// A triangle whose corners turn to the left, with the rectangle around it.
pub struct Triangle {
    corners: [[f64; 2]; 3],
    around: Rectangle,
}

impl Triangle {
    /// With these corners.
    pub fn new(corners: [[f64; 2]; 3]) -> Self {
        Self { corners, around: Rectangle::around(corners) }
    }

    /// Whether the rectangle may have a point in common with the triangle.
    fn may_meet(&self, rectangle: Rectangle) -> bool {
        let [a, b, c] = self.corners;
        rectangle.meets(self.around)
            && ![[a, b], [b, c], [c, a]].into_iter().any(|side| rectangle.is_beyond(side))
    }
}

/// The tree. Each leaf is an edge, known by the place of its first corner in the outline.
pub struct BoxTree {
    /// The root is 1, and the children of k are 2k and 2k + 1. The second half are the leaves.
    nodes: Vec<Rectangle>,
}

impl BoxTree {
    /// A tree with room for this number of edges.
    pub fn new(edges: usize) -> Self {
        Self { nodes: vec![Rectangle::EMPTY; 2 * edges.next_power_of_two()] }
    }

    fn leaves(&self) -> usize {
        self.nodes.len() / 2
    }

    /// Puts an edge in place of the one that starts at this corner.
    pub fn put(&mut self, edge: usize, rectangle: Rectangle) {
        let mut node = self.leaves() + edge;
        self.nodes[node] = rectangle;
        while node > 1 {
            node /= 2;
            self.nodes[node] = self.nodes[2 * node].joined(self.nodes[2 * node + 1]);
        }
    }

    /// Removes the edge that starts at this corner.
    pub fn remove(&mut self, edge: usize) {
        self.put(edge, Rectangle::EMPTY);
    }

    /// Whether `is_wanted` holds for any edge that may have a point in common with a triangle. It may be asked of others.
    pub fn any(&self, triangle: &Triangle, is_wanted: &impl Fn(usize) -> bool) -> bool {
        self.any_below(1, triangle, is_wanted)
    }

    /// The recursion is as deep as the tree: the logarithm of the number of edges.
    fn any_below(&self, node: usize, triangle: &Triangle, is_wanted: &impl Fn(usize) -> bool) -> bool {
        if !triangle.may_meet(self.nodes[node]) {
            return false;
        }
        match node.checked_sub(self.leaves()) {
            Some(edge) => is_wanted(edge),
            None => (2 * node..2 * node + 2).any(|child| self.any_below(child, triangle, is_wanted)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edges_that_meet_a_triangle_are_found() {
        for count in [1, 2, 5, 16] {
            let mut tree = BoxTree::new(count);
            let at = |k: usize| k as f64;
            (0..count)
                .for_each(|k| tree.put(k, Rectangle::around([[at(k), at(k)], [at(k) + 0.5, at(k) + 0.5]])));
            for k in 0..count {
                let upper = Triangle::new([[at(k), at(k)], [at(k) + 0.5, at(k) + 0.5], [at(k), at(k) + 0.5]]);
                assert!(tree.any(&upper, &|edge| edge == k));
                assert!(!tree.any(&upper, &|edge| edge != k));
            }
            // The rectangle around it meets all others, from which its longest side separates it.
            let below = Triangle::new([[0.0, -1.0], [20.0, -1.0], [20.0, 19.0]]);
            assert!(!tree.any(&below, &|_| true));
            // Its corner touches the first.
            assert!(tree.any(&Triangle::new([[-1.0, 1.0], [0.0, 0.0], [-1.0, 2.0]]), &|edge| edge == 0));
            tree.remove(0);
            assert!(!tree.any(&Triangle::new([[0.0, 0.0], [0.5, 0.0], [0.5, 0.5]]), &|_| true));
        }
    }
}
