//! The program's allocator: memory in large pages, where the system offers them. The library leaves the
//! choice of an allocator to whoever uses it.
//!
//! A page of 4 KB that is touched for the first time costs more than filling it and giving it back
//! costs again, some 1.8 microseconds in all. A large page is 512 times the size and costs 60 times as
//! much; and reads find their addresses sooner. So every long list stands in large pages.
//!
//! Measured on whole commands on one thread, in pairs, medians of seconds of processor time (user +
//! system) and of peak memory; the rabbit with shadows, of 40,000 faces with `-grid 40 40 33` (25 runs)
//! and split into 2.56 million with `-grid auto` (7 runs), 200 by 200 pixels:
//!
//! | | 40,000 faces | | 2.56 million faces | |
//! |---|---:|---:|---:|---:|
//! | the system's allocator | 0.021 | 11.4 MiB | 0.35 + 0.19 | 301 MiB |
//! | this one | 0.019 | 14.2 MiB | 0.32 + 0.44 | 309 MiB |
//! | large pages for the grid's lists alone | 0.021 | 11.6 MiB | 0.34 + 0.20 | 301 MiB |
//! | crate `mimalloc` | 0.020 | 23.1 MiB | 0.31 + 0.56 | 395 MiB |
//!
//! So it saves a tenth of the first command. For the second the user's part falls by a tenth, while the
//! system's part was between 0.05 and 0.78 in large pages and between 0.16 and 0.22 in usual ones: on the virtual
//! machine that this was measured on, the host first has to find a large page that no guest has touched.

use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr;

#[global_allocator]
static ALLOCATOR: LargePages = LargePages;

/// Gives large pages for what is long, and the system's usual memory for all else.
struct LargePages;

/// The size of the system's large pages on most machines; elsewhere only the speed differs.
const LARGE_PAGE: usize = 2 << 20;

/// So many bytes are long. From an eighth of a large page on it would cost less time than usual ones, but
/// the lists of a thousand small grids shall not take several times their memory.
const LONG: usize = LARGE_PAGE / 2;

/// Every mapping is aligned to at least this.
const ALIGNMENT: usize = 4096;

fn is_long(layout: Layout) -> bool {
    layout.size() >= LONG && layout.align() <= ALIGNMENT
}

/// A long layout's size in whole large pages.
fn whole_pages(layout: Layout) -> usize {
    // Does not overflow: a layout's size is at most `isize::MAX`.
    layout.size().next_multiple_of(LARGE_PAGE)
}

/// New zeros for a long layout; null where they are not to be had. Out of the way of what is short.
#[cold]
fn mapped(layout: Layout) -> *mut u8 {
    let size = whole_pages(layout);
    let writable = libc::PROT_READ | libc::PROT_WRITE;
    let own = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS;
    // SAFETY: a new mapping, at no address asked for, touches no memory that anybody has.
    let memory = unsafe { libc::mmap(ptr::null_mut(), size, writable, own, -1, 0) };
    if memory == libc::MAP_FAILED {
        return ptr::null_mut();
    }
    // A system that cannot do it says so, and its usual pages serve as well.
    // SAFETY: all of it is the mapping just made, whose contents the advice leaves alone.
    unsafe { libc::madvise(memory, size, libc::MADV_HUGEPAGE) };
    memory.cast()
}

// SAFETY: what is not long is the system allocator's in all respects. What is long has a mapping of its
// own, not smaller than its layout, aligned to a page and so to the layout's alignment, and zeroed. It
// stays until `dealloc`, which is called with the same layout, so that it takes the same branch and
// computes the same size. Nothing here panics.
unsafe impl GlobalAlloc for LargePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if is_long(layout) {
            return mapped(layout);
        }
        // SAFETY: the caller promises a layout that is not empty, which is what the system asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if is_long(layout) {
            return mapped(layout);
        }
        // SAFETY: the caller promises a layout that is not empty, which is what the system asks for.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        if is_long(layout) {
            // SAFETY: the caller promises that `memory` came from here with this layout, so it is one mapping of
            // this size, and that nobody uses it any more.
            unsafe { libc::munmap(memory.cast(), whole_pages(layout)) };
        } else {
            // SAFETY: the caller promises that `memory` came from here with this layout, so the system gave it.
            unsafe { System.dealloc(memory, layout) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lists_are_zero_and_their_own() {
        for bytes in [1, 4097, LONG - 1, LONG, LARGE_PAGE, LARGE_PAGE + 1] {
            let mut lists = [vec![0u8; bytes], vec![0u8; bytes]];
            for number in [1, 2] {
                assert!(lists[number - 1].iter().all(|&byte| byte == 0));
                lists[number - 1].fill(number as u8);
            }
            assert!(lists[0].iter().all(|&byte| byte == 1));
        }
    }

    #[test]
    fn a_list_keeps_what_it_holds_while_it_grows() {
        let list: Vec<u32> = (0..).step_by(3).take(1 << 20).collect();
        let mut grown = vec![];
        list.iter().for_each(|&number| grown.push(number));
        assert_eq!(grown, list);
        grown.truncate(LONG / 4 - 1);
        grown.shrink_to_fit();
        assert_eq!(grown, list[..LONG / 4 - 1]);
    }

    #[test]
    fn too_much_is_an_error() {
        let mut list: Vec<u8> = vec![];
        for bytes in [isize::MAX as usize, isize::MAX as usize / 2] {
            assert!(list.try_reserve_exact(bytes).is_err());
        }
    }
}
