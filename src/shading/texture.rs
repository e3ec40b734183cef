//! Solid textures: mixtures of Phong materials that depend on the point of space.

use super::checkerboard::{self, is_in_odd_cell};
use super::perlin::turbulence;
use super::phong::{Mixture, PointMaterial};
use crate::math::instructions::Level;
use crate::math::rounded::{RoundedAffine, RoundedPoint};
use crate::math::simd::ROUND_TO_INTEGER;
use crate::picture::Color;
use crate::scene::MaterialId;
use crate::scene::limits::LARGEST;
use crate::scene::material::{Material, Paint, Pattern, Phong, Texture};
use crate::world::{SurfacePoint, World};
use fearless_simd::{Simd, dispatch};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Returns the material of a surface, with its textures evaluated at the point.
#[inline(always)]
pub fn material_of_surface<'m>(
    world: &'m World,
    surface: &SurfacePoint,
    level: Level,
    mixture: &'m mut Mixture,
) -> PointMaterial<'m> {
    match &world.materials[surface.material] {
        Material::Phong(phong) => phong.into(),
        Material::Painted(phong, paint) => {
            let diffuse = match *paint {
                Paint::Image { image, .. } => world.image_color(image, surface),
                Paint::Pattern(pattern, colors) => {
                    Some(mixed_color(pattern, colors, surface.position, level))
                }
            };
            mixture.start(&Phong { diffuse: diffuse.unwrap_or(phong.diffuse), ..*phong }, 1.0);
            mixture.material()
        }
        Material::Texture(_) => world.with_rounded_point(surface, |point| {
            material_at(&world.materials, surface.material, point, level, mixture)
        }),
    }
}

/// Returns the material `id` at a point of world space. Evaluates each texture that it depends on once.
///
/// A point of a checkerboard has just one material, which is borrowed from the scene. If a texture mixes several
/// materials, the result is in `mixture`.
#[inline(always)]
pub fn material_at<'m>(
    materials: &'m [Material],
    id: MaterialId,
    point: &RoundedPoint,
    level: Level,
    mixture: &'m mut Mixture,
) -> PointMaterial<'m> {
    let mut id = id;
    loop {
        let texture = match &materials[id] {
            // A painted material is not part of a texture, so it does not occur here.
            Material::Phong(phong) | Material::Painted(phong, _) => return phong.into(),
            Material::Texture(texture) => texture,
        };
        if texture.pattern == Pattern::Checkerboard {
            let is_odd = is_in_odd_cell(&texture.world_to_texture, point, level);
            id = texture.children[usize::from(is_odd)];
            continue;
        }
        let before = &materials[..id];
        match dispatch!(level, simd => only_child(before, texture, point, simd.level(), mixture)) {
            Some(child) => id = child,
            None => return mixture.material(),
        }
    }
}

/// Returns the child of a texture that has all the weight at a point. If there is no such child, returns `None`, and
/// the material is in `mixture`. `materials` are the materials before the texture in the scene, which include its
/// children.
#[inline(always)]
fn only_child(
    materials: &[Material],
    texture: &Texture,
    point: &RoundedPoint,
    level: Level,
    mixture: &mut Mixture,
) -> Option<MaterialId> {
    let first = first_weight(texture, point, level);
    match first {
        1.0 => Some(texture.children[0]),
        0.0 => Some(texture.children[1]),
        _ => {
            mix(materials, (texture, first), point, level, mixture);
            None
        }
    }
}

/// Calls `part` with each Phong material that has a weight, and the weight, from the last material to the first.
/// `first` returns the part of a texture's weight that its first child gets.
///
/// Textures may share children. So the weights are propagated from the last material to the first: a texture
/// distributes its weight to its two children, which come before it. This takes linear time in the number of
/// materials. A recursion could take exponential time.
#[inline(always)]
pub fn each_part(
    materials: &[Material],
    weights: &mut [f64],
    mut first: impl FnMut(MaterialId, &Texture) -> f64,
    mut part: impl FnMut(MaterialId, &Phong, f64),
) {
    for (id, material) in materials.iter().enumerate().rev() {
        let weight = weights[id];
        if weight == 0.0 {
            continue;
        }
        match material {
            Material::Phong(phong) | Material::Painted(phong, _) => part(id, phong, weight),
            Material::Texture(texture) => {
                let first = first(id, texture);
                weights[texture.children[0]] += weight * first;
                weights[texture.children[1]] += weight * (1.0 - first);
            }
        }
    }
}

/// Builds the mixture for a texture whose first child has the given weight.
///
#[inline(always)]
fn mix(
    materials: &[Material],
    (texture, first): (&Texture, f64),
    point: &RoundedPoint,
    level: Level,
    mixture: &mut Mixture,
) {
    let [i, j] = texture.children;
    if let [Material::Phong(one), Material::Phong(other)] = [&materials[i], &materials[j]]
        && i != j
    {
        // Most textures end here. As in longer mixtures, add the parts from the last material to the first.
        let parts = [(one, first), (other, 1.0 - first)];
        let [later, earlier] = if i > j { parts } else { [parts[1], parts[0]] };
        mixture.start(later.0, later.1);
        return mixture.add(earlier.0, earlier.1);
    }
    // Most scenes have few materials, whose weights need no allocation.
    let (mut few, mut many) = ([0.0; 16], vec![]);
    let weights = few.get_mut(..materials.len()).unwrap_or_else(|| {
        many.resize(materials.len(), 0.0);
        &mut many
    });
    weights[texture.children[0]] += first;
    weights[texture.children[1]] += 1.0 - first;
    let mut is_empty = true;
    let first = |_, texture: &Texture| first_weight(texture, point, level);
    each_part(materials, weights, first, |_, phong, weight| {
        if std::mem::take(&mut is_empty) {
            mixture.start(phong, weight);
        } else {
            mixture.add(phong, weight);
        }
    });
    if is_empty {
        mixture.start(&Default::default(), 1.0);
    }
}

/// Returns the mixture of two colours at a point of world space, by a pattern.
pub fn mixed_color(pattern: Pattern, colors: [Color; 2], point: DVec3, level: Level) -> Color {
    let texture = Texture {
        pattern,
        world_to_texture: RoundedAffine::IDENTITY,
        factors: Box::default(),
        children: [0, 1],
    };
    let first = first_weight(&texture, &point.into(), level);
    colors[0] * first + colors[1] * (1.0 - first)
}

/// Returns the weight of a texture's first material at a point of world space, from 0 to 1.
#[inline(always)]
pub fn first_weight(texture: &Texture, point: &RoundedPoint, level: Level) -> f64 {
    let map = &texture.world_to_texture;
    match texture.pattern {
        Pattern::Checkerboard if is_in_odd_cell(map, point, level) => 0.0,
        Pattern::Checkerboard => 1.0,
        Pattern::Noise { octaves } => {
            (turbulence(to_texture(map, point), octaves, level) + 0.5).clamp(0.0, 1.0)
        }
        Pattern::Marble { octaves, frequency, amplitude } => {
            let q = to_texture(map, point);
            (1.0 + libm::sin(frequency * q.x + amplitude * turbulence(q, octaves, level))) / 2.0
        }
        Pattern::Wood { octaves, frequency, amplitude } => {
            let q = to_texture(map, point);
            let radius = (q.x * q.x + q.z * q.z).sqrt() + 0.05 * q.y;
            let grain = turbulence(DVec3::new(q.x, 0.2 * q.y, q.z), octaves, level);
            let ring = ring(frequency * radius + amplitude * grain);
            ring * ring
        }
    }
}

/// Up to this angle, the error of the number of half turns is far less than the margin in [`ring`].
const LARGEST_RING_ANGLE: f64 = 1e6;

/// Returns the weight of the first material in a ring of wood at this angle, in radians: 0.5 plus the sine, clamped to
/// 0 and 1. For two thirds of all angles it is certainly 0 or 1, and the sine is not computed.
#[inline(always)]
fn ring(angle: f64) -> f64 {
    // From a sixth of a half turn to five sixths the sine is at least 0.5.
    const CERTAIN: f64 = 1.0 / 6.0 + 1e-6;
    let half_turns = angle * FRAC_1_PI;
    let shifted = half_turns + ROUND_TO_INTEGER;
    let beyond_nearest = half_turns - (shifted - ROUND_TO_INTEGER);
    if beyond_nearest.abs() > CERTAIN && angle.abs() < LARGEST_RING_ANGLE {
        // The sine changes its sign with each half turn.
        let is_odd = shifted.to_bits() & 1 != 0;
        return if (beyond_nearest > 0.0) != is_odd { 1.0 } else { 0.0 };
    }
    (0.5 + libm::sin(angle)).clamp(0.0, 1.0)
}

/// Maps a point of world space to the texture's space, clamped to the range in which the patterns do not overflow.
#[inline(always)]
fn to_texture(map: &RoundedAffine, point: &RoundedPoint) -> DVec3 {
    let bound = DVec3::splat(LARGEST);
    map.map.transform_point3(point.position).clamp(-bound, bound)
}

/// Returns true if a point lies in a boundary of a checkerboard, within its error bounds.
pub fn is_in_boundary(texture: &Texture, point: &RoundedPoint) -> bool {
    texture.pattern == Pattern::Checkerboard && checkerboard::is_in_boundary(&texture.world_to_texture, point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::material::Phong;
    use glam::DAffine3;

    fn texture(pattern: Pattern, children: [MaterialId; 2]) -> Texture {
        Texture { pattern, world_to_texture: RoundedAffine::IDENTITY, factors: Box::default(), children }
    }

    /// Tests angles at which the sine is 0.5 away from 0, their neighbours among floating-point numbers, others
    /// between them, and angles too large for the shortcut.
    #[test]
    fn a_ring_is_what_the_sine_makes_of_it() {
        let (mut all, mut none) = (0, 0);
        let thresholds = (-4000..4000).map(|sixth| f64::from(sixth) * std::f64::consts::FRAC_PI_6);
        let beside = thresholds.flat_map(|angle| [angle.next_down(), angle, angle.next_up()]);
        let near = (-40_000..40_000).map(|k| f64::from(k) * 2e-4);
        let far = (0..20_000).map(|k| 0.9 * LARGEST_RING_ANGLE + 17.3 * f64::from(k));
        let too_far = (0..2000).map(|k| 1e15 + 17.3 * f64::from(k));
        let extreme = [0.0, -0.0, 1e18, 1e300, f64::MAX];
        let angles = beside.chain(near).chain(far).chain(too_far).chain(extreme);
        for angle in angles.flat_map(|angle| [angle, -angle]) {
            let expected = (0.5 + libm::sin(angle)).clamp(0.0, 1.0);
            assert_eq!(ring(angle), expected, "{angle}");
            all += u32::from(expected == 1.0);
            none += u32::from(expected == 0.0);
        }
        assert!(all > 20_000 && none > 20_000, "{all} {none}");
        assert!(ring(f64::NAN).is_nan());
    }

    #[test]
    fn nested_textures_mix_and_their_weights_sum_to_one() {
        let colors = [Color::X, Color::Y, Color::Z];
        let mut materials: Vec<Material> =
            colors.map(|diffuse| Material::Phong(Phong { diffuse, ..Phong::default() })).into();
        materials.push(Material::Texture(texture(Pattern::Noise { octaves: 3 }, [0, 1])));
        materials.push(Material::Texture(texture(
            Pattern::Marble { octaves: 2, frequency: 3.0, amplitude: 1.0 },
            [3, 2],
        )));
        let point = DVec3::new(0.3, -1.2, 7.7);
        let mut mixture = Mixture::default();
        let m = material_at(&materials, 4, &point.into(), Level::baseline(), &mut mixture);
        assert!(
            (m.phong.diffuse.element_sum() - 1.0).abs() < 1e-15
                && (m.phong.index_of_refraction - 1.0).abs() < 1e-15
        );
        let marble = |t: &Material| {
            if let Material::Texture(t) = t {
                first_weight(t, &point.into(), Level::baseline())
            } else {
                f64::NAN
            }
        };
        assert!((m.phong.diffuse.z - (1.0 - marble(&materials[4]))).abs() < 1e-15);
    }

    #[test]
    fn a_deep_chain_of_shared_children_takes_linear_time() {
        let (mut materials, mut mixture) = (vec![Material::Phong(Phong::default())], Mixture::default());
        for i in 0..2000 {
            materials.push(Material::Texture(texture(Pattern::Noise { octaves: 1 }, [i, i])));
        }
        assert!(
            (material_at(&materials, 2000, &DVec3::splat(0.3).into(), Level::baseline(), &mut mixture)
                .phong
                .diffuse
                .x
                - 1.0)
                .abs()
                < 1e-12
        );
    }

    /// Returns the weight of the first material at a point given in texture space, for a map that is not the identity.
    fn weight(pattern: Pattern, texture_point: DVec3) -> f64 {
        let world_to_texture = DAffine3::from_translation(DVec3::new(1.0, -2.0, 4.0));
        let t = Texture { world_to_texture: world_to_texture.into(), ..texture(pattern, [0, 1]) };
        first_weight(&t, &(texture_point - DVec3::new(1.0, -2.0, 4.0)).into(), Level::baseline())
    }

    #[test]
    fn noise_is_turbulence_about_a_half() {
        for p in [DVec3::new(0.25, 0.5, 0.625), DVec3::new(1.25, -0.5, 3.375), DVec3::new(0.5, 0.25, 0.25)] {
            let expected = (turbulence(p, 3, Level::baseline()) + 0.5).clamp(0.0, 1.0);
            assert_eq!(weight(Pattern::Noise { octaves: 3 }, p), expected);
        }
    }

    #[test]
    fn a_square_of_a_checkerboard_borrows_its_material() {
        let phong = |diffuse| Material::Phong(Phong { diffuse, ..Phong::default() });
        let board = Material::Texture(texture(Pattern::Checkerboard, [0, 1]));
        let materials = [phong(Color::X), phong(Color::Y), board];
        let mut mixture = Mixture::default();
        for (x, color) in [(0.5, Color::X), (1.5, Color::Y)] {
            let point = DVec3::new(x, 0.5, 0.5);
            let found = material_at(&materials, 2, &point.into(), Level::baseline(), &mut mixture).phong;
            assert!(
                materials
                    .iter()
                    .any(|material| matches!(material, Material::Phong(phong) if std::ptr::eq(phong, found)))
            );
            assert_eq!(found.diffuse, color);
        }
    }
}
