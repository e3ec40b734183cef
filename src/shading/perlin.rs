//! Perlin's improved noise (Perlin, "Improving Noise", SIGGRAPH 2002), in f64.

use crate::math::instructions::Level;
use crate::math::simd::{FourLanes, Number, sums, swap_halves};
use fearless_simd::{Simd, SimdFrom, dispatch, f64x4};
use fearless_simd_macros::simd;
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

/// The permutation, followed by its first element. So the element after any other can be loaded without wrapping the
/// index.
const HASHES: [u8; 257] = followed_by_first(&PERMUTATION);

/// The gradient for each element of [`HASHES`], with an unused lane that is 0.
static HASHED_GRADIENTS: [[f64; 4]; 257] = {
    let mut gradients = [[0.0; 4]; 257];
    let mut i = 0;
    while i < 257 {
        let [x, y, z] = GRADIENTS[HASHES[i] as usize & 15];
        gradients[i] = [x, y, z, 0.0];
        i += 1;
    }
    gradients
};

const fn followed_by_first(permutation: &[u8; 256]) -> [u8; 257] {
    let mut followed = [permutation[0]; 257];
    let mut i = 0;
    while i < 256 {
        followed[i] = permutation[i];
        i += 1;
    }
    followed
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

/// Returns one octave of noise at `p`, whose first three lanes are the coordinates. It is between about -1 and 1, zero
/// at integer points, and has period 256 along each axis. The absolute coordinates are at most [`NEAR`].
#[inline(always)]
fn noise<S: Simd>(p: f64x4<S>) -> f64 {
    let cell = fearless_simd::SimdFloat::floor(p);
    let indices = cell.to_i32().map(|index| index as u8);
    let near = p - cell;
    let steep = near * near.broadcast(6.0) - near.broadcast(15.0);
    let fade = near * near * near * (near * steep + near.broadcast(10.0));
    let [fade_x, fade_y, fade_z, _] = fade.to_array();
    let (left, right) = (side::<S, 0>(near, indices), side::<S, 1>(near, indices));
    let low_then_high = left + near.broadcast(fade_x) * (right - left);
    let high_then_low = swap_halves(low_then_high);
    let along_y = low_then_high + near.broadcast(fade_y) * (high_then_low - low_then_high);
    let [at_near, at_far, ..] = along_y.to_array();
    at_near + fade_z * (at_far - at_near)
}

/// Returns the dot products of the gradients and the offsets at the four corners of a cell that are `DX` from its
/// index along x. Bit 0 of a lane's number is the corner's distance from the index along z. Bit 1 is the distance
/// along y.
#[inline(always)]
fn side<S: Simd, const DX: usize>(near: f64x4<S>, [x, y, z, _]: [u8; 4]) -> f64x4<S> {
    // Each step of the hash is computed once for all corners that share it.
    let column = usize::from(HASHES[usize::from(x) + DX].wrapping_add(y));
    let low = usize::from(HASHES[column].wrapping_add(z));
    let high = usize::from(HASHES[column + 1].wrapping_add(z));
    let dx = DX as f64;
    sums([
        products(low, near, [dx, 0.0, 0.0]),
        products(low + 1, near, [dx, 0.0, 1.0]),
        products(high, near, [dx, 1.0, 0.0]),
        products(high + 1, near, [dx, 1.0, 1.0]),
    ])
}

/// Returns the terms of the dot product of a gradient with the offset from a corner. Two of them are exact and the
/// third is zero, so the order of their sum does not matter.
#[inline(always)]
fn products<S: Simd>(gradient: usize, near: f64x4<S>, [dx, dy, dz]: [f64; 3]) -> f64x4<S> {
    f64x4::simd_from(near.proof(), HASHED_GRADIENTS[gradient])
        * (near - f64x4::simd_from(near.proof(), [dx, dy, dz, 0.0]))
}

/// Returns the gradient at an integer point.
pub fn gradient(x: u8, y: u8, z: u8) -> DVec3 {
    let hash = |sum: u8| PERMUTATION[usize::from(sum)];
    DVec3::from_array(GRADIENTS[usize::from(hash(hash(hash(x).wrapping_add(y)).wrapping_add(z)) & 15)])
}

/// The largest coordinate for which the indices of cells are converted to integers exactly.
const NEAR: f64 = i32::MAX as f64;

/// Returns the sum of `octaves` octaves of noise, each at twice the frequency and half the amplitude of the last.
#[inline(always)]
pub fn turbulence(p: DVec3, octaves: u32, level: Level) -> f64 {
    dispatch!(level, simd => turbulence_at(simd, p.x, p.y, p.z, octaves))
}

/// Returns the sum of `octaves` octaves of noise, each at twice the frequency and half the amplitude of the last. The
/// coordinates are separate parameters, to be passed in registers. A vector would be written to memory in three parts
/// and read in two, so that store forwarding fails.
#[simd]
#[inline(never)]
fn turbulence_at<S: Simd>(simd: S, x: f64, y: f64, z: f64, octaves: u32) -> f64 {
    let lanes = f64x4::simd_from(simd, [x, y, z, 0.0]);
    // The coordinates are largest in the last octave.
    let growth = 1u32.checked_shl(octaves).map_or(f64::INFINITY, f64::from);
    let is_near = (lanes.abs() * lanes.broadcast(growth)).le_mask(lanes.broadcast(NEAR)) & 7 == 7;
    if is_near { sum_of_octaves::<S, false>(lanes, octaves) } else { far_turbulence(simd, x, y, z, octaves) }
}

/// Returns the sum of octaves if coordinates may be larger than [`NEAR`]. The coordinates are separate parameters
/// here, too: to pass a vector in memory, the caller would keep its own copy there.
#[cold]
fn far_turbulence<S: Simd>(simd: S, x: f64, y: f64, z: f64, octaves: u32) -> f64 {
    sum_of_octaves::<S, true>(f64x4::simd_from(simd, [x, y, z, 0.0]), octaves)
}

/// Returns the sum of octaves. Unless `IS_FAR`, the absolute coordinates are at most [`NEAR`] in each octave.
#[inline(always)]
fn sum_of_octaves<S: Simd, const IS_FAR: bool>(mut p: f64x4<S>, octaves: u32) -> f64 {
    let (mut sum, mut amplitude) = (0.0, 1.0);
    for _ in 0..octaves {
        if IS_FAR {
            // The remainder is exact, and 256 is a period.
            p = f64x4::simd_from(p.proof(), p.to_array().map(|x| x % 256.0));
        }
        sum += amplitude * noise(p);
        p = p + p;
        amplitude *= 0.5;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::instructions;

    /// Returns one octave of noise.
    fn noise(p: DVec3) -> f64 {
        turbulence(p, 1, Level::baseline())
    }

    #[test]
    fn the_table_is_a_permutation() {
        let mut sorted = PERMUTATION;
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, &p)| p as usize == i));
    }

    #[test]
    fn no_octave_is_no_noise() {
        assert_eq!(turbulence(DVec3::splat(0.3), 0, Level::baseline()), 0.0);
        assert_eq!(turbulence(DVec3::splat(0.3), 1, Level::baseline()), noise(DVec3::splat(0.3)));
    }

    /// Returns the dot product with the gradient that Perlin's reference implementation selects by the bits of a hash.
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

    /// Returns one octave, computed corner by corner.
    fn plain_noise(p: DVec3) -> f64 {
        let lerp = |t: f64, a: f64, b: f64| a + t * (b - a);
        let (cell, f) = (p.floor(), p - p.floor());
        let [u, v, w] = f.to_array().map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
        let hash = |i: usize| PERMUTATION[i % 256] as usize;
        let [x, y, z] = cell.to_array().map(|index| index.rem_euclid(256.0) as usize);
        let at = |dx: usize, dy: usize, dz: usize| {
            let corner = [dx, dy, dz].map(|d| d as f64);
            selected(hash(hash(hash(x + dx) + y + dy) + z + dz), f - DVec3::from(corner))
        };
        let along_x = |dy, dz| lerp(u, at(0, dy, dz), at(1, dy, dz));
        lerp(w, lerp(v, along_x(0, 0), along_x(1, 0)), lerp(v, along_x(0, 1), along_x(1, 1)))
    }

    #[test]
    fn noise_has_the_bits_of_one_corner_after_the_other() {
        let coordinate = |k: u32, step: f64| 2e3 * (step * f64::from(k)).fract() - 1e3;
        for k in 0..5000 {
            let p = DVec3::new(coordinate(k, 0.754), coordinate(k, 0.56984), coordinate(k, 0.43016));
            for p in [p, p / 1024.0, p * 5e5, p * 2f64.powi(30)] {
                // Adding zero removes a sign of zero.
                let expected = (plain_noise(p) + 0.0).to_bits();
                let with = |level| turbulence(p, 1, level).to_bits();
                assert!(instructions::available().into_iter().all(|set| with(set) == expected), "{p}");
            }
        }
    }

    #[test]
    fn noise_has_the_value_of_the_reference_implementation() {
        assert!((noise(DVec3::new(314.0 / 100.0, 42.0, 7.0)) - 0.136919958784).abs() < 1e-12);
    }

    #[test]
    fn octaves_double_the_frequency_and_halve_the_amplitude() {
        let p = DVec3::new(0.3, 0.45, 0.6);
        let sum = noise(p) + noise(p * 2.0) / 2.0 + noise(p * 4.0) / 4.0;
        assert!((turbulence(p, 3, Level::baseline()) - sum).abs() < 1e-15);
    }
}
