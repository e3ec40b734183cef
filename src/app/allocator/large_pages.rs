//! Large allocations use large pages on Linux.
//!
//! The first access to a 4 KB page costs more than filling it, and returning the page to the system costs as
//! much again, some 1.8 microseconds in all. A large page has 512 times the size but costs only 60 times as
//! much, and address translation misses less often. So every large allocation uses large pages.
//!
//! Measured for whole commands on one thread, in turns on a quiet machine: medians of the processor time in
//! seconds (user + system) and of the peak memory. The scene is the rabbit with shadows at 200 by 200 pixels,
//! with 40,000 faces and `-grid 40 40 33` (25 runs), and subdivided into 2.56 million faces with `-grid auto`
//! (9 runs):
//!
//! | | 40,000 faces | | 2.56 million faces | |
//! |---|---:|---:|---:|---:|
//! | the system's allocator | 0.018 | 14 MiB | 0.31 + 0.21 | 301 MiB |
//! | this one | 0.017 | 15 MiB | 0.27 + 0.10 | 309 MiB |
//!
//! So it saves a twentieth and a quarter of the time. In one of the nine runs the system time was 0.63 instead
//! of 0.10: on a virtual machine the host may first have to find unused large pages, and on a busy one it often
//! does. In an earlier run on a busy machine, large pages for the grid's lists alone saved nothing at 40,000
//! faces, and crate `mimalloc` was no faster than this and took 23 and 395 MiB.

use super::{given, refused};
use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr;

/// Allocates large blocks in large pages, and all others with the system's allocator. Ends the program if the system has
/// no memory, unless the block is asked for.
pub struct Allocator;

/// The size in bytes of the system's large pages on most machines. On others only the speed differs.
const LARGE_PAGE: usize = 2 << 20;

/// The size in bytes from which a block is large. Large pages save time from an eighth of a page on, but a
/// higher limit keeps the lists of a thousand small grids from taking several times their size.
const LARGE_BLOCK: usize = LARGE_PAGE / 2;

/// Every mapping is aligned to at least this.
const ALIGNMENT: usize = 4096;

fn is_large(layout: Layout) -> bool {
    layout.size() >= LARGE_BLOCK && layout.align() <= ALIGNMENT
}

/// The size of a large layout, rounded up to whole large pages.
fn whole_pages(layout: Layout) -> usize {
    // This does not overflow, because a layout's size is at most `isize::MAX`.
    layout.size().next_multiple_of(LARGE_PAGE)
}

/// A new zeroed mapping for a large layout. It is marked cold, so that its code stays out of the path of small
/// allocations.
#[cold]
fn mapped(layout: Layout) -> *mut u8 {
    let size = whole_pages(layout);
    let writable = libc::PROT_READ | libc::PROT_WRITE;
    let private = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS;
    // SAFETY: a new mapping at an address that the system chooses overlaps no memory in use.
    let memory = unsafe { libc::mmap(ptr::null_mut(), size, writable, private, -1, 0) };
    if memory == libc::MAP_FAILED {
        return refused(layout);
    }
    // An error is ignored, because small pages work as well.
    // SAFETY: the range is the mapping just made, and the advice does not change its contents.
    unsafe { libc::madvise(memory, size, libc::MADV_HUGEPAGE) };
    memory.cast()
}

// SAFETY: small blocks are handled by the system's allocator in every method. A large block has a mapping of
// its own, which is at least as large as its layout, aligned to a page and so to the layout's alignment, and
// zeroed. It is valid until `dealloc`, which is called with the same layout, so that it takes the same branch
// and computes the same size. Nothing here panics.
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if is_large(layout) {
            return mapped(layout);
        }
        // SAFETY: the caller promises a layout of nonzero size, as the system's allocator requires.
        given(unsafe { System.alloc(layout) }, layout)
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if is_large(layout) {
            return mapped(layout);
        }
        // SAFETY: the caller promises a layout of nonzero size, as the system's allocator requires.
        given(unsafe { System.alloc_zeroed(layout) }, layout)
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        if is_large(layout) {
            // SAFETY: the caller promises that `memory` was allocated here with this layout, so it is one
            // mapping of this size, and that it is no longer used.
            unsafe { libc::munmap(memory.cast(), whole_pages(layout)) };
        } else {
            // SAFETY: the caller promises that `memory` was allocated here with this layout, so it comes from
            // the system's allocator.
            unsafe { System.dealloc(memory, layout) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_zeroed_and_do_not_overlap() {
        for bytes in [1, 4097, LARGE_BLOCK - 1, LARGE_BLOCK, LARGE_PAGE, LARGE_PAGE + 1] {
            let mut lists = [vec![0u8; bytes], vec![0u8; bytes]];
            for number in [1, 2] {
                assert!(lists[number - 1].iter().all(|&byte| byte == 0));
                lists[number - 1].fill(number as u8);
            }
            assert!(lists[0].iter().all(|&byte| byte == 1));
        }
    }

    #[test]
    fn a_list_keeps_its_contents_while_it_grows_and_shrinks() {
        let list: Vec<u32> = (0..).step_by(3).take(1 << 20).collect();
        let mut grown = vec![];
        list.iter().for_each(|&number| grown.push(number));
        assert_eq!(grown, list);
        grown.truncate(LARGE_BLOCK / 4 - 1);
        grown.shrink_to_fit();
        assert_eq!(grown, list[..LARGE_BLOCK / 4 - 1]);
    }
}
