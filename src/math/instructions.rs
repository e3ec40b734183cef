//! Instructions that not every processor has, and proofs that this one has them.

/// Proof of nothing: instructions that every processor has that the program is compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Portable;

/// Proof that this processor has AVX2, FMA and the bit manipulation that comes with them. Only
/// [`Avx2::detect`] makes one, and only where that is so; so safe code cannot run these instructions
/// elsewhere:
///
/// ```compile_fail
/// let claimed = raytracer::math::instructions::Avx2(());
/// ```
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Avx2(());

#[cfg(target_arch = "x86_64")]
impl Avx2 {
    /// Asks the processor, and the system whether it keeps the registers. Whatever is compiled with
    /// `#[target_feature]` and called on the strength of this type enables no more than these features.
    pub fn detect() -> Option<Self> {
        use std::arch::is_x86_feature_detected as has;
        let vectors = has!("avx2") && has!("fma");
        let bits = has!("bmi1") && has!("bmi2") && has!("lzcnt") && has!("popcnt");
        (vectors && bits).then_some(Self(()))
    }
}

/// The instructions that the inner loop is compiled for. Every hit is the same with each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instructions {
    /// Those that every processor has.
    Portable,
    /// Eight numbers of single precision at once, or four of double.
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
}

impl Instructions {
    /// What this machine can run, the fastest first.
    pub fn available() -> Vec<Self> {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = Avx2::detect() {
            return vec![Self::Avx2(avx2), Self::Portable];
        }
        vec![Self::Portable]
    }
}
