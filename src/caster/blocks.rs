//! Where blocks stand, which are most of what a grid takes in memory.

use super::block::Block;
use crate::grid::build::GridTooLarge;
use crate::pages::LargePages;
use bytemuck::Zeroable;

/// Blocks one after the other.
#[derive(Debug)]
pub enum Blocks {
    /// Systems count the pages that are asked for one by one, and grids within cells are many.
    Few(Vec<Block>),
    Many {
        /// The blocks' bytes, and what is left of the last page.
        pages: LargePages,
        count: usize,
    },
}

const BLOCK_BYTES: usize = size_of::<Block>();

/// From so many on blocks fill a large page.
const MANY: usize = (1 << 20) / BLOCK_BYTES;

impl Blocks {
    /// So many that hold nothing yet: all their bytes are zero.
    pub fn zeroed(count: usize) -> Result<Self, GridTooLarge> {
        if count < MANY {
            return Ok(Self::Few(vec![Block::zeroed(); count]));
        }
        let bytes = count.checked_mul(BLOCK_BYTES).ok_or(GridTooLarge)?;
        let pages = LargePages::zeroed(bytes).map_err(|_| GridTooLarge)?;
        Ok(Self::Many { pages, count })
    }

    #[inline(always)]
    pub fn as_slice(&self) -> &[Block] {
        match self {
            Self::Few(list) => list,
            Self::Many { pages, count } => bytemuck::cast_slice(&pages[..count * BLOCK_BYTES]),
        }
    }

    pub fn as_mut_slice(&mut self) -> &mut [Block] {
        match self {
            Self::Few(list) => list,
            Self::Many { pages, count } => bytemuck::cast_slice_mut(&mut pages[..*count * BLOCK_BYTES]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_block_is_its_own() {
        // As many as fill usual pages, and as many as fill large ones.
        for count in [1, 20, 6000] {
            let mut blocks = Blocks::zeroed(count).unwrap();
            assert_eq!(blocks.as_slice().len(), count);
            for (number, block) in blocks.as_mut_slice().iter_mut().enumerate() {
                assert_eq!((block.count, block.numbers), (0, [0; 8]));
                block.numbers = [number as u32; 8];
            }
            let numbers = blocks.as_slice().iter().map(|block| block.numbers);
            assert!(numbers.eq((0..count).map(|number| [number as u32; 8])));
        }
        assert!(Blocks::zeroed(0).unwrap().as_slice().is_empty());
    }

    #[test]
    fn too_many_are_an_error() {
        for count in [usize::MAX, usize::MAX / BLOCK_BYTES] {
            assert_eq!(Blocks::zeroed(count).err(), Some(GridTooLarge));
        }
    }
}
