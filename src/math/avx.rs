//! Four floats in one AVX register.

use super::f64x4::F64x4;
use super::instructions::Avx2;
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

/// One AVX register, and the proof that there is such a thing. In a function that is not itself compiled
/// for AVX it works as well, but slowly.
#[derive(Clone, Copy, Debug)]
pub struct Avx {
    lanes: __m256d,
    proof: Avx2,
}

/// Runs intrinsics of AVX, none of which may take a pointer, by an [`Avx2`].
macro_rules! avx {
    ($proof:expr, $intrinsics:expr) => {{
        let _: Avx2 = $proof;
        // SAFETY: there is an `Avx2` only where the processor has AVX2, of which AVX is a part, and
        // intrinsics without pointers ask for nothing else.
        unsafe { $intrinsics }
    }};
}

impl Avx {
    /// Other numbers by this one's proof.
    #[inline(always)]
    fn with(self, lanes: __m256d) -> Self {
        Self { lanes, ..self }
    }

    /// x, y and z, each in front of a register.
    #[inline(always)]
    fn axes(self) -> [__m128d; 3] {
        avx!(self.proof, {
            let low = _mm256_castpd256_pd128(self.lanes);
            [low, _mm_unpackhi_pd(low, low), _mm256_extractf128_pd::<1>(self.lanes)]
        })
    }
}

impl F64x4 for Avx {
    type Proof = Avx2;

    #[inline(always)]
    fn proof(self) -> Avx2 {
        self.proof
    }

    #[inline(always)]
    fn new(proof: Avx2, [x, y, z, w]: [f64; 4]) -> Self {
        Self { lanes: avx!(proof, _mm256_set_pd(w, z, y, x)), proof }
    }

    #[inline(always)]
    fn splat(proof: Avx2, x: f64) -> Self {
        Self { lanes: avx!(proof, _mm256_set1_pd(x)), proof }
    }

    #[inline(always)]
    fn to_array(self) -> [f64; 4] {
        bytemuck::cast(self.lanes)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.with(avx!(self.proof, _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.lanes)))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_min_pd(self.lanes, other.lanes)))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_max_pd(self.lanes, other.lanes)))
    }

    #[inline(always)]
    fn one_where_positive(self) -> Self {
        self.with(avx!(self.proof, {
            let positive = _mm256_cmp_pd::<_CMP_GT_OQ>(self.lanes, _mm256_setzero_pd());
            _mm256_and_pd(positive, _mm256_set1_pd(1.0))
        }))
    }

    #[inline(always)]
    fn where_negative(self, one: f64) -> Self {
        // The selection looks at the sign alone.
        let one = self.broadcast(one).lanes;
        self.with(avx!(self.proof, _mm256_blendv_pd(_mm256_setzero_pd(), one, self.lanes)))
    }

    #[inline(always)]
    fn unless_infinite(self, other: Self, instead: f64) -> Self {
        let (size, infinity, instead) = (other.abs(), self.broadcast(f64::INFINITY), self.broadcast(instead));
        self.with(avx!(self.proof, {
            let infinite = _mm256_cmp_pd::<_CMP_EQ_OQ>(size.lanes, infinity.lanes);
            _mm256_blendv_pd(self.lanes, instead.lanes, infinite)
        }))
    }

    #[inline(always)]
    fn le_mask(self, other: Self) -> u32 {
        avx!(self.proof, _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(self.lanes, other.lanes)) as u32)
    }

    #[inline(always)]
    fn sign_mask(self) -> usize {
        avx!(self.proof, _mm256_movemask_pd(self.lanes)) as usize & 7
    }

    #[inline(always)]
    fn to_i32(self) -> [i32; 4] {
        bytemuck::cast(avx!(self.proof, _mm256_cvtpd_epi32(self.lanes)))
    }

    #[inline(always)]
    fn to_f32(self) -> [f32; 4] {
        bytemuck::cast(avx!(self.proof, _mm256_cvtpd_ps(self.lanes)))
    }

    // By name: two such selections side by side the compiler would do as one, in four times as
    // many steps, for which the whole ray waits.
    #[inline(always)]
    fn min3(self) -> f64 {
        let [x, y, z] = self.axes();
        avx!(self.proof, _mm_cvtsd_f64(_mm_min_sd(_mm_min_sd(x, y), z)))
    }

    #[inline(always)]
    fn max3(self) -> f64 {
        let [x, y, z] = self.axes();
        avx!(self.proof, _mm_cvtsd_f64(_mm_max_sd(_mm_max_sd(x, y), z)))
    }
}

impl Add for Avx {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_add_pd(self.lanes, other.lanes)))
    }
}

impl Sub for Avx {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_sub_pd(self.lanes, other.lanes)))
    }
}

impl Mul for Avx {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_mul_pd(self.lanes, other.lanes)))
    }
}

impl Div for Avx {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_div_pd(self.lanes, other.lanes)))
    }
}
