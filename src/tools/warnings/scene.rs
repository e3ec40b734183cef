//! Warns about lights and triangles.

use super::Warning;
use crate::diagnostic::{Diagnostic, limited};
use crate::math::exact::projected_area;
use crate::picture::Color;
use crate::scene::mesh::Mesh;
use crate::scene::{Light, Object, Scene};
use crate::trace::{Effects, Shadows};
use crate::world::World;
use glam::DVec3;
use rayon::prelude::*;

/// Warns about a scene without lights.
pub fn no_lights(scene: &Scene) -> Option<Diagnostic> {
    scene.lights.is_empty().then(|| Warning::NoLights.into())
}

/// Warns about lights that have no effect on any picture of the scene.
pub fn lights_without_effect(scene: &Scene, world: &World, effects: &Effects) -> Vec<Diagnostic> {
    let warning = |(index, light): (usize, &Light)| {
        let (Light::Directional { color, .. } | Light::Point { color, .. }) = *light;
        let why = match light {
            _ if color == Color::ZERO => "its colour is 0 0 0",
            Light::Point { attenuation, .. } if attenuation.iter().all(|&factor| factor <= 0.0) => {
                "its attenuation is above 0 at no distance"
            }
            _ if effects.shadows == Shadows::Opaque && !world.primitives_at_light(index).is_empty() => {
                "it lies on a surface, which shadows everything from it"
            }
            _ => return None,
        };
        let at = scene.positions.lights.get(index).copied().unwrap_or_default();
        Some(Diagnostic::from(Warning::LightWithoutEffect { why }).at(at))
    };
    limited(scene.lights.iter().enumerate().filter_map(warning).collect())
}

/// Warns about triangles without an area: once for the scene's text, at the first of them, and once for each mesh.
/// `meshes` are the scene's meshes, in its order.
pub fn triangles_without_area(scene: &Scene, meshes: &[Mesh]) -> Vec<Diagnostic> {
    let is_flat_object =
        |object: &Object| matches!(object, Object::Triangle { vertices, .. } if is_flat(vertices.each_ref()));
    let own: Vec<usize> = (0..scene.objects.len()).filter(|&id| is_flat_object(&scene.objects[id])).collect();
    let first = own.first().map(|&first| {
        let at = scene.positions.objects.get(first).copied().unwrap_or_default();
        Diagnostic::from(Warning::FlatTriangles { count: own.len() }).at(at)
    });
    let of_meshes = scene.meshes.iter().zip(meshes).filter_map(|(file, mesh)| {
        let (count, all) = (flat_count(mesh), mesh.triangles.len());
        (count > 0).then(|| Diagnostic::from(Warning::FlatTrianglesOfMesh { count, all }).at(file.at))
    });
    limited(first.into_iter().chain(of_meshes).collect())
}

fn flat_count(mesh: &Mesh) -> usize {
    /// The number of triangles that justifies another thread.
    const PART: usize = 1 << 15;
    let vertex = |id: u32| &mesh.vertices[id as usize];
    let count = |part: &[[u32; 3]]| part.iter().filter(|ids| is_flat(ids.map(vertex))).count();
    mesh.triangles.par_chunks(PART).map(count).sum()
}

/// Returns true if the area is exactly zero. For most triangles with an area, one rounded coordinate of the normal
/// decides, so only this one is computed.
#[inline(always)]
fn is_flat([a, b, c]: [&DVec3; 3]) -> bool {
    (b.x - a.x) * (c.y - a.y) == (b.y - a.y) * (c.x - a.x) && has_no_area([*a, *b, *c])
}

#[cold]
fn has_no_area([a, b, c]: [DVec3; 3]) -> bool {
    (b - a).cross(c - a) == DVec3::ZERO
        && DVec3::AXES.into_iter().all(|axis| projected_area(axis, [a, b, c]).sign() == 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(corners: [[f64; 3]; 3]) -> bool {
        is_flat(corners.map(DVec3::from_array).each_ref())
    }

    #[test]
    fn corners_on_a_line_have_no_area() {
        assert!(flat([[0.0; 3], [1.0, 1.0, 1.0], [3.0, 3.0, 3.0]]));
        assert!(flat([[1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [5.0, 6.0, 8.0]]));
        assert!(flat([[0.1, 0.0, 7.0], [0.3, 0.0, 7.0], [0.7, 0.0, 7.0]]));
        assert!(flat([[2.0; 3]; 3]));
        assert!(flat([[0.0; 3], [1e-200, 0.0, 0.0], [3e-200, 0.0, 0.0]]));
        let least = f64::from_bits(1);
        assert!(flat([[0.0; 3], [least, least, 0.0], [3.0 * least, 3.0 * least, 0.0]]));
    }

    #[test]
    fn the_smallest_area_is_one() {
        assert!(!flat([[0.0; 3], [1.0, 1.0, 1.0], [3.0, 3.0, 3.0_f64.next_up()]]));
        assert!(!flat([[0.0; 3], [1e-200, 0.0, 0.0], [0.0, 1e-200, 0.0]]));
        // The products of the coordinates are zero.
        let least = f64::from_bits(1);
        assert!(!flat([[0.0; 3], [least, 0.0, 0.0], [0.0, least, 0.0]]));
        assert!(!flat([[0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]));
        assert!(!flat([[0.0; 3], [1e100, 0.0, 0.0], [0.0, 0.0, 1e-100]]));
        // The rounded products are equal.
        let (x, y) = (1.0 + f64::EPSILON, 1.0 - f64::EPSILON);
        assert!(!flat([[0.0; 3], [x, 1.0, 0.0], [1.0, y, 0.0]]));
    }
}
