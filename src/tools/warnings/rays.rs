//! What `-bounces` and `-weight` make of the materials of a scene.

use super::idle::Idle;
use super::{Warning, known};
use crate::scene::material::{Material, Pattern};
use crate::scene::model::Highlight;
use crate::scene::{MaterialId, Scene};
use crate::trace::{Effects, Shadows};
use std::fmt;

/// The number of rays that are too many for a sample of a pixel.
const TOO_MANY: u64 = 1 << 20;
/// The values of `-weight` that are suggested.
const WEIGHTS: [f64; 3] = [0.001, 0.01, 0.1];

/// What would keep the number of rays down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remedy {
    /// The largest value of `-bounces` below the limit.
    pub bounces: u32,
    /// A value of `-weight`, if one suffices.
    pub weight: Option<f64>,
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`-bounces {}` allows fewer", self.bounces)?;
        match self.weight {
            Some(weight) => write!(f, ", and so does `-weight {weight}`"),
            None => Ok(()),
        }
    }
}

/// The secondary rays at a material.
#[derive(Clone, Copy, Default)]
struct Secondary {
    /// The length of the reflective colour, which the weight of a reflected ray is multiplied by.
    reflected: f64,
    /// The same for refracted rays.
    refracted: f64,
    /// Whether a ray can be both reflected and refracted at one point.
    both: bool,
}

/// Warnings about `-bounces` and `-weight` where they decide about no ray, about shadows that nothing tints, and about a
/// light from behind that there is anyway.
/// `says_no_bounces` tells that there is a `-bounces 0`, which is meant: the course's commands have it with a `-weight`.
pub fn without_effect(scene: &Scene, effects: &Effects, says_no_bounces: bool) -> Vec<Warning> {
    let Effects { bounces, min_weight, shadows, shade_back } = *effects;
    let heaviest = used(scene).map(|(_, it)| it.reflected.max(it.refracted)).fold(0.0, f64::max);
    let idle = |flag: String, reason: Idle| Warning::IdleFlags { flags: vec![flag], reason };
    let of_bounces = match bounces {
        0 if min_weight > 0.0 && !says_no_bounces => {
            Some(idle(format!("-weight {min_weight}"), Idle::NoBounces))
        }
        0 => None,
        _ if heaviest == 0.0 => Some(idle(format!("-bounces {bounces}"), Idle::NothingBounces)),
        _ if heaviest <= min_weight => {
            Some(idle(format!("-bounces {bounces}"), Idle::EndedByWeight(min_weight)))
        }
        _ => None,
    };
    let nothing_transmits = used(scene).all(|(_, it)| it.refracted == 0.0);
    let of_shadows = (shadows == Shadows::Transparent && nothing_transmits)
        .then(|| idle("-transparent_shadows".into(), Idle::NothingTransmits));
    let of_backs = (shade_back && scene.model.highlight == Highlight::Phong)
        .then(|| idle("-shade_back".into(), Idle::LitAsOutside));
    of_bounces.into_iter().chain(of_shadows).chain(of_backs).collect()
}

/// A warning for the first material that reflects or transmits light where no ray is followed, as there is no
/// `-bounces`.
pub fn not_followed(scene: &Scene, effects: &Effects, says_no_bounces: bool) -> Option<Warning> {
    let is_lost = effects.bounces == 0 && !says_no_bounces;
    let (id, secondary) =
        used(scene).filter(|_| is_lost).find(|(_, it)| it.reflected > 0.0 || it.refracted > 0.0)?;
    let at = known(scene.material_positions.get(id));
    Some(Warning::NoBounces { at, transmits: secondary.refracted > 0.0 })
}

/// A warning for the first material that transmits light which nobody sees inside of it, as there is no `-shade_back`.
pub fn black_inside(scene: &Scene, effects: &Effects) -> Option<Warning> {
    let Effects { bounces, min_weight, shade_back, .. } = *effects;
    let is_lit_as_outside = shade_back || scene.model.highlight == Highlight::Phong;
    let (id, _) = used(scene)
        .filter(|_| bounces > 0 && !is_lit_as_outside)
        .find(|(_, it)| it.refracted > min_weight)?;
    Some(Warning::BlackInside { at: known(scene.material_positions.get(id)) })
}

/// A warning if the rays of one sample may be 2^20 or more.
///
/// Every ray is taken to hit a material that reflects and transmits as much as any of the scene does.
pub fn too_many(scene: &Scene, effects: &Effects) -> Option<Warning> {
    let bounces = effects.bounces;
    // Fewer bounces cannot make as many rays.
    if bounces < TOO_MANY.ilog2() {
        return None;
    }
    let (material, _) = used(scene).find(|(_, secondary)| secondary.both)?;
    let factors = used(scene).fold([0.0_f64; 2], |[reflected, refracted], (_, secondary)| {
        [reflected.max(secondary.reflected), refracted.max(secondary.refracted)]
    });
    let depth = depth_of_too_many(bounces, effects.min_weight, factors)?;
    let suffices =
        |&weight: &f64| weight > effects.min_weight && depth_of_too_many(bounces, weight, factors).is_none();
    let remedy = Remedy { bounces: depth - 1, weight: WEIGHTS.into_iter().find(suffices) };
    Some(Warning::ManyRays { at: known(scene.material_positions.get(material)), bounces, remedy })
}

/// The materials of objects, with the secondary rays at them.
fn used(scene: &Scene) -> impl Iterator<Item = (MaterialId, Secondary)> {
    let all = secondary_rays(&scene.materials);
    let mut is_used = vec![false; all.len()];
    for object in &scene.objects {
        if let Some(used) = object.material().and_then(|material| is_used.get_mut(material)) {
            *used = true;
        }
    }
    let of = move |id: MaterialId| (id, all[id]);
    is_used.into_iter().enumerate().filter(|&(_, is_used)| is_used).map(move |(id, _)| of(id))
}

/// For every material. A texture comes after those that it mixes.
fn secondary_rays(materials: &[Material]) -> Vec<Secondary> {
    let mut all: Vec<Secondary> = Vec::with_capacity(materials.len());
    for material in materials {
        all.push(match material {
            Material::Phong(phong) | Material::Painted(phong, _) => {
                let (reflected, refracted) = (phong.reflective.length(), phong.transparent.length());
                Secondary { reflected, refracted, both: reflected > 0.0 && refracted > 0.0 }
            }
            Material::Texture(texture) => {
                let [a, b] = texture.children.map(|child| all.get(child).copied().unwrap_or_default());
                let (reflected, refracted) = (a.reflected.max(b.reflected), a.refracted.max(b.refracted));
                // A checkerboard shows one of its materials at a point, other textures mix both.
                let mixes = texture.pattern != Pattern::Checkerboard && reflected > 0.0 && refracted > 0.0;
                Secondary { reflected, refracted, both: a.both || b.both || mixes }
            }
        });
    }
    all
}

/// The number of bounces, up to `bounces`, at which a ray that splits in two at every hit has become
/// [`TOO_MANY`]; none if it never does. `factors` are those of the weights of reflected and refracted rays;
/// a ray is traced if its weight is above `min_weight`.
fn depth_of_too_many(bounces: u32, min_weight: f64, [reflected, refracted]: [f64; 2]) -> Option<u32> {
    // The rays of one depth by how often they were refracted: that number, how many, and the weight of each.
    let mut level = vec![(0_u32, 1_u64, 1.0_f64)];
    let mut total = 1_u64;
    for depth in 1..=bounces {
        let mut next: Vec<(u32, u64, f64)> = Vec::with_capacity(level.len() + 1);
        for &(times, count, weight) in &level {
            for (times, weight) in [(times, weight * reflected), (times + 1, weight * refracted)] {
                match next.last_mut() {
                    _ if weight.is_nan() || weight <= min_weight => {}
                    Some((last, sum, _)) if *last == times => *sum = sum.saturating_add(count),
                    _ => next.push((times, count, weight)),
                }
            }
        }
        total = next.iter().fold(total, |total, &(_, count, _)| total.saturating_add(count));
        if total >= TOO_MANY {
            return Some(depth);
        }
        if next.is_empty() {
            return None;
        }
        level = next;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_double_with_each_bounce() {
        let depth = |bounces| depth_of_too_many(bounces, 0.0, [1.0, 1.0]);
        assert_eq!((depth(19), depth(20), depth(u32::MAX)), (None, Some(20), Some(20)));
    }

    #[test]
    fn weights_end_them() {
        assert_eq!(depth_of_too_many(u32::MAX, 0.01, [0.5, 0.5]), None);
        assert_eq!(depth_of_too_many(u32::MAX, 0.01, [0.9, 0.9]), Some(20));
        assert_eq!(depth_of_too_many(u32::MAX, 0.1, [0.9, 0.9]), Some(20));
        // Weights that vanish end the recursion of the renderer too.
        assert_eq!(depth_of_too_many(u32::MAX, 0.0, [1e-200, 1e-200]), None);
        assert_eq!(depth_of_too_many(u32::MAX, 0.0, [f64::INFINITY, 0.0]), Some(TOO_MANY as u32 - 1));
    }

    #[test]
    fn one_that_hardly_splits_takes_long() {
        // With at most one refraction on the way, depth n has n + 1 rays.
        let depth = depth_of_too_many(u32::MAX, 0.0, [1.0, 1e-300]).unwrap();
        let rays = |n: u64| (n + 1) * (n + 2) / 2;
        let depth = u64::from(depth);
        assert!(rays(depth) >= TOO_MANY && rays(depth - 1) < TOO_MANY);
    }
}
