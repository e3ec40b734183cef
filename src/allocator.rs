//! The program's allocator: the system's, but an allocation that fails ends the program with one line, where Rust would
//! abort it. If there is a reserve, it is given back first, and the allocation succeeds.
//!
//! Work that takes much memory asks for it beforehand ([`raytracer::base::memory`]); a refusal there is an ordinary
//! error. Large blocks ask for large pages: without them a mesh of 2.56 million faces takes 1.4 times as long to read.

use raytracer::base::memory::{Bytes, give_reserve_back};
use std::alloc::{GlobalAlloc, Layout, System};
use std::io::{Write, stderr};
use std::process::exit;
use std::sync::atomic::{AtomicBool, Ordering};

#[global_allocator]
static ALLOCATOR: Allocator = Allocator;

/// True if a thread is ending the program.
static IS_ENDING: AtomicBool = AtomicBool::new(false);

struct Allocator;

// SAFETY: the system's allocator does the work, and nothing here panics.
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the contract of this method.
        given(layout.size(), || unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as in `alloc`.
        given(layout.size(), || unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as in `alloc`. The block is as it was if this fails.
        given(size, || unsafe { System.realloc(block, layout, size) })
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: as in `alloc`.
        unsafe { System.dealloc(block, layout) }
    }
}

#[inline(always)]
fn given(bytes: usize, allocate: impl Fn() -> *mut u8) -> *mut u8 {
    let mut block = allocate();
    while block.is_null() {
        if !give_reserve_back() {
            end(bytes)
        }
        block = allocate();
    }
    #[cfg(target_os = "linux")]
    if bytes >= LARGE_PAGE {
        ask_for_large_pages(block as usize, bytes);
    }
    block
}

/// The size of a large page, on most processors.
#[cfg(target_os = "linux")]
const LARGE_PAGE: usize = 2 << 20;

/// Asks the system to put a block into large pages, each of which it provides sooner than 512 small ones.
#[cfg(target_os = "linux")]
#[cold]
fn ask_for_large_pages(start: usize, bytes: usize) {
    let (first, end) = (start.next_multiple_of(LARGE_PAGE), (start + bytes) / LARGE_PAGE * LARGE_PAGE);
    if first < end {
        // SAFETY: the pages are inside the block, and the advice changes nothing that they contain.
        unsafe { libc::madvise(first as *mut libc::c_void, end - first, libc::MADV_HUGEPAGE) };
    }
}

/// Ends the program. The line is formatted without an allocation, and written at once, so that no other thread that
/// finds no memory breaks it.
#[cold]
fn end(bytes: usize) -> ! {
    while IS_ENDING.swap(true, Ordering::Relaxed) {
        // Another thread has said so, and ends this one too.
        std::thread::yield_now();
    }
    let mut line = [0; 100];
    let mut rest = line.as_mut_slice();
    let _ = writeln!(rest, "error: not enough memory: at least {} more are needed", Bytes(bytes as u64));
    let left = rest.len();
    let _ = stderr().write_all(&line[..line.len() - left]);
    exit(1)
}
