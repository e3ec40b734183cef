//! What stands in each cell, laid out for the loop that reads it: one word a cell, blocks of eight
//! triangles one after the other, and a list of the few primitives that are no triangles.

use super::cell_table::EMPTY;
use super::prim_set::PrimSet;
use super::triangle8::{Block, Frame, LANES, NONE};
use crate::grid::Lattice;
use crate::grid::cell_lists::{CellLists, GridTooLarge, filled_with, with_room_for};
use crate::world::World;
use bytemuck::allocation::try_zeroed_vec;
use rayon::prelude::*;
use std::ops::Range;

/// A word's lowest bits say how many blocks its cell has, so that nobody waits for the blocks to know
/// it; this many where there are as many or more.
const MANY_BLOCKS: u32 = (1 << COUNT_BITS) - 1;
const COUNT_BITS: u32 = 4;
/// From this word on up to the next one a word names a grid of the cell's own, the first one by this.
pub const NESTED: u32 = 1 << 31;

/// The cells' contents. A word names the cell's first block and says how many follow one another from
/// there, or is one of those above.
#[derive(Debug)]
pub struct CellContents {
    /// Until they are handed over.
    entries: Vec<u32>,
    pub blocks: Vec<Block>,
    /// The primitives that are no triangles, cell by cell: each cell's last block says which are its own.
    pub non_triangles: Vec<u32>,
    pub frame: Frame,
}

impl CellContents {
    /// Lays out the primitives of a lattice's cells, each cell's in the order of their numbers.
    pub fn new(
        world: &World,
        lattice: &Lattice,
        cell_lists: &CellLists,
        prims: &PrimSet,
    ) -> Result<Self, GridTooLarge> {
        let triangles = prims.triangles(world);
        let non_triangles = triangles..prims.count(world);
        let mut entries = counts(lattice, cell_lists, triangles, non_triangles.clone())?;
        let lanes = to_ends(lattice, &mut entries)?;
        let mut ids = filled_with([NONE; LANES], lanes / LANES)?;
        scatter(cell_lists, prims, triangles, &mut entries, ids.as_flattened_mut());
        let mut cells = Self::of_ids(world, ids, Frame::new(&lattice.bounds))?;
        cells.finish(entries, lattice);
        cells.add_non_triangles(cell_lists, prims, non_triangles)?;
        Ok(cells)
    }

    /// Hands over the words, by index of the lattice that the cells were made for.
    pub fn take_entries(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.entries)
    }

    /// The first block of the cell with this word, if there is one.
    #[inline(always)]
    pub fn first_block(blocks: &[Block], entry: u32) -> Option<&Block> {
        if entry < NESTED && entry != EMPTY { blocks.get((entry >> COUNT_BITS) as usize) } else { None }
    }

    /// The blocks of the cell with this word, which is none of those that stand for something else.
    #[inline(always)]
    pub fn blocks_of(blocks: &[Block], entry: u32) -> &[Block] {
        let first = (entry >> COUNT_BITS) as usize;
        let count = entry & MANY_BLOCKS;
        let count = if count < MANY_BLOCKS { count } else { blocks[first].count };
        &blocks[first..first + count as usize]
    }

    /// Everything in one cell.
    pub fn all(world: &World, prims: &PrimSet, frame: Frame) -> Result<Self, GridTooLarge> {
        let triangles = prims.triangles(world);
        let mut ids = filled_with([NONE; LANES], triangles.div_ceil(LANES).max(1))?;
        let lanes = ids.as_flattened_mut().iter_mut();
        lanes.zip(0..triangles).for_each(|(lane, i)| *lane = prims.id(i));
        let mut cells = Self::of_ids(world, ids, frame)?;
        let last = cells.blocks.len() - 1;
        let non_triangles = triangles..prims.count(world);
        cells.note_non_triangles(non_triangles.map(|i| (last as u32, prims.id(i))).collect())?;
        Ok(cells)
    }

    /// How many primitives stand in all cells, each as often as it does.
    pub fn references(&self) -> usize {
        let ids = self.blocks.iter().flat_map(|block| &block.ids);
        ids.filter(|&&id| id != NONE).count() + self.non_triangles.len()
    }

    /// Lets the words of these cells, which are empty so far, name grids from the first one on.
    pub fn link_nested(&mut self, cells: impl Iterator<Item = u32>) {
        for (entry, cell) in (NESTED..).zip(cells) {
            self.entries[cell as usize] = entry;
        }
    }

    /// Blocks of these triangles, which do not say yet how many their cells have.
    fn of_ids(world: &World, ids: Vec<[u32; LANES]>, frame: Frame) -> Result<Self, GridTooLarge> {
        let mut blocks: Vec<Block> = try_zeroed_vec(ids.len()).map_err(|()| GridTooLarge)?;
        let all_within = frame.holds(&world.bounds);
        let empty = blocks.par_iter_mut();
        empty.zip(&ids).for_each(|(block, ids)| block.fill(world, &frame, all_within, ids));
        Ok(Self { entries: vec![], blocks, non_triangles: vec![], frame })
    }

    /// Turns the place of each cell's first lane into its word.
    fn finish(&mut self, mut entries: Vec<u32>, lattice: &Lattice) {
        let blocks = &mut self.blocks;
        let mut end = blocks.len() as u32;
        for run in lattice.x_runs().rev() {
            for entry in entries[run].iter_mut().rev().filter(|entry| **entry != EMPTY) {
                let first = *entry / LANES as u32 - 1;
                let count = end - first;
                blocks[first as usize].count = count;
                *entry = first << COUNT_BITS | count.min(MANY_BLOCKS);
                end = first;
            }
        }
        self.entries = entries;
    }

    fn add_non_triangles(
        &mut self,
        cell_lists: &CellLists,
        prims: &PrimSet,
        non_triangles: Range<usize>,
    ) -> Result<(), GridTooLarge> {
        let mut places = with_room_for(non_triangles.clone().map(|i| cell_lists.cells_of(i).len()).sum())?;
        for i in non_triangles {
            places.extend(cell_lists.cells_of(i).iter().map(|&cell| (self.last_block(cell), prims.id(i))));
        }
        places.sort_unstable();
        self.note_non_triangles(places)
    }

    /// The last block of a cell that is not empty.
    fn last_block(&self, cell: u32) -> u32 {
        let first = self.entries[cell as usize] >> COUNT_BITS;
        first + self.blocks[first as usize].count - 1
    }

    /// Takes last blocks, which must ascend, and numbers of what is no triangle.
    fn note_non_triangles(&mut self, places: Vec<(u32, u32)>) -> Result<(), GridTooLarge> {
        self.non_triangles = with_room_for(places.len())?;
        let blocks = &mut self.blocks;
        for (&(block, id), place) in places.iter().zip(0..) {
            let block = &mut blocks[block as usize];
            if block.non_triangles == [0, 0] {
                block.non_triangles[0] = place;
            }
            block.non_triangles[1] = place + 1;
            self.non_triangles.push(id);
        }
        Ok(())
    }
}

/// How many lanes each cell needs.
fn counts(
    lattice: &Lattice,
    cell_lists: &CellLists,
    triangles: usize,
    non_triangles: Range<usize>,
) -> Result<Vec<u32>, GridTooLarge> {
    let mut counts: Vec<u32> = try_zeroed_vec(lattice.index_count()).map_err(|()| GridTooLarge)?;
    for &cell in cell_lists.cells_below(triangles).flatten() {
        counts[cell as usize] += 1;
    }
    // A cell without triangles also has a block, to name its other primitives.
    for &cell in non_triangles.flat_map(|id| cell_lists.cells_of(id)) {
        counts[cell as usize] = counts[cell as usize].max(1);
    }
    Ok(counts)
}

/// Lanes end here at the latest, so that a word below [`NESTED`] can name every block.
const LANES_END: u32 = (NESTED >> COUNT_BITS) * LANES as u32;

/// Turns each cell's count into the place where its lanes end, and gives the number of all lanes.
/// Each cell begins a block. Places count from one block, so that none is [`EMPTY`].
fn to_ends(lattice: &Lattice, counts: &mut [u32]) -> Result<usize, GridTooLarge> {
    let mut next = LANES as u64;
    for run in lattice.x_runs() {
        for count in counts[run].iter_mut().filter(|count| **count > 0) {
            let end = next + *count as u64;
            next = end.next_multiple_of(LANES as u64);
            *count = u32::try_from(end).ok().filter(|&end| end <= LANES_END).ok_or(GridTooLarge)?;
        }
    }
    Ok(next as usize - LANES)
}

/// Enters the triangles backwards from the `ends` of their cells, which become the cells' starts.
/// The end of a cell that only names other primitives stays in its one block.
fn scatter(cell_lists: &CellLists, prims: &PrimSet, triangles: usize, ends: &mut [u32], lanes: &mut [u32]) {
    for i in (0..triangles).rev() {
        let id = prims.id(i);
        for &cell in cell_lists.cells_of(i) {
            let place = &mut ends[cell as usize];
            *place -= 1;
            lanes[*place as usize - LANES] = id;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::cell_lists::widened;
    use crate::grid::voxelize;
    use crate::math::aabb::Aabb;
    use crate::scene::parser::parse;

    #[test]
    fn blocks_hold_what_the_rows_say() {
        let objects: String = (0..50)
            .map(|i| {
                format!("Triangle {{ vertex0 {i} 0 0 vertex1 {} 1 0 vertex2 {} 0 {} }}", i + 3, i + 1, i % 7)
            })
            .chain((0..5).map(|i| format!("Sphere {{ center {} 0 0 radius 2 }}", i * 9)))
            .collect();
        let text = format!(
            "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
             Group {{ numObjects 55 Material {{ }} {objects} }}"
        );
        let world = World::new(&parse(&text).unwrap(), &[]).unwrap();
        let lattice = Lattice::new(widened(world.bounds), [5, 2, 2]);
        let triangles = (0..50).map(|i| Aabb::around(world.corners(i)));
        let boxes: Vec<_> = triangles.chain(world.boxes()).collect();
        let cell_lists =
            CellLists::new(&lattice, 55, |i, out| voxelize::of_box(&lattice, &boxes[i], 1e-6, out)).unwrap();
        let cells = CellContents::new(&world, &lattice, &cell_lists, &PrimSet::All).unwrap();
        for index in 0..lattice.index_count() {
            let mut found: Vec<u32> = vec![];
            match cells.entries[index] {
                EMPTY => {}
                entry => {
                    let own = CellContents::blocks_of(&cells.blocks, entry);
                    found.extend(own.iter().flat_map(|b| b.ids).filter(|&n| n != NONE));
                    let [start, end] = own[own.len() - 1].non_triangles.map(|i| i as usize);
                    found.extend(&cells.non_triangles[start..end]);
                }
            }
            let expected: Vec<u32> =
                (0..55).filter(|&n| cell_lists.cells_of(n as usize).contains(&(index as u32))).collect();
            assert_eq!(found, expected);
        }
    }
}
