//! The binary tree of primitives from which the nodes of a [`Tree`](super::Tree) are made.
//!
//! A node with its eight children stands for several levels of the binary tree. Which ones is chosen such that the sum
//! of the nodes' surface areas is least, to which the number of nodes that a ray visits is proportional. This takes
//! dynamic programming from the leaves upwards (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs
//! Through Compressed Wide BVHs", High Performance Graphics 2017).

use crate::caster::block::LANES;
use crate::caster::division::{Bounds, Item, ItemRun};
use arrayvec::ArrayVec;
use std::ops::Range;

/// The number of levels that are divided by the heuristic. Below them the primitives are divided by their number, which
/// bounds the depth of trees of primitives that the heuristic does not divide evenly.
pub const HEURISTIC_LEVELS: usize = 40;

/// Upper bound on the number of levels: [`HEURISTIC_LEVELS`], and 29 that halve the at most 2^29 leaves.
pub const MAX_LEVELS: usize = HEURISTIC_LEVELS + 29;

/// A binary tree over a list of items, which it has put in order.
pub struct BinaryTree {
    /// The halves of a half come before it.
    halves: Vec<Half>,
}

/// A branch of the binary tree.
pub struct Half {
    pub bounds: Bounds,
    /// The range of its items.
    pub items: Range<usize>,
    pub content: BranchContent,
    /// By the number of children, up to [`LANES`], that may stand for it in a node.
    plans: [Plan; LANES + 1],
}

/// What becomes of a branch of the binary tree.
pub enum BranchContent {
    /// A leaf.
    Leaf,
    /// A branch with a frame of its own, below so many levels.
    Small { level: usize },
    /// Two halves, given by their indices.
    Halves([usize; 2]),
}

/// How some of a node's children stand for a branch.
#[derive(Clone, Copy)]
struct Plan {
    /// The sum of half the areas of the nodes that the branch needs.
    area: f32,
    /// The number of these children for the first half; zero if one child stands for both halves.
    first: u32,
}

/// From this number of items on, both halves are divided at the same time.
const PARALLEL_ITEMS: usize = 1 << 13;

impl BinaryTree {
    /// The tree of more than [`LANES`] items, below so many levels.
    pub fn new(items: &mut [Item], level: usize) -> Self {
        Self::divided(ItemRun::new(items), 0, level)
    }

    /// The whole tree.
    pub fn root(&self) -> &Half {
        &self.halves[self.halves.len() - 1]
    }

    /// The children of the node that is made of a half.
    pub fn children(&self, half: &Half) -> ArrayVec<&Half, LANES> {
        let mut children = ArrayVec::new();
        self.add_halves(half, LANES, &mut children);
        children
    }

    /// Adds the children that stand for a branch, which are at most `count`.
    fn add_children<'a>(&'a self, half: &'a Half, count: usize, children: &mut ArrayVec<&'a Half, LANES>) {
        match half.plans[count].first {
            0 => children.push(half),
            _ => self.add_halves(half, count, children),
        }
    }

    fn add_halves<'a>(&'a self, half: &Half, count: usize, children: &mut ArrayVec<&'a Half, LANES>) {
        if let BranchContent::Halves([a, b]) = half.content {
            let first = half.plans[count].first as usize;
            self.add_children(&self.halves[a], first, children);
            self.add_children(&self.halves[b], count - first, children);
        }
    }

    /// The tree of a branch with these items, the first of which has the index `start`.
    fn of(group: ItemRun, start: usize, level: usize) -> Self {
        let content = if group.items.len() <= LANES {
            BranchContent::Leaf
        } else if level < HEURISTIC_LEVELS && group.is_small {
            BranchContent::Small { level }
        } else {
            return Self::divided(group, start, level);
        };
        let items = start..start + group.items.len();
        let mut tree = Self { halves: vec![] };
        tree.halves.push(Half { bounds: group.bounds, items, content, plans: [Plan::NOTHING; LANES + 1] });
        tree
    }

    /// The same for a group that is divided.
    fn divided(group: ItemRun, start: usize, level: usize) -> Self {
        let (bounds, items) = (group.bounds, start..start + group.items.len());
        let [a, b] = group.halves(level >= HEURISTIC_LEVELS);
        let middle = start + a.items.len();
        let divide = |group, start| Self::of(group, start, level + 1);
        let (mut tree, second) = match items.len() {
            PARALLEL_ITEMS.. => rayon::join(|| divide(a, start), || divide(b, middle)),
            _ => (divide(a, start), divide(b, middle)),
        };
        let halves = [tree.halves.len() - 1, tree.append(second)];
        let plans = plans(bounds.half_area(), halves.map(|half| &tree.halves[half].plans));
        tree.halves.push(Half { bounds, items, content: BranchContent::Halves(halves), plans });
        tree
    }

    /// Appends the halves of another tree, and returns the index of its root.
    fn append(&mut self, mut other: Self) -> usize {
        let shift = self.halves.len();
        for half in &mut other.halves {
            if let BranchContent::Halves(halves) = &mut half.content {
                halves.iter_mut().for_each(|half| *half += shift);
            }
        }
        self.halves.append(&mut other.halves);
        self.halves.len() - 1
    }
}

impl Plan {
    /// Of a branch that needs no nodes.
    const NOTHING: Self = Self { area: 0.0, first: 0 };
}

/// The plans for a branch of half this area, whose halves have these plans. The last one is for the node that is made
/// of the branch.
fn plans(half_area: f32, [a, b]: [&[Plan; LANES + 1]; 2]) -> [Plan; LANES + 1] {
    let among = |count: usize| {
        let plan = |first: usize| Plan { area: a[first].area + b[count - first].area, first: first as u32 };
        (2..count).fold(plan(1), |best, first| if plan(first).area < best.area { plan(first) } else { best })
    };
    let inside = among(LANES);
    let whole = Plan { area: half_area + inside.area, first: 0 };
    std::array::from_fn(|count| match count {
        0 | 1 => whole,
        LANES => inside,
        _ => Some(among(count)).filter(|plan| plan.area < whole.area).unwrap_or(whole),
    })
}

#[cfg(test)]
mod tests;
