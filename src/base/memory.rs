//! Asks for memory before large work, so that a lack of it is an error and does not end the program.
//!
//! Work that may take much memory and knows how much (a picture, the cells of a grid, a mesh by its file) asks once
//! before it starts. A refusal is an error that says how much is needed. Everything else simply allocates: the
//! program's allocator ends the program with one line when an allocation fails.
//!
//! The live page goes on in that case. It keeps a reserve, which the allocator gives back when an allocation fails; the
//! requests that run are then ended, and new ones are refused until there is a reserve again.

use std::alloc::{GlobalAlloc, Layout, System};
use std::hint::black_box;
use std::ptr::null_mut;
use std::sync::atomic::{AtomicPtr, Ordering};
use std::{fmt, io};

/// The least number of bytes to ask for. Smaller blocks lie in the heap, and asking for them would leave gaps there,
/// which the program keeps.
const WORTH_ASKING: u64 = 1 << 20;

/// Returns an error if the system has less memory than this. Does not keep the memory.
pub fn ask(bytes: u64) -> Result<(), NoMemory> {
    if bytes < WORTH_ASKING {
        return Ok(());
    }
    let refused = NoMemory { bytes };
    let size = usize::try_from(bytes).map_err(|_| refused)?;
    let layout = Layout::from_size_align(size, 1).map_err(|_| refused)?;
    // SAFETY: the layout has at least `WORTH_ASKING` bytes, and what was allocated is freed with the same layout. The
    // system's allocator is asked, since the program's own ends it when there is no memory.
    unsafe {
        // The compiler leaves out an allocation that it knows not to be used.
        let block = black_box(System.alloc(layout));
        if block.is_null() {
            return Err(refused);
        }
        System.dealloc(block, layout);
    }
    Ok(())
}

/// The size of the reserve in bytes, for what requests allocate until they notice that it is used.
const RESERVE: usize = 16 << 20;
static RESERVED: AtomicPtr<u8> = AtomicPtr::new(null_mut());

/// Takes the reserve, unless it is there.
pub fn keep_reserve() -> Result<(), NoMemory> {
    let Ok(layout) = Layout::from_size_align(RESERVE, 1) else { return Ok(()) };
    if has_reserve() {
        return Ok(());
    }
    // SAFETY: the layout has a size.
    let block = unsafe { System.alloc(layout) };
    if block.is_null() {
        return Err(NoMemory { bytes: RESERVE as u64 });
    }
    if RESERVED.compare_exchange(null_mut(), block, Ordering::AcqRel, Ordering::Acquire).is_err() {
        // SAFETY: the block has just been allocated with this layout. Another thread has taken the reserve meanwhile.
        unsafe { System.dealloc(block, layout) };
    }
    Ok(())
}

/// Returns the number of bytes that the system would give at once, up to `most`.
pub fn free_space(most: u64) -> u64 {
    let (mut least, mut beyond) = (0, most / WORTH_ASKING + 1);
    while least + 1 < beyond {
        let middle = least.midpoint(beyond);
        if ask(middle * WORTH_ASKING).is_ok() {
            least = middle;
        } else {
            beyond = middle;
        }
    }
    if least == most / WORTH_ASKING { most } else { least * WORTH_ASKING }
}

/// Lets all threads share a heap if the address space is limited, and keeps large blocks out of it, so that they are
/// given back to the system. Otherwise the C library maps 64 MB for each thread, of which little is used.
pub fn use_few_heaps() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        let mut limit = libc::rlimit { rlim_cur: libc::RLIM_INFINITY, rlim_max: libc::RLIM_INFINITY };
        // SAFETY: the call writes to `limit` only.
        let is_known = unsafe { libc::getrlimit(libc::RLIMIT_AS, &raw mut limit) } == 0;
        if is_known && limit.rlim_cur != libc::RLIM_INFINITY {
            // SAFETY: the calls set numbers in the C library, under its lock.
            unsafe {
                libc::mallopt(libc::M_ARENA_MAX, 1);
                libc::mallopt(libc::M_MMAP_THRESHOLD, WORTH_ASKING as i32);
            }
        }
    }
}

/// Returns true if the reserve is there.
pub fn has_reserve() -> bool {
    !RESERVED.load(Ordering::Acquire).is_null()
}

/// Gives the reserve back to the system. Returns false if there was none.
pub fn give_reserve_back() -> bool {
    let block = RESERVED.swap(null_mut(), Ordering::AcqRel);
    let Ok(layout) = Layout::from_size_align(RESERVE, 1) else { return false };
    if block.is_null() {
        return false;
    }
    // SAFETY: `keep_reserve` has allocated the block with this layout, and no other thread has it any more.
    unsafe { System.dealloc(block, layout) };
    true
}

/// Too little memory. The error is displayed as a part of a line that says how much was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoMemory {
    /// The number of bytes that were asked for at once. More may be needed after it.
    pub bytes: u64,
}

impl fmt::Display for NoMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "not enough memory: at least {} are needed", Bytes(self.bytes))
    }
}

impl std::error::Error for NoMemory {}

/// A number of bytes, displayed in units of a thousand.
#[derive(Clone, Copy, Debug)]
pub struct Bytes(pub u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const UNITS: [&str; 6] = ["kB", "MB", "GB", "TB", "PB", "EB"];
        if self.0 < 1000 {
            return write!(f, "{} bytes", self.0);
        }
        let (mut size, mut unit) = (self.0 as f64 / 1e3, 0);
        // At 999.95 one decimal would be rounded to four digits.
        while size >= 999.95 {
            size /= 1e3;
            unit += 1;
        }
        write!(f, "{size:.1} {}", UNITS[unit])
    }
}

/// Returns an empty list with room for exactly `count` elements.
pub fn with_room<T>(count: usize) -> Result<Vec<T>, NoMemory> {
    ask((count as u64).saturating_mul(size_of::<T>() as u64))?;
    Ok(Vec::with_capacity(count))
}

impl From<NoMemory> for io::Error {
    fn from(refused: NoMemory) -> Self {
        Self::new(io::ErrorKind::OutOfMemory, refused)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_says_how_much_was_asked_for() {
        let message = |refused: Result<(), NoMemory>| refused.unwrap_err().to_string();
        let most = isize::MAX as usize;
        assert_eq!(message(ask(most as u64)), "not enough memory: at least 9.2 EB are needed");
        assert_eq!(with_room::<u64>(most / 8), Err(NoMemory { bytes: most as u64 - 7 }));
        assert_eq!(ask(u64::MAX).unwrap_err().bytes, u64::MAX);
    }

    #[test]
    fn the_free_space_is_measured_up_to_a_bound() {
        assert_eq!([free_space(0), free_space(5 << 20)], [0, 5 << 20]);
    }

    #[test]
    fn what_is_given_has_room_for_all() {
        assert_eq!(with_room::<u16>(1 << 20).unwrap().capacity(), 1 << 20);
        assert_eq!(ask(1 << 20), Ok(()));
    }

    #[test]
    fn sizes_have_one_decimal_and_at_most_three_digits_before_it() {
        let shown = [0, 999, 1000, 1949, 999_949, 999_950, 48_000_000, 12_884_901_888, u64::MAX];
        let expected = [
            "0 bytes",
            "999 bytes",
            "1.0 kB",
            "1.9 kB",
            "999.9 kB",
            "1.0 MB",
            "48.0 MB",
            "12.9 GB",
            "18.4 EB",
        ];
        assert_eq!(shown.map(|bytes| Bytes(bytes).to_string()), expected);
    }
}
