//! Surfaces that a ray hits at exactly the same t: it sees the first object of the scene.

use crate::support::measure::{Failures, measure};
use crate::support::placed::{scene_of, world_of};
use crate::support::rays;
use crate::support::rng::Rng;
use glam::DVec3;
use raytracer::caster::Caster;
use raytracer::caster::choose::Layout;
use raytracer::math::instructions;
use raytracer::math::ray::Ray;
use raytracer::scene::mesh::Mesh;

/// Whole numbers whose squares sum to the square of a whole number.
const ON_SPHERES: [([f64; 3], f64); 4] =
    [([2.0, 3.0, 6.0], 7.0), ([1.0, 4.0, 8.0], 9.0), ([2.0, 6.0, 9.0], 11.0), ([1.0, 2.0, 2.0], 3.0)];

/// An object of whole numbers through a point. A ray from `towards` hits it there first.
fn object(rng: &mut Rng, point: DVec3, towards: DVec3) -> String {
    let text = |v: DVec3| format!("{} {} {}", v.x, v.y, v.z);
    let side = |on: [f64; 3]| DVec3::from(on) * towards.signum();
    match rng.below(4) {
        0 => {
            let (mut on, radius) = ON_SPHERES[rng.below(4)];
            on.rotate_left(rng.below(3));
            format!("Sphere {{ center {} radius {radius} }}", text(point - side(on)))
        }
        1 => {
            // All factors are powers of two, so that nothing is rounded.
            let (factors, mut on) = (DVec3::new(2.0, 4.0, 1.0), [0.0, 0.0, 2.0]);
            on.rotate_left(rng.below(3));
            let center = point - factors * side(on);
            let sphere = "Sphere { center 0 0 0 radius 2 }";
            format!("Transform {{ Translate {} Scale {} {sphere} }}", text(center), text(factors))
        }
        2 => format!("Plane {{ normal 0 3 0 offset {} }}", point.y),
        _ => {
            let corner = |x: f64, z: f64| text(point + DVec3::new(x, 0.0, z));
            let [a, b, c] = [corner(-5.0, -6.0), corner(1.0, 7.0), corner(7.0, -3.0)];
            format!("Triangle {{ vertex0 {a} vertex1 {b} vertex2 {c} }}")
        }
    }
}

/// Counts the casts that do not see the first of some objects.
fn one(index: u64, failures: &Failures) -> ([u64; 2], [f64; 0]) {
    let mut rng = Rng::at(74, index);
    let point = DVec3::from([0; 3].map(|_| rng.integer(9)));
    let towards = DVec3::from([0; 3].map(|_| (1.0 + rng.below(20) as f64) * [1.0, -1.0][rng.below(2)]));
    let objects: Vec<String> = (0..2 + rng.below(3)).map(|_| object(&mut rng, point, towards)).collect();
    let world = world_of(&scene_of(&objects, ""), &Mesh { vertices: vec![], triangles: vec![] });
    // A ray may start at the point.
    let eye = if rng.below(3) == 0 { point } else { point + towards };
    let ray = Ray::new(eye, -towards);
    let [mut cast, mut wrong] = [0; 2];
    for layout in [Layout::List, Layout::Tree, Layout::Grid([3, 2, 4])] {
        let caster = Caster::with(&world, layout, instructions::available()[0]).expect("a small structure");
        let material = caster.closest(&ray).map(|hit| world.surface(&ray, &hit).material);
        cast += 1;
        wrong += failures.note(material != Some(0), || {
            format!("{index} {layout:?}: {ray:?} sees {material:?} of {objects:?}")
        });
    }
    ([cast, wrong], [])
}

#[test]
fn of_surfaces_at_the_same_t_the_first_object_is_seen() {
    let failures = Failures::default();
    let ([cast, wrong], []) = measure(rays(4000, 400_000), |index| one(index, &failures));
    assert_eq!(wrong, 0, "of {cast}");
}

/// The camera is on a sphere and in a plane.
#[test]
fn a_ray_that_starts_on_two_surfaces_sees_the_first_object() {
    let objects = ["Sphere { center 0 0 0 radius 1 }", "Plane { normal 0 1 0 offset 0 }"];
    for order in [[0, 1], [1, 0]] {
        let objects = order.map(|k| objects[k].to_string());
        let world = world_of(&scene_of(&objects, ""), &Mesh { vertices: vec![], triangles: vec![] });
        let ray = Ray::new(DVec3::X, DVec3::new(-1.0, 0.2, 0.3));
        let hit = Caster::new(&world, None).expect("no grid").closest(&ray).expect("both");
        assert_eq!((hit.t, world.surface(&ray, &hit).material), (0.0, 0), "{objects:?}");
    }
}
