//! Asking for memory ahead, so that waits for it overlap.

/// Asks for something that will be read soon. Nothing but the time of that changes.
#[inline(always)]
pub fn prefetch<T>(soon: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        const LINE: usize = 64;
        let start: *const i8 = std::ptr::from_ref(soon).cast();
        for line in (0..size_of::<T>()).step_by(LINE) {
            // SAFETY: nothing is read, and every address is allowed.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(line)) }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = soon;
}
