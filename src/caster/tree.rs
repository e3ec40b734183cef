//! A tree of boxes over the finite primitives: a bounding volume hierarchy with up to eight branches per node and up to
//! eight primitives per leaf.
//!
//! A branch whose primitives are too small for the coordinates of the frame gets a frame of its own.

use crate::base::memory;
use crate::base::patience::Patience;
use crate::caster::block::{Frame, LANES};
use crate::caster::bounds::Region;
use crate::caster::box8::Box8;
use crate::caster::contents::Contents;
use crate::caster::division::{Division, Item};
use crate::caster::lattice::NotBuilt;
use crate::world::World;
use std::ops::Range;

/// A branch of a tree: the index of a node, or an index marked with one of the following bits.
pub type Branch = u32;

/// Marks a leaf. The other bits are its index in the contents.
pub const LEAF: Branch = 1 << 31;

/// Marks a branch with a frame of its own. The other bits are its index among such branches.
pub const SMALL: Branch = 1 << 30;

/// A tree of boxes.
#[derive(Debug, Default)]
pub struct Tree {
    /// The branch that holds everything.
    pub root: Branch,
    pub nodes: Vec<Box8>,
    /// The branches with frames of their own.
    pub small: Vec<Small>,
}

/// A branch with a frame of its own.
#[derive(Debug)]
pub struct Small {
    /// The branch, in the coordinates of its frame.
    pub branch: Branch,
    pub region: Region,
    /// Its leaves.
    pub leaves: Range<usize>,
}

impl Tree {
    /// Builds the tree of these primitives, and the contents of its leaves. The coordinates are in a frame whose box
    /// contains the primitives.
    pub fn new(
        world: &World,
        ids: Vec<u32>,
        frame: Frame,
        patience: &dyn Patience,
    ) -> Result<(Self, Contents), NotBuilt> {
        memory::ask(least_bytes(ids.len())).map_err(|_| NotBuilt::TooLarge)?;
        let division = Division::new((world, patience), ids, &frame, 0)?;
        let contents = Contents::with_capacity(division.leaves(), division.leaves(), world)?;
        let mut growing = Growing { world, tree: Self::default(), contents, frames: vec![(0, frame)] };
        growing.tree.root = growing.add(division, frame);
        let Growing { tree, mut contents, frames, .. } = growing;
        contents.fill(world, &frames, patience)?;
        let fits = tree.nodes.len() <= SMALL as usize && contents.len() <= SMALL as usize;
        if fits { Ok((tree, contents)) } else { Err(NotBuilt::TooLarge) }
    }
}

/// Returns the least memory, in bytes, that dividing this number of primitives takes: if all leaves are full. The memory
/// of the blocks is asked for when the leaves are known.
fn least_bytes(count: usize) -> u64 {
    (count * size_of::<Item>() + count / LANES * size_of::<Division>()) as u64
}

/// A tree that is being built.
struct Growing<'w> {
    world: &'w World,
    tree: Tree,
    contents: Contents,
    /// The frames, each with the index of the first block for which it holds.
    frames: Vec<(usize, Frame)>,
}

impl Growing<'_> {
    /// Adds a branch in the coordinates of a frame.
    fn add(&mut self, division: Division, frame: Frame) -> Branch {
        match division {
            Division::Leaf(ids) => {
                self.contents.push_leaf(self.world, &ids);
                LEAF | (self.contents.len() as Branch - 1)
            }
            Division::Small(small) => {
                let (region, division) = *small;
                let start = self.contents.len();
                self.frames.push((self.contents.blocks.len(), region.frame));
                let branch = self.add(division, region.frame);
                self.frames.push((self.contents.blocks.len(), frame));
                self.tree.small.push(Small { branch, region, leaves: start..self.contents.len() });
                SMALL | (self.tree.small.len() as Branch - 1)
            }
            Division::Node(children) => {
                let index = self.tree.nodes.len();
                self.tree.nodes.push(Box8::EMPTY);
                for (lane, (bounds, child)) in children.into_iter().enumerate() {
                    let branch = self.add(child, frame);
                    self.tree.nodes[index].set(lane, [bounds.min, bounds.max], branch);
                }
                index as Branch
            }
        }
    }
}

#[cfg(test)]
mod tests;
