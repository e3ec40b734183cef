//! The binary tree of primitives from which the nodes of a [`Tree`](super::Tree) are made.
//!
//! A node with its eight children stands for several levels of the binary tree. The levels are chosen to minimise the
//! sum of the nodes' surface areas, which is proportional to the number of nodes that a ray visits. This uses dynamic
//! programming from the leaves upwards (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", High Performance Graphics 2017).

use crate::caster::block::LANES;
use crate::caster::division::{Bounds, Item, ItemRun};
use arrayvec::ArrayVec;
use std::ops::Range;

/// The number of levels that are divided by the heuristic. Below them the primitives are divided by their number. This
/// bounds the depth of the tree if the heuristic does not divide the primitives evenly.
pub const HEURISTIC_LEVELS: usize = 40;

/// Upper bound on the number of levels: [`HEURISTIC_LEVELS`], and 29 that halve the at most 2^29 leaves.
pub const MAX_LEVELS: usize = HEURISTIC_LEVELS + 29;

/// A binary tree over a list of items, which it reorders.
pub struct BinaryTree {
    /// The branches. The two halves of a branch precede it.
    halves: Vec<Half>,
}

/// A branch of the binary tree.
pub struct Half {
    pub bounds: Bounds,
    /// The range of the branch's items.
    pub items: Range<usize>,
    pub content: BranchContent,
    /// The best plan for each number of children, up to [`LANES`], that may stand for the branch in a node.
    plans: [Plan; LANES + 1],
}

/// The content of a branch of the binary tree.
pub enum BranchContent {
    /// A leaf.
    Leaf,
    /// A branch with a frame of its own, below this number of levels.
    Small { level: usize },
    /// Two halves, given by their indices.
    Halves([usize; 2]),
}

/// How the children of a node stand for a branch.
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
    /// Builds the tree of more than [`LANES`] items, below this number of levels.
    pub fn new(items: &mut [Item], level: usize) -> Self {
        Self::divided(ItemRun::new(items), 0, level)
    }

    /// Returns the root, which holds all items.
    pub fn root(&self) -> &Half {
        &self.halves[self.halves.len() - 1]
    }

    /// Returns the children of the node that is made from a branch.
    pub fn children(&self, half: &Half) -> ArrayVec<&Half, LANES> {
        let mut children = ArrayVec::new();
        self.add_halves(half, LANES, &mut children);
        children
    }

    /// Adds the children that stand for a branch. There are at most `count`.
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

    /// Builds the tree of a branch with these items. The first item has the index `start`.
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

    /// Builds the tree of a branch that is divided into two halves.
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
    /// The plan of a branch that needs no nodes.
    const NOTHING: Self = Self { area: 0.0, first: 0 };
}

/// Returns the plans for a branch. `half_area` is half its surface area, and `a` and `b` are the plans of its halves.
/// The last plan is for the node that is made from the branch.
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
