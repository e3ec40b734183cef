//! What stands in each cell, laid out for the loop that reads it: one word a cell, blocks of eight
//! triangles one after the other, and a list of the few primitives that are no triangles.

use super::cell_table::EMPTY;
use super::prim_set::Items;
use super::triangle8::{Block, Frame, LANES, NONE};
use crate::grid::Lattice;
use crate::grid::cell_lists::{GridTooLarge, Rows, filled_with, with_room_for};
use crate::world::World;
use bytemuck::allocation::try_zeroed_vec;
use rayon::prelude::*;
use std::ops::Range;

/// A word's lowest bits say how many blocks its cell has, so that nobody waits for the blocks to know
/// it; this many where there are as many or more.
const MANY: u32 = (1 << COUNT_BITS) - 1;
const COUNT_BITS: u32 = 4;
/// From this word on up to the next one a word names a grid of the cell's own, the first one by this.
pub const NESTED: u32 = 1 << 31;

/// The cells' contents. A word names the cell's first block and says how many follow one another from
/// there, or is one of those above.
#[derive(Debug)]
pub struct Cells {
    /// Until they are handed over.
    words: Vec<u32>,
    pub blocks: Vec<Block>,
    /// The primitives that are no triangles, cell by cell: each cell's last block says which are its own.
    pub others: Vec<u32>,
    pub frame: Frame,
}

impl Cells {
    /// Lays out the primitives of a lattice's cells, each cell's in the order of their numbers.
    pub fn new(world: &World, lattice: &Lattice, rows: &Rows, items: &Items) -> Result<Self, GridTooLarge> {
        let triangles = items.triangles(world);
        let others = triangles..items.count(world);
        let mut words = counts(lattice, rows, triangles, others.clone())?;
        let lanes = to_ends(lattice, &mut words)?;
        let mut numbers = filled_with([NONE; LANES], lanes / LANES)?;
        scatter(rows, items, triangles, &mut words, numbers.as_flattened_mut());
        let mut cells = Self::of_numbers(world, numbers, Frame::new(&lattice.bounds))?;
        cells.finish(words, lattice);
        cells.add_others(rows, items, others)?;
        Ok(cells)
    }

    /// Hands over the words, by index of the lattice that the cells were made for.
    pub fn take_words(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.words)
    }

    /// The first block of the cell with this word, if there is one.
    #[inline(always)]
    pub fn first_block(blocks: &[Block], word: u32) -> Option<&Block> {
        if word < NESTED && word != EMPTY { blocks.get((word >> COUNT_BITS) as usize) } else { None }
    }

    /// The blocks of the cell with this word, which is none of those that stand for something else.
    #[inline(always)]
    pub fn blocks_of(blocks: &[Block], word: u32) -> &[Block] {
        let first = (word >> COUNT_BITS) as usize;
        let count = word & MANY;
        let count = if count < MANY { count } else { blocks[first].count };
        &blocks[first..first + count as usize]
    }

    /// Everything in one cell.
    pub fn all(world: &World, items: &Items, frame: Frame) -> Result<Self, GridTooLarge> {
        let triangles = items.triangles(world);
        let mut numbers = filled_with([NONE; LANES], triangles.div_ceil(LANES).max(1))?;
        let lanes = numbers.as_flattened_mut().iter_mut();
        lanes.zip(0..triangles).for_each(|(lane, i)| *lane = items.number(i));
        let mut cells = Self::of_numbers(world, numbers, frame)?;
        let last = cells.blocks.len() - 1;
        let others = triangles..items.count(world);
        cells.note_others(others.map(|i| (last as u32, items.number(i))).collect())?;
        Ok(cells)
    }

    /// How many primitives stand in all cells, each as often as it does.
    pub fn entries(&self) -> usize {
        let numbers = self.blocks.iter().flat_map(|block| &block.numbers);
        numbers.filter(|&&number| number != NONE).count() + self.others.len()
    }

    /// Lets the words of these cells, which are empty so far, name grids from the first one on.
    pub fn name_nested(&mut self, cells: impl Iterator<Item = u32>) {
        for (word, cell) in (NESTED..).zip(cells) {
            self.words[cell as usize] = word;
        }
    }

    /// Blocks of these triangles, which do not say yet how many their cells have.
    fn of_numbers(world: &World, numbers: Vec<[u32; LANES]>, frame: Frame) -> Result<Self, GridTooLarge> {
        let mut blocks: Vec<Block> = try_zeroed_vec(numbers.len()).map_err(|()| GridTooLarge)?;
        let all_within = frame.holds(&world.bounds);
        let empty = blocks.par_iter_mut();
        empty.zip(&numbers).for_each(|(block, numbers)| block.fill(world, &frame, all_within, numbers));
        Ok(Self { words: vec![], blocks, others: vec![], frame })
    }

    /// Turns the place of each cell's first lane into its word.
    fn finish(&mut self, mut words: Vec<u32>, lattice: &Lattice) {
        let blocks = &mut self.blocks;
        let mut end = blocks.len() as u32;
        for row in lattice.rows().rev() {
            for word in words[row].iter_mut().rev().filter(|word| **word != EMPTY) {
                let first = *word / LANES as u32 - 1;
                let count = end - first;
                blocks[first as usize].count = count;
                *word = first << COUNT_BITS | count.min(MANY);
                end = first;
            }
        }
        self.words = words;
    }

    fn add_others(&mut self, rows: &Rows, items: &Items, others: Range<usize>) -> Result<(), GridTooLarge> {
        let mut places = with_room_for(others.clone().map(|i| rows.cells_of(i).len()).sum())?;
        for i in others {
            places.extend(rows.cells_of(i).iter().map(|&cell| (self.last_block(cell), items.number(i))));
        }
        places.sort_unstable();
        self.note_others(places)
    }

    /// The last block of a cell that is not empty.
    fn last_block(&self, cell: u32) -> u32 {
        let first = self.words[cell as usize] >> COUNT_BITS;
        first + self.blocks[first as usize].count - 1
    }

    /// Takes last blocks, which must ascend, and numbers of what is no triangle.
    fn note_others(&mut self, places: Vec<(u32, u32)>) -> Result<(), GridTooLarge> {
        self.others = with_room_for(places.len())?;
        let blocks = &mut self.blocks;
        for (&(block, number), place) in places.iter().zip(0..) {
            let block = &mut blocks[block as usize];
            if block.others == [0, 0] {
                block.others[0] = place;
            }
            block.others[1] = place + 1;
            self.others.push(number);
        }
        Ok(())
    }
}

/// How many lanes each cell needs.
fn counts(
    lattice: &Lattice,
    rows: &Rows,
    triangles: usize,
    others: Range<usize>,
) -> Result<Vec<u32>, GridTooLarge> {
    let mut counts: Vec<u32> = try_zeroed_vec(lattice.index_count()).map_err(|()| GridTooLarge)?;
    for &cell in rows.cells_below(triangles).flatten() {
        counts[cell as usize] += 1;
    }
    // A cell without triangles also has a block, to name its other primitives.
    for &cell in others.flat_map(|number| rows.cells_of(number)) {
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
    for row in lattice.rows() {
        for count in counts[row].iter_mut().filter(|count| **count > 0) {
            let end = next + *count as u64;
            next = end.next_multiple_of(LANES as u64);
            *count = u32::try_from(end).ok().filter(|&end| end <= LANES_END).ok_or(GridTooLarge)?;
        }
    }
    Ok(next as usize - LANES)
}

/// Enters the triangles backwards from the `ends` of their cells, which become the cells' starts.
/// The end of a cell that only names other primitives stays in its one block.
fn scatter(rows: &Rows, items: &Items, triangles: usize, ends: &mut [u32], lanes: &mut [u32]) {
    for i in (0..triangles).rev() {
        let number = items.number(i);
        for &cell in rows.cells_of(i) {
            let place = &mut ends[cell as usize];
            *place -= 1;
            lanes[*place as usize - LANES] = number;
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
        let rows =
            Rows::new(&lattice, 55, |i, out| voxelize::of_box(&lattice, &boxes[i], 1e-6, out)).unwrap();
        let cells = Cells::new(&world, &lattice, &rows, &Items::All).unwrap();
        for index in 0..lattice.index_count() {
            let mut found: Vec<u32> = vec![];
            match cells.words[index] {
                EMPTY => {}
                word => {
                    let own = Cells::blocks_of(&cells.blocks, word);
                    found.extend(own.iter().flat_map(|b| b.numbers).filter(|&n| n != NONE));
                    let [start, end] = own[own.len() - 1].others.map(|i| i as usize);
                    found.extend(&cells.others[start..end]);
                }
            }
            let expected: Vec<u32> =
                (0..55).filter(|&n| rows.cells_of(n as usize).contains(&(index as u32))).collect();
            assert_eq!(found, expected);
        }
    }
}
