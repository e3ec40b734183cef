//! Solid textures with Perlin's improved noise.

use super::mistake::Mistake::*;
use super::mistake::Mistakes;
use glam::{Affine3A, Vec3};
use raytracer::scene::material::{Pattern, Texture};

/// Perlin's permutation.
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

/// Returns the weight of a texture's first material at a point of world space.
pub fn first_weight(texture: &Texture, point: Vec3, mistakes: &Mistakes) -> f32 {
    let map = texture.world_to_texture.map.as_affine3a();
    let wrong = [(TextureMatrixMissing, Affine3A::IDENTITY), (TextureMatrixInverted, map.inverse())];
    let q = mistakes.pick(map, wrong).transform_point3(point);
    match texture.pattern {
        Pattern::Checkerboard => {
            let cell = q.floor();
            if (cell.x + cell.y + cell.z).rem_euclid(2.0) == 0.0 { 1.0 } else { 0.0 }
        }
        Pattern::Noise { octaves } => (turbulence(q, octaves, mistakes) + 0.5).clamp(0.0, 1.0),
        Pattern::Marble { octaves, frequency, amplitude } => {
            let phase = frequency as f32 * q.x + amplitude as f32 * turbulence(q, octaves, mistakes);
            (1.0 + phase.sin()) / 2.0
        }
        Pattern::Wood { octaves, frequency, amplitude } => {
            let squared = q.x * q.x + q.z * q.z;
            let radius = mistakes.pick(squared.sqrt(), [(WoodWithoutRoot, squared)]);
            let grain = turbulence(Vec3::new(q.x, 0.2 * q.y, q.z), octaves, mistakes);
            let phase = frequency as f32 * (radius + 0.05 * q.y) + amplitude as f32 * grain;
            let ring = (0.5 + phase.sin()).clamp(0.0, 1.0);
            mistakes.pick(ring * ring, [(WoodNotSquared, ring)])
        }
    }
}

/// Returns the sum of octaves of noise.
fn turbulence(q: Vec3, octaves: u32, mistakes: &Mistakes) -> f32 {
    let octaves = octaves.saturating_sub(u32::from(mistakes.has(OneOctaveFewer)));
    let factors = (0..octaves).map(|octave| (1u32 << octave) as f32);
    factors.map(|factor| noise(factor * q, mistakes) / factor).sum()
}

/// Returns one octave of noise, from about -1 to 1.
fn noise(q: Vec3, mistakes: &Mistakes) -> f32 {
    let fade = |t: f32| {
        let right = t * t * t * (t * (6.0 * t - 15.0) + 10.0);
        mistakes.pick(right, [(NoiseWithOldCurve, t * t * (3.0 - 2.0 * t))])
    };
    let cell = q.floor();
    let inside = q - cell;
    let [x, y, z] = cell.to_array().map(|index| index.rem_euclid(256.0) as usize);
    let [u, v, w] = inside.to_array().map(fade);
    let hash = |index: usize| usize::from(PERMUTATION[index & 255]);
    let corner = |[i, j, k]: [usize; 3]| {
        let gradient = hash(hash(hash(x + i) + y + j) + z + k);
        slope(gradient, inside - Vec3::new(i as f32, j as f32, k as f32))
    };
    let mix = |t: f32, a: f32, b: f32| a + t * (b - a);
    let edge = |j, k| mix(u, corner([0, j, k]), corner([1, j, k]));
    mix(w, mix(v, edge(0, 0), edge(1, 0)), mix(v, edge(0, 1), edge(1, 1)))
}

/// Returns the dot product of an offset with the gradient of a hash: one of 12 directions to the edges of a cube.
fn slope(hash: usize, Vec3 { x, y, z }: Vec3) -> f32 {
    let u = if hash & 8 == 0 { x } else { y };
    let v = match hash & 15 {
        0..4 => y,
        12 | 14 => x,
        _ => z,
    };
    (if hash & 1 == 0 { u } else { -u }) + (if hash & 2 == 0 { v } else { -v })
}
