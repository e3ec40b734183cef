//! Which instruction sets the inner loops may use. They are compiled for each [`Level`], whose tokens prove that the
//! processor has the instructions. Hits and pictures do not depend on it.

use crate::base::shortcut::Shortcut;
pub use fearless_simd::Level;
#[cfg(target_arch = "x86_64")]
use fearless_simd::Simd;

/// The levels that this machine can run, the fastest first and last the one that the compilation target guarantees.
pub fn available() -> Vec<Level> {
    let mut levels = Vec::new();
    #[cfg(target_arch = "x86_64")]
    {
        let best = Level::new();
        levels.extend(best.as_avx2().filter(|_| Shortcut::Avx2.is_taken()).map(|simd| simd.level()));
        levels.extend(best.as_sse4_2().filter(|_| Shortcut::Sse4_2.is_taken()).map(|simd| simd.level()));
    }
    levels.push(Level::baseline());
    levels
}
