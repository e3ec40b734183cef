//! A tree of boxes over all primitives: a bounding volume hierarchy with eight branches per node and eight primitives
//! per leaf.
//!
//! A branch whose primitives are too small for the coordinates of the frame gets a frame of its own.

use crate::base::memory;
use crate::caster::block::{Frame, LANES, NONE};
use crate::caster::bounds::{Region, widened};
use crate::caster::box8::Box8;
use crate::caster::division::{BinaryTree, Bounds, BranchContent, HEURISTIC_LEVELS, Half, Item, ItemRun};
use crate::caster::lattice::GridTooLarge;
use crate::math::aabb::Aabb;
use crate::world::World;
use rayon::prelude::*;

/// A branch of a tree: the index of a node, or an index marked with one of the following bits.
pub type Branch = u32;

/// Marks a leaf. The other bits are the index of its block.
pub const LEAF: Branch = 1 << 31;

/// Marks a branch with a frame of its own. The other bits are its index among such branches.
pub const SMALL: Branch = 1 << 30;

/// The number of levels that a branch with a frame of its own counts as, so that at most eight are nested.
const LEVELS_OF_SMALL: usize = HEURISTIC_LEVELS / 8;

/// A tree of boxes.
#[derive(Debug)]
pub struct Tree {
    /// The branch that holds everything.
    pub root: Branch,
    pub nodes: Vec<Box8>,
    /// The branches with frames of their own.
    pub small: Vec<Small>,
}

/// The leaves of a tree.
#[derive(Debug)]
pub struct Leaves {
    /// The ids of the primitives in each leaf, in ascending order and padded with [`NONE`].
    pub ids: Vec<[u32; LANES]>,
    /// The frames, each with the index of the first leaf for which it holds.
    pub frames: Vec<(usize, Frame)>,
}

/// A branch with a frame of its own.
#[derive(Debug)]
pub struct Small {
    /// The branch, in the coordinates of its frame.
    pub branch: Branch,
    pub region: Region,
}

impl Tree {
    /// Builds the tree of all primitives that rays may hit, and its leaves. The coordinates are in a frame whose box
    /// contains the primitives.
    pub fn new(world: &World, frame: &Frame) -> Result<(Self, Leaves), GridTooLarge> {
        let ids =
            (0..world.finite_count() as u32).filter(|&id| !world.is_triangle(id) || world.may_be_hit(id));
        let ids: Vec<u32> = ids.collect();
        memory::ask(least_bytes(ids.len())).map_err(|_| GridTooLarge)?;
        let tree = Self { root: 0, nodes: vec![], small: vec![] };
        let mut growing = Growing { tree, leaves: Leaves { ids: vec![], frames: vec![(0, *frame)] }, world };
        let mut items = growing.items(&ids, frame);
        let ItemRun { items, is_small, .. } = ItemRun::new(&mut items);
        growing.tree.root = match items.len() {
            0..=LANES => growing.add_leaf(items),
            _ if is_small => growing.add_small(items, frame, 0),
            _ => growing.add_tree(items, frame, 0),
        };
        let fits = growing.tree.nodes.len() <= SMALL as usize && growing.leaves.ids.len() <= SMALL as usize;
        if fits { Ok((growing.tree, growing.leaves)) } else { Err(GridTooLarge) }
    }

    /// Returns true if `holds` returns true for the block of any leaf of a branch. The leaves after the first such leaf
    /// are not visited.
    pub fn any_leaf(&self, branch: Branch, holds: &mut impl FnMut(u32) -> bool) -> bool {
        if branch >= LEAF {
            holds(branch - LEAF)
        } else if branch >= SMALL {
            self.any_leaf(self.small[(branch - SMALL) as usize].branch, holds)
        } else {
            self.nodes[branch as usize].branches().any(|child| self.any_leaf(child, holds))
        }
    }
}

/// Returns the least memory, in bytes, that building a tree of this number of primitives takes: if all leaves are full.
fn least_bytes(count: usize) -> u64 {
    let per_leaf = LANES * size_of::<Item>() + 2 * size_of::<Half>() + size_of::<[u32; LANES]>();
    (count / LANES * per_leaf) as u64
}

/// A tree that is being built.
struct Growing<'w> {
    tree: Tree,
    leaves: Leaves,
    world: &'w World,
}

impl Growing<'_> {
    fn add_leaf(&mut self, items: &[Item]) -> Branch {
        let mut ids = [NONE; LANES];
        ids.iter_mut().zip(items).for_each(|(id, item)| *id = item.id);
        ids.sort_unstable();
        self.leaves.ids.push(ids);
        LEAF | (self.leaves.ids.len() as u32 - 1)
    }

    fn add_small(&mut self, items: &[Item], outer: &Frame, level: usize) -> Branch {
        let boxes = items.iter().map(|item| self.world.box_of(item.id));
        let bounds = widened(boxes.fold(Aabb::EMPTY, |all, bounds| all.union(bounds)));
        let region = Region::new(&bounds, f64::INFINITY);
        let frame = region.frame;
        self.set_frame(frame);
        let ids: Vec<u32> = items.iter().map(|item| item.id).collect();
        let mut items = self.items(&ids, &frame);
        let branch = self.add_tree(&mut items, &frame, level + LEVELS_OF_SMALL);
        self.set_frame(*outer);
        self.tree.small.push(Small { branch, region });
        SMALL | (self.tree.small.len() as u32 - 1)
    }

    /// Sets the frame of the leaves that follow.
    fn set_frame(&mut self, frame: Frame) {
        self.leaves.frames.push((self.leaves.ids.len(), frame));
    }

    /// Adds the nodes of more items than fit into a leaf. `level` is the number of levels above them.
    fn add_tree(&mut self, items: &mut [Item], frame: &Frame, level: usize) -> Branch {
        let tree = BinaryTree::new(items, level);
        self.add_node(&tree, tree.root(), items, frame)
    }

    fn add_node(&mut self, tree: &BinaryTree, half: &Half, items: &[Item], frame: &Frame) -> Branch {
        let index = self.tree.nodes.len() as Branch;
        self.tree.nodes.push(Box8::EMPTY);
        for (lane, child) in tree.children(half).into_iter().enumerate() {
            let own = &items[child.items.clone()];
            let branch = match child.content {
                BranchContent::Leaf => self.add_leaf(own),
                BranchContent::Small { level } => self.add_small(own, frame, level),
                BranchContent::Halves(_) => self.add_node(tree, child, items, frame),
            };
            let Bounds { min, max } = child.bounds;
            self.tree.nodes[index as usize].set(lane, [min, max], branch);
        }
        index
    }

    /// Returns primitives in the coordinates of a frame.
    fn items(&self, ids: &[u32], frame: &Frame) -> Vec<Item> {
        ids.par_iter().map(|&id| Item::new(frame, &self.world.box_of(id), id)).collect()
    }
}

#[cfg(test)]
mod tests;
