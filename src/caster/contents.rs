//! The primitives of cells and of leaves, laid out for the inner loop: contiguous blocks of eight triangles, and a list
//! of the few primitives that are not triangles. One 32-bit entry encodes the position and the number of a cell's
//! blocks.
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

/// The number of low bits of an entry that hold the number of the cell's blocks, so that the traversal need not load
/// the first block to know it.
const COUNT_BITS: u32 = 4;
/// The largest number of blocks that fits into an entry. It means this number or more, and the first block
/// then holds the exact number.
const MAX_COUNT: u32 = (1 << COUNT_BITS) - 1;
/// The entry of an empty cell.
pub const EMPTY: u32 = 0;
/// The entry of every border cell, at which the traversal ends.
const BORDER: u32 = u32::MAX;
/// The bit that [`BORDER`] has and the entry of a cell with blocks never has.
pub const NO_BLOCKS: u32 = 1 << 31;

/// The numbers of cells and of blocks between two questions whether the work should end.
const CELLS_AT_ONCE: usize = 1 << 16;
const BLOCKS_AT_ONCE: usize = 1 << 16;

/// The contents of all cells or leaves.
#[derive(Debug)]
pub struct Contents {
    pub blocks: Vec<Block>,
    /// The ids of the primitives that are not triangles, cell by cell. The last block of a cell holds the cell's range
    /// in this list.
    non_triangles: Vec<u32>,
}

impl Contents {
    /// Returns the blocks of the cell with this entry. The cell must have blocks.
    #[inline(always)]
    pub fn blocks_of(&self, entry: u32) -> &[Block] {
        let first = (entry >> COUNT_BITS) as usize;
        let count = entry & MAX_COUNT;
        let count = if count < MAX_COUNT { count } else { self.blocks[first].count };
        &self.blocks[first..first + count as usize]
    }

    /// Returns the blocks of a cell that have triangles. A cell without triangles also has a block, for its other
    /// primitives.
    #[inline(always)]
    pub fn with_triangles<'b>(&self, blocks: &'b [Block]) -> &'b [Block] {
        match blocks {
            // Most worlds do not need to read the block for this.
            [only] if self.has_non_triangles() && only.ids[0] == NONE => &[],
            _ => blocks,
        }
    }

    /// Returns true if any cell has primitives other than triangles.
    #[inline(always)]
    pub fn has_non_triangles(&self) -> bool {
        !self.non_triangles.is_empty()
    }

    /// Returns the ids of the primitives other than triangles in a cell of these blocks.
    #[inline(always)]
    pub fn non_triangles_in(&self, blocks: &[Block]) -> &[u32] {
        blocks.last().map_or(&[], |last| {
            let [start, end] = last.non_triangles;
            &self.non_triangles[start as usize..end as usize]
        })
    }

    /// Returns the ids of the primitives of whole cells or leaves: the triangles, and then the others.
    pub fn primitives_of<'a>(&'a self, blocks: &'a [Block]) -> impl Iterator<Item = u32> + 'a {
        let triangles = blocks.iter().flat_map(|block| block.ids).filter(|&id| id != NONE);
        let others = blocks.iter().flat_map(|block| self.non_triangles_in(std::slice::from_ref(block)));
        triangles.chain(others.copied())
    }

    /// Returns no contents, and reserves memory for this number of blocks.
    pub fn with_capacity(blocks: usize) -> Result<Self, NotBuilt> {
        memory::ask((blocks * size_of::<Block>()) as u64).map_err(|_| NotBuilt::TooLarge)?;
        Ok(Self { blocks: Vec::with_capacity(blocks), non_triangles: vec![] })
    }

    /// Lays out the cells of a lattice by a counting sort, and returns the entries by index of the lattice, including
    /// the border.
    pub fn of_cells(
        world: &World,
        lattice: &Lattice,
        references: Vec<Vec<Reference>>,
        patience: &dyn Patience,
    ) -> Result<(Self, Vec<u32>), NotBuilt> {
        // The references have taken some memory since the last check.
        lattice.ask_for_entries()?;
        // Each entry is first a count, then the start and finally the end of the cell's ids.
        let mut entries = vec![0u32; lattice.index_count()];
        for references in &references {
            patience.check()?;
            references.iter().for_each(|&[cell, _]| entries[cell as usize] += 1);
        }
        let blocks = entries.iter().map(|count| count.div_ceil(LANES as u32) as usize).sum();
        if blocks > (NO_BLOCKS >> COUNT_BITS) as usize {
            return Err(NotBuilt::TooLarge);
        }
        let mut cells = Self::with_capacity(blocks)?;
        let mut total = 0;
        for entry in &mut entries {
            total += std::mem::replace(entry, total);
        }
        let mut ids = vec![0; total as usize];
        for references in references {
            patience.check()?;
            for [cell, id] in references {
                let place = &mut entries[cell as usize];
                ids[*place as usize] = id;
                *place += 1;
            }
        }
        let mut start = 0;
        for part in entries.chunks_mut(CELLS_AT_ONCE) {
            patience.check()?;
            for entry in part {
                let end = *entry as usize;
                *entry = if start == end { EMPTY } else { cells.push(world, &ids[start..end]) };
                start = end;
            }
        }
        let mut end = 0;
        for run in lattice.x_runs() {
            entries[end..run.start].fill(BORDER);
            end = run.end;
        }
        entries[end..].fill(BORDER);
        Ok((cells, entries))
    }

    /// Appends the blocks of a cell or a leaf with these primitives, which must be in ascending order, and returns its
    /// entry.
    pub fn push(&mut self, world: &World, ids: &[u32]) -> u32 {
        let (triangles, others) = ids.split_at(ids.partition_point(|&id| world.is_triangle(id)));
        let (first, start) = (self.blocks.len(), self.non_triangles.len() as u32);
        self.non_triangles.extend_from_slice(others);
        // A cell without triangles also needs a block, which holds the range of its other primitives.
        for block in 0..triangles.len().div_ceil(LANES).max(1) {
            let own = &triangles[block * LANES..triangles.len().min((block + 1) * LANES)];
            let mut ids = [NONE; LANES];
            ids[..own.len()].copy_from_slice(own);
            self.blocks.push(Block::new(ids));
        }
        let count = (self.blocks.len() - first) as u32;
        self.blocks[first].count = count;
        if let Some(last) = self.blocks.last_mut() {
            last.non_triangles = [start, self.non_triangles.len() as u32];
        }
        (first as u32) << COUNT_BITS | count.min(MAX_COUNT)
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
            let all_in_frame = frame.holds(&world.bounds);
            let fill = |block: &mut Block| block.fill(world, frame, all_in_frame);
            for part in self.blocks[*start..end].chunks_mut(BLOCKS_AT_ONCE) {
                patience.check()?;
                part.par_iter_mut().for_each(fill);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
