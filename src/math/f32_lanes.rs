//! Lanes of single precision in SIMD values, for the conservative tests of eight triangles or boxes at a time.
//!
//! Eight numbers take as many SIMD values as their lanes need, which are counted as parts: two of four lanes, or one of
//! eight.

use super::instructions::Portable;
use std::ops::{Add, BitAnd, Mul, Sub};
use wide::{f32x4, u32x4};

/// The numbers that are tested at a time.
pub const LANES: usize = 8;

/// Numbers in single precision. Where a comparison holds, all bits of the lane are set.
///
/// Implementations may differ in the last bits, since only some of them fuse multiplications with additions.
pub trait F32Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + BitAnd<Output = Self>
{
    /// Proves that the processor has the instructions that the implementation uses.
    type Proof: Copy;
    /// The number of lanes, which divides [`LANES`].
    const COUNT: usize;
    /// `x` in all lanes.
    fn splat(proof: Self::Proof, x: f32) -> Self;
    /// A part of eight numbers.
    fn load(proof: Self::Proof, numbers: &[f32; LANES], part: usize) -> Self;
    /// Stores these lanes as a part of eight numbers.
    fn store(self, numbers: &mut [f32; LANES], part: usize);
    /// The minima. Where both numbers are NaN, so is the minimum; where one is, either may be.
    fn min(self, other: Self) -> Self;
    /// The maxima. Where both numbers are NaN, so is the maximum; where one is, either may be.
    fn max(self, other: Self) -> Self;
    /// The absolute values.
    fn abs(self) -> Self;
    /// These numbers, negated where the sign bit of `other` is set.
    fn negated_with(self, other: Self) -> Self;
    /// a b + c, fused where the instructions can.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// a b - c, fused where the instructions can.
    fn mul_sub(self, b: Self, c: Self) -> Self;
    /// Where these numbers are at least the others, and neither is NaN.
    fn at_least(self, other: Self) -> Self;
    /// Where these numbers are above the others, and neither is NaN.
    fn above(self, other: Self) -> Self;
    /// The set of lanes whose sign bit is set, with bit 0 for the first lane of the part.
    fn sign_set(self) -> u32;
    /// The set of lanes of a part of these ids that equal one of two.
    fn lanes_with(proof: Self::Proof, ids: &[u32; LANES], part: usize, either: [u32; 2]) -> u32;

    /// a0 b0 + (a1 b1 + a2 b2).
    #[inline(always)]
    fn dot(a: [Self; 3], b: [Self; 3]) -> Self {
        a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
    }

    /// The cross product a x b.
    #[inline(always)]
    fn cross(a: [Self; 3], b: [Self; 3]) -> [Self; 3] {
        [a[1].mul_sub(b[2], a[2] * b[1]), a[2].mul_sub(b[0], a[0] * b[2]), a[0].mul_sub(b[1], a[1] * b[0])]
    }
}

/// Four lanes in what every processor of the target has: SSE2, NEON, or as many numbers.
impl F32Lanes for f32x4 {
    type Proof = Portable;
    const COUNT: usize = 4;

    #[inline(always)]
    fn splat(_: Portable, x: f32) -> Self {
        Self::splat(x)
    }

    #[inline(always)]
    fn load(_: Portable, numbers: &[f32; LANES], part: usize) -> Self {
        Self::new(half(numbers, part))
    }

    #[inline(always)]
    fn store(self, numbers: &mut [f32; LANES], part: usize) {
        numbers.as_chunks_mut().0[part] = self.to_array();
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.fast_min(other)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.fast_max(other)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn negated_with(self, other: Self) -> Self {
        self ^ (other & Self::splat(-0.0))
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self.mul_add(b, c)
    }

    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        self.mul_sub(b, c)
    }

    #[inline(always)]
    fn at_least(self, other: Self) -> Self {
        self.simd_ge(other)
    }

    #[inline(always)]
    fn above(self, other: Self) -> Self {
        self.simd_gt(other)
    }

    #[inline(always)]
    fn sign_set(self) -> u32 {
        self.to_bitmask()
    }

    #[inline(always)]
    fn lanes_with(_: Portable, ids: &[u32; LANES], part: usize, [a, b]: [u32; 2]) -> u32 {
        let ids = u32x4::new(half(ids, part));
        (ids.simd_eq(u32x4::splat(a)) | ids.simd_eq(u32x4::splat(b))).to_bitmask()
    }
}

/// The first four of eight, or the last.
#[inline(always)]
fn half<T: Copy>(of: &[T; LANES], part: usize) -> [T; 4] {
    of.as_chunks().0[part]
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: [f32; LANES] = [0.5, -0.0, 3.25, f32::NAN, -2.0, 1e-30, f32::NAN, f32::INFINITY];
    const B: [f32; LANES] = [0.25, 0.0, -7.1, f32::NAN, -2.0, 1e30, 1.0, 4.0];
    const C: [f32; LANES] = [-1.0, -1.5, 23.075, 0.0, 4.1, -1.0, 2.0, -0.0];

    /// The results of an operation on A, B and C.
    fn results<F: F32Lanes>(proof: F::Proof, operation: impl Fn([F; 3]) -> F) -> [f32; LANES] {
        let mut results = [0.0; LANES];
        for part in 0..LANES / F::COUNT {
            operation([A, B, C].map(|numbers| F::load(proof, &numbers, part))).store(&mut results, part);
        }
        results
    }

    /// The lanes where a comparison of A and B holds.
    fn set<F: F32Lanes>(proof: F::Proof, comparison: impl Fn(F, F) -> F) -> u32 {
        (0..LANES / F::COUNT).fold(0, |set, part| {
            let [a, b] = [A, B].map(|numbers| F::load(proof, &numbers, part));
            set | comparison(a, b).sign_set() << (part * F::COUNT)
        })
    }

    fn computes_as_numbers<F: F32Lanes>(proof: F::Proof) {
        // There may be two right results: a sum that is rounded once or twice, or either of two numbers.
        let check = |operation: fn([F; 3]) -> F, expected: fn([f32; 3]) -> [f32; 2]| {
            let found = results(proof, operation);
            for lane in 0..LANES {
                let numbers = [A[lane], B[lane], C[lane]];
                let is_found =
                    |x: f32| x.to_bits() == found[lane].to_bits() || x.is_nan() && found[lane].is_nan();
                assert!(expected(numbers).into_iter().any(is_found), "{numbers:?} {}", found[lane]);
            }
        };
        check(|[a, b, _]| a + b, |[a, b, _]| [a + b; 2]);
        check(|[a, b, _]| a - b, |[a, b, _]| [a - b; 2]);
        check(|[a, b, _]| a * b, |[a, b, _]| [a * b; 2]);
        check(|[a, b, c]| a.mul_add(b, c), |[a, b, c]| [a.mul_add(b, c), a * b + c]);
        check(|[a, b, c]| a.mul_sub(b, c), |[a, b, c]| [a.mul_add(b, -c), a * b - c]);
        check(|[a, ..]| a.abs(), |[a, ..]| [a.abs(); 2]);
        check(|[a, b, _]| a.negated_with(b), |[a, b, _]| [if b.is_sign_negative() { -a } else { a }; 2]);
        check(|[a, b, _]| a.min(b), |[a, b, _]| if a < b { [a; 2] } else { [if a > b { b } else { a }, b] });
        check(|[a, b, _]| a.max(b), |[a, b, _]| if a > b { [a; 2] } else { [if a < b { b } else { a }, b] });

        assert_eq!(set::<F>(proof, F::at_least), 0b1001_0111);
        assert_eq!(set::<F>(proof, F::above), 0b1000_0101);
        assert_eq!(set::<F>(proof, |a, b| a.at_least(b) & b.at_least(a)), 0b0001_0010);
        assert_eq!(set::<F>(proof, |a, _| a), 0b0001_0010);
        let ids = [7, 1, 2, 3, 4, 5, 6, 7];
        let with = |part: usize| F::lanes_with(proof, &ids, part, [7, 3]) << (part * F::COUNT);
        assert_eq!((0..LANES / F::COUNT).fold(0, |set, part| set | with(part)), 0b1000_1001);
    }

    #[test]
    fn lanes_compute_as_numbers_do() {
        computes_as_numbers::<f32x4>(Portable);
        #[cfg(target_arch = "x86_64")]
        if let Some(proof) = crate::math::instructions::Avx2::detect() {
            computes_as_numbers::<crate::math::avx::Avx8>(proof);
        }
    }
}
