//! Four floats in one AVX register.

use super::four::Four;
use super::instructions::Avx2;
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

/// One AVX register, and the proof that there is such a thing. In a function that is not itself compiled
/// for AVX it works as well, but slowly.
#[derive(Clone, Copy, Debug)]
pub struct Wide {
    places: __m256d,
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

impl Wide {
    /// Other numbers by this one's proof.
    #[inline(always)]
    fn with(self, places: __m256d) -> Self {
        Self { places, ..self }
    }

    /// x, y and z, each in front of a register.
    #[inline(always)]
    fn axes(self) -> [__m128d; 3] {
        avx!(self.proof, {
            let low = _mm256_castpd256_pd128(self.places);
            [low, _mm_unpackhi_pd(low, low), _mm256_extractf128_pd::<1>(self.places)]
        })
    }
}

impl Four for Wide {
    type Proof = Avx2;

    #[inline(always)]
    fn proof(self) -> Avx2 {
        self.proof
    }

    #[inline(always)]
    fn new(proof: Avx2, [x, y, z, w]: [f64; 4]) -> Self {
        Self { places: avx!(proof, _mm256_set_pd(w, z, y, x)), proof }
    }

    #[inline(always)]
    fn splat(proof: Avx2, x: f64) -> Self {
        Self { places: avx!(proof, _mm256_set1_pd(x)), proof }
    }

    #[inline(always)]
    fn places(self) -> [f64; 4] {
        bytemuck::cast(self.places)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.with(avx!(self.proof, _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.places)))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_min_pd(self.places, other.places)))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_max_pd(self.places, other.places)))
    }

    #[inline(always)]
    fn is_positive(self) -> Self {
        self.with(avx!(self.proof, {
            let positive = _mm256_cmp_pd::<_CMP_GT_OQ>(self.places, _mm256_setzero_pd());
            _mm256_and_pd(positive, _mm256_set1_pd(1.0))
        }))
    }

    #[inline(always)]
    fn sign_of(self, one: f64) -> Self {
        // The selection looks at the sign alone.
        let one = self.all(one).places;
        self.with(avx!(self.proof, _mm256_blendv_pd(_mm256_setzero_pd(), one, self.places)))
    }

    #[inline(always)]
    fn unless_infinite(self, other: Self, instead: f64) -> Self {
        let (size, infinity, instead) = (other.abs(), self.all(f64::INFINITY), self.all(instead));
        self.with(avx!(self.proof, {
            let infinite = _mm256_cmp_pd::<_CMP_EQ_OQ>(size.places, infinity.places);
            _mm256_blendv_pd(self.places, instead.places, infinite)
        }))
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> u32 {
        avx!(self.proof, _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(self.places, other.places)) as u32)
    }

    #[inline(always)]
    fn signs(self) -> usize {
        avx!(self.proof, _mm256_movemask_pd(self.places)) as usize & 7
    }

    #[inline(always)]
    fn whole(self) -> [i32; 4] {
        bytemuck::cast(avx!(self.proof, _mm256_cvtpd_epi32(self.places)))
    }

    #[inline(always)]
    fn single(self) -> [f32; 4] {
        bytemuck::cast(avx!(self.proof, _mm256_cvtpd_ps(self.places)))
    }

    // By name: two such selections side by side the compiler would do as one, in four times as
    // many steps, for which the whole ray waits.
    #[inline(always)]
    fn least(self) -> f64 {
        let [x, y, z] = self.axes();
        avx!(self.proof, _mm_cvtsd_f64(_mm_min_sd(_mm_min_sd(x, y), z)))
    }

    #[inline(always)]
    fn greatest(self) -> f64 {
        let [x, y, z] = self.axes();
        avx!(self.proof, _mm_cvtsd_f64(_mm_max_sd(_mm_max_sd(x, y), z)))
    }
}

impl Add for Wide {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_add_pd(self.places, other.places)))
    }
}

impl Sub for Wide {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_sub_pd(self.places, other.places)))
    }
}

impl Mul for Wide {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_mul_pd(self.places, other.places)))
    }
}

impl Div for Wide {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_div_pd(self.places, other.places)))
    }
}
