//! Three counts side by side, one for each axis, and the step that the least of them takes.

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

/// Whole numbers for x, y and z. On x86-64 they share a register (SSE2, which is always present).
#[derive(Clone, Copy, Debug)]
pub struct FixedT(#[cfg(target_arch = "x86_64")] __m128i, #[cfg(not(target_arch = "x86_64"))] [i32; 3]);

#[cfg(target_arch = "x86_64")]
impl FixedT {
    #[inline(always)]
    pub fn new(places: [i32; 4]) -> Self {
        Self(bytemuck::cast(places))
    }

    /// The least of the three.
    #[inline(always)]
    pub fn min3(self) -> i32 {
        let t = self.0;
        // SAFETY: every x86-64 has SSE2, and intrinsics without pointers ask for nothing else.
        unsafe {
            let y = _mm_shuffle_epi32::<0b01_01_01_01>(t);
            let z = _mm_shuffle_epi32::<0b10_10_10_10>(t);
            _mm_cvtsi128_si32(min(min(t, y), z))
        }
    }

    /// Adds `t_delta` to those that are the least, wrapping, and gives the set of the others: bit 0
    /// for x.
    #[inline(always)]
    pub fn step(&mut self, t_delta: Self) -> usize {
        let t = self.0;
        // The spare place is compared with itself and never in the set.
        // SAFETY: every x86-64 has SSE2, and intrinsics without pointers ask for nothing else.
        unsafe {
            let after = _mm_shuffle_epi32::<0b11_00_10_01>(t);
            let before = _mm_shuffle_epi32::<0b11_01_00_10>(t);
            let stays = _mm_or_si128(_mm_cmpgt_epi32(t, after), _mm_cmpgt_epi32(t, before));
            self.0 = _mm_add_epi32(t, _mm_andnot_si128(stays, t_delta.0));
            _mm_movemask_ps(_mm_castsi128_ps(stays)) as usize
        }
    }
}

/// The lesser, place by place.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn min(a: __m128i, b: __m128i) -> __m128i {
    // SAFETY: every x86-64 has SSE2, and intrinsics without pointers ask for nothing else.
    unsafe {
        let less = _mm_cmplt_epi32(a, b);
        _mm_or_si128(_mm_and_si128(less, a), _mm_andnot_si128(less, b))
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl FixedT {
    #[inline(always)]
    pub fn new([x, y, z, _]: [i32; 4]) -> Self {
        Self([x, y, z])
    }

    /// The least of the three.
    #[inline(always)]
    pub fn min3(self) -> i32 {
        self.0[0].min(self.0[1]).min(self.0[2])
    }

    /// Adds `t_delta` to those that are the least, wrapping, and gives the set of the others: bit 0
    /// for x.
    #[inline(always)]
    pub fn step(&mut self, t_delta: Self) -> usize {
        let min3 = self.min3();
        let mut stays = 0;
        for axis in 0..3 {
            let steps = self.0[axis] == min3;
            stays |= usize::from(!steps) << axis;
            self.0[axis] = self.0[axis].wrapping_add(if steps { t_delta.0[axis] } else { 0 });
        }
        stays
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_step() {
        let t_delta = FixedT::new([10, 20, 30, 0]);
        for ([x, y, z], min3, steps, then) in [
            ([1, 2, 3], 1, 0b001, 2),
            ([3, 2, 9], 2, 0b010, 3),
            ([5, 4, -7], -7, 0b100, 4),
            ([4, 4, 9], 4, 0b011, 9),
            ([9, 4, 4], 4, 0b110, 9),
            ([4, 9, 4], 4, 0b101, 9),
            ([6, 6, 6], 6, 0b111, 16),
        ] {
            let mut t = FixedT::new([x, y, z, -9]);
            assert_eq!((t.min3(), t.step(t_delta), t.min3()), (min3, 7 - steps, then), "{x} {y} {z}");
        }
    }

    #[test]
    fn steps_wrap() {
        let mut t = FixedT::new([i32::MAX; 4]);
        assert_eq!(t.step(FixedT::new([1; 4])), 0);
        assert_eq!(t.min3(), i32::MIN);
    }
}
