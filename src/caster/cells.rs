//! What stands in each cell, laid out for the loop that reads it: one word a cell, blocks of eight
//! triangles one after the other, and a list of the few primitives that are no triangles.

use super::block::{Block, Frame, LANES};
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
    pub words: Vec<u32>,
    pub blocks: Vec<Block>,
    /// Numbers of primitives that are no triangles.
    pub others: Vec<u32>,
    pub frame: Frame,
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
            for index in row..row + nx {
                let items = rows.items(index);
                words[index] = EMPTY;
                if !items.is_empty() {
                    words[index] = count + 1;
                    let cell = Filled::new(index, items, world);
                    count = count.checked_add(cell.blocks() as u32).ok_or(GridTooLarge)?;
                    filled.push(cell);
                }
            }
        }
        let frame = Frame::new(&lattice.bounds);
        let items = |cell: &Filled| rows.items(cell.index);
        let mut others = vec![];
        let mut blocks = empty_blocks(count as usize)?;
        fill(world, &frame, &filled, &items, &mut blocks);
        // Few cells hold anything else, and their list is not worth a thread.
        if world.triangles.len() < world.finite_count() {
            for cell in &filled {
                let rest = &items(cell)[cell.triangles..];
                let block = &mut blocks[words[cell.index] as usize - 1];
                (block.others_start, block.others_count) = (others.len() as u32, rest.len() as u32);
                others.extend_from_slice(rest);
            }
        }
        Ok(Self { words, blocks, others, frame })
    }

    /// Everything in one cell, for a world without a grid. There are no words.
    pub fn all(world: &World, frame: Frame) -> Result<Self, GridTooLarge> {
        let triangles: Vec<u32> = (0..world.triangles.len() as u32).collect();
        let others: Vec<u32> = (world.triangles.len() as u32..world.finite_count() as u32).collect();
        let cell = Filled { index: 0, triangles: triangles.len() };
        let mut blocks = empty_blocks(cell.blocks())?;
        fill(world, &frame, &[cell], &|_| &triangles, &mut blocks);
        blocks[0].others_count = others.len() as u32;
        Ok(Self { words: vec![], blocks, others, frame })
    }
}

fn empty_blocks(count: usize) -> Result<Vec<Block>, GridTooLarge> {
    let mut blocks = Vec::new();
    blocks.try_reserve_exact(count).map_err(|_| GridTooLarge)?;
    blocks.resize(count, Block::EMPTY);
    Ok(blocks)
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
        let (first, second) = blocks.split_at_mut(left.iter().map(Filled::blocks).sum());
        rayon::join(|| fill(world, frame, left, items, first), || fill(world, frame, right, items, second));
        return;
    }
    let mut rest = blocks;
    for cell in cells {
        let (own, behind) = rest.split_at_mut(cell.blocks());
        let triangles = &items(cell)[..cell.triangles];
        for (block, chunk) in own.iter_mut().zip(triangles.chunks(LANES)) {
            block.fill(world, frame, chunk);
        }
        let last = own.len() - 1;
        own[..last].iter_mut().for_each(|block| block.is_last = false);
        rest = behind;
    }
}

#[cfg(test)]
mod tests {
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
            let mut found = vec![];
            match cells.words[index] {
                EMPTY | BORDER => {}
                word => {
                    let first = word as usize - 1;
                    let length = cells.blocks[first..].iter().position(|b| b.is_last).unwrap() + 1;
                    let own = &cells.blocks[first..first + length];
                    found.extend(
                        own.iter().flat_map(|b| b.numbers).filter(|&n| n != super::super::block::NONE),
                    );
                    found.extend(
                        &cells.others[own[0].others_start as usize..][..own[0].others_count as usize],
                    );
                }
            }
            assert_eq!(found, rows.items(index));
        }
    }
}
