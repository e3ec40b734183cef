//! Changes that must not change a picture, tested for all scenes: scaling by a power of two, translation, the
//! grid, counting rays, the number of threads, the order of a mesh's faces, and faces that add nothing. Cases
//! 50 and 51 of section E are among them.

use crate::support::all_scenes::{
    Named, moved_world, own_scenes, render, render_with, scaled, scenes, translated,
};
use crate::support::brute::Brute;
use crate::support::measure::{Failures, measure};
use crate::support::meshes::shuffle;
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::world_of_mesh;
use crate::support::textbook::{lower, lower_triangle, moller_trumbore};
use crate::support::{failed_ray, rays};
use glam::{DVec2, DVec3};
use raytracer::camera::Camera;
use raytracer::caster::Caster;
use raytracer::math::ray::Ray;
use raytracer::render::Tracing;
use raytracer::scene::mesh::Mesh;
use raytracer::world::World;
use std::collections::BTreeSet;

/// Compares every scene's picture with those of its variants. Returns the number of comparisons and the names
/// of the scenes that differ.
fn different_pictures<V: std::fmt::Debug>(
    variants: &[V],
    picture: impl Fn(&Named, &V) -> Vec<u8>,
) -> (usize, Vec<String>) {
    let mut compared = 0;
    let mut different = Vec::new();
    for scene in scenes() {
        let expected = render(&scene, &scene.world(), Some([9, 8, 7]), 0);
        let colors: BTreeSet<_> = expected.chunks_exact(3).collect();
        assert!(colors.len() >= 3, "{} shows nothing", scene.name);
        for variant in variants {
            compared += 1;
            if picture(&scene, variant) != expected {
                different.push(format!("{} {variant:?}", scene.name));
            }
        }
    }
    (compared, different)
}

/// Asserts that no variant of a scene changes its picture.
fn same_pictures<V: std::fmt::Debug>(variants: &[V], picture: impl Fn(&Named, &V) -> Vec<u8>) {
    let (_, different) = different_pictures(variants, picture);
    assert!(different.is_empty(), "other pictures:\n{}", different.join("\n"));
}

fn is_long() -> bool {
    rays(0, 1) == 1
}

#[test]
fn case_50_scaled_by_powers_of_two() {
    let powers: Vec<i32> = if is_long() { (-40..=40).collect() } else { vec![-40, -20, -1, 1, 20, 40] };
    let (compared, different) = different_pictures(&powers, |scene, &k| {
        let large = scaled(scene, k);
        render(&large, &large.world(), Some([9, 8, 7]), k)
    });
    let lost = textbook_loses_hits(2f64.powi(-20));
    Record {
        case: 50,
        basis: Basis::Sampled,
        name: "scenes scaled by 2^-40 to 2^40",
        inputs: format!("{compared} pictures with their depths and normals, shadows and 3 bounces"),
        measure: "pictures of other bytes",
        textbook: format!(
            "Moeller-Trumbore f32 with an epsilon of 1e-6 at 2^-20 loses {:.1}% of hits",
            100.0 * lost
        ),
        ours: different.len().to_string(),
        target: "0",
    }
    .write();
    assert!(different.is_empty(), "other pictures:\n{}", different.join("\n"));
    assert!(lost > 0.5, "the case tests nothing");
}

/// The fraction of the rabbit's hits that a fixed epsilon loses at a scale.
fn textbook_loses_hits(scale: f64) -> f64 {
    let mesh = crate::support::meshes::bunny("1k");
    let world = world_of_mesh(&mesh);
    let brute = Brute::new(&world);
    let one = |index| {
        let rng = &mut Rng::at(1050, index);
        let ray = Ray::new(
            DVec3::new(0.0, 0.1, 1.0),
            DVec3::new(0.0, 0.1, 0.0) + 0.1 * rng.in_ball() - DVec3::new(0.0, 0.1, 1.0),
        );
        let Some(hit) = brute.closest(&ray) else { return ([0, 0], []) };
        let t = world.corners(hit.primitive as usize).map(|v| v * scale);
        let found =
            moller_trumbore(lower(ray.origin * scale), lower(ray.direction), lower_triangle::<f32>(t), 1e-6);
        ([1, found.is_none() as u64], [])
    };
    let ([hits, lost], []) = measure(10_000, one);
    lost as f64 / hits as f64
}

/// The camera rays of a picture's pixels.
fn camera_rays(scene: &Named, width: usize) -> impl Fn(u64) -> Ray + Sync {
    let camera = Camera::new(&scene.scene.camera, [width, width]);
    move |index| {
        let pixel = [index as usize % width, index as usize / width].map(|i| i as f64);
        camera.ray(DVec2::from_array(pixel), DVec2::ZERO)
    }
}

/// First the scenes' triangles, with coordinates rounded to multiples of 2^-30 of the extent. Adding 2^20
/// extents to these is exact, so that any difference is an error of the tracer. Then whole scenes, whose
/// coordinates are rounded by the translation itself, so that bytes may differ by one.
#[test]
fn case_51_moved_by_a_million_extents() {
    let width = rays(80, 800) as usize;
    let failures = Failures::default();
    let (mut inputs, mut sums) = (0, [0; 3]);
    for scene in scenes() {
        let Some((at_home, unit)) = moved_world(&scene, DVec3::ZERO) else { continue };
        let home = Caster::new(&at_home, Some([20, 20, 20])).expect("a small grid");
        let draw = camera_rays(&scene, width);
        for (k, signs) in
            [(3, DVec3::ONE), (12, DVec3::new(1.0, -1.0, 0.5)), (20, DVec3::new(-1.0, 0.25, 1.0))]
        {
            let shift = unit * 2f64.powi(k) * signs;
            let (world, _) = moved_world(&scene, shift).expect("it was one at home");
            let away = Caster::new(&world, Some([20, 20, 20])).expect("a small grid");
            let one = |index| {
                let ray = draw(index);
                let grid = unit * 0.5f64.powi(30);
                let ray = Ray { origin: (ray.origin / grid).round() * grid, ..ray };
                let there = Ray { origin: ray.origin + shift, ..ray };
                let (hit, moved) = (home.closest(&ray), away.closest(&there));
                failures.note(hit != moved, || failed_ray(51, 0, index, there.origin, there.direction));
                (
                    [
                        (hit != moved) as u64,
                        hit.is_some() as u64,
                        changes_in_f32(&at_home, &world, hit, &there) as u64,
                    ],
                    [],
                )
            };
            let (counts, []) = measure::<3, 0>((width * width) as u64, one);
            inputs += width * width;
            sums = crate::grid::sum([sums, counts]);
        }
    }
    let [changed, hits, textbook] = sums;
    let (pixels, off) = pixels_that_move();
    Record {
        case: 51,
        basis: Basis::Sampled,
        name: "scenes moved by up to 1e6 extents",
        inputs: format!("{inputs} camera rays, {hits} of which hit; {pixels} bytes of whole pictures"),
        measure: "hits that change, in t or in what is hit; bytes that change by more than one",
        textbook: format!("Moeller-Trumbore f32: {textbook} hits are lost"),
        ours: format!("{changed}; {off}"),
        target: "0; 0",
    }
    .write();
    assert_eq!((changed, off), (0, 0));
    assert!(textbook > 0 && hits > 0, "the case tests nothing");
}

/// Translates every scene of this project by a million of its extents. Returns the number of bytes compared
/// and the number of those that differ by more than one.
///
/// This number cannot be zero for every scene, since the translation rounds the coordinates. Where the camera
/// is in the plane of a checkerboard's boundary, the colour of a row of pixels depends on how the points of a
/// curved surface are rounded, even without the translation. The facets of a gem multiply an angle at every
/// bounce. And the shadow rays of two mirrored pixels may just touch an edge, where a translation by a tenth
/// already changes the result. The course has scenes of each kind. One scene of this project has details of 1e-12 of
/// its extent, which such a translation rounds away.
fn pixels_that_move() -> (usize, usize) {
    let (mut pixels, mut off) = (0, 0);
    for scene in own_scenes().into_iter().filter(|scene| !scene.name.ends_with("show_scales.txt")) {
        let extent = scene.world().bounds.extent().max_element();
        let there = translated(&scene, 1e6 * extent * DVec3::new(1.0, -0.3, 0.5));
        let picture = |scene: &Named| render(scene, &scene.world(), Some([9, 8, 7]), 0);
        let (before, after) = (picture(&scene), picture(&there));
        let different = before.iter().zip(&after).filter(|(a, b)| a.abs_diff(**b) > 1).count();
        if different > 0 {
            println!("{}: {different} of {} bytes", scene.name, before.len());
        }
        pixels += before.len();
        off += different;
    }
    (pixels, off)
}

/// Whether single precision loses the hit at the triangle's translated position.
fn changes_in_f32(home: &World, away: &World, hit: Option<raytracer::math::ray::Hit>, ray: &Ray) -> bool {
    let triangle = hit.map(|h| h.primitive as usize).filter(|&i| i < home.triangles.len());
    triangle.is_some_and(|i| {
        moller_trumbore(lower(ray.origin), lower(ray.direction), lower_triangle::<f32>(away.corners(i)), 0.0)
            .is_none()
    })
}

#[test]
fn any_grid_makes_the_same_picture() {
    let mut cells = vec![
        None,
        Some([1; 3]),
        Some([2; 3]),
        Some([50; 3]),
        Some([500, 1, 1]),
        Some([1, 500, 2]),
        Some([3, 2, 500]),
        Some([33, 120, 7]),
    ];
    if is_long() {
        cells.extend([
            Some([500; 3]),
            Some([250; 3]),
            Some([500, 500, 1]),
            Some([128; 3]),
            Some([499, 3, 100]),
        ]);
    }
    same_pictures(&cells, |scene, &cells| render(scene, &scene.world(), cells, 0));
}

#[test]
fn rays_that_are_counted_make_the_same_picture() {
    same_pictures(&[None, Some([9, 8, 7])], |scene, &cells| {
        let world = scene.world();
        // Without a grid each ray would be tested against all triangles.
        let cells = cells.or((world.triangles.len() > 10_000).then_some([30; 3]));
        let caster = Caster::new(&world, cells).expect("a small grid");
        render_with(scene, &caster, Tracing::Counted, 0)
    });
}

#[test]
fn any_number_of_threads_makes_the_same_picture() {
    same_pictures(&[1, 2, 7], |scene, &threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| render(scene, &scene.world(), Some([9, 8, 7]), 0))
    });
}

/// A change to the faces of a mesh.
#[derive(Debug)]
enum Change {
    Shuffled,
    Doubled,
    WithDegenerates,
    All,
}

impl Change {
    fn apply(&self, mesh: &Mesh) -> Mesh {
        let rng = &mut Rng::new(77);
        let mut changed = mesh.clone();
        let faces = mesh.triangles.len();
        if matches!(self, Self::Doubled | Self::All) {
            changed.triangles.extend_from_slice(&mesh.triangles);
        }
        if matches!(self, Self::WithDegenerates | Self::All) {
            changed.triangles.extend((0..faces).map(|i| {
                let [a, b, c] = mesh.triangles[i];
                [[a, a, b], [b, c, b], [c, c, c], [c, a, a]][rng.below(4)]
            }));
        }
        if matches!(self, Self::Shuffled | Self::All) {
            shuffle(&mut changed.triangles, rng);
        }
        changed
    }
}

#[test]
fn the_faces_order_and_faces_that_add_nothing_leave_the_picture() {
    // The last is all others together; these tell which of them it is that fails.
    let changes = [Change::All, Change::Shuffled, Change::Doubled, Change::WithDegenerates];
    let changes = if is_long() { &changes[..] } else { &changes[..1] };
    same_pictures(changes, |scene, change| {
        let meshes = scene.meshes.iter().map(|m| change.apply(m)).collect();
        let changed = Named { meshes, ..scene.clone() };
        render(&changed, &changed.world(), Some([40, 36, 32]), 0)
    });
}
