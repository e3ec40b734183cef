//! Perlin noise as in textbooks. The permutation and the gradients do not matter for the measurements, so
//! they come from a separate hash of period 256.

use super::rng::Rng;
use glam::{DVec3, Vec3};
use raytracer::math::instructions::Level;
use raytracer::shading::perlin::turbulence;

/// This program's noise: one octave of it.
pub fn noise(p: DVec3) -> f64 {
    turbulence(p, 1, Level::baseline())
}

/// The noise in f64, with the cell computed by conversion to a 32-bit integer, which truncates.
pub fn truncated_noise(p: DVec3) -> f64 {
    let cell = DVec3::from_array(p.to_array().map(|x| x as i32 as f64));
    blend(cell.to_array().map(|c| c.rem_euclid(256.0) as u64), (p - cell).to_array())
}

/// This program's noise at a point whose cell and position in the cell were computed in f32.
pub fn noise32(p: Vec3) -> f64 {
    let cell = p.floor();
    let position = (p - cell).as_dvec3();
    let reduced = DVec3::from_array(cell.to_array().map(|c| c.rem_euclid(256.0) as f64));
    noise(reduced + position)
}

fn blend(cell: [u64; 3], f: [f64; 3]) -> f64 {
    let fade = f.map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let mut sum = 0.0;
    for corner in 0..8u64 {
        let bit = |axis: usize| corner >> axis & 1;
        let weight: f64 = (0..3).map(|a| if bit(a) == 1 { fade[a] } else { 1.0 - fade[a] }).product();
        let code = (0..3).fold(0, |code, a| code * 256 + (cell[a] + bit(a)) % 256);
        let hash = Rng::at(0, code).next_u64();
        let signs = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)][(hash & 3) as usize];
        let (i, j) = [(0, 1), (1, 2), (2, 0)][(hash >> 2) as usize % 3];
        let offset = |a: usize| f[a] - bit(a) as f64;
        sum += weight * (signs.0 * offset(i) + signs.1 * offset(j));
    }
    sum
}
