//! The program's allocator: one that the system refuses ends the program with one line, and large allocations use large
//! pages where the system offers them. The library has no allocator of its own, so the choice is left to the program
//! that uses it.
//!
//! What takes much memory asks for it beforehand ([`raytracer::memory`]), and a refusal is an error as any other.
//! Everything else allocates without asking, also within the libraries in use. Where the system refuses that, Rust
//! would abort the program, as if it were faulty. There is nothing to clean up then: what has been rendered is in memory
//! or in a file without a name.

#[cfg(target_os = "linux")]
mod large_pages;
#[cfg(not(target_os = "linux"))]
mod of_system;

#[cfg(target_os = "linux")]
use large_pages::Allocator;
#[cfg(not(target_os = "linux"))]
use of_system::Allocator;
use raytracer::memory::{self, Bytes};
use std::alloc::Layout;
use std::io::Write;
use std::ptr;
use std::sync::atomic::{AtomicBool, Ordering};

#[global_allocator]
static ALLOCATOR: Allocator = Allocator;

/// The exit status of an error.
const FAILURE: i32 = 1;

/// Whether a thread is ending the program for want of memory.
static IS_ENDING: AtomicBool = AtomicBool::new(false);

/// What a block is that the system refuses: null if it is asked for, and otherwise the end of the program. Nothing here
/// allocates.
#[cold]
fn refused(layout: Layout) -> *mut u8 {
    if memory::is_asked_for(layout) {
        return ptr::null_mut();
    }
    while IS_ENDING.swap(true, Ordering::Relaxed) {
        // Another thread has said so, and ends this one too.
        std::thread::yield_now();
    }
    let mut line = [0; 80];
    let room = line.len();
    let mut rest = line.as_mut_slice();
    // The line is shorter than its room.
    let _ =
        writeln!(rest, "error: not enough memory: at least {} more are needed", Bytes(layout.size() as u64));
    let length = room - rest.len();
    end(&line[..length])
}

/// Ends the program with this line. Nothing here waits for a lock, which a thread may hold that waits in [`refused`].
#[cfg(unix)]
fn end(line: &[u8]) -> ! {
    // SAFETY: the bytes written are those of `line`. The second function does not return.
    unsafe {
        libc::write(libc::STDERR_FILENO, line.as_ptr().cast(), line.len());
        libc::_exit(FAILURE)
    }
}

/// Ends the program with this line. Nothing here waits for a lock, which a thread may hold that waits in [`refused`].
#[cfg(windows)]
fn end(line: &[u8]) -> ! {
    use std::fs::File;
    use std::mem::ManuallyDrop;
    use std::os::windows::io::{AsRawHandle, FromRawHandle};
    let handle = std::io::stderr().as_raw_handle();
    if !handle.is_null() {
        // SAFETY: the handle is open as long as the program runs, since the file that has it is not dropped.
        let mut file = ManuallyDrop::new(unsafe { File::from_raw_handle(handle) });
        let _ = file.write_all(line);
    }
    std::process::exit(FAILURE)
}

/// A block that the system has given or refused.
#[inline(always)]
fn given(memory: *mut u8, layout: Layout) -> *mut u8 {
    if memory.is_null() { refused(layout) } else { memory }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_that_is_too_large_is_an_error_if_it_is_asked_for() {
        for bytes in [isize::MAX as usize, isize::MAX as usize / 2] {
            assert!(memory::ask(bytes as u64).is_err());
        }
    }
}
