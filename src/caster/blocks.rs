//! Where blocks stand, which are most of what a grid takes in memory.

use super::block::Block;
use crate::grid::build::GridTooLarge;
use crate::pages::LargePages;
use std::ops::Index;

/// Blocks one after the other.
#[derive(Debug)]
pub struct Blocks {
    /// The blocks' bytes, and what is left of the last page.
    pages: LargePages,
    count: usize,
}

const BLOCK_BYTES: usize = size_of::<Block>();

impl Blocks {
    /// So many that hold nothing yet: all their bytes are zero.
    pub fn zeroed(count: usize) -> Result<Self, GridTooLarge> {
        let bytes = count.checked_mul(BLOCK_BYTES).ok_or(GridTooLarge)?;
        let pages = LargePages::zeroed(bytes).map_err(|_| GridTooLarge)?;
        Ok(Self { pages, count })
    }

    pub fn as_slice(&self) -> &[Block] {
        bytemuck::cast_slice(&self.pages[..self.count * BLOCK_BYTES])
    }

    pub fn as_mut_slice(&mut self) -> &mut [Block] {
        bytemuck::cast_slice_mut(&mut self.pages[..self.count * BLOCK_BYTES])
    }
}

/// Without a division, unlike [`Blocks::as_slice`], for the loop that reads one block after the other.
impl Index<usize> for Blocks {
    type Output = Block;

    #[inline(always)]
    fn index(&self, number: usize) -> &Block {
        bytemuck::from_bytes(&self.pages[number * BLOCK_BYTES..][..BLOCK_BYTES])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caster::block::Then;

    #[test]
    fn each_block_is_its_own() {
        // As many as fill usual pages, and as many as fill large ones.
        for count in [1, 20, 6000] {
            let mut blocks = Blocks::zeroed(count).unwrap();
            assert_eq!(blocks.as_slice().len(), count);
            for (number, block) in blocks.as_mut_slice().iter_mut().enumerate() {
                assert_eq!((block.then, block.numbers), (Then::Block, [0; 8]));
                block.numbers = [number as u32; 8];
            }
            assert!((0..count).all(|number| blocks[number].numbers == [number as u32; 8]));
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
