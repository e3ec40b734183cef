//! Numbers in one or in four lanes. A formula that is written over [`Number`] computes one result from plain
//! numbers, or four results from [`f64x4`](fearless_simd::f64x4), each with the same bits.

use super::extremes;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// One number, or one in each of several lanes. A set of lanes is a number whose bit 0 stands for the first lane.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Proves that the processor has the instructions that the implementation uses.
    type Proof: Copy;
    /// The proof that this value was made with.
    fn proof(self) -> Self::Proof;
    /// `x` in all lanes.
    fn splat(proof: Self::Proof, x: f64) -> Self;
    /// `x` in all lanes, with the proof of this value.
    #[inline(always)]
    fn broadcast(self, x: f64) -> Self {
        Self::splat(self.proof(), x)
    }
    /// The reciprocals.
    #[inline(always)]
    fn recip(self) -> Self {
        self.broadcast(1.0) / self
    }
    /// The absolute values.
    fn abs(self) -> Self;
    /// The minima; the lane of `other` where either one is NaN.
    fn min(self, other: Self) -> Self;
    /// The maxima; the lane of `other` where either one is NaN.
    fn max(self, other: Self) -> Self;
    /// The square roots.
    fn sqrt(self) -> Self;
    /// `then` where this is less than `other`, and `otherwise` elsewhere.
    fn select_lt(self, other: Self, then: Self, otherwise: Self) -> Self;
    /// The set of lanes where this is at most `other`. A lane with a NaN is not in it.
    fn le_mask(self, other: Self) -> u32;
    /// The set of lanes where this is less than `other`. A lane with a NaN is not in it.
    fn lt_mask(self, other: Self) -> u32;
}

impl Number for f64 {
    type Proof = ();

    #[inline(always)]
    fn proof(self) {}

    #[inline(always)]
    fn splat(_: (), x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        extremes::min(self, other)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        extremes::max(self, other)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline(always)]
    fn select_lt(self, other: Self, then: Self, otherwise: Self) -> Self {
        if self < other { then } else { otherwise }
    }

    #[inline(always)]
    fn le_mask(self, other: Self) -> u32 {
        u32::from(self <= other)
    }

    #[inline(always)]
    fn lt_mask(self, other: Self) -> u32 {
        u32::from(self < other)
    }
}
