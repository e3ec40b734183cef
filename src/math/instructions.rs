//! Which instructions the inner loops may use. Zero-sized values prove that the processor has them, so that
//! safe code cannot reach an instruction that would fault.

#[cfg(target_arch = "x86_64")]
use crate::shortcut::Shortcut;

/// The empty proof: only instructions of the target that the program is compiled for are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Portable;

/// Proof that this processor has AVX2, FMA and the bit-manipulation instructions that come with them. Only
/// [`Avx2::detect`] makes such a value, so that safe code cannot run these instructions on another processor:
///
/// ```compile_fail
/// let claimed = raytracer::math::instructions::Avx2(());
/// ```
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Avx2(());

#[cfg(target_arch = "x86_64")]
impl Avx2 {
    /// Detects the features at run time, including whether the operating system saves the registers. A
    /// function with `#[target_feature]` that is called on the strength of this proof must enable no further
    /// features.
    pub fn detect() -> Option<Self> {
        use std::arch::is_x86_feature_detected as has;
        let vectors = has!("avx2") && has!("fma");
        let bits = has!("bmi1") && has!("bmi2") && has!("lzcnt") && has!("popcnt");
        (vectors && bits).then_some(Self(()))
    }
}

/// The instruction set that the inner loops are compiled for. Hits do not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instructions {
    /// Only what the compilation target guarantees.
    Portable,
    /// Eight lanes in single precision, or four in double precision.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
}

impl Instructions {
    /// The instruction sets that this machine can run, the fastest first.
    pub fn available() -> Vec<Self> {
        #[cfg(target_arch = "x86_64")]
        if Shortcut::Avx2.is_taken()
            && let Some(avx2) = Avx2::detect()
        {
            return vec![Self::Avx2(avx2), Self::Portable];
        }
        vec![Self::Portable]
    }
}
