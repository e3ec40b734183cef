//! Textures that are computed in wrong ways.

use super::rules::Rule;
use super::student::LEVEL;
use crate::scene::material::{Pattern, Texture};
use crate::shading::perlin::{gradient, turbulence};
use crate::shading::texture;
use glam::DVec3;

/// The rules that change textures.
pub const RULES: [Rule; 5] = [
    Rule::CheckerboardCut,
    Rule::NoiseHalved,
    Rule::NoiseSmoothStep,
    Rule::WoodRootMissing,
    Rule::WoodNotSquared,
];

/// The rules that change wood.
const WOOD_RULES: [Rule; 3] = [Rule::NoiseSmoothStep, Rule::WoodRootMissing, Rule::WoodNotSquared];

/// Returns the weight of a texture's first child at a point.
pub fn first_weight(rules: &[Rule], texture: &Texture, point: DVec3) -> f64 {
    let breaks = |rule| rules.contains(&rule);
    let q = texture.world_to_texture.map.transform_point3(point);
    let noise = |q, octaves| match breaks(Rule::NoiseSmoothStep) {
        true => smooth_step_turbulence(q, octaves),
        false => turbulence(q, octaves, LEVEL),
    };
    match texture.pattern {
        Pattern::Checkerboard if breaks(Rule::CheckerboardCut) => {
            // The coordinates are truncated towards zero.
            let cells = q.to_array().map(|q| q as i64);
            f64::from(cells.iter().filter(|&cell| cell % 2 != 0).count() % 2 == 0)
        }
        Pattern::Noise { octaves } if breaks(Rule::NoiseHalved) || breaks(Rule::NoiseSmoothStep) => {
            let factor = if breaks(Rule::NoiseHalved) { 0.5 } else { 1.0 };
            (factor * noise(q, octaves) + 0.5).clamp(0.0, 1.0)
        }
        Pattern::Marble { octaves, frequency, amplitude } if breaks(Rule::NoiseSmoothStep) => {
            (1.0 + libm::sin(frequency * q.x + amplitude * noise(q, octaves))) / 2.0
        }
        Pattern::Wood { octaves, frequency, amplitude }
            if rules.iter().any(|rule| WOOD_RULES.contains(rule)) =>
        {
            let square = q.x * q.x + q.z * q.z;
            let distance = if breaks(Rule::WoodRootMissing) { square } else { square.sqrt() };
            let grain = noise(DVec3::new(q.x, 0.2 * q.y, q.z), octaves);
            let angle = frequency * (distance + 0.05 * q.y) + amplitude * grain;
            let ring = (0.5 + libm::sin(angle)).clamp(0.0, 1.0);
            if breaks(Rule::WoodNotSquared) { ring } else { ring * ring }
        }
        _ => texture::first_weight(texture, &point.into(), LEVEL),
    }
}

/// Returns the sum of octaves of noise that is interpolated by t^2 (3 - 2 t).
fn smooth_step_turbulence(point: DVec3, octaves: u32) -> f64 {
    let octave = |i: u32| libm::exp2(-f64::from(i)) * smooth_step_noise(libm::exp2(f64::from(i)) * point);
    (0..octaves.min(64)).map(octave).sum()
}

fn smooth_step_noise(point: DVec3) -> f64 {
    let (cell, near) = (point.floor(), point - point.floor());
    let fade = near * near * (3.0 - 2.0 * near);
    // The noise has period 256 along each axis.
    let [x, y, z] = cell.to_array().map(|index| index.rem_euclid(256.0) as u8);
    let mut sum = 0.0;
    for corner in 0..8_u8 {
        let [i, j, k] = [corner & 1, corner >> 1 & 1, corner >> 2];
        let offset = DVec3::new(i.into(), j.into(), k.into());
        let weights = offset * fade + (1.0 - offset) * (1.0 - fade);
        let slope = gradient(x.wrapping_add(i), y.wrapping_add(j), z.wrapping_add(k));
        sum += weights.element_product() * slope.dot(near - offset);
    }
    sum
}
