//! Warns about lights, triangles, and pictures that show nothing of the scene.

use crate::diagnostic::{Diagnostic, Severity, limited};
use crate::math::aabb::Aabb;
use crate::math::exact::projected_area;
use crate::math::robust::unit;
use crate::picture::Color;
use crate::render::renderer::Prepared;
use crate::render::{Layer, Request, Watch};
use crate::scene::mesh::Mesh;
use crate::scene::{Camera, Light, Object, Scene};
use crate::trace::{Effects, Shadows};
use crate::world::World;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Warns about a scene without lights, in the words of the course's program.
pub fn no_lights(scene: &Scene) -> Option<Diagnostic> {
    let warning = || Diagnostic::warning("No lights specified");
    scene.lights.is_empty().then(|| Diagnostic { severity: Severity::CourseWarning, ..warning() })
}

/// Warns about lights that have no effect on any picture of the scene.
pub fn lights_without_effect(scene: &Scene, world: &World, effects: &Effects) -> Vec<Diagnostic> {
    let warning = |(index, light): (usize, &Light)| {
        let (Light::Directional { color, .. } | Light::Point { color, .. }) = *light;
        let why = match light {
            _ if color == Color::ZERO => "its colour is 0 0 0",
            Light::Point { attenuation, .. } if attenuation.iter().all(|&factor| factor <= 0.0) => {
                "it is attenuated to nothing at every distance"
            }
            _ if effects.shadows == Shadows::Opaque && !world.primitives_at_light(index).is_empty() => {
                "it lies on a surface, which shadows everything from it"
            }
            _ => return None,
        };
        let warning = Diagnostic::warning(format!("the light has no effect: {why}"));
        Some(warning.at(scene.positions.light(index)))
    };
    limited(scene.lights.iter().enumerate().filter_map(warning).collect())
}

/// Warns about triangles without an area: once for the scene's text, at the first of them, and once for each mesh.
/// `meshes` are the scene's meshes, in its order.
pub fn triangles_without_area(scene: &Scene, meshes: &[Mesh]) -> Vec<Diagnostic> {
    let hint = "no ray hits a triangle whose corners lie on one line";
    let is_flat_object =
        |object: &Object| matches!(object, Object::Triangle { vertices, .. } if is_flat(vertices.each_ref()));
    let own: Vec<usize> = (0..scene.objects.len()).filter(|&id| is_flat_object(&scene.objects[id])).collect();
    let first = own.first().map(|&first| {
        let message = match own.len() {
            1 => "the triangle has no area".into(),
            count => format!("{count} triangles have no area; this is the first"),
        };
        Diagnostic::warning(message).with_hint(hint).at(scene.positions.object(first))
    });
    let of_meshes = scene.meshes.iter().zip(meshes).filter_map(|(file, mesh)| {
        let (count, all) = (flat_count(mesh), mesh.triangles.len());
        let have = if count == 1 { "has" } else { "have" };
        let message = format!("{count} of the {all} triangles of the mesh {have} no area");
        (count > 0).then(|| Diagnostic::warning(message).with_hint(hint).at(file.at))
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

/// Warns if no ray through a pixel's centre hits anything. This takes as long as rendering such a picture up to the
/// first row with a hit, so call it only for a picture of one colour. Returns `None` if `watch` ends it.
pub fn nothing_visible(prepared: &Prepared, request: &Request, watch: Watch) -> Option<Diagnostic> {
    let renderer = prepared.renderer();
    let (world, at) = (renderer.world(), renderer.scene.positions.camera);
    let warning = |(why, hint)| {
        let warning = Diagnostic::warning(format!("no ray hits anything{why}"));
        Some(Diagnostic { hint, ..warning }.at(at))
    };
    if world.ids().is_empty() {
        return warning((": the scene has no objects", None));
    }
    let centers =
        Request { layers: vec![Layer::SignedNormals], camera: request.camera, ..Request::new(request.size) };
    // Normals have unit length. They are zero where nothing is hit.
    let mut take_row = |_: usize, row: &[Color]| match row.iter().all(|&color| color == Color::ZERO) {
        true => Ok(()),
        false => Err(Diagnostic::note("something is visible")),
    };
    prepared.render_rows(&centers, watch, &mut take_row).ok()?;
    // With planes, or gaps between objects, there is nothing to advise.
    let bounds = renderer.bounds().filter(|_| world.planes.is_empty());
    warning(bounds.map_or(("", None), |bounds| reason(prepared, &centers, bounds)))
}

/// Returns why nothing in these bounds is visible, as the end of a sentence, and advice.
fn reason(prepared: &Prepared, request: &Request, bounds: Aabb) -> (&'static str, Option<String>) {
    let [width, height] = request.size.map(|side| side as f64);
    let (middle, corners) = ((bounds.min + bounds.max) / 2.0, bounds.corners());
    let camera = request.camera.unwrap_or(prepared.renderer().scene.camera);
    let (Camera::Perspective { center, direction, .. } | Camera::Orthographic { center, direction, .. }) =
        camera;
    let is_perspective = matches!(camera, Camera::Perspective { .. });
    let hint = if is_perspective {
        let way = middle - center;
        // Adding zero turns a negative zero into zero.
        let short = |x: f64| ((x * 1000.0).round() / 1000.0 + 0.0).to_string();
        let [x, y, z] = (way / way.abs().max_element()).to_array().map(short);
        format!("`direction {x} {y} {z}` looks at the middle of the scene")
    } else {
        "move the camera's `center`".into()
    };
    let is_behind = |corner: &DVec3| (corner - center).dot(unit(direction)) <= 0.0;
    if is_perspective && corners.iter().all(is_behind) {
        return (": the scene is behind the camera", Some(hint));
    }
    // Two neighbouring corners of the picture span a plane that divides what may be seen from what is beside it.
    let camera = prepared.camera(request);
    let ray = |x: f64, y: f64| camera.ray(DVec2::new(x, y), DVec2::ZERO);
    let seen = ray((width - 1.0) / 2.0, (height - 1.0) / 2.0).at(1.0);
    let (right, top) = (width - 0.5, height - 0.5);
    let sides = [(-0.5, -0.5), (right, -0.5), (right, top), (-0.5, top)].map(|(x, y)| ray(x, y));
    let is_beside = |side: usize| {
        let (a, b) = (&sides[side], &sides[(side + 1) % 4]);
        let out = a.direction.cross(b.at(1.0) - a.origin);
        let out = if out.dot(seen - a.origin) > 0.0 { -out } else { out };
        corners.iter().all(|&corner| out.dot(corner - a.origin) > 0.0)
    };
    if (0..4).any(is_beside) {
        return (": the camera looks away from the scene", Some(hint));
    }
    // A step to the next pixel, as far away as the scene, is longer than the scene in its direction.
    let distance = (middle - center).length();
    let is_small = |x: f64, y: f64| {
        let step = ray(x, y).at(distance) - ray(0.0, 0.0).at(distance);
        unit(step).abs().dot(bounds.extent()) < step.length()
    };
    if is_small(1.0, 0.0) && is_small(0.0, 1.0) {
        let hint = "a smaller `angle` or `size` of the camera shows it larger";
        return (": the scene is smaller than a pixel", Some(hint.into()));
    }
    ("", None)
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
