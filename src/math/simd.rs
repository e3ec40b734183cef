//! Numbers in one or in four lanes. A formula over [`Number`] computes one result from plain numbers, or four results
//! from [`f64x4`]. Each has the same bits, whatever the instruction set is.
//!
//! Four lanes hold the three axes of one ray and an unused fourth lane, or one axis of four rays. The unused lane never
//! influences a result and may hold any value.

use super::extremes;
use super::ray::Ray;
use fearless_simd::prelude::*;
use fearless_simd::{f64x2, f64x4, mask64x4};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// One number, or one in each of several lanes. A set of lanes is a number whose bit 0 stands for the first lane.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Proves that the processor has the instructions that the implementation uses.
    type Proof: Copy;
    /// Returns the proof with which this value was made.
    fn proof(self) -> Self::Proof;
    /// Returns `x` in all lanes.
    fn splat(proof: Self::Proof, x: f64) -> Self;
    /// Returns `x` in all lanes, with the proof of this value.
    #[inline(always)]
    fn broadcast(self, x: f64) -> Self {
        Self::splat(self.proof(), x)
    }
    /// Returns the reciprocals.
    #[inline(always)]
    fn recip(self) -> Self {
        self.broadcast(1.0) / self
    }
    /// Returns the absolute values.
    fn abs(self) -> Self;
    /// Returns the minima, and the lane of `other` if either one is NaN.
    fn min(self, other: Self) -> Self;
    /// Returns the maxima, and the lane of `other` if either one is NaN.
    fn max(self, other: Self) -> Self;
    /// Returns the square roots.
    fn sqrt(self) -> Self;
    /// Returns `then` in lanes where this is less than `other`, and `otherwise` in the others.
    fn select_lt(self, other: Self, then: Self, otherwise: Self) -> Self;
    /// Returns the set of lanes where this is at most `other`. A lane with a NaN is not in it.
    fn le_mask(self, other: Self) -> u32;
    /// Returns the set of lanes where this is less than `other`. A lane with a NaN is not in it.
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

/// The number of lanes.
pub const LANES: usize = 4;

/// 1.5 * 2^52. If this constant is added to a number below 2^51, the sum is so large that its last bit stands for 1. So
/// it is rounded to an integer, which its lowest bits hold. This is faster than a conversion with `as`, which must also
/// handle NaN and numbers out of range.
pub const ROUND_TO_INTEGER: f64 = 1.5 * (1u64 << 52) as f64;

impl<S: Simd> Number for f64x4<S> {
    type Proof = S;

    #[inline(always)]
    fn proof(self) -> S {
        self.token()
    }

    #[inline(always)]
    fn splat(simd: S, x: f64) -> Self {
        SimdBase::splat(simd, x)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        SimdBase::abs(self)
    }

    // On x86 this is one instruction. The instructions of other processors return a NaN if either number is one.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if cfg!(target_arch = "x86_64") {
            SimdBase::min(self, other)
        } else {
            self.select_lt(other, self, other)
        }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if cfg!(target_arch = "x86_64") {
            SimdBase::max(self, other)
        } else {
            other.select_lt(self, self, other)
        }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        SimdFloat::sqrt(self)
    }

    #[inline(always)]
    fn select_lt(self, other: Self, then: Self, otherwise: Self) -> Self {
        self.simd_lt(other).select(then, otherwise)
    }

    #[inline(always)]
    fn le_mask(self, other: Self) -> u32 {
        self.simd_le(other).to_bitmask() as u32
    }

    #[inline(always)]
    fn lt_mask(self, other: Self) -> u32 {
        self.simd_lt(other).to_bitmask() as u32
    }
}

/// Operations on four lanes that a single number does not need.
pub trait FourLanes: Number {
    /// Returns the lanes as an array.
    fn to_array(self) -> [f64; 4];
    /// Returns the set of axes (the first three lanes) whose sign bit is set, bit 0 for x.
    fn sign_mask(self) -> usize;
    /// Rounds to the nearest integers, for absolute values below 2^31.
    fn to_i32(self) -> [i32; 4];
    /// Rounds to single precision.
    fn to_f32(self) -> [f32; 4];
    /// Returns the minimum of the three axes. If two are compared and one is NaN, the later axis counts.
    fn min3(self) -> f64;
    /// Returns the maximum of the three axes. If two are compared and one is NaN, the later axis counts.
    fn max3(self) -> f64;
}

impl<S: Simd> FourLanes for f64x4<S> {
    #[inline(always)]
    fn to_array(self) -> [f64; 4] {
        self.into()
    }

    #[inline(always)]
    fn sign_mask(self) -> usize {
        self.is_sign_negative().to_bitmask() as usize & 7
    }

    // Each lane is named, since an array's `map` is not always inlined.
    #[inline(always)]
    fn to_i32(self) -> [i32; 4] {
        let [x, y, z, w]: [f64; 4] = (self + ROUND_TO_INTEGER).into();
        [x.to_bits() as i32, y.to_bits() as i32, z.to_bits() as i32, w.to_bits() as i32]
    }

    #[inline(always)]
    fn to_f32(self) -> [f32; 4] {
        self.narrow(self).split().0.into()
    }

    #[inline(always)]
    fn min3(self) -> f64 {
        let [x, y, z] = axes(self);
        if cfg!(target_arch = "x86_64") { x.min(y).min(z)[0] } else { extremes::min3([x[0], y[0], z[0]]) }
    }

    #[inline(always)]
    fn max3(self) -> f64 {
        let [x, y, z] = axes(self);
        if cfg!(target_arch = "x86_64") { x.max(y).max(z)[0] } else { extremes::max3([x[0], y[0], z[0]]) }
    }
}

/// Returns the last two lanes, followed by the first two.
#[inline(always)]
pub fn swap_halves<S: Simd>(lanes: f64x4<S>) -> f64x4<S> {
    let (low, high) = lanes.split();
    high.combine(low)
}

/// Returns the sum of the lanes of each of these, (a + c) + (b + d).
#[inline(always)]
pub fn sums<S: Simd>([p, q, r, s]: [f64x4<S>; 4]) -> f64x4<S> {
    let (pr, qs) = (sums_of_halves(p, r), sums_of_halves(q, s));
    // Two steps within halves, since steps across them take three times as long.
    let odd = mask64x4::from_bitmask(p.token(), 0b1010);
    pr.slide_within_blocks::<1>(qs) + odd.select(qs, pr)
}

/// Returns lanes 0 and 1 plus lanes 2 and 3 of `p`, followed by those sums of `r`.
#[inline(always)]
fn sums_of_halves<S: Simd>(p: f64x4<S>, r: f64x4<S>) -> f64x4<S> {
    let ((p_low, p_high), (r_low, r_high)) = (p.split(), r.split());
    p_low.combine(r_low) + p_high.combine(r_high)
}

/// Returns the x, y and z lanes, each in the lowest lane of a pair. The compiler would merge adjacent minima and maxima
/// of plain numbers into one vector sequence four times as long, which is on the critical path of every ray.
#[inline(always)]
fn axes<S: Simd>(lanes: f64x4<S>) -> [f64x2<S>; 3] {
    let (xy, z) = lanes.split();
    [xy, xy.slide::<1>(xy), z]
}

/// All axes of a ray.
#[derive(Clone, Copy, Debug)]
pub struct RayLanes<S: Simd> {
    /// The point at t = 0.
    pub origin: f64x4<S>,
    /// The direction, of any length.
    pub direction: f64x4<S>,
    /// The reciprocal of the direction.
    pub inv_direction: f64x4<S>,
}

impl<S: Simd> RayLanes<S> {
    /// Returns the three axes of a ray. The unused lanes repeat numbers that are in registers anyway.
    #[inline(always)]
    pub fn all_axes(simd: S, ray: &Ray) -> Self {
        let (o, d) = (ray.origin, ray.direction);
        let origin = f64x4::simd_from(simd, [o.x, o.y, o.z, d.x]);
        let direction = f64x4::simd_from(simd, [d.x, d.y, d.z, ray.t_max]);
        Self { origin, direction, inv_direction: Number::recip(direction) }
    }
}

/// Returns the members of a set of lanes, in order.
#[inline(always)]
pub fn lanes(mut set: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = set.trailing_zeros() as usize;
        (set != 0).then(|| {
            set &= set - 1;
            lane
        })
    })
}

/// Computes exp(x) for x from -708, below which results would be subnormal, to 0.
///
/// It takes the steps of `libm::exp` (FreeBSD's e_exp.c, Sun Microsystems, 2004), so that the result has the same
/// bits: x = k ln 2 + r with an integer k and |r| at most ln(2) / 2, and exp(r) = 1 + r + r c / (2 - c) with
/// c = r - (P1 r^2 + ... + P5 r^10). Where that function branches, this one selects.
#[inline(always)]
pub fn exp_of_negative<S: Simd>(x: f64x4<S>) -> f64x4<S> {
    /// ln 2 in two parts. The first has so few bits that its product with k is exact.
    const LN_2: [f64; 2] = [0.6931471803691238, 1.9082149292705877e-10];
    const P: [f64; 5] = [
        0.16666666666666602,
        -0.0027777777777015593,
        6.613756321437934e-5,
        -1.6533902205465252e-6,
        4.1381367970572385e-8,
    ];
    /// The number of bits below a float's exponent.
    const EXPONENT_SHIFT: u32 = 52;
    // Above the first, k is 0; above the second, exp(x) is 1 + x. `libm::exp` compares the upper halves of the
    // bits.
    let (no_multiple, no_square) =
        (-f64::from_bits(0x3FD6_2E42_FFFF_FFFF), -f64::from_bits(0x3E30_0000_FFFF_FFFF));
    let splat = |number: f64| x.broadcast(number);
    let (zero, one) = (splat(0.0), splat(1.0));

    // The conversion to an integer rounds towards zero, which is upwards here.
    let multiple = fearless_simd::SimdFloat::ceil(splat(std::f64::consts::LOG2_E) * x - splat(0.5));
    let k = x.select_lt(splat(no_multiple), multiple, zero);
    let high = x - k * splat(LN_2[0]);
    let low = k * splat(LN_2[1]);
    let r = high - low;
    let square = r * r;
    let polynomial = P.into_iter().rev().map(splat).reduce(|sum, p| p + square * sum).unwrap_or(zero);
    let c = r - square * polynomial;
    let curved = x.select_lt(splat(no_square), r * c / (splat(2.0) - c), zero);
    // The bits of k are added to the exponent. The product is not subnormal.
    let exponents = (k + ROUND_TO_INTEGER).to_bits() << EXPONENT_SHIFT;
    f64x4::from_bits((one + ((curved - low) + high)).to_bits() + exponents)
}

#[cfg(test)]
mod tests;
