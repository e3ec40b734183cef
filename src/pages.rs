//! Memory in large pages, where the system offers them.
//!
//! A page of 4 KB that is touched for the first time costs more than filling it and giving it back
//! costs again, some 1.8 microseconds in all. A large page is 512 times the size and costs 60 times as
//! much; and reads find their addresses sooner. So every long list stands in large pages.

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
    // SAFETY: a new mapping touches no memory that anybody has, and the advice is on all of it.
    unsafe {
        let writable = libc::PROT_READ | libc::PROT_WRITE;
        let own = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS;
        let memory = libc::mmap(ptr::null_mut(), size, writable, own, -1, 0);
        if memory == libc::MAP_FAILED {
            return ptr::null_mut();
        }
        // A system that cannot do it says so, and its usual pages serve as well.
        libc::madvise(memory, size, libc::MADV_HUGEPAGE);
        memory.cast()
    }
}

// SAFETY: what is not long is the system allocator's in all respects. What is long has a mapping of its
// own, not smaller than its layout, aligned to a page and so to the layout's alignment, and zeroed. It
// stays until `dealloc`, which is called with the same layout, so that it takes the same branch and
// computes the same size. Nothing here panics.
unsafe impl GlobalAlloc for LargePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promises are the system allocator's.
        if is_long(layout) { mapped(layout) } else { unsafe { System.alloc(layout) } }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        if is_long(layout) { mapped(layout) } else { unsafe { System.alloc_zeroed(layout) } }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        if is_long(layout) {
            // SAFETY: all of it is one mapping of this size, which nobody uses any more.
            unsafe { libc::munmap(memory.cast(), whole_pages(layout)) };
        } else {
            // SAFETY: as above.
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
