//! Scenes that no grid can separate, or that lead to a grid far larger than its contents: the size of what is built stays
//! within a stated multiple of the number of primitives.

use super::support::{automatic, random, world};
use glam::DVec3;
use rayon::prelude::*;
use raytracer::caster::RayOrigin;
use raytracer::caster::choose::Layout;
use raytracer::caster::{Caster, StructureSize};
use raytracer::math::instructions;
use raytracer::math::ray::Ray;
use raytracer::scene::mesh::Mesh;
use raytracer::world::World;

/// A scene with its name. It is built for about the given number of primitives.
type Scene = (&'static str, fn(usize) -> World);

const SCENES: [Scene; 14] = [
    ("almost equal triangles", |n| {
        of_triangles(n, |i, _| [DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0), (1.0 + 1e-12 * i as f64) * DVec3::Z])
    }),
    ("almost equal spheres", |n| {
        of_objects(n, |i| format!("Sphere {{ center 0 0 0 radius {} }}", 1.0 + 1e-12 * i as f64))
    }),
    ("identical boxes", |n| of_objects(n / 12 + 1, |_| "Box { min 0 0 0 max 1 1 1 }".to_string())),
    ("stacked plates", |n| {
        of_objects(n / 12 + 1, |i| {
            let low = 0.0001 * i as f64;
            format!("Box {{ min 0 0 {low} max 1 1 {} }}", low + 0.00005)
        })
    }),
    ("nested spheres", |n| {
        of_objects(n, |i| format!("Sphere {{ center 0 0 0 radius {} }}", 1.0 + i as f64 / n as f64))
    }),
    ("boxes each in the corner of another", |n| {
        of_objects(n / 12 + 1, |i| format!("Box {{ min 0 0 0 max {0} {0} {0} }}", 0.5f64.powi(i as i32 % 64)))
    }),
    ("diagonal slivers", |n| {
        of_triangles(n, |_, point| {
            let (from, across) = (0.2 * point(), 1e-4 * point());
            [from, from + across, from + 1.0]
        })
    }),
    ("triangles through a box", |n| of_triangles(n, |_, point| [point(), point(), point()])),
    ("triangles in a plane", |n| {
        of_triangles(n, |_, point| [0; 3].map(|_| point()).map(|p: DVec3| p.with_z(0.0)))
    }),
    ("a fan", |n| {
        of_triangles(n, |i, _| {
            let rim = |i: usize| {
                let angle = i as f64 * std::f64::consts::TAU / n as f64;
                DVec3::new(libm::cos(angle), libm::sin(angle), 0.0)
            };
            [DVec3::ZERO, rim(i), rim(i + 1)]
        })
    }),
    ("a star", |n| {
        of_triangles(n, |_, point| {
            let tip = point().normalize_or(DVec3::X);
            [DVec3::ZERO, tip, tip + 0.001 * point()]
        })
    }),
    ("one huge among many", |n| of_triangles(n, |i, point| small_or(i == 7, 2.0, n, point))),
    ("a hundredth huge among many", |n| of_triangles(n, |i, point| small_or(i % 100 == 7, 2.0, n, point))),
    ("a heap of almost equal triangles among others", |n| {
        of_triangles(n, |i, point| match i % 2 {
            0 => [DVec3::ZERO, DVec3::new(0.2, 0.2, 0.0), DVec3::new(0.0, 0.1, 0.2 + 1e-12 * i as f64)],
            _ => small_or(false, 0.0, n, point),
        })
    }),
];

/// A world of `n` triangles, made from their indices and random points between -0.5 and 0.5.
fn of_triangles(n: usize, corners: impl Fn(usize, &mut dyn FnMut() -> DVec3) -> [DVec3; 3]) -> World {
    let mut random = random(3);
    let mut point = || DVec3::new(random(), random(), random());
    let vertices: Vec<DVec3> = (0..n).flat_map(|i| corners(i, &mut point)).collect();
    let triangles = (0..n as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    world(&["TriangleMesh { obj_file a.obj }".to_string()], &[Mesh { vertices, triangles }])
}

/// A triangle at a random position. It has this size if `huge`, and otherwise one so small that `n` of them
/// hardly overlap.
fn small_or(huge: bool, size: f64, n: usize, point: &mut dyn FnMut() -> DVec3) -> [DVec3; 3] {
    let size = if huge { size } else { 0.3 / libm::cbrt(n as f64) };
    let middle = point();
    [0; 3].map(|_| middle + size * point())
}

/// A world of `n` objects, made from their indices.
fn of_objects(n: usize, object: impl Fn(usize) -> String) -> World {
    world(&(0..n).map(object).collect::<Vec<_>>(), &[])
}

/// The numbers of rays for a small picture and for a large one.
const RAYS: [usize; 2] = [10_000, 100_000_000];

/// The limit that `src/caster/choose.rs` states.
fn most_entries(count: usize) -> usize {
    (16 * count).max(65536)
}

fn assert_bounded(name: &str, count: usize, size: StructureSize) {
    let most = most_entries(count);
    assert!(size.references <= most, "{name}, {count}: {size:?}");
    assert!(size.blocks <= most / 4, "{name}, {count}: {size:?}");
    assert!(size.cells <= 2 * most, "{name}, {count}: {size:?}");
}

#[test]
fn sizes_are_bounded_by_the_number_of_primitives() {
    check_sizes(&[100, 110, 200, 300, 600, 1000, 10_000]);
}

#[test]
#[ignore = "slow: ten seconds"]
fn sizes_are_bounded_by_a_large_number_of_primitives() {
    let is_long = std::env::var("HARD_CASES").is_ok_and(|tier| tier == "long");
    check_sizes(if is_long { &[100_000, 1_000_000] } else { &[100_000] });
}

fn check_sizes(sizes: &[usize]) {
    for &n in sizes {
        for (name, scene) in SCENES {
            let world = scene(n);
            let count = world.finite_count();
            for rays in RAYS {
                let grid = automatic(&world, rays, instructions::available()[0]).size();
                println!("{name}, {count}, {rays} rays: a grid {grid:?}");
                assert_bounded(name, count, grid);
            }
            let tree = Caster::with(&world, Layout::Tree, instructions::available()[0]).unwrap().size();
            assert_bounded(name, count, tree);
            assert_eq!(tree.references, world.visible_count(), "{name}, {n}");
        }
    }
}

/// Rays to the centres of triangles, or to random points in a world without triangles.
fn rays_at(world: &World, count: usize) -> impl Iterator<Item = Ray> {
    let mut random = random(count as u64);
    (0..count).map(move |i| {
        let mut point = || DVec3::new(random(), random(), random());
        let (from, spot) = (4.0 * point(), point());
        let middle = |triangle: usize| world.corners(triangle).into_iter().sum::<DVec3>() / 3.0;
        let triangles = world.triangles.len();
        let to = if triangles > 0 { middle(i * 7919 % triangles) } else { spot };
        Ray::new(from, to - from)
    })
}

#[test]
fn some_rays_hit_every_bad_scene_where_testing_everything_hits_it() {
    check_hits(&[(100, 100), (300, 50), (1000, 30)]);
}

#[test]
#[ignore = "slow: half a minute"]
fn every_bad_scene_is_hit_where_testing_everything_hits_it() {
    check_hits(&[(100, 300), (300, 300), (1000, 300), (3000, 50)]);
}

/// Tries scenes of these numbers of primitives, each with a number of rays.
fn check_hits(sizes: &[(usize, usize)]) {
    SCENES.par_iter().for_each(|(name, scene)| {
        for &(n, count) in sizes {
            let world = scene(n);
            let everything = Caster::new(&world, None).unwrap();
            let [few, many] = RAYS;
            let with = instructions::available()[0];
            let tree = Caster::with(&world, Layout::Tree, with).unwrap();
            let casters = [automatic(&world, few, with), automatic(&world, many, with), tree];
            let mut hits = 0;
            for ray in rays_at(&world, count) {
                let expected = everything.closest(&ray);
                hits += usize::from(expected.is_some());
                for caster in &casters {
                    assert_eq!(caster.closest(&ray), expected, "{name}, {n}: {ray:?}");
                    assert_eq!(caster.any(&ray, RayOrigin::FREE), expected.is_some(), "{name}, {n}: {ray:?}");
                }
            }
            assert!(2 * hits > count, "{name}, {n}: {hits}");
        }
    });
}

/// A grid whose cells the user specifies is built as specified.
#[test]
fn a_grid_of_given_cells_is_taken_literally() {
    let world = SCENES[0].1(300);
    let caster = Caster::new(&world, Some([20; 3])).unwrap();
    let size = caster.size();
    assert!(size.cells == 22 * 22 * 22 && size.references > 300 * 20 * 10, "{size:?}");
}
