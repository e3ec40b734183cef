//! The system's own allocator, where large pages are not asked for.

use super::given;
use std::alloc::{GlobalAlloc, Layout, System};

/// Allocates with the system's allocator. Ends the program if the system has no memory, unless the block is asked for.
pub struct Allocator;

// SAFETY: every method is the system's allocator's, for the same blocks. Nothing here panics.
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller promises a layout of nonzero size, as the system's allocator requires.
        given(unsafe { System.alloc(layout) }, layout)
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as in `alloc`.
        given(unsafe { System.alloc_zeroed(layout) }, layout)
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller promises that `memory` was allocated here with this layout, so it comes from the system's
        // allocator, and that the size is not zero and makes a layout with the same alignment.
        unsafe {
            let grown = Layout::from_size_align_unchecked(size, layout.align());
            given(System.realloc(memory, layout, size), grown)
        }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller promises that `memory` was allocated here with this layout.
        unsafe { System.dealloc(memory, layout) }
    }
}
