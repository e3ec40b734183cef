//! The primitives of cells and of leaves, laid out for the inner loop: contiguous blocks of eight triangles, and a list of
//! the few primitives that are not triangles. One 32-bit entry tells which blocks are those of a cell.
//!
//! Only the ids are laid out at first, by [`Ids::push`] cell by cell. The blocks are filled, on all threads, when all
//! of them are known.

use crate::base::memory;
use crate::caster::block::{Block, BlockIndex, Frame, LANES, NONE};
use crate::caster::dda::EMPTY;
use crate::caster::insertion::Reference;
use crate::caster::lattice::{GridTooLarge, Lattice};
use crate::world::World;
use bytemuck::allocation::zeroed_vec;
use rayon::prelude::*;

/// Number of low bits of an entry that hold the number of the cell's blocks, so that the traversal need not
/// load the first block to know it.
const COUNT_BITS: u32 = 4;
/// The largest number of blocks that fits into an entry. It means this number or more, and the first block
/// then holds the exact number.
const MAX_COUNT: u32 = (1 << COUNT_BITS) - 1;
/// No entry of a cell with blocks has this bit, which that of a [`BORDER`](crate::caster::dda::BORDER) has.
pub const NO_BLOCKS: u32 = 1 << 31;

/// The contents of all cells or leaves.
#[derive(Debug)]
pub struct Contents {
    pub blocks: Vec<Block>,
    /// The ids of the primitives that are not triangles, cell by cell. The last block of a cell holds the range of its
    /// own.
    non_triangles: Vec<u32>,
}

impl Contents {
    /// Returns the blocks of the cell with this entry, which must be that of a cell with blocks.
    #[inline(always)]
    pub fn blocks_of(&self, entry: u32) -> &[Block] {
        let first = (entry >> COUNT_BITS) as usize;
        let count = entry & MAX_COUNT;
        let count = if count < MAX_COUNT { count } else { self.blocks[first].index.count };
        &self.blocks[first..first + count as usize]
    }

    /// Returns those of a cell's blocks that have triangles. A cell without any has a block as well, for its other
    /// primitives.
    #[inline(always)]
    pub fn with_triangles<'b>(&self, blocks: &'b [Block]) -> &'b [Block] {
        match blocks {
            // Most worlds need not read the block for this.
            [only] if self.has_non_triangles() && only.index.ids[0] == NONE => &[],
            _ => blocks,
        }
    }

    /// Whether any cell has primitives other than triangles.
    #[inline(always)]
    pub fn has_non_triangles(&self) -> bool {
        !self.non_triangles.is_empty()
    }

    /// Returns the ids of the primitives other than triangles in a cell of these blocks.
    #[inline(always)]
    pub fn non_triangles_in(&self, blocks: &[Block]) -> &[u32] {
        blocks.last().map_or(&[], |last| {
            let [start, end] = last.index.non_triangles;
            &self.non_triangles[start as usize..end as usize]
        })
    }

    /// Returns the ids of the primitives of a leaf: the triangles, and then the others.
    pub fn primitives_of<'a>(&'a self, block: &'a Block) -> impl Iterator<Item = u32> + 'a {
        let triangles = block.index.ids.into_iter().take_while(|&id| id != NONE);
        triangles.chain(self.non_triangles_in(std::slice::from_ref(block)).iter().copied())
    }

    /// Returns the number of primitives in these blocks; one counts for each cell that it is in.
    pub fn references(blocks: &[Block]) -> usize {
        let non_triangles = |[start, end]: [u32; 2]| (end - start) as usize;
        blocks.iter().map(|block| block.index.triangles() + non_triangles(block.index.non_triangles)).sum()
    }
}

/// The ids in the contents that are being laid out.
pub struct Ids<'w> {
    world: &'w World,
    indices: Vec<BlockIndex>,
    non_triangles: Vec<u32>,
}

impl<'w> Ids<'w> {
    /// Starts without cells, with memory for this number of blocks.
    pub fn new(world: &'w World, blocks: usize) -> Result<Self, GridTooLarge> {
        let bytes = blocks * (size_of::<BlockIndex>() + size_of::<Block>());
        memory::ask(bytes as u64).map_err(|_| GridTooLarge)?;
        Ok(Self { world, indices: Vec::with_capacity(blocks), non_triangles: vec![] })
    }

    /// Lays out the cells of a lattice by a counting sort, and returns the entries by index of the lattice: those of cells
    /// without primitives are [`EMPTY`].
    pub fn of_cells(
        world: &'w World,
        lattice: &Lattice,
        references: Vec<Vec<Reference>>,
    ) -> Result<(Self, Vec<u32>), GridTooLarge> {
        // The references have taken some memory since.
        lattice.ask_for_entries()?;
        // Each entry is a count at first, then the start and then the end of the cell's ids.
        let mut entries = vec![0u32; lattice.index_count()];
        references.iter().flatten().for_each(|&[cell, _]| entries[cell as usize] += 1);
        let blocks = entries.iter().map(|count| count.div_ceil(LANES as u32) as usize).sum();
        if blocks > (NO_BLOCKS >> COUNT_BITS) as usize {
            return Err(GridTooLarge);
        }
        let mut cells = Self::new(world, blocks)?;
        let mut total = 0;
        for entry in &mut entries {
            total += std::mem::replace(entry, total);
        }
        let mut ids = vec![0; total as usize];
        for [cell, id] in references.into_iter().flatten() {
            let place = &mut entries[cell as usize];
            ids[*place as usize] = id;
            *place += 1;
        }
        let mut start = 0;
        for entry in &mut entries {
            let end = *entry as usize;
            *entry = if start == end { EMPTY } else { cells.push(&ids[start..end]) };
            start = end;
        }
        Ok((cells, entries))
    }

    /// Appends the blocks of a cell or a leaf with these primitives, which are in ascending order, and returns the entry.
    pub fn push(&mut self, ids: &[u32]) -> u32 {
        let (triangles, others) = ids.split_at(ids.partition_point(|&id| self.world.is_triangle(id)));
        let (first, start) = (self.indices.len(), self.non_triangles.len() as u32);
        self.non_triangles.extend_from_slice(others);
        // A cell without triangles needs a block as well, which holds the range of its other primitives.
        for block in 0..triangles.len().div_ceil(LANES).max(1) {
            let own = &triangles[block * LANES..triangles.len().min((block + 1) * LANES)];
            let mut index = BlockIndex::EMPTY;
            index.ids[..own.len()].copy_from_slice(own);
            self.indices.push(index);
        }
        let count = (self.indices.len() - first) as u32;
        self.indices[first].count = count;
        if let Some(last) = self.indices.last_mut() {
            last.non_triangles = [start, self.non_triangles.len() as u32];
        }
        (first as u32) << COUNT_BITS | count.min(MAX_COUNT)
    }

    /// Fills the blocks, with the coordinates of each of the frames from its first block on.
    pub fn fill(self, frames: &[(usize, Frame)]) -> Contents {
        let Self { world, indices, non_triangles } = self;
        let mut blocks: Vec<Block> = zeroed_vec(indices.len());
        let ends = frames.iter().skip(1).map(|(start, _)| *start).chain([indices.len()]);
        for ((start, frame), end) in frames.iter().zip(ends) {
            let all_in_frame = frame.holds(&world.bounds);
            let zeroed = blocks[*start..end].par_iter_mut();
            zeroed
                .zip(&indices[*start..end])
                .for_each(|(block, index)| block.fill(world, frame, all_in_frame, index));
        }
        Contents { blocks, non_triangles }
    }
}

#[cfg(test)]
mod tests;
