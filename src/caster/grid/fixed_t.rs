//! The fixed-point t of the next face crossing along each axis, and the step of the DDA that advances the
//! smallest.

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

/// Three integers, for x, y and z. On x86-64 they share an SSE2 register, which every such processor has.
#[derive(Clone, Copy, Debug)]
pub struct FixedT(#[cfg(target_arch = "x86_64")] __m128i, #[cfg(not(target_arch = "x86_64"))] [i32; 4]);

#[cfg(target_arch = "x86_64")]
impl FixedT {
    /// Of x, y and z; the fourth lane is ignored.
    #[inline(always)]
    pub fn new(lanes: [i32; 4]) -> Self {
        Self(bytemuck::cast(lanes))
    }

    /// The minimum of the three.
    #[inline(always)]
    pub fn min3(self) -> i32 {
        let t = self.0;
        // SAFETY: every x86-64 processor has SSE2, and intrinsics without pointers have no further
        // requirements.
        unsafe {
            let y = _mm_shuffle_epi32::<0b01_01_01_01>(t);
            let z = _mm_shuffle_epi32::<0b10_10_10_10>(t);
            _mm_cvtsi128_si32(min(min(t, y), z))
        }
    }

    /// Adds `t_delta` to all lanes that equal the minimum, wrapping on overflow, and returns the set of the
    /// other axes (bit 0 for x).
    #[inline(always)]
    pub fn step(&mut self, t_delta: Self) -> usize {
        let t = self.0;
        // The unused lane is compared with itself, so it is never in the set. SAFETY: every x86-64 processor
        // has SSE2, and intrinsics without pointers have no further requirements.
        unsafe {
            let yzx = _mm_shuffle_epi32::<0b11_00_10_01>(t);
            let zxy = _mm_shuffle_epi32::<0b11_01_00_10>(t);
            let unstepped = _mm_or_si128(_mm_cmpgt_epi32(t, yzx), _mm_cmpgt_epi32(t, zxy));
            self.0 = _mm_add_epi32(t, _mm_andnot_si128(unstepped, t_delta.0));
            _mm_movemask_ps(_mm_castsi128_ps(unstepped)) as usize
        }
    }
}

/// The lane-wise minimum.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn min(a: __m128i, b: __m128i) -> __m128i {
    // SAFETY: every x86-64 processor has SSE2, and intrinsics without pointers have no further requirements.
    unsafe {
        let less = _mm_cmplt_epi32(a, b);
        _mm_or_si128(_mm_and_si128(less, a), _mm_andnot_si128(less, b))
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl FixedT {
    /// Of x, y and z; the fourth lane is ignored.
    #[inline(always)]
    pub fn new(lanes: [i32; 4]) -> Self {
        Self(lanes)
    }

    /// The minimum of the three.
    #[inline(always)]
    pub fn min3(self) -> i32 {
        let [x, y, z, _] = self.0;
        x.min(y).min(z)
    }

    /// Adds `t_delta` to all lanes that equal the minimum, wrapping on overflow, and returns the set of the
    /// other axes (bit 0 for x).
    #[inline(always)]
    pub fn step(&mut self, t_delta: Self) -> usize {
        let (min, mut unstepped) = (self.min3(), 0);
        for axis in 0..3 {
            let steps = self.0[axis] == min;
            self.0[axis] = self.0[axis].wrapping_add(if steps { t_delta.0[axis] } else { 0 });
            unstepped |= usize::from(!steps) << axis;
        }
        unstepped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_of_the_three_step() {
        let t_delta = FixedT::new([10, 20, 30, 0]);
        for ([x, y, z], min3, stepped, next) in [
            ([1, 2, 3], 1, 0b001, 2),
            ([3, 2, 9], 2, 0b010, 3),
            ([5, 4, -7], -7, 0b100, 4),
            ([4, 4, 9], 4, 0b011, 9),
            ([9, 4, 4], 4, 0b110, 9),
            ([4, 9, 4], 4, 0b101, 9),
            ([6, 6, 6], 6, 0b111, 16),
        ] {
            let mut t = FixedT::new([x, y, z, -9]);
            assert_eq!((t.min3(), t.step(t_delta), t.min3()), (min3, 7 - stepped, next), "{x} {y} {z}");
        }
    }

    #[test]
    fn steps_wrap_on_overflow() {
        let mut t = FixedT::new([i32::MAX; 4]);
        assert_eq!(t.step(FixedT::new([1; 4])), 0);
        assert_eq!(t.min3(), i32::MIN);
    }
}
