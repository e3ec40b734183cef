//! The primitives of cells and of leaves: blocks of eight triangles, and the ids of the few primitives that are not
//! triangles, cell by cell. Arrays of starts tell which belong to a cell.
//!
//! [`Contents::push`] first lays out the ids only, cell by cell. When all blocks are known, [`Contents::fill`] fills
//! them on all threads.

use crate::base::memory;
use crate::base::patience::{Ended, Patience};
use crate::caster::block::{Block, Frame, LANES, NONE};
use crate::caster::insertion::Reference;
use crate::caster::lattice::{Lattice, NotBuilt};
use crate::world::World;
use rayon::prelude::*;
use std::ops::Range;

/// The bit of a start that marks the border of a lattice, at which a traversal ends.
const BORDER: u32 = 1 << 31;

/// The numbers of cells and of blocks between two questions whether the work should end.
const CELLS_AT_ONCE: usize = 1 << 16;
const BLOCKS_AT_ONCE: usize = 1 << 16;

/// The contents of all cells or leaves.
#[derive(Debug)]
pub struct Contents {
    pub blocks: Vec<Block>,
    /// The first block of each cell, and at the end the number of blocks.
    starts: Vec<u32>,
    /// The ids of the primitives that are not triangles.
    others: Vec<u32>,
    /// The first of the others in each cell, and at the end their number. Empty if there are none.
    other_starts: Vec<u32>,
}

/// The primitives of a cell: its triangles in blocks, and the ids of the others.
pub type Cell<'c> = (&'c [Block], &'c [u32]);

impl Contents {
    /// Returns no contents, and reserves memory for these numbers of cells and blocks.
    pub fn with_capacity(cells: usize, blocks: usize, world: &World) -> Result<Self, NotBuilt> {
        let arrays = if world.shapes.is_empty() { 1 } else { 2 };
        let bytes = blocks * size_of::<Block>() + arrays * (cells + 1) * size_of::<u32>();
        memory::ask(bytes as u64).map_err(|_| NotBuilt::TooLarge)?;
        let starts = || {
            let mut starts = Vec::with_capacity(cells + 1);
            starts.push(0);
            starts
        };
        Ok(Self {
            blocks: Vec::with_capacity(blocks),
            starts: starts(),
            others: vec![],
            other_starts: if world.shapes.is_empty() { vec![] } else { starts() },
        })
    }

    /// Lays out the cells of a lattice by a counting sort.
    pub fn of_cells(
        world: &World,
        lattice: &Lattice,
        references: Vec<Vec<Reference>>,
        patience: &dyn Patience,
    ) -> Result<Self, NotBuilt> {
        // The references have taken some memory since the last check.
        lattice.ask_for_entries()?;
        // Each place is first a count, then the start and finally the end of the cell's ids.
        let mut places = vec![0u32; lattice.index_count()];
        for references in &references {
            patience.check()?;
            references.iter().for_each(|&[cell, _]| places[cell as usize] += 1);
        }
        let blocks: usize = places.iter().map(|count| count.div_ceil(LANES as u32) as usize).sum();
        if blocks >= BORDER as usize {
            return Err(NotBuilt::TooLarge);
        }
        let mut contents = Self::with_capacity(places.len(), blocks, world)?;
        let mut total = 0;
        for place in &mut places {
            total += std::mem::replace(place, total);
        }
        let mut ids = vec![0; total as usize];
        for references in references {
            patience.check()?;
            for [cell, id] in references {
                let place = &mut places[cell as usize];
                ids[*place as usize] = id;
                *place += 1;
            }
        }
        let mut start = 0;
        for ends in places.chunks(CELLS_AT_ONCE) {
            patience.check()?;
            for &end in ends {
                contents.push(world, &ids[start..end as usize]);
                start = end as usize;
            }
        }
        let mut end = 0;
        for run in lattice.x_runs() {
            contents.starts[end..run.start].iter_mut().for_each(|start| *start |= BORDER);
            end = run.end;
        }
        contents.starts[end..places.len()].iter_mut().for_each(|start| *start |= BORDER);
        Ok(contents)
    }

    /// Appends a cell or a leaf with these primitives, which must be in ascending order.
    pub fn push(&mut self, world: &World, ids: &[u32]) {
        let (triangles, others) = ids.split_at(ids.partition_point(|&id| world.is_triangle(id)));
        for some in triangles.chunks(LANES) {
            let mut ids = [NONE; LANES];
            ids[..some.len()].copy_from_slice(some);
            self.blocks.push(Block::new(ids));
        }
        self.starts.push(self.blocks.len() as u32);
        if !self.other_starts.is_empty() {
            self.others.extend_from_slice(others);
            self.other_starts.push(self.others.len() as u32);
        }
    }

    /// Appends a leaf like [`push`](Self::push). It has one block even without triangles, so that its index tells where
    /// the block is.
    pub fn push_leaf(&mut self, world: &World, ids: &[u32]) {
        if !ids.first().is_some_and(|&id| world.is_triangle(id)) {
            self.blocks.push(Block::new([NONE; LANES]));
        }
        self.push(world, ids);
    }

    /// Fills the blocks. Each frame comes with the index of the first block that uses its coordinates.
    pub fn fill(
        &mut self,
        world: &World,
        frames: &[(usize, Frame)],
        patience: &dyn Patience,
    ) -> Result<(), Ended> {
        let ends = frames.iter().skip(1).map(|(start, _)| *start).chain([self.blocks.len()]);
        for ((start, frame), end) in frames.iter().zip(ends.collect::<Vec<_>>()) {
            let fill = |block: &mut Block| block.fill(world, frame);
            for part in self.blocks[*start..end].chunks_mut(BLOCKS_AT_ONCE) {
                patience.check()?;
                part.par_iter_mut().for_each(fill);
            }
        }
        Ok(())
    }

    /// Returns the number of cells or leaves.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns the primitives of a leaf.
    #[inline(always)]
    pub fn leaf(&self, index: usize) -> Cell<'_> {
        (std::slice::from_ref(&self.blocks[index]), self.others_of(index))
    }

    #[inline(always)]
    fn others_of(&self, cell: usize) -> &[u32] {
        match self.other_starts.get(cell..cell + 2) {
            Some([start, end]) => &self.others[*start as usize..*end as usize],
            _ => &[],
        }
    }

    /// Returns the primitives of a cell, or `None` at the border of a lattice.
    #[inline(always)]
    pub fn cell(&self, index: usize) -> Option<Cell<'_>> {
        let [start, end] = self.starts.get(index..index + 2)? else { return None };
        if start & BORDER != 0 {
            return None;
        }
        let blocks = &self.blocks[*start as usize..(end & !BORDER) as usize];
        Some((blocks, self.others_of(index)))
    }

    /// Returns the ids of the primitives of some cells or leaves.
    pub fn primitives_of(&self, cells: Range<usize>) -> impl Iterator<Item = u32> + '_ {
        cells.filter_map(|index| self.cell(index)).flat_map(|(blocks, others)| {
            let triangles = blocks.iter().flat_map(|block| block.ids).filter(|&id| id != NONE);
            triangles.chain(others.iter().copied())
        })
    }
}

#[cfg(test)]
mod tests;
