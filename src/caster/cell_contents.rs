//! The contents of the cells, laid out for the inner loop: one 32-bit entry per cell, contiguous blocks of
//! eight triangles, and a list of the few primitives that are not triangles. They are built from the
//! [`CellLists`] by a counting sort in two passes, count and fill. The leaves of a tree are such blocks, too. Only the
//! indices of the blocks are made at first, and the blocks are filled when all of them are known.

use crate::base::memory;
use crate::caster::blocks::triangle8::{Block, BlockIndex, Frame, LANES, NONE};
use crate::caster::error::GridTooLarge;
use crate::caster::grid::cell_lists::CellLists;
use crate::caster::grid::cell_table::EMPTY;
use crate::caster::grid::lattice::Lattice;
use crate::caster::tree::Leaves;
use crate::world::World;
use rayon::prelude::*;
use std::ops::Range;

/// Number of low bits of an entry that hold the number of the cell's blocks, so that the traversal need not
/// load the first block to know it.
const COUNT_BITS: u32 = 4;
/// The largest number of blocks that fits into an entry. It means this number or more, and the first block
/// then holds the exact number.
const MAX_COUNT: u32 = (1 << COUNT_BITS) - 1;
/// No entry of a cell with blocks has this bit, which that of a [`BORDER`](crate::caster::grid::cell_table::BORDER) has.
pub const NO_BLOCKS: u32 = 1 << 31;

/// The contents of all cells. The entry of a cell with primitives holds the index of its first block and the
/// number of its blocks, which are contiguous. Other entries are [`EMPTY`].
#[derive(Debug)]
pub struct CellContents {
    /// By index of the lattice, until [`take_entries`](Self::take_entries) moves them out.
    entries: Vec<u32>,
    /// The indices of the blocks, cell by cell, until [`fill`](Self::fill) has copied them to the blocks.
    indices: Vec<BlockIndex>,
    /// The ids of the other primitives, cell by cell. The last block of a cell holds the range of its own.
    non_triangles: Vec<u32>,
    /// The coordinates of the blocks of cells.
    pub frame: Frame,
    /// From which blocks on which coordinates hold.
    frames: Vec<(usize, Frame)>,
}

impl CellContents {
    /// Lays out the primitives of the cells of a lattice. Those of each cell are in ascending order.
    pub fn new(world: &World, lattice: &Lattice, cell_lists: &CellLists) -> Result<Self, GridTooLarge> {
        let triangles = world.triangles.len();
        let non_triangles = triangles..world.finite_count();
        // The lists of the cells have taken some memory since.
        lattice.ask_for_entries()?;
        // What `entries` holds changes with each step: lane counts, ends of lanes, starts of lanes, entries.
        let mut entries = counts(lattice, cell_lists, triangles, non_triangles.clone());
        let blocks = to_ends(lattice, &mut entries)? / LANES;
        ask_for_blocks(blocks)?;
        let mut indices = vec![BlockIndex::EMPTY; blocks];
        scatter(cell_lists, triangles, &mut entries, &mut indices);
        let mut cells = Self::of_indices(indices, Frame::new(&lattice.bounds));
        cells.encode_entries(entries, lattice);
        cells.add_non_triangles(cell_lists, non_triangles);
        Ok(cells)
    }

    /// Moves out the entries, by index of the lattice that the contents were built for.
    pub fn take_entries(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.entries)
    }

    /// The number of blocks, until [`fill`](Self::fill) has copied their indices.
    pub fn block_count(&self) -> usize {
        self.indices.len()
    }

    /// The blocks of the cell with this entry, which must be that of a cell with blocks.
    #[inline(always)]
    pub fn blocks_of(blocks: &[Block], entry: u32) -> &[Block] {
        let first = (entry >> COUNT_BITS) as usize;
        let count = entry & MAX_COUNT;
        let count = if count < MAX_COUNT { count } else { blocks[first].index.count };
        &blocks[first..first + count as usize]
    }

    /// Those of a cell's blocks that have triangles. A cell without any has a block as well, for its other primitives.
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

    /// The ids of the primitives other than triangles in a cell of these blocks.
    #[inline(always)]
    pub fn non_triangles_in(&self, blocks: &[Block]) -> &[u32] {
        blocks.last().map_or(&[], |last| self.non_triangles_of(&last.index))
    }

    /// The ids of the primitives other than triangles of a block.
    #[inline(always)]
    fn non_triangles_of(&self, index: &BlockIndex) -> &[u32] {
        let [start, end] = index.non_triangles;
        &self.non_triangles[start as usize..end as usize]
    }

    /// The ids of the primitives of a block: the triangles, and then the others.
    pub fn primitives_of(&self, block: &Block) -> impl Iterator<Item = u32> {
        let triangles = block.index.ids.into_iter().take_while(|&id| id != NONE);
        triangles.chain(self.non_triangles_of(&block.index).iter().copied())
    }

    /// All primitives in a single cell, or only those that rays may hit.
    pub fn all(world: &World, frame: Frame, hittable: bool) -> Self {
        let triangles = world.triangles.len();
        let listed =
            if hittable { world.hittable_count() - (world.finite_count() - triangles) } else { triangles };
        let mut indices = vec![BlockIndex::EMPTY; listed.div_ceil(LANES).max(1)];
        let lanes = indices.iter_mut().flat_map(|index| &mut index.ids);
        let ids = (0..triangles as u32).filter(|&id| !hittable || world.may_be_hit(id));
        lanes.zip(ids).for_each(|(lane, id)| *lane = id);
        let mut cells = Self::of_indices(indices, frame);
        let last = cells.block_count() - 1;
        let non_triangles = triangles..world.finite_count();
        cells.set_non_triangles(non_triangles.map(|id| (last as u32, id as u32)).collect());
        cells
    }

    /// The number of references to primitives in these blocks.
    pub fn references(blocks: &[Block]) -> usize {
        let non_triangles = |[start, end]: [u32; 2]| (end - start) as usize;
        blocks.iter().map(|block| block.index.triangles() + non_triangles(block.index.non_triangles)).sum()
    }

    /// The leaves of a tree, a block for each.
    pub fn of_leaves(world: &World, Leaves { ids, frames }: &Leaves) -> Result<Self, GridTooLarge> {
        let (_, frame) = frames[0];
        ask_for_blocks(ids.len())?;
        let mut cells = Self::of_indices(Vec::with_capacity(ids.len()), frame);
        for &(leaf, frame) in frames {
            if cells.frames.last().is_none_or(|(_, last)| *last != frame) {
                cells.frames.push((leaf, frame));
            }
        }
        for leaf in ids {
            let [triangles, end] =
                [world.triangles.len() as u32, NONE].map(|id| leaf.partition_point(|&i| i < id));
            let mut index = BlockIndex { count: 1, ..BlockIndex::EMPTY };
            index.ids[..triangles].copy_from_slice(&leaf[..triangles]);
            if triangles < end {
                let others = cells.non_triangles.len() as u32;
                index.non_triangles = [others, others + (end - triangles) as u32];
                cells.non_triangles.extend_from_slice(&leaf[triangles..end]);
            }
            cells.indices.push(index);
        }
        Ok(cells)
    }

    /// Contents with blocks of these indices, whose entries and counts are still to be set.
    fn of_indices(indices: Vec<BlockIndex>, frame: Frame) -> Self {
        Self { entries: vec![], indices, non_triangles: vec![], frame, frames: vec![(0, frame)] }
    }

    /// Fills the blocks, which are zeroed and as many as [`block_count`](Self::block_count).
    pub fn fill(&mut self, world: &World, blocks: &mut [Block]) {
        let indices = std::mem::take(&mut self.indices);
        let ends = self.frames.iter().skip(1).map(|(start, _)| *start).chain([indices.len()]);
        for ((start, frame), end) in self.frames.iter().zip(ends) {
            let all_in_frame = frame.holds(&world.bounds);
            let zeroed = blocks[*start..end].par_iter_mut();
            zeroed
                .zip(&indices[*start..end])
                .for_each(|(block, index)| block.fill(world, frame, all_in_frame, index));
        }
    }

    /// Sets the counts of the blocks, and turns the position of each cell's first lane into its entry.
    fn encode_entries(&mut self, mut entries: Vec<u32>, lattice: &Lattice) {
        let indices = &mut self.indices;
        let mut end = indices.len() as u32;
        for run in lattice.x_runs().rev() {
            for entry in entries[run].iter_mut().rev().filter(|entry| **entry != EMPTY) {
                let first = *entry / LANES as u32 - 1;
                let count = end - first;
                indices[first as usize].count = count;
                *entry = first << COUNT_BITS | count.min(MAX_COUNT);
                end = first;
            }
        }
        self.entries = entries;
    }

    /// Adds the primitives that are not triangles, which have these ids.
    fn add_non_triangles(&mut self, cell_lists: &CellLists, non_triangles: Range<usize>) {
        let references = non_triangles.clone().map(|id| cell_lists.cells_of(id).len()).sum();
        let mut by_block = Vec::with_capacity(references);
        for id in non_triangles {
            by_block.extend(cell_lists.cells_of(id).iter().map(|&cell| (self.last_block(cell), id as u32)));
        }
        by_block.sort_unstable();
        self.set_non_triangles(by_block);
    }

    /// The indices of the blocks of the cell with this entry, which must be that of a cell with blocks.
    fn range(&self, entry: u32) -> Range<usize> {
        let first = (entry >> COUNT_BITS) as usize;
        first..first + self.indices[first].count as usize
    }

    /// The index of the last block of a cell that has blocks.
    fn last_block(&self, cell: u32) -> u32 {
        self.range(self.entries[cell as usize]).end as u32 - 1
    }

    /// Stores primitives that are not triangles, given as pairs of the cell's last block and the primitive's
    /// id in ascending order.
    fn set_non_triangles(&mut self, by_block: Vec<(u32, u32)>) {
        self.non_triangles.reserve_exact(by_block.len());
        let indices = &mut self.indices;
        for (&(block, id), i) in by_block.iter().zip(0..) {
            let index = &mut indices[block as usize];
            if index.non_triangles == [0, 0] {
                index.non_triangles[0] = i;
            }
            index.non_triangles[1] = i + 1;
            self.non_triangles.push(id);
        }
    }
}

/// Asks for the memory of so many blocks and of their indices.
fn ask_for_blocks(count: usize) -> Result<(), GridTooLarge> {
    let bytes = count * (size_of::<BlockIndex>() + size_of::<Block>());
    memory::ask(bytes as u64).map_err(|_| GridTooLarge)
}

/// The number of lanes that each cell needs.
fn counts(
    lattice: &Lattice,
    cell_lists: &CellLists,
    triangles: usize,
    non_triangles: Range<usize>,
) -> Vec<u32> {
    let mut counts = vec![0u32; lattice.index_count()];
    for &cell in cell_lists.cells_below(triangles).flatten() {
        counts[cell as usize] += 1;
    }
    // A cell without triangles also needs a block, which holds the range of its other primitives.
    for &cell in non_triangles.flat_map(|id| cell_lists.cells_of(id)) {
        counts[cell as usize] = counts[cell as usize].max(1);
    }
    counts
}

/// Upper bound on the end of a cell's lanes, so that the index of every block fits into an entry below
/// [`NO_BLOCKS`].
const MAX_LANE_END: u32 = (NO_BLOCKS >> COUNT_BITS) * LANES as u32;

/// Turns the count of each cell into the position where its lanes end, and returns the number of all lanes.
/// The lanes of each cell start a new block. Positions are offset by one block, so that none of them equals
/// [`EMPTY`].
fn to_ends(lattice: &Lattice, counts: &mut [u32]) -> Result<usize, GridTooLarge> {
    let mut next = LANES as u64;
    for run in lattice.x_runs() {
        for count in counts[run].iter_mut().filter(|count| **count > 0) {
            let end = next + *count as u64;
            next = end.next_multiple_of(LANES as u64);
            *count = u32::try_from(end).ok().filter(|&end| end <= MAX_LANE_END).ok_or(GridTooLarge)?;
        }
    }
    Ok(next as usize - LANES)
}

/// Writes the ids of the triangles backwards from the `ends` of their cells, which thereby become the starts.
/// The end of a cell without triangles stays as it is, in the cell's only block.
fn scatter(cell_lists: &CellLists, triangles: usize, ends: &mut [u32], indices: &mut [BlockIndex]) {
    for id in (0..triangles).rev() {
        for &cell in cell_lists.cells_of(id) {
            let position = &mut ends[cell as usize];
            *position -= 1;
            let lane = *position as usize - LANES;
            indices[lane / LANES].ids[lane % LANES] = id as u32;
        }
    }
}

#[cfg(test)]
mod tests;
