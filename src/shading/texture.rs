//! Solid textures: how much of which Phong material a point of space is made of.

use super::perlin::turbulence;
use super::phong::PointMaterial;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::scene::MaterialId;
use crate::scene::material::{Material, Pattern, Texture};
use glam::{DAffine3, DVec3};

/// The material `id` at the world point `point`, every texture on the way evaluated once.
pub fn material_at(materials: &[Material], id: MaterialId, point: DVec3) -> PointMaterial {
    match &materials[id] {
        Material::Phong(phong) => phong.into(),
        Material::Texture(_) => mixed(materials, id, point),
    }
}

/// Textures may share children, so weights are collected from the last material down: a texture
/// passes its weight on to its two children, which stand before it. Time is linear in the number of
/// materials where a recursion could take exponentially long.
fn mixed(materials: &[Material], id: MaterialId, point: DVec3) -> PointMaterial {
    let mut weights = vec![0.0; id + 1];
    weights[id] = 1.0;
    let mut sum: Option<PointMaterial> = None;
    for i in (0..=id).rev() {
        let weight = weights[i];
        if weight == 0.0 {
            continue;
        }
        match &materials[i] {
            Material::Phong(phong) => {
                let part = PointMaterial::from(phong).weighted(weight);
                sum = Some(match sum {
                    Some(sum) => sum.plus(part),
                    None => part,
                });
            }
            Material::Texture(texture) => {
                let first = first_weight(texture, point);
                weights[texture.children[0]] += weight * first;
                weights[texture.children[1]] += weight * (1.0 - first);
            }
        }
    }
    sum.unwrap_or_else(|| PointMaterial::from(&Default::default()))
}

/// The weight of a texture's first material at a world point, 0 to 1.
pub fn first_weight(texture: &Texture, point: DVec3) -> f64 {
    let map = &texture.world_to_texture;
    match texture.pattern {
        Pattern::Checkerboard => checkerboard(map, point),
        Pattern::Noise { octaves } => {
            (turbulence(map.transform_point3(point), octaves) + 0.5).clamp(0.0, 1.0)
        }
        Pattern::Marble { octaves, frequency, amplitude } => {
            let q = map.transform_point3(point);
            (1.0 + libm::sin(frequency * q.x + amplitude * turbulence(q, octaves))) / 2.0
        }
        Pattern::Wood { octaves, frequency, amplitude } => {
            let q = map.transform_point3(point);
            let radius = (q.x * q.x + q.z * q.z).sqrt() + 0.05 * q.y;
            let grain = turbulence(DVec3::new(q.x, 0.2 * q.y, q.z), octaves);
            let ring = (0.5 + libm::sin(frequency * radius + amplitude * grain)).clamp(0.0, 1.0);
            ring * ring
        }
    }
}

/// 1 in the cells whose indices have an even sum. Cells are half open: a boundary belongs to the
/// cell above it.
///
/// Where a surface lies in a boundary, rounding alone would decide on which side each of its points
/// falls, whatever the precision. So a coordinate within its own rounding of a boundary is on it.
fn checkerboard(map: &DAffine3, point: DVec3) -> f64 {
    let q = map.transform_point3(point);
    let rows = map.matrix3.transpose();
    let parity: f64 = (0..3)
        .map(|axis| {
            let nearest = q[axis].round();
            let rounding = coordinate_rounding(rows.col(axis), map.translation[axis], point);
            let on_boundary = (q[axis] - nearest).abs() <= rounding;
            let cell = if on_boundary { nearest } else { q[axis].floor() };
            cell.rem_euclid(2.0)
        })
        .sum();
    if parity.rem_euclid(2.0) == 0.0 { 1.0 } else { 0.0 }
}

/// How far `row . point + translation` may be off, for a point of a surface that is a boundary.
fn coordinate_rounding(row: DVec3, translation: f64, point: DVec3) -> f64 {
    // A turned surface and a turned texture are parallel only within the rounding of their
    // matrices; along an axis both are exact.
    let turned = row.to_array().into_iter().filter(|&x| x != 0.0).count() > 1;
    let roundings = if turned { 16.0 } else { 4.0 };
    roundings * UNIT_ROUNDOFF * (row.abs().dot(point.abs()) + translation.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Color;
    use crate::scene::material::Phong;

    fn texture(pattern: Pattern, children: [MaterialId; 2]) -> Texture {
        Texture { pattern, world_to_texture: DAffine3::IDENTITY, children }
    }

    #[test]
    fn parity_is_mathematical_also_below_zero() {
        let t = texture(Pattern::Checkerboard, [0, 1]);
        for (point, first) in [
            (DVec3::new(0.5, 0.5, 0.5), 1.0),
            (DVec3::new(-0.5, 0.5, 0.5), 0.0),
            (DVec3::new(-0.5, -0.5, 0.5), 1.0),
            (DVec3::new(-1.5, -0.5, -0.5), 1.0),
            (DVec3::new(1e9 + 0.5, 0.5, 0.5), 1.0),
        ] {
            assert_eq!(first_weight(&t, point), first, "{point}");
        }
    }

    #[test]
    fn a_boundary_belongs_to_the_cell_above_on_whichever_side_rounding_falls() {
        let t = texture(Pattern::Checkerboard, [0, 1]);
        for y in [3.0 - 4e-16, 3.0, 3.0 + 4e-16] {
            assert_eq!(first_weight(&t, DVec3::new(0.5, y, 0.5)), 0.0);
        }
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
        let m = material_at(&materials, 4, point);
        assert!((m.diffuse.element_sum() - 1.0).abs() < 1e-15 && (m.index_of_refraction - 1.0).abs() < 1e-15);
        let marble =
            |t: &Material| if let Material::Texture(t) = t { first_weight(t, point) } else { f64::NAN };
        assert!((m.diffuse.z - (1.0 - marble(&materials[4]))).abs() < 1e-15);
    }

    #[test]
    fn a_deep_chain_of_shared_children_takes_linear_time() {
        let mut materials = vec![Material::Phong(Phong::default())];
        for i in 0..2000 {
            materials.push(Material::Texture(texture(Pattern::Noise { octaves: 1 }, [i, i])));
        }
        assert!((material_at(&materials, 2000, DVec3::splat(0.3)).diffuse.x - 1.0).abs() < 1e-12);
    }
}
