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
use division::{Bounds, Group, Item, children};

mod division;

/// A branch of a tree is a node with this index, or has one of the following bits.
pub type Branch = u32;

/// The branch is a leaf, and the other bits are the index of its block.
pub const LEAF: Branch = 1 << 31;

/// The branch has a frame of its own, and the other bits are its index among such branches.
pub const SMALL: Branch = 1 << 30;

/// Upper bound on the number of nodes on the way from a root to a leaf: [`HEURISTIC_LEVELS`], and the 13 levels that
/// 2^32 primitives need if each node has at most 14 more than an eighth of the primitives above it.
pub const MAX_LEVELS: usize = HEURISTIC_LEVELS + 13;

/// The number of levels that are divided by the heuristic. Below them the primitives are divided by their number, which
/// bounds the depth of trees of primitives that the heuristic does not divide evenly.
const HEURISTIC_LEVELS: usize = 12;

/// The tree of one cell.
#[derive(Debug)]
pub struct Bvh {
    /// Everything in the cell.
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
    /// The tree of primitives in the coordinates of a frame, whose box contains them.
    pub fn new(world: &World, ids: &[u32], frame: &Frame) -> Result<Self, GridTooLarge> {
        let (nodes, leaves, small, frames) = (vec![], vec![], vec![], vec![(0, *frame)]);
        let mut bvh = Self { root: 0, nodes, leaves, small, frames };
        let mut items = items_of(world, ids.iter().copied(), frame)?;
        bvh.root = bvh.add(world, Group::new(&mut items), frame, 0)?;
        Ok(bvh)
    }

    /// Adds a branch with these items, with so many levels above it.
    fn add(
        &mut self,
        world: &World,
        group: Group,
        frame: &Frame,
        level: usize,
    ) -> Result<Branch, GridTooLarge> {
        if group.items.len() <= LANES {
            self.add_leaf(group.items)
        } else if level < HEURISTIC_LEVELS && group.is_small {
            self.add_small(world, group.items, frame, level)
        } else {
            self.add_node(world, group.items, frame, level)
        }
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
        world: &World,
        items: &[Item],
        outer: &Frame,
        level: usize,
    ) -> Result<Branch, GridTooLarge> {
        let boxes = items.iter().map(|item| world.box_of(item.id));
        let bounds = widened(boxes.fold(Aabb::EMPTY, |all, bounds| all.union(bounds)));
        let frame = Frame::new(&bounds);
        self.set_frame(frame)?;
        let mut items = items_of(world, items.iter().map(|item| item.id), &frame)?;
        let branch = self.add_node(world, &mut items, &frame, level + 1)?;
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

    fn add_node(
        &mut self,
        world: &World,
        items: &mut [Item],
        frame: &Frame,
        level: usize,
    ) -> Result<Branch, GridTooLarge> {
        let index = self.nodes.len();
        memory::push(&mut self.nodes, Box8::EMPTY).map_err(|_| GridTooLarge)?;
        for (lane, group) in children(items, level >= HEURISTIC_LEVELS).into_iter().enumerate() {
            let Bounds { min, max } = group.bounds;
            let branch = self.add(world, group, frame, level + 1)?;
            self.nodes[index].set(lane, [min.to_array(), max.to_array()], branch);
        }
        Ok(index as u32)
    }

    /// Adds to the indices in its branches the numbers of what comes before it in the lists of all trees. An error if
    /// an index does not fit.
    pub fn shift(&mut self, nodes: usize, leaves: usize, small: usize) -> Result<(), GridTooLarge> {
        let fits = nodes + self.nodes.len() <= SMALL as usize
            && small + self.small.len() <= SMALL as usize
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

/// Primitives in the coordinates of a frame.
fn items_of(
    world: &World,
    ids: impl ExactSizeIterator<Item = u32>,
    frame: &Frame,
) -> Result<Vec<Item>, GridTooLarge> {
    let mut items = with_room_for(ids.len())?;
    items.extend(ids.map(|id| Item::new(frame, &world.box_of(id), id)));
    Ok(items)
}

#[cfg(test)]
mod tests;
