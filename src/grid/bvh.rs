//! Bounding volume hierarchies for the crowded cells of a grid: trees of boxes with eight branches and with eight
//! primitives per leaf.
//!
//! Where the primitives of a branch are too small for the coordinates of the frame, the branch gets a frame of its own.

use super::box8::Box8;
use super::cell_lists::{widened, with_room_for};
use super::error::GridTooLarge;
use super::ray_aabb::SimdAabb;
use super::reach::max_origin_distance;
use super::triangle8::{Frame, LANES, NONE};
use crate::math::aabb::Aabb;
use crate::memory;
use crate::world::World;
use binary::{BinaryTree, BranchContent, HEURISTIC_LEVELS, Half};
use division::{Bounds, Item, ItemRun};

pub use binary::MAX_LEVELS;

mod binary;
mod division;

/// A branch of a tree is a node with this index, or has one of the following bits.
pub type Branch = u32;

/// The branch is a leaf, and the other bits are the index of its block.
pub const LEAF: Branch = 1 << 31;

/// The branch has a frame of its own, and the other bits are its index among such branches.
pub const SMALL: Branch = 1 << 30;

/// The number of levels that a branch with a frame of its own counts as, so that at most eight are nested.
const LEVELS_OF_SMALL: usize = HEURISTIC_LEVELS / 8;

/// The tree of one cell.
#[derive(Debug)]
pub struct Bvh {
    /// Everything in the cell, which is not a leaf.
    pub root: Branch,
    /// The nodes of the tree.
    pub nodes: Vec<Box8>,
    /// The ids of the primitives in each leaf, in ascending order and followed by [`NONE`].
    pub leaves: Vec<[u32; LANES]>,
    /// The branches with frames of their own.
    pub small: Vec<Small>,
    /// From which leaf on which frame holds.
    pub frames: Vec<(usize, Frame)>,
}

/// A branch with a frame of its own.
#[derive(Debug)]
pub struct Small {
    /// The branch in these coordinates.
    pub branch: Branch,
    /// The bounds of its primitives.
    pub simd_bounds: SimdAabb,
    /// The frame of these bounds.
    pub frame: Frame,
    /// The error bounds of the filter hold for rays whose origin is at most this far from the frame's centre along
    /// each axis.
    pub max_origin_distance: f64,
}

impl Bvh {
    /// The tree of the primitives of a cell, in the coordinates of a frame whose box contains the cell. Rays find in it
    /// what they hit within the cell, whose box has to be padded for their rounding errors.
    pub fn new(world: &World, ids: &[u32], frame: &Frame, cell: &Aabb) -> Result<Self, GridTooLarge> {
        let primitives = &Primitives { world, cell };
        let (nodes, leaves, small, frames) = (vec![], vec![], vec![], vec![(0, *frame)]);
        let mut bvh = Self { root: 0, nodes, leaves, small, frames };
        let mut items = primitives.items(ids.iter().copied(), frame)?;
        let ItemRun { items, bounds, is_small, .. } = ItemRun::new(&mut items);
        bvh.root = match items.len() {
            0..=LANES => bvh.add_single_leaf(items, bounds)?,
            _ if is_small => bvh.add_small(primitives, items, frame, 0)?,
            _ => bvh.add_tree(primitives, items, frame, 0)?,
        };
        Ok(bvh)
    }

    /// Adds a node with nothing but a leaf.
    fn add_single_leaf(&mut self, items: &[Item], bounds: Bounds) -> Result<Branch, GridTooLarge> {
        let mut node = Box8::EMPTY;
        node.set(0, [bounds.min, bounds.max], self.add_leaf(items)?);
        self.push_node(node)
    }

    fn add_leaf(&mut self, items: &[Item]) -> Result<Branch, GridTooLarge> {
        let mut ids = [NONE; LANES];
        ids.iter_mut().zip(items).for_each(|(id, item)| *id = item.id);
        ids.sort_unstable();
        memory::push(&mut self.leaves, ids).map_err(|_| GridTooLarge)?;
        Ok(LEAF | (self.leaves.len() as u32 - 1))
    }

    fn add_small(
        &mut self,
        primitives: &Primitives,
        items: &[Item],
        outer: &Frame,
        level: usize,
    ) -> Result<Branch, GridTooLarge> {
        let boxes = items.iter().map(|item| primitives.box_of(item.id));
        let bounds = widened(boxes.fold(Aabb::EMPTY, |all, bounds| all.union(bounds)));
        let frame = Frame::new(&bounds);
        self.set_frame(frame)?;
        let mut items = primitives.items(items.iter().map(|item| item.id), &frame)?;
        let branch = self.add_tree(primitives, &mut items, &frame, level + LEVELS_OF_SMALL)?;
        let small = Small {
            branch,
            simd_bounds: SimdAabb::new(&bounds),
            frame,
            max_origin_distance: max_origin_distance(&bounds, f64::INFINITY),
        };
        self.set_frame(*outer)?;
        memory::push(&mut self.small, small).map_err(|_| GridTooLarge)?;
        Ok(SMALL | (self.small.len() as u32 - 1))
    }

    /// Sets the frame of the leaves that follow.
    fn set_frame(&mut self, frame: Frame) -> Result<(), GridTooLarge> {
        memory::push(&mut self.frames, (self.leaves.len(), frame)).map_err(|_| GridTooLarge)
    }

    /// Adds the nodes of more items than fit into a leaf, below so many levels.
    fn add_tree(
        &mut self,
        primitives: &Primitives,
        items: &mut [Item],
        frame: &Frame,
        level: usize,
    ) -> Result<Branch, GridTooLarge> {
        let tree = BinaryTree::new(items, level).map_err(|_| GridTooLarge)?;
        self.add_node(primitives, &tree, tree.root(), items, frame)
    }

    fn add_node(
        &mut self,
        primitives: &Primitives,
        tree: &BinaryTree,
        half: &Half,
        items: &[Item],
        frame: &Frame,
    ) -> Result<Branch, GridTooLarge> {
        let index = self.push_node(Box8::EMPTY)?;
        for (lane, child) in tree.children(half).into_iter().enumerate() {
            let own = &items[child.items.clone()];
            let branch = match child.content {
                BranchContent::Leaf => self.add_leaf(own)?,
                BranchContent::Small { level } => self.add_small(primitives, own, frame, level)?,
                BranchContent::Halves(_) => self.add_node(primitives, tree, child, items, frame)?,
            };
            let Bounds { min, max } = child.bounds;
            self.nodes[index as usize].set(lane, [min, max], branch);
        }
        Ok(index)
    }

    fn push_node(&mut self, node: Box8) -> Result<Branch, GridTooLarge> {
        memory::push(&mut self.nodes, node).map_err(|_| GridTooLarge)?;
        Ok(self.nodes.len() as u32 - 1)
    }

    /// Adds to the indices in its branches the numbers of what comes before it in the lists of all trees. An error if
    /// an index does not fit.
    pub fn shift(&mut self, nodes: usize, leaves: usize, small: usize) -> Result<(), GridTooLarge> {
        let fits = nodes + self.nodes.len() <= SMALL as usize
            && small + self.small.len() < SMALL as usize
            && leaves + self.leaves.len() <= LEAF as usize;
        if !fits {
            return Err(GridTooLarge);
        }
        let [nodes, leaves, small] = [nodes, leaves, small].map(|count| count as u32);
        let shift = |branch: &mut Branch| {
            *branch += if *branch >= LEAF {
                leaves
            } else if *branch >= SMALL {
                small
            } else {
                nodes
            };
        };
        shift(&mut self.root);
        // Also those of empty lanes, which nothing reads.
        self.nodes.iter_mut().flat_map(|node| &mut node.children).for_each(shift);
        self.small.iter_mut().for_each(|small| shift(&mut small.branch));
        Ok(())
    }
}

/// The primitives of a cell.
struct Primitives<'w> {
    world: &'w World,
    cell: &'w Aabb,
}

impl Primitives<'_> {
    /// The box around the part of a primitive in the cell.
    fn box_of(&self, id: u32) -> Aabb {
        let Aabb { min, max } = self.world.box_of(id);
        let Aabb { min: lowest, max: highest } = *self.cell;
        Aabb { min: min.clamp(lowest, highest), max: max.clamp(lowest, highest) }
    }

    /// Some of them in the coordinates of a frame.
    fn items(
        &self,
        ids: impl ExactSizeIterator<Item = u32>,
        frame: &Frame,
    ) -> Result<Vec<Item>, GridTooLarge> {
        let mut items = with_room_for(ids.len())?;
        items.extend(ids.map(|id| Item::new(frame, &self.box_of(id), id)));
        Ok(items)
    }
}

#[cfg(test)]
mod tests;
