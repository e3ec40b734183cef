//! The instruction sets that the inner loops may use. The loops are compiled for each [`Level`], whose tokens prove
//! that the processor has the instructions. Hits and pictures do not depend on the level.

pub use fearless_simd::Level;
#[cfg(target_arch = "x86_64")]
use {crate::base::shortcut::Shortcut, fearless_simd::Simd as _};

/// Returns the levels that this machine can run, from the fastest to the one that the compilation target guarantees.
pub fn available() -> Vec<Level> {
    #[cfg(not(target_arch = "x86_64"))]
    let best = None;
    #[cfg(target_arch = "x86_64")]
    let best = Level::new().as_avx2().filter(|_| Shortcut::Avx2.is_taken()).map(|simd| simd.level());
    best.into_iter().chain([Level::baseline()]).collect()
}

/// Prefetches all cache lines of a value that will be read soon. This affects only the time, and does nothing on
/// processors other than x86-64.
#[inline(always)]
pub fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        const LINE: usize = 64;
        let start: *const i8 = std::ptr::from_ref(value).cast();
        for line in (0..size_of::<T>()).step_by(LINE) {
            // SAFETY: a prefetch reads nothing that the program can observe, and never faults on any address.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(line)) }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}
