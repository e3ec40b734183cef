//! The AVX implementations of [`F64x4`], four floats in one register, and of [`F32Lanes`], eight of single precision. For
//! rays the former is the fast counterpart of [`Scalar`](super::f64x4::Scalar) and gives the same bits.

use super::f32_lanes::{F32Lanes, LANES};
use super::f64x4::{EXPONENT_SHIFT, F64x4, ROUND_TO_INTEGER};
use super::instructions::Avx2;
use super::number::Number;
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, Div, Mul, Neg, Sub};

/// Four floats in an AVX register, together with the proof that the processor has AVX. The operations are
/// fast only in functions that are themselves compiled for AVX; elsewhere each one becomes a function call.
#[derive(Clone, Copy, Debug)]
pub struct Avx {
    lanes: __m256d,
    proof: Avx2,
}

/// Evaluates an expression of AVX intrinsics, none of which may take a pointer, on the strength of an
/// [`Avx2`].
macro_rules! avx {
    ($proof:expr, $intrinsics:expr) => {{
        let _: Avx2 = $proof;
        // SAFETY: a value of type `Avx2` exists only when the processor has AVX2, which includes AVX, and
        // intrinsics without pointers have no further requirements.
        unsafe { $intrinsics }
    }};
}

impl Avx {
    /// Wraps other lanes with the proof of this value.
    #[inline(always)]
    fn with(self, lanes: __m256d) -> Self {
        Self { lanes, ..self }
    }

    /// The x, y and z lanes, each in the lowest lane of a register of its own.
    #[inline(always)]
    fn axes(self) -> [__m128d; 3] {
        avx!(self.proof, {
            let xy = _mm256_castpd256_pd128(self.lanes);
            [xy, _mm_unpackhi_pd(xy, xy), _mm256_extractf128_pd::<1>(self.lanes)]
        })
    }
}

impl Number for Avx {
    type Proof = Avx2;

    #[inline(always)]
    fn proof(self) -> Avx2 {
        self.proof
    }

    #[inline(always)]
    fn splat(proof: Avx2, x: f64) -> Self {
        Self { lanes: avx!(proof, _mm256_set1_pd(x)), proof }
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
    fn sqrt(self) -> Self {
        self.with(avx!(self.proof, _mm256_sqrt_pd(self.lanes)))
    }

    #[inline(always)]
    fn select_lt(self, other: Self, then: Self, otherwise: Self) -> Self {
        self.with(avx!(self.proof, {
            let less = _mm256_cmp_pd::<_CMP_LT_OQ>(self.lanes, other.lanes);
            _mm256_or_pd(_mm256_and_pd(less, then.lanes), _mm256_andnot_pd(less, otherwise.lanes))
        }))
    }

    #[inline(always)]
    fn le_mask(self, other: Self) -> u32 {
        avx!(self.proof, _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(self.lanes, other.lanes)) as u32)
    }

    #[inline(always)]
    fn lt_mask(self, other: Self) -> u32 {
        avx!(self.proof, _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(self.lanes, other.lanes)) as u32)
    }
}

impl F64x4 for Avx {
    #[inline(always)]
    fn new(proof: Avx2, [x, y, z, w]: [f64; 4]) -> Self {
        Self { lanes: avx!(proof, _mm256_set_pd(w, z, y, x)), proof }
    }

    #[inline(always)]
    fn to_array(self) -> [f64; 4] {
        bytemuck::cast(self.lanes)
    }

    #[inline(always)]
    fn one_where_positive(self) -> Self {
        self.with(avx!(self.proof, {
            let positive = _mm256_cmp_pd::<_CMP_GT_OQ>(self.lanes, _mm256_setzero_pd());
            _mm256_and_pd(positive, _mm256_set1_pd(1.0))
        }))
    }

    #[inline(always)]
    fn unless_infinite(self, other: Self, replacement: f64) -> Self {
        let (infinity, replacement) = (self.broadcast(f64::INFINITY), self.broadcast(replacement));
        let abs = other.abs();
        self.with(avx!(self.proof, {
            let infinite = _mm256_cmp_pd::<_CMP_EQ_OQ>(abs.lanes, infinity.lanes);
            _mm256_blendv_pd(self.lanes, replacement.lanes, infinite)
        }))
    }

    #[inline(always)]
    fn times_exp2(self, exponents: Self) -> Self {
        let exponents = exponents + self.broadcast(ROUND_TO_INTEGER);
        self.with(avx!(self.proof, {
            let exponents = _mm256_slli_epi64::<EXPONENT_SHIFT>(_mm256_castpd_si256(exponents.lanes));
            _mm256_castsi256_pd(_mm256_add_epi64(_mm256_castpd_si256(self.lanes), exponents))
        }))
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
    fn ceil(self) -> Self {
        self.with(avx!(self.proof, _mm256_ceil_pd(self.lanes)))
    }

    #[inline(always)]
    fn floor(self) -> Self {
        self.with(avx!(self.proof, _mm256_floor_pd(self.lanes)))
    }

    #[inline(always)]
    fn sums([p, q, r, s]: [Self; 4]) -> Self {
        p.with(avx!(p.proof, {
            // The halves of each of the four: p and q in one register, r and s in the other.
            let (pq, rs) = (_mm256_hadd_pd(p.lanes, q.lanes), _mm256_hadd_pd(r.lanes, s.lanes));
            let first = _mm256_permute2f128_pd::<0x20>(pq, rs);
            let second = _mm256_permute2f128_pd::<0x31>(pq, rs);
            _mm256_add_pd(first, second)
        }))
    }

    #[inline(always)]
    fn swap_halves(self) -> Self {
        self.with(avx!(self.proof, _mm256_permute2f128_pd::<0x01>(self.lanes, self.lanes)))
    }

    #[inline(always)]
    fn to_f32(self) -> [f32; 4] {
        bytemuck::cast(avx!(self.proof, _mm256_cvtpd_ps(self.lanes)))
    }

    // The scalar instructions are named explicitly, since the compiler would merge adjacent generic minima
    // and maxima into one vector sequence four times as long, which is on the critical path of every ray.
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

impl Neg for Avx {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.with(avx!(self.proof, _mm256_xor_pd(_mm256_set1_pd(-0.0), self.lanes)))
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

/// Eight floats of single precision in an AVX register, with the same proof.
#[derive(Clone, Copy, Debug)]
pub struct Avx8 {
    lanes: __m256,
    proof: Avx2,
}

impl Avx8 {
    /// Wraps other lanes with the proof of this value.
    #[inline(always)]
    fn with(self, lanes: __m256) -> Self {
        Self { lanes, ..self }
    }
}

impl F32Lanes for Avx8 {
    type Proof = Avx2;
    const COUNT: usize = 8;

    #[inline(always)]
    fn splat(proof: Avx2, x: f32) -> Self {
        Self { lanes: avx!(proof, _mm256_set1_ps(x)), proof }
    }

    #[inline(always)]
    fn load(proof: Avx2, numbers: &[f32; LANES], _: usize) -> Self {
        Self { lanes: bytemuck::cast(*numbers), proof }
    }

    #[inline(always)]
    fn store(self, numbers: &mut [f32; LANES], _: usize) {
        *numbers = bytemuck::cast(self.lanes);
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_min_ps(self.lanes, other.lanes)))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_max_ps(self.lanes, other.lanes)))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.with(avx!(self.proof, _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.lanes)))
    }

    #[inline(always)]
    fn negated_with(self, other: Self) -> Self {
        let sign = avx!(self.proof, _mm256_and_ps(other.lanes, _mm256_set1_ps(-0.0)));
        self.with(avx!(self.proof, _mm256_xor_ps(self.lanes, sign)))
    }

    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self.with(avx!(self.proof, _mm256_fmadd_ps(self.lanes, b.lanes, c.lanes)))
    }

    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        self.with(avx!(self.proof, _mm256_fmsub_ps(self.lanes, b.lanes, c.lanes)))
    }

    #[inline(always)]
    fn at_least(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_cmp_ps::<_CMP_GE_OQ>(self.lanes, other.lanes)))
    }

    #[inline(always)]
    fn above(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_cmp_ps::<_CMP_GT_OQ>(self.lanes, other.lanes)))
    }

    #[inline(always)]
    fn sign_set(self) -> u32 {
        avx!(self.proof, _mm256_movemask_ps(self.lanes)) as u32
    }

    #[inline(always)]
    fn lanes_with(proof: Avx2, ids: &[u32; LANES], _: usize, either: [u32; 2]) -> u32 {
        let ids: __m256i = bytemuck::cast(*ids);
        avx!(proof, {
            let a = _mm256_cmpeq_epi32(ids, _mm256_set1_epi32(either[0] as i32));
            let b = _mm256_cmpeq_epi32(ids, _mm256_set1_epi32(either[1] as i32));
            _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_or_si256(a, b))) as u32
        })
    }
}

impl BitAnd for Avx8 {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_and_ps(self.lanes, other.lanes)))
    }
}

impl Add for Avx8 {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_add_ps(self.lanes, other.lanes)))
    }
}

impl Sub for Avx8 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_sub_ps(self.lanes, other.lanes)))
    }
}

impl Mul for Avx8 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(avx!(self.proof, _mm256_mul_ps(self.lanes, other.lanes)))
    }
}
