//! Perlin's improved noise (Perlin, "Improving Noise", SIGGRAPH 2002), in f64.

use crate::math::f64x4::ROUND_TO_INTEGER;
use glam::DVec3;

/// Perlin's permutation of 0..=255.
const PERMUTATION: [u8; 256] = [
    151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225, 140, 36, 103, 30, 69, 142, 8, 99,
    37, 240, 21, 10, 23, 190, 6, 148, 247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219, 203, 117, 35, 11, 32,
    57, 177, 33, 88, 237, 149, 56, 87, 174, 20, 125, 136, 171, 168, 68, 175, 74, 165, 71, 134, 139, 48, 27,
    166, 77, 146, 158, 231, 83, 111, 229, 122, 60, 211, 133, 230, 220, 105, 92, 41, 55, 46, 245, 40, 244,
    102, 143, 54, 65, 25, 63, 161, 1, 216, 80, 73, 209, 76, 132, 187, 208, 89, 18, 169, 200, 196, 135, 130,
    116, 188, 159, 86, 164, 100, 109, 198, 173, 186, 3, 64, 52, 217, 226, 250, 124, 123, 5, 202, 38, 147,
    118, 126, 255, 82, 85, 212, 207, 206, 59, 227, 47, 16, 58, 17, 182, 189, 28, 42, 223, 183, 170, 213, 119,
    248, 152, 2, 44, 154, 163, 70, 221, 153, 101, 155, 167, 43, 172, 9, 129, 22, 39, 253, 19, 98, 108, 110,
    79, 113, 224, 232, 178, 185, 112, 104, 218, 246, 97, 228, 251, 34, 242, 193, 238, 210, 144, 12, 191, 179,
    162, 241, 81, 51, 145, 235, 249, 14, 239, 107, 49, 192, 214, 31, 181, 199, 106, 157, 184, 84, 204, 176,
    115, 121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93, 222, 114, 67, 29, 24, 72, 243, 141, 128, 195, 78,
    66, 215, 61, 156, 180,
];

fn permute(i: usize) -> usize {
    PERMUTATION[i & 255] as usize
}

/// The integer `cell` modulo `period`, which is a power of two. `cell` may be larger than an `i64`.
pub fn wrapped(cell: f64, period: i64) -> i64 {
    // Below this the conversion is exact, and it is many times as fast as a floating-point remainder.
    const EXACT: f64 = (1i64 << 53) as f64;
    if cell.abs() < EXACT { cell as i64 & (period - 1) } else { cell.rem_euclid(period as f64) as i64 }
}

/// The directions to the edges of a cube in Perlin's order, four of them twice: the gradients for the low four bits of
/// a hash.
const GRADIENTS: [[f64; 3]; 16] = [
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [-1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [-1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [-1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, -1.0, 1.0],
    [0.0, 1.0, -1.0],
    [0.0, -1.0, -1.0],
    [1.0, 1.0, 0.0],
    [0.0, -1.0, 1.0],
    [-1.0, 1.0, 0.0],
    [0.0, -1.0, -1.0],
];

/// The largest integer up to `x`, and its remainder modulo 256.
#[inline(always)]
fn cell_along_axis(x: f64) -> (f64, usize) {
    if x.abs() >= ROUND_TO_INTEGER / 3.0 {
        let cell = x.floor();
        return (cell, wrapped(cell, 256) as usize);
    }
    // Without SSE4.1, which the compilation target may lack, the library's function takes three times as long.
    let shifted = x + ROUND_TO_INTEGER;
    let nearest = shifted - ROUND_TO_INTEGER;
    let is_above = nearest > x;
    (nearest - f64::from(is_above as u8), (shifted.to_bits().wrapping_sub(is_above as u64) & 255) as usize)
}

/// One octave of noise: between about -1 and 1, zero at integer points, with period 256 along each axis.
pub fn noise(p: DVec3) -> f64 {
    let [(cell_x, x), (cell_y, y), (cell_z, last)] = p.to_array().map(cell_along_axis);
    let near = p - DVec3::new(cell_x, cell_y, cell_z);
    let far = near - 1.0;
    let fade = near * near * near * (near * (near * 6.0 - 15.0) + 10.0);
    // Each step of the hash is computed once for all corners that share it.
    let columns = [permute(x) + y, permute(x + 1) + y];
    let row = |dy: usize, dz: usize, y: f64, z: f64| {
        let [left, right] = columns.map(|column| permute(permute(column + dy) + last + dz));
        lerp(fade.x, gradient(left, DVec3::new(near.x, y, z)), gradient(right, DVec3::new(far.x, y, z)))
    };
    let slice = |dz, z| lerp(fade.y, row(0, dz, near.y, z), row(1, dz, far.y, z));
    lerp(fade.z, slice(0, near.z), slice(1, far.z))
}

/// The sum of `octaves` octaves of noise, each at twice the frequency and half the amplitude of the last.
pub fn turbulence(p: DVec3, octaves: u32) -> f64 {
    let (mut sum, mut frequency) = (0.0, 1.0);
    for _ in 0..octaves {
        sum += noise(p * frequency) / frequency;
        frequency *= 2.0;
    }
    sum
}

fn lerp(t: f64, a: f64, b: f64) -> f64 {
    a + t * (b - a)
}

/// The dot product of `offset` with the gradient of a hash. Two of its terms are exact and the third is zero.
#[inline(always)]
fn gradient(hash: usize, offset: DVec3) -> f64 {
    DVec3::from_array(GRADIENTS[hash & 15]).dot(offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_a_permutation() {
        let mut sorted = PERMUTATION;
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, &p)| p as usize == i));
    }

    #[test]
    fn zero_at_integer_points() {
        for x in -5..=5 {
            for y in -5..=5 {
                for z in -5..=5 {
                    assert_eq!(noise(DVec3::new(x as f64, y as f64, z as f64)), 0.0);
                }
            }
        }
    }

    #[test]
    fn repeats_after_256_and_does_not_mirror_at_zero() {
        let p = DVec3::new(-0.375, -3.25, 2.625);
        assert_eq!(noise(p), noise(p + 256.0));
        assert_ne!(noise(p), noise(-p));
    }

    #[test]
    fn no_octave_is_no_noise() {
        assert_eq!(turbulence(DVec3::splat(0.3), 0), 0.0);
        assert_eq!(turbulence(DVec3::splat(0.3), 1), noise(DVec3::splat(0.3)));
    }

    /// The dot product with a gradient as Perlin's reference implementation selects it by the bits of a hash.
    fn selected(hash: usize, offset: DVec3) -> f64 {
        let h = hash & 15;
        let u = if h < 8 { offset.x } else { offset.y };
        let v = match h {
            0..4 => offset.y,
            12 | 14 => offset.x,
            _ => offset.z,
        };
        (if h & 1 == 0 { u } else { -u }) + (if h & 2 == 0 { v } else { -v })
    }

    #[test]
    fn gradients_are_those_of_the_reference() {
        for hash in 0..256 {
            for offset in [DVec3::new(0.25, 0.5, 0.125), DVec3::new(-0.7, 0.1, -1.0 / 3.0)] {
                assert_eq!(gradient(hash, offset), selected(hash, offset), "{hash}");
            }
        }
    }

    #[test]
    fn cells_are_those_of_the_floor() {
        let large = ROUND_TO_INTEGER / 3.0;
        for x in [0.0, -0.0, 0.5, 0.75, 1.0, 254.5, 255.5, 256.0, 1e9 + 0.3, large - 1.0, large, 2e18, 1e300]
        {
            for x in [x, -x, x.next_up(), -x.next_up(), x.next_down(), -x.next_down()] {
                let (cell, wrap) = cell_along_axis(x);
                assert_eq!((cell, wrap as i64), (x.floor(), wrapped(x.floor(), 256)), "{x}");
            }
        }
    }

    #[test]
    fn noise_blends_the_corners_by_the_fifth_degree_fade() {
        let fade = |t: f64| 6.0 * t.powi(5) - 15.0 * t.powi(4) + 10.0 * t.powi(3);
        for p in [
            DVec3::new(314.0 / 100.0, 42.0, 7.0),
            DVec3::new(-5.3, 0.7, 254.9),
            DVec3::new(255.2, -0.4, -300.8),
        ] {
            let f = p - p.floor();
            let mut sum = 0.0;
            for corner in 0..8 {
                let at = [corner & 1, corner >> 1 & 1, corner >> 2].map(|bit| bit as f64);
                let [x, y, z] = [0, 1, 2].map(|axis| (p[axis].floor() + at[axis]).rem_euclid(256.0) as usize);
                let hash = |i: usize, then: usize| PERMUTATION[i % 256] as usize + then;
                let direction = GRADIENTS[PERMUTATION[hash(hash(x, y), z) % 256] as usize % 16];
                let weights = [0, 1, 2].map(|axis| (1.0 - at[axis] - fade(f[axis])).abs());
                let value = DVec3::from(direction).dot(f - DVec3::from(at));
                sum += weights.iter().product::<f64>() * value;
            }
            assert!((noise(p) - sum).abs() < 1e-13, "{p}: {} {sum}", noise(p));
        }
        // The value that Perlin's reference implementation gives.
        assert!((noise(DVec3::new(314.0 / 100.0, 42.0, 7.0)) - 0.136919958784).abs() < 1e-12);
    }

    #[test]
    fn octaves_double_the_frequency_and_halve_the_amplitude() {
        let p = DVec3::new(0.3, 0.45, 0.6);
        let sum = noise(p) + noise(p * 2.0) / 2.0 + noise(p * 4.0) / 4.0;
        assert!((turbulence(p, 3) - sum).abs() < 1e-15);
    }

    #[test]
    fn integers_of_any_size_wrap() {
        for (cell, wrap) in [(0.0, 0), (255.0, 255), (256.0, 0), (-1.0, 255), (-257.0, 255)] {
            assert_eq!(wrapped(cell, 256), wrap);
        }
        let end = 2f64.powi(53);
        for (cell, wrap) in [(end - 1.0, 255), (end, 0), (end + 2.0, 2), (-end - 2.0, 254), (2e30, 0)] {
            assert_eq!(wrapped(cell, 256), wrap, "{cell}");
        }
    }
}
