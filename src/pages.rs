//! Memory in large pages, where the system offers them.
//!
//! A page that is touched for the first time costs more than filling it, so that large lists are
//! dear to write where pages are small. Large pages are 512 times as few, and reads find their
//! addresses sooner.

use memmap2::{MmapMut, MmapOptions};
use std::io;
use std::ops::{Deref, DerefMut};

/// Bytes that are zero at first, aligned to a page.
#[derive(Debug)]
pub struct LargePages(MmapMut);

/// The size of the system's large pages on most machines; elsewhere only the speed differs.
const LARGE_PAGE: usize = 2 << 20;

impl LargePages {
    /// At least so many bytes, or an error where the memory is not to be had.
    pub fn zeroed(bytes: usize) -> io::Result<Self> {
        let size = whole_pages(bytes).ok_or(io::ErrorKind::OutOfMemory)?;
        let memory = MmapOptions::new().len(size).map_anon()?;
        prefer_large_pages(&memory);
        Ok(Self(memory))
    }
}

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

impl Deref for LargePages {
    type Target = [u8];

    #[inline(always)]
    fn deref(&self) -> &[u8] {
        &self.0
    }
}

impl DerefMut for LargePages {
    fn deref_mut(&mut self) -> &mut [u8] {
        &mut self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_enough_zeros() {
        for bytes in [0, 1, 4097, LARGE_PAGE / 2, LARGE_PAGE, LARGE_PAGE + 1] {
            let mut pages = LargePages::zeroed(bytes).unwrap();
            assert!(pages.len() >= bytes && pages.iter().all(|&byte| byte == 0));
            pages.fill(1);
        }
    }

    #[test]
    fn too_many_are_an_error() {
        for bytes in [usize::MAX, usize::MAX / 2 + 1] {
            assert!(LargePages::zeroed(bytes).is_err());
        }
    }
}
