//! Four floats side by side, so that whole registers do the work: one ray's three axes and a spare
//! place, or one axis of four rays.
//!
//! What stands in the spare place never reaches a result; it may be anything.

use std::ops::{Add, Div, Mul, Sub};

/// Arithmetic place by place. Every implementation gives the same bits.
pub trait Four:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    fn new(places: [f64; 4]) -> Self;
    fn splat(x: f64) -> Self;
    fn places(self) -> [f64; 4];
    /// One over each.
    #[inline(always)]
    fn inverse(self) -> Self {
        Self::splat(1.0) / self
    }
    fn abs(self) -> Self;
    /// The lesser; the other's where this one is NaN.
    fn min(self, other: Self) -> Self;
    /// The greater; the other's where this one is NaN.
    fn max(self, other: Self) -> Self;
    /// 1 where this is positive, 0 elsewhere.
    fn is_positive(self) -> Self;
    /// `one` where this has a sign, 0 elsewhere.
    fn sign_of(self, one: f64) -> Self;
    /// This where `other` is finite or NaN, `instead` where it is infinite.
    fn unless_infinite(self, other: Self, instead: f64) -> Self;
    /// The places where this is at most `other`, bit 0 for the first; none where one is NaN.
    fn at_most(self, other: Self) -> u32;
    /// Which of the three axes have a sign, bit 0 for x.
    fn signs(self) -> usize;
    /// The nearest whole numbers, of numbers that are below 2^31.
    fn whole(self) -> [i32; 4];
    /// To the nearest whole numbers, of numbers from 0 to 2^51.
    #[inline(always)]
    fn round(self) -> Self {
        (self + Self::splat(TO_WHOLE)) - Self::splat(TO_WHOLE)
    }
    /// To single precision.
    fn single(self) -> [f32; 4];
    /// The least of the three axes; the later one's where an axis is NaN.
    fn least(self) -> f64;
    /// The greatest of the three axes; the later one's where an axis is NaN.
    fn greatest(self) -> f64;
}

/// Added to a number below 2^51 it leaves no bits for a fraction, and the nearest whole number in
/// the lowest ones: 1.5 * 2^52. Faster than a conversion that must also say what becomes of others.
pub const TO_WHOLE: f64 = 6_755_399_441_055_744.0;

/// Runs on every machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plain([f64; 4]);

impl Plain {
    /// Place by place.
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }

    /// Place by place with another.
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

impl Four for Plain {
    #[inline(always)]
    fn new(places: [f64; 4]) -> Self {
        Self(places)
    }

    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self([x; 4])
    }

    #[inline(always)]
    fn places(self) -> [f64; 4] {
        self.0
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f64::abs)
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn is_positive(self) -> Self {
        self.map(|x| if x > 0.0 { 1.0 } else { 0.0 })
    }

    #[inline(always)]
    fn sign_of(self, one: f64) -> Self {
        self.map(|x| if x.is_sign_negative() { one } else { 0.0 })
    }

    #[inline(always)]
    fn unless_infinite(self, other: Self, instead: f64) -> Self {
        self.zip(other, |x, y| if y.abs() == f64::INFINITY { instead } else { x })
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> u32 {
        (0..4).fold(0, |set, i| set | u32::from(self.0[i] <= other.0[i]) << i)
    }

    #[inline(always)]
    fn signs(self) -> usize {
        let sign = |axis: usize| usize::from(self.0[axis].is_sign_negative()) << axis;
        sign(0) | sign(1) | sign(2)
    }

    #[inline(always)]
    fn whole(self) -> [i32; 4] {
        self.0.map(|x| (x + TO_WHOLE).to_bits() as i32)
    }

    #[inline(always)]
    fn single(self) -> [f32; 4] {
        self.0.map(|x| x as f32)
    }

    #[inline(always)]
    fn least(self) -> f64 {
        let least = |a: f64, b: f64| if a < b { a } else { b };
        least(least(self.0[0], self.0[1]), self.0[2])
    }

    #[inline(always)]
    fn greatest(self) -> f64 {
        let greatest = |a: f64, b: f64| if a > b { a } else { b };
        greatest(greatest(self.0[0], self.0[1]), self.0[2])
    }
}

impl Add for Plain {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Plain {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Plain {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Div for Plain {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
}

#[cfg(target_arch = "x86_64")]
pub use wide::Wide;

#[cfg(target_arch = "x86_64")]
mod wide {
    use super::{Add, Div, Four, Mul, Sub};
    use std::arch::x86_64::*;

    /// One AVX register. To be named only inside functions that are compiled for AVX and called
    /// after it was detected: all that is unsafe in here rests on that.
    #[derive(Clone, Copy, Debug)]
    pub struct Wide(__m256d);

    // SAFETY, of every block below: the instructions are there, see `Wide`.

    impl Wide {
        /// x, y and z, each in front of a register.
        #[inline(always)]
        fn axes(self) -> [__m128d; 3] {
            unsafe {
                let low = _mm256_castpd256_pd128(self.0);
                [low, _mm_unpackhi_pd(low, low), _mm256_extractf128_pd::<1>(self.0)]
            }
        }
    }

    impl Four for Wide {
        #[inline(always)]
        fn new([x, y, z, w]: [f64; 4]) -> Self {
            Self(unsafe { _mm256_set_pd(w, z, y, x) })
        }

        #[inline(always)]
        fn splat(x: f64) -> Self {
            Self(unsafe { _mm256_set1_pd(x) })
        }

        #[inline(always)]
        fn places(self) -> [f64; 4] {
            // Both are thirty-two bytes without padding.
            unsafe { std::mem::transmute(self.0) }
        }

        #[inline(always)]
        fn abs(self) -> Self {
            Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
        }

        #[inline(always)]
        fn min(self, other: Self) -> Self {
            Self(unsafe { _mm256_min_pd(self.0, other.0) })
        }

        #[inline(always)]
        fn max(self, other: Self) -> Self {
            Self(unsafe { _mm256_max_pd(self.0, other.0) })
        }

        #[inline(always)]
        fn is_positive(self) -> Self {
            let positive = unsafe { _mm256_cmp_pd::<_CMP_GT_OQ>(self.0, _mm256_setzero_pd()) };
            Self(unsafe { _mm256_and_pd(positive, _mm256_set1_pd(1.0)) })
        }

        #[inline(always)]
        fn sign_of(self, one: f64) -> Self {
            // The selection looks at the sign alone.
            Self(unsafe { _mm256_blendv_pd(_mm256_setzero_pd(), _mm256_set1_pd(one), self.0) })
        }

        #[inline(always)]
        fn unless_infinite(self, other: Self, instead: f64) -> Self {
            let infinity = Self::splat(f64::INFINITY).0;
            let infinite = unsafe { _mm256_cmp_pd::<_CMP_EQ_OQ>(other.abs().0, infinity) };
            Self(unsafe { _mm256_blendv_pd(self.0, _mm256_set1_pd(instead), infinite) })
        }

        #[inline(always)]
        fn at_most(self, other: Self) -> u32 {
            unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0)) as u32 }
        }

        #[inline(always)]
        fn signs(self) -> usize {
            unsafe { _mm256_movemask_pd(self.0) as usize & 7 }
        }

        #[inline(always)]
        fn whole(self) -> [i32; 4] {
            // Sixteen bytes each.
            unsafe { std::mem::transmute(_mm256_cvtpd_epi32(self.0)) }
        }

        #[inline(always)]
        fn single(self) -> [f32; 4] {
            unsafe { std::mem::transmute(_mm256_cvtpd_ps(self.0)) }
        }

        // By name: two such selections side by side the compiler would do as one, in four times as
        // many steps, for which the whole ray waits.
        #[inline(always)]
        fn least(self) -> f64 {
            let [x, y, z] = self.axes();
            unsafe { _mm_cvtsd_f64(_mm_min_sd(_mm_min_sd(x, y), z)) }
        }

        #[inline(always)]
        fn greatest(self) -> f64 {
            let [x, y, z] = self.axes();
            unsafe { _mm_cvtsd_f64(_mm_max_sd(_mm_max_sd(x, y), z)) }
        }
    }

    impl Add for Wide {
        type Output = Self;
        #[inline(always)]
        fn add(self, other: Self) -> Self {
            Self(unsafe { _mm256_add_pd(self.0, other.0) })
        }
    }

    impl Sub for Wide {
        type Output = Self;
        #[inline(always)]
        fn sub(self, other: Self) -> Self {
            Self(unsafe { _mm256_sub_pd(self.0, other.0) })
        }
    }

    impl Mul for Wide {
        type Output = Self;
        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            Self(unsafe { _mm256_mul_pd(self.0, other.0) })
        }
    }

    impl Div for Wide {
        type Output = Self;
        #[inline(always)]
        fn div(self, other: Self) -> Self {
            Self(unsafe { _mm256_div_pd(self.0, other.0) })
        }
    }
}
