//! Where blocks stand: memory of their own, in large pages where the system offers them.
//!
//! Most of what a grid takes in memory is its blocks, and a page that is touched for the first time
//! costs as much as filling the nine blocks in it. Large pages are 512 times as few, and the rays
//! afterwards find their addresses sooner.

use super::block::Block;
use crate::grid::build::GridTooLarge;
use memmap2::{MmapMut, MmapOptions};
use std::ops::Index;

/// Blocks one after the other.
#[derive(Debug)]
pub struct Blocks {
    /// The blocks' bytes, and what is left of the last page.
    memory: MmapMut,
    count: usize,
}

const BLOCK_BYTES: usize = size_of::<Block>();

impl Blocks {
    /// So many that hold nothing yet: all their bytes are zero.
    pub fn zeroed(count: usize) -> Result<Self, GridTooLarge> {
        let bytes = count.checked_mul(BLOCK_BYTES).and_then(whole_pages).ok_or(GridTooLarge)?;
        let memory = MmapOptions::new().len(bytes).map_anon().map_err(|_| GridTooLarge)?;
        prefer_large_pages(&memory);
        Ok(Self { memory, count })
    }

    pub fn as_slice(&self) -> &[Block] {
        bytemuck::cast_slice(&self.memory[..self.count * BLOCK_BYTES])
    }

    pub fn as_mut_slice(&mut self) -> &mut [Block] {
        bytemuck::cast_slice_mut(&mut self.memory[..self.count * BLOCK_BYTES])
    }
}

/// Without a division, unlike [`Blocks::as_slice`], for the loop that reads one block after the other.
impl Index<usize> for Blocks {
    type Output = Block;

    #[inline(always)]
    fn index(&self, number: usize) -> &Block {
        bytemuck::from_bytes(&self.memory[number * BLOCK_BYTES..][..BLOCK_BYTES])
    }
}

/// The size of the system's large pages on most machines; elsewhere only the speed differs.
const LARGE_PAGE: usize = 2 << 20;

/// A size to ask for: enough large pages, unless half of one would do. None where it is too large.
fn whole_pages(bytes: usize) -> Option<usize> {
    if bytes < LARGE_PAGE / 2 { Some(bytes) } else { bytes.checked_next_multiple_of(LARGE_PAGE) }
}

/// A system that cannot do it says so, and its usual pages serve as well.
fn prefer_large_pages(memory: &MmapMut) {
    #[cfg(target_os = "linux")]
    if memory.len() >= LARGE_PAGE {
        let _ = memory.advise(memmap2::Advice::HugePage);
    }
    #[cfg(not(target_os = "linux"))]
    let _ = memory;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caster::block::Then;

    #[test]
    fn each_block_is_its_own() {
        // As many as fill usual pages, and as many as fill large ones.
        for count in [1, 20, 6000, 20_000] {
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
        for count in [usize::MAX, usize::MAX / BLOCK_BYTES, usize::MAX / BLOCK_BYTES / 2] {
            assert_eq!(Blocks::zeroed(count).err(), Some(GridTooLarge));
        }
    }
}
