//! Scenes whose primitives are dense in one place and sparse in another.

use super::support::{rabbit, random, world};
use glam::DVec3;
use raytracer::caster::choose::Layout;
use raytracer::caster::{Caster, RayOrigin};
use raytracer::math::instructions;
use raytracer::math::ray::Ray;
use raytracer::world::World;

/// The rabbit alone, or in one corner of a stadium that is `times` as large: a floor of two triangles, stands
/// of boxes, and a few objects that extend across many cells or lie within the rabbit's.
fn stadium(times: Option<f64>) -> World {
    let mut objects = vec!["TriangleMesh { obj_file rabbit.obj }".to_string()];
    if let Some(size) = times {
        objects.extend((0..300).map(|i| {
            let (x, z) = (size * (0.4 + (i % 20) as f64), -size * (0.3 + (i / 20) as f64));
            let (far_x, far_z) = (x + 0.4 * size, z - 0.4 * size);
            format!("Box {{ min {x} 0 {far_z} max {far_x} {size} {z} }}")
        }));
        let (low, high) = (-0.5 * size, 21.0 * size);
        objects.extend([
            format!(
                "Triangle {{ vertex0 {low} -0.1 {} vertex1 {low} -0.1 {high} vertex2 {high} -0.1 {high} }}",
                -high
            ),
            format!(
                "Triangle {{ vertex0 {low} -0.1 {} vertex1 {high} -0.1 {high} vertex2 {high} -0.1 {} }}",
                -high, -high
            ),
            format!("Triangle {{ vertex0 -0.2 0.3 0.4 vertex1 0.2 0.31 0.4 vertex2 {size} 0.3 0.41 }}"),
            "Sphere { center -0.12 0.05 0.1 radius 0.02 }".to_string(),
            format!("Sphere {{ center 0 {} 0 radius {size} }}", size + 1.0),
            "Transform { Translate 0.15 0.2 0 Scale 0.02 0.05 0.03 Sphere { center 0 0 0 radius 1 } }"
                .to_string(),
        ]);
    }
    world(&objects, &[rabbit()])
}

/// Rays that start within `radius` of the rabbit and run through the rabbit's box, or along an axis through
/// it.
fn rays(count: usize, radius: f64) -> impl Iterator<Item = Ray> {
    let mut random = random(11);
    (0..count).map(move |i| {
        let mut point = || DVec3::new(random(), random(), random());
        let (from, to) = (radius * point(), 0.4 * point() + DVec3::new(0.0, 0.1, 0.0));
        if i % 9 == 0 {
            Ray::new(to + radius * DVec3::AXES[i % 3], DVec3::AXES[i % 3] * -radius)
        } else {
            Ray::new(from, to - from)
        }
    })
}

#[test]
fn a_tree_gives_some_hits_that_testing_everything_gives() {
    check_tree(600);
}

#[test]
#[ignore = "slow: five seconds"]
fn a_tree_gives_the_hits_that_testing_everything_gives() {
    check_tree(3000);
}

/// Casts this number of rays from near and from far in each stadium.
fn check_tree(count: usize) {
    for size in [1.0, 1e3, 1e7] {
        let world = stadium(Some(size));
        let everything = Caster::new(&world, None).unwrap();
        let casters = instructions::available().into_iter();
        let casters: Vec<Caster> =
            casters.map(|with| Caster::with(&world, Layout::Tree, with).unwrap()).collect();
        // The farthest rays start too far from the innermost grids for their error bounds.
        for radius in [1.0, 20.0 * size] {
            let mut hits = 0;
            for ray in rays(count, radius) {
                let expected = everything.closest(&ray);
                hits += usize::from(expected.is_some());
                for caster in &casters {
                    assert_eq!(caster.closest(&ray), expected, "{size} {ray:?}");
                    assert_eq!(caster.any(&ray, RayOrigin::FREE), expected.is_some(), "{size} {ray:?}");
                }
            }
            assert!(hits > count / 3, "{hits}");
        }
    }
}

/// The object that spans a flat cell may be much smaller than the cell is long, and far from where a ray
/// enters it.
#[test]
fn a_small_thing_across_a_flat_crowded_cell_is_hit_from_afar() {
    let tiles = (0..200).map(|i| {
        let (x, z) = (0.01 * (i % 20) as f64, 0.01 * (i / 20) as f64);
        format!("Triangle {{ vertex0 {x} 0 {z} vertex1 {} 0 {z} vertex2 {x} 0 {} }}", x + 0.01, z + 0.01)
    });
    let upright = "Triangle { vertex0 9.9 0 9.9 vertex1 9.95 0 9.9 vertex2 9.92 0.1 9.91 }".to_string();
    let objects: Vec<String> = tiles.chain([upright]).collect();
    let world = world(&objects, &[]);
    for level in instructions::available() {
        let caster = Caster::with(&world, Layout::Tree, level).unwrap();
        let mut random = random(5);
        for _ in 0..1000 {
            let target = DVec3::new(9.92 + 0.02 * random(), 0.03 + 0.02 * random(), 9.903);
            let origin = DVec3::new(-3.0 * random(), 0.05 + 0.1 * random(), -2.0);
            let ray = Ray::new(origin, target - origin);
            assert_eq!(caster.closest(&ray).map(|hit| hit.primitive), Some(200), "{ray:?}");
            assert!(caster.any(&ray, RayOrigin::FREE));
        }
    }
}
