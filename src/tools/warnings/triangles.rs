//! Warns about triangles without an area. No ray hits them.

use super::have;
use crate::diagnostic::{Diagnostic, limited};
use crate::math::double_double::exact_product;
use crate::scene::mesh::Mesh;
use crate::scene::{Object, Position, Scene};
use glam::DVec3;
use rayon::prelude::*;

/// Warns about triangles without an area: once for the scene's text, at the first of them, and once for each mesh.
/// `meshes` are the scene's meshes, in its order.
pub fn triangles_without_area(scene: &Scene, meshes: &[Mesh]) -> Vec<Diagnostic> {
    let warning = |message: String, at: Position| {
        Diagnostic::warning(message).at(at).with_hint("no ray hits a triangle whose corners lie on one line")
    };
    let is_flat_object =
        |object: &Object| matches!(object, Object::Triangle { vertices, .. } if is_flat(vertices.each_ref()));
    let mut own = (0..scene.objects.len()).filter(|&id| is_flat_object(&scene.objects[id]));
    let own = own.next().map(|first| {
        let message = match 1 + own.count() {
            1 => "the triangle has no area".into(),
            count => format!("{count} triangles have no area; this is the first"),
        };
        warning(message, scene.positions.objects.get(first).copied().unwrap_or_default())
    });
    let of_meshes = scene.meshes.iter().zip(meshes).filter_map(|(file, mesh)| {
        let (count, all) = (flat_count(mesh), mesh.triangles.len());
        let message = || format!("{count} of the {all} triangles of the mesh {} no area", have(count));
        (count > 0).then(|| warning(message(), file.at))
    });
    limited(own.into_iter().chain(of_meshes).collect())
}

fn flat_count(mesh: &Mesh) -> usize {
    /// The number of triangles that justifies another thread.
    const PART: usize = 1 << 15;
    let vertex = |id: u32| &mesh.vertices[id as usize];
    let count = |part: &[[u32; 3]]| part.iter().filter(|ids| is_flat(ids.map(vertex))).count();
    mesh.triangles.par_chunks(PART).map(count).sum()
}

/// Returns true if the area is zero. For most triangles with an area, one coordinate of the normal decides, so only
/// this one is computed.
#[inline(always)]
fn is_flat([a, b, c]: [&DVec3; 3]) -> bool {
    (b.x - a.x) * (c.y - a.y) == (b.y - a.y) * (c.x - a.x) && has_no_normal(*b - *a, *c - *a)
}

/// Returns true if the cross product of two differences of corners is exactly zero.
#[cold]
fn has_no_normal(u: DVec3, v: DVec3) -> bool {
    // If the rounded products differ, the exact ones differ, too.
    if u.y * v.z != v.y * u.z || u.z * v.x != v.z * u.x {
        return false;
    }
    // Scaling by a power of two is exact and keeps the products from underflow.
    let scale = |w: DVec3| match w.abs().max_element() {
        largest if largest > 0.0 && largest.is_finite() => {
            let (_, exponent) = libm::frexp(largest);
            w.map(|x| libm::ldexp(x, -exponent))
        }
        _ => w,
    };
    let (u, v) = (scale(u), scale(v));
    are_equal_products(u.x, v.y, u.y, v.x)
        && are_equal_products(u.y, v.z, u.z, v.y)
        && are_equal_products(u.z, v.x, u.x, v.z)
}

/// Returns true if a b = c d without rounding.
fn are_equal_products(a: f64, b: f64, c: f64, d: f64) -> bool {
    exact_product(a, b) == exact_product(c, d)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::double_double::with_and_without_fused;

    fn flat(corners: [[f64; 3]; 3]) -> bool {
        let mut found = vec![];
        with_and_without_fused(|| found.push(is_flat(corners.map(DVec3::from_array).each_ref())));
        assert_eq!(found[0], found[1], "{corners:?}");
        found[0]
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
        // The reciprocal of the least positive number is infinite.
        let least = f64::from_bits(1);
        assert!(!flat([[0.0; 3], [least, 0.0, 0.0], [0.0, least, 0.0]]));
        assert!(!flat([[0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]));
        assert!(!flat([[0.0; 3], [1e100, 0.0, 0.0], [0.0, 0.0, 1e-100]]));
        // The rounded products are equal.
        let (x, y) = (1.0 + f64::EPSILON, 1.0 - f64::EPSILON);
        assert!(!flat([[0.0; 3], [x, 1.0, 0.0], [1.0, y, 0.0]]));
    }
}
