//! The trees of a grid's crowded cells. Their nodes are in one list and their leaves are blocks of the grid, because
//! long lists are in large pages.

use super::box8::Box8;
use super::bvh::{Branch, Bvh, LEAF, SMALL, Small};
use super::cell_contents::CellContents;
use super::cell_lists::with_room_for;
use super::error::GridTooLarge;
use super::fitting::padding;
use super::lattice::Lattice;
use crate::math::prefetch::prefetch;
use crate::world::World;
use rayon::prelude::*;

/// The trees of all crowded cells of a grid.
#[derive(Debug, Default)]
pub struct Trees {
    /// The nodes of all trees.
    pub nodes: Vec<Box8>,
    /// The branches of all trees that have frames of their own.
    pub small: Vec<Small>,
}

impl Trees {
    /// Builds the trees of crowded cells, given by the ids of their primitives. The contents of the grid's cells get
    /// the leaves and the entries.
    pub fn new(
        world: &World,
        lattice: &Lattice,
        crowded: &[(u32, Vec<u32>)],
        cells: &mut CellContents,
    ) -> Result<Self, GridTooLarge> {
        let padding = padding(lattice);
        let grown = crowded.par_iter().map(|(cell, ids)| {
            let cell = lattice.box_of(*cell as usize, padding);
            Bvh::new(world, ids, &cells.frame, &cell)
        });
        let grown = grown.collect::<Result<Vec<_>, _>>()?;
        let mut trees = Self {
            nodes: with_room_for(grown.iter().map(|bvh| bvh.nodes.len()).sum())?,
            small: with_room_for(grown.iter().map(|bvh| bvh.small.len()).sum())?,
        };
        for ((cell, _), mut bvh) in crowded.iter().zip(grown) {
            let first_leaf = cells.append_leaves(world, &bvh.leaves, &bvh.frames)?;
            bvh.shift(trees.nodes.len(), first_leaf, trees.small.len())?;
            cells.link_tree(*cell, bvh.root);
            trees.nodes.append(&mut bvh.nodes);
            trees.small.append(&mut bvh.small);
        }
        Ok(trees)
    }

    /// Whether there are none.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Prefetches a branch that is a node.
    #[inline(always)]
    pub fn prefetch_node(&self, branch: Branch) {
        if let Some(node) = self.nodes.get(branch as usize) {
            prefetch(node);
        }
    }

    /// Whether a condition holds for the block of any leaf of a branch. The leaves after it are not visited.
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
