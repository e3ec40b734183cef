//! Checks that must hold for any scene text and any mesh text. The fuzz targets run them on random texts, and
//! `tests/casting/fuzz_findings.rs` on the seeds and on the texts for which they once failed.

use glam::DVec3;
use raytracer::camera::Camera;
use raytracer::caster::choose::Layout;
use raytracer::caster::{Caster, LazyCaster};
use raytracer::math::instructions::{self, Level};
use raytracer::picture::FloatPicture;
use raytracer::render::{Layer, Request, Shot, Tracing, View, render_in_memory};
use raytracer::scene::mesh::Mesh;
use raytracer::scene::obj::parse_obj;
use raytracer::scene::{Scene, parser::parse};
use raytracer::trace::{Effects, Shadows};
use raytracer::world::World;
use std::ops::ControlFlow;
use std::path::Path;

/// Checks that reading, flattening and rendering end without a panic, that neither a grid nor counting changes a byte of the pictures, and that no colour, depth or normal is NaN.
pub fn check_scene(text: &str) {
    let scene = match parse(text) {
        Ok(scene) => scene,
        Err(error) => return drop(error.in_text(Path::new("scene.txt"), text).to_string()),
    };
    let is_small = scene.objects.len() <= 60
        && scene.materials.len() <= 30
        && scene.lights.len() <= 6
        && scene.meshes.len() <= 4;
    if !is_small {
        return;
    }
    let meshes: Vec<Mesh> = meshes().into_iter().cycle().take(scene.meshes.len()).collect();
    match World::new(&scene, &meshes) {
        Ok(world) => check_pictures(&scene, &world),
        Err(error) => drop(error.in_text(Path::new("scene.txt"), text).to_string()),
    }
}

fn check_pictures(scene: &Scene, world: &World) {
    let (fastest, portable) = (instructions::available()[0], Level::baseline());
    let some = Layout::Grid([3, 2, 4]);
    let plain = tiny_picture(scene, Tracing::Fast, world, Layout::List, fastest);
    for (options, level) in [
        (some, fastest),
        (some, portable),
        (Layout::Tree, fastest),
        (Layout::Tree, portable),
        (Layout::List, portable),
    ] {
        let picture = tiny_picture(scene, Tracing::Fast, world, options, level);
        assert!(plain == picture, "the picture differs with {options:?}, {level:?}");
    }
    let counted = tiny_picture(scene, Tracing::Counted, world, some, fastest);
    assert!(plain == counted, "counting changes the picture");
}

/// The bytes of a picture of sixteen pixels with every effect.
fn tiny_picture(scene: &Scene, tracing: Tracing, world: &World, layout: Layout, level: Level) -> Vec<u8> {
    let caster = Caster::with(world, layout, level).expect("a small grid");
    let (bytes, nans) = bytes_and_nans(scene, &caster, tracing, [4, 4], [1.0, 10.0]);
    assert_eq!(nans, 0, "colours that are not numbers");
    bytes
}

/// The bytes of colours with every effect, of depths in a range and of normals, and the number of colours
/// with a NaN in these layers.
pub fn bytes_and_nans(
    scene: &Scene,
    caster: &Caster,
    tracing: Tracing,
    size: [usize; 2],
    [near, far]: [f64; 2],
) -> (Vec<u8>, u64) {
    let effects = Effects { shadows: Shadows::Transparent, shade_back: true, bounces: 3, min_weight: 0.01 };
    let layers = vec![Layer::Color, Layer::Depth { near, far }, Layer::Normals];
    let request = Request { effects, layers, tracing, ..Request::new(size) };
    let (camera, caster) = (Camera::new(&scene.camera, size), &LazyCaster::from(caster.clone()));
    let rendered = render_in_memory(&Shot { camera, caster, view: View::Scene }, &request, &|_| {
        ControlFlow::Continue(())
    });
    let (pictures, _) = rendered.expect("small pictures");
    pictures.iter().map(FloatPicture::to_bytes).fold((vec![], 0), |(mut all, nans), (bytes, more)| {
        all.extend(bytes);
        (all, nans + more)
    })
}

/// The meshes in place of those that a scene names, in turn: a tetrahedron, and a mesh of which only one
/// triangle has an area.
pub fn meshes() -> [Mesh; 2] {
    let tetrahedron = Mesh {
        vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    };
    let flat = Mesh {
        vertices: vec![DVec3::ZERO, DVec3::X, 0.5 * DVec3::X, DVec3::Y],
        triangles: vec![[0, 1, 2], [0, 0, 3], [3, 3, 3], [0, 1, 3]],
    };
    [tetrahedron, flat]
}

/// Checks that every mesh that is read is valid, and that a plain text of vertices and triangles is read
/// correctly.
pub fn check_obj(bytes: &[u8]) {
    let read = parse_obj(bytes);
    if let Ok(mesh) = &read {
        assert!(mesh.vertices.iter().all(|v| v.is_finite()));
        let vertices = mesh.vertices.len();
        assert!(mesh.triangles.as_flattened().iter().all(|&i| (i as usize) < vertices));
        let mut used = vec![false; vertices];
        mesh.triangles.as_flattened().iter().for_each(|&i| used[i as usize] = true);
        assert!(used.iter().all(|&used| used), "a vertex that no face uses");
    }
    if let Some(corners) = std::str::from_utf8(bytes).ok().and_then(plain_corners) {
        let mesh = read.expect("a plain mesh is read");
        let found: Vec<DVec3> =
            mesh.triangles.as_flattened().iter().map(|&i| mesh.vertices[i as usize]).collect();
        assert!(found == corners, "the corners differ");
    }
}

/// The corners of all triangles of a mesh text that consists of `v x y z` and `f i j k` only, where every
/// vertex comes before the faces that use it. None for any other text.
fn plain_corners(text: &str) -> Option<Vec<DVec3>> {
    let (mut vertices, mut corners) = (vec![], vec![]);
    for line in text.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        match words[..] {
            ["v", x, y, z] => vertices.push(DVec3::new(plain_number(x)?, plain_number(y)?, plain_number(z)?)),
            ["f", i, j, k] => {
                for index in [i, j, k] {
                    let index: usize =
                        Some(index).filter(|i| i.bytes().all(|b| b.is_ascii_digit()))?.parse().ok()?;
                    corners.push(*vertices.get(index.checked_sub(1)?)?);
                }
            }
            _ => return None,
        }
    }
    (!corners.is_empty()).then_some(corners)
}

/// A number of digits with at most one point between them and an optional minus sign.
fn plain_number(word: &str) -> Option<f64> {
    let digits = word.strip_prefix('-').unwrap_or(word);
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, "0"));
    let is_number = |s: &str| !s.is_empty() && s.len() < 30 && s.bytes().all(|b| b.is_ascii_digit());
    if is_number(whole) && is_number(fraction) { word.parse().ok() } else { None }
}
