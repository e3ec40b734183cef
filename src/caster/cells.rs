//! What stands in each cell, laid out for the loop that reads it: one word a cell, blocks of eight
//! triangles one after the other, and a list of the few primitives that are no triangles.

use super::block::{Block, Frame, LANES, Then};
use crate::grid::Lattice;
use crate::grid::build::{GridTooLarge, Rows};
use crate::world::World;

/// The word of an empty cell.
pub const EMPTY: u32 = 0;
/// The word of a border cell.
pub const BORDER: u32 = u32::MAX;

/// The cells' contents. A word is the number of the cell's first block plus one, or one of the two
/// above; the cell's blocks follow one another up to the one marked as last.
#[derive(Debug)]
pub struct Cells {
    words: Vec<u32>,
    pub blocks: Vec<Block>,
    others: Others,
    pub frame: Frame,
}

/// The primitives that are no triangles, cell by cell.
#[derive(Debug, Default)]
struct Others {
    /// The last block of each cell that has some, in increasing order, and where its list starts.
    cells: Vec<(u32, u32)>,
    numbers: Vec<u32>,
}

impl Others {
    fn push(&mut self, block: usize, numbers: &[u32]) {
        self.cells.push((block as u32, self.numbers.len() as u32));
        self.numbers.extend_from_slice(numbers);
    }

    fn of(&self, block: usize) -> &[u32] {
        let Ok(place) = self.cells.binary_search_by_key(&(block as u32), |cell| cell.0) else { return &[] };
        let end = self.cells.get(place + 1).map_or(self.numbers.len(), |next| next.1 as usize);
        &self.numbers[self.cells[place].1 as usize..end]
    }
}

/// A cell on its way into the blocks.
struct Filled {
    index: usize,
    /// How many of its items, which ascend, are triangles.
    triangles: usize,
}

impl Filled {
    fn new(index: usize, items: &[u32], world: &World) -> Self {
        Self { index, triangles: items.partition_point(|&n| (n as usize) < world.triangles.len()) }
    }

    /// A cell without triangles also has a block, to name its other primitives.
    fn blocks(&self) -> usize {
        self.triangles.div_ceil(LANES).max(1)
    }
}

impl Cells {
    /// Lays out the `rows` of a lattice.
    pub fn new(world: &World, lattice: &Lattice, rows: &Rows) -> Result<Self, GridTooLarge> {
        let mut words = vec![BORDER; lattice.index_count()];
        let mut filled = vec![];
        let mut count = 0;
        let [nx, ny, nz] = lattice.cells;
        for (y, z) in (0..nz).flat_map(|z| (0..ny).map(move |y| (y, z))) {
            let row = lattice.index([0, y, z]);
            for (index, word) in words.iter_mut().enumerate().skip(row).take(nx) {
                let items = rows.items(index);
                *word = EMPTY;
                if !items.is_empty() {
                    *word = count + 1;
                    let cell = Filled::new(index, items, world);
                    count = count.checked_add(cell.blocks() as u32).ok_or(GridTooLarge)?;
                    filled.push(cell);
                }
            }
        }
        let frame = Frame::new(&lattice.bounds);
        let items = |cell: &Filled| rows.items(cell.index);
        let mut cells = Self::empty(count as usize, words, frame)?;
        fill(world, &frame, &filled, &items, &mut cells.blocks);
        // Few cells hold anything else, and their list is not worth a thread.
        if world.triangles.len() < world.finite_count() {
            for cell in &filled {
                cells.add_others(cells.words[cell.index] as usize - 1, cell, items(cell));
            }
        }
        Ok(cells)
    }

    /// The word of a cell.
    ///
    /// # Safety
    /// `index` is one of the lattice that the cells were made for, its border's included.
    #[inline(always)]
    pub unsafe fn word(&self, index: usize) -> u32 {
        debug_assert!(index < self.words.len());
        // SAFETY: there is a word for every index.
        unsafe { *self.words.get_unchecked(index) }
    }

    /// Everything in one cell, for a world without a grid. There are no words.
    pub fn all(world: &World, frame: Frame) -> Result<Self, GridTooLarge> {
        let all: Vec<u32> = (0..world.first_plane()).collect();
        let cell = Filled::new(0, &all, world);
        let mut cells = Self::empty(cell.blocks(), vec![], frame)?;
        fill(world, &frame, std::slice::from_ref(&cell), &|_| &all, &mut cells.blocks);
        cells.add_others(0, &cell, &all);
        Ok(cells)
    }

    /// The numbers in the cell whose last block this is that are no triangles'.
    pub fn others_of(&self, block: usize) -> &[u32] {
        self.others.of(block)
    }

    fn empty(blocks: usize, words: Vec<u32>, frame: Frame) -> Result<Self, GridTooLarge> {
        Ok(Self { words, blocks: filled_with(Block::EMPTY, blocks)?, others: Others::default(), frame })
    }

    /// Enters what is no triangle among the `items` of a cell whose `first` block this is.
    fn add_others(&mut self, first: usize, cell: &Filled, items: &[u32]) {
        let others = &items[cell.triangles..];
        if !others.is_empty() {
            let last = first + cell.blocks() - 1;
            self.blocks[last].then = Then::Others;
            self.others.push(last, others);
        }
    }
}

/// A list of exactly this length, or an error where the memory is not to be had.
fn filled_with<T: Clone>(value: T, count: usize) -> Result<Vec<T>, GridTooLarge> {
    let mut list = Vec::new();
    list.try_reserve_exact(count).map_err(|_| GridTooLarge)?;
    list.resize(count, value);
    Ok(list)
}

/// Fills the cells' blocks, which follow one another, on all threads.
fn fill<'r>(
    world: &World,
    frame: &Frame,
    cells: &[Filled],
    items: &(impl Fn(&Filled) -> &'r [u32] + Sync),
    blocks: &mut [Block],
) {
    const SERIAL: usize = 512;
    if cells.len() > SERIAL {
        let (left, right) = cells.split_at(cells.len() / 2);
        let middle = left.iter().map(Filled::blocks).sum();
        let (first, second) = blocks.split_at_mut(middle);
        rayon::join(|| fill(world, frame, left, items, first), || fill(world, frame, right, items, second));
        return;
    }
    let mut next = 0;
    for cell in cells {
        let own = next..next + cell.blocks();
        next = own.end;
        blocks[own.clone()].iter_mut().rev().skip(1).for_each(|block| block.then = Then::Block);
        let triangles = &items(cell)[..cell.triangles];
        for (place, chunk) in own.zip(triangles.chunks(LANES)) {
            blocks[place].fill(world, frame, chunk);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::block::NONE;
    use super::*;
    use crate::grid::build::widened;
    use crate::grid::footprint;
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
        let boxes: Vec<_> = world.boxes().collect();
        let rows =
            Rows::new(&lattice, 55, |i, out| footprint::of_box(&lattice, &boxes[i], 1e-6, out)).unwrap();
        let cells = Cells::new(&world, &lattice, &rows).unwrap();
        for index in 0..lattice.index_count() {
            let mut found: Vec<u32> = vec![];
            match cells.words[index] {
                EMPTY | BORDER => {}
                word => {
                    let first = word as usize - 1;
                    let length =
                        cells.blocks[first..].iter().position(|b| b.then != Then::Block).unwrap() + 1;
                    let own = &cells.blocks[first..first + length];
                    found.extend(own.iter().flat_map(|b| b.numbers).filter(|&n| n != NONE));
                    found.extend(cells.others_of(first + length - 1));
                }
            }
            assert_eq!(found, rows.items(index));
        }
    }
}
