//! The edges of an outline in a binary tree of boxes, to find those near a triangle. Neighbouring edges are close to
//! each other, so that the order along the outline serves as the tree's.

use crate::memory::{NoMemory, filled};

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

    fn meets(self, other: Self) -> bool {
        (0..2).all(|axis| self.min[axis] <= other.max[axis] && other.min[axis] <= self.max[axis])
    }
}

/// The tree. Each leaf is an edge, known by the place of its first corner in the outline.
pub struct BoxTree {
    /// The root is 1, and the children of k are 2k and 2k + 1. The second half are the leaves.
    nodes: Vec<Rectangle>,
}

impl BoxTree {
    /// A tree with room for this number of edges.
    pub fn new(edges: usize) -> Result<Self, NoMemory> {
        Ok(Self { nodes: filled(Rectangle::EMPTY, 2 * edges.next_power_of_two())? })
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

    /// Whether `is_wanted` holds for any edge whose rectangle meets this one.
    pub fn any(&self, rectangle: Rectangle, is_wanted: &impl Fn(usize) -> bool) -> bool {
        self.any_below(1, rectangle, is_wanted)
    }

    /// The recursion is as deep as the tree: the logarithm of the number of edges.
    fn any_below(&self, node: usize, rectangle: Rectangle, is_wanted: &impl Fn(usize) -> bool) -> bool {
        if !self.nodes[node].meets(rectangle) {
            return false;
        }
        match node.checked_sub(self.leaves()) {
            Some(edge) => is_wanted(edge),
            None => (2 * node..2 * node + 2).any(|child| self.any_below(child, rectangle, is_wanted)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edges_that_meet_a_rectangle_are_found() {
        for count in [1, 2, 5, 16] {
            let mut tree = BoxTree::new(count).unwrap();
            let square = |k: usize| Rectangle::around([[k as f64, 0.0], [k as f64 + 0.5, 1.0]]);
            (0..count).for_each(|k| tree.put(k, square(k)));
            for k in 0..count {
                assert!(tree.any(square(k), &|edge| edge == k));
                assert!(!tree.any(square(k), &|edge| edge != k));
            }
            tree.remove(0);
            assert!(!tree.any(square(0), &|_| true));
        }
    }
}
