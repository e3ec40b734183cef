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
