//! Every hit is the same for all instruction sets that the inner loop is compiled for, and for all
//! structures.

use super::support::{rabbit, random, world};
use glam::DVec3;
use raytracer::base::patience::Endless;
use raytracer::caster::choose::Layout;
use raytracer::caster::dda::Dda;
use raytracer::caster::insertion::{bounds_of, push_cells};
use raytracer::caster::lattice::Lattice;
use raytracer::caster::{Caster, RayOrigin};
use raytracer::math::instructions::{self, Level};
use raytracer::math::ray::{Hit, Ray};

const OBJECTS: [&str; 4] = [
    "TriangleMesh { obj_file bunny_5k.obj }",
    "Sphere { center 0.05 0.3 0.05 radius 0.04 }",
    "Transform { Translate -0.1 0.1 0.1 Scale 0.05 0.02 0.03 Sphere { center 0 0 0 radius 1 } }",
    "Plane { normal 0.1 1 0 offset 0.06 }",
];

/// Enough cells for few primitives in each.
const FINE: [usize; 3] = [20, 17, 23];

/// Rays from all around to all around. Some of them are parallel to the axes, some end, some start too far
/// away for the filter and the DDA, and some have no direction.
fn rays() -> impl Iterator<Item = Ray> {
    let mut random = random(7);
    (0..30_000).map(move |i| {
        let mut point = || DVec3::new(random(), random() + 0.4, random());
        let (origin, target) = (2.0 * point(), point());
        let direction = if i % 10 == 0 { DVec3::AXES[i / 10 % 3] } else { target - origin };
        let t_min = if i % 7 == 0 { f64::NEG_INFINITY } else { 0.0 };
        let t_max = if i % 9 == 0 { 0.7 } else { f64::INFINITY };
        match i % 97 {
            // There are few of these, since every primitive is tested exactly for them.
            1 if i < 200 => Ray::new(target - 1e13 * direction, direction),
            2 => Ray::new(origin, DVec3::ZERO),
            3 => Ray::new(origin.with_y(f64::NAN), direction),
            4 => Ray::new(origin, direction.with_z(f64::NAN)),
            _ => Ray { origin, t_min, direction, t_max },
        }
    })
}

#[test]
fn hits_depend_neither_on_instructions_nor_on_structure() {
    let world = world(&OBJECTS.map(String::from), &[rabbit()]);
    let reference = Caster::with(&world, Layout::List, Level::baseline()).unwrap();
    let expected: Vec<(Ray, Option<Hit>)> = rays().map(|ray| (ray, reference.closest(&ray))).collect();
    assert!(expected.iter().filter(|(_, hit)| hit.is_some()).count() > 5000);
    for level in instructions::available() {
        for layout in [Layout::List, Layout::Grid([1; 3]), Layout::Grid(FINE), Layout::Tree] {
            let caster = Caster::with(&world, layout, level).unwrap();
            let is_fine = layout == Layout::Tree || layout.cells() == Some(FINE);
            // Where every ray is tested against all triangles, fewer do.
            let single = if is_fine { expected.len() } else { expected.len() / 10 };
            for (ray, hit) in &expected[..single] {
                let context = (level, layout, ray);
                assert_eq!(caster.closest(ray), *hit, "{context:?}");
                assert_eq!(caster.any(ray, RayOrigin::FREE), hit.is_some(), "{context:?}");
            }
        }
    }
}

/// A sphere or an ellipsoid that a ray is said to leave is tested first.
#[test]
fn what_is_tested_first_changes_no_answer() {
    let world = world(&OBJECTS.map(String::from), &[rabbit()]);
    let triangles = world.triangles.len() as u32;
    let round = triangles..world.first_plane();
    for level in instructions::available() {
        for layout in [Layout::List, Layout::Grid(FINE), Layout::Tree] {
            let caster = Caster::with(&world, layout, level).unwrap();
            let step = if layout == Layout::List { 50 } else { 1 };
            for ray in rays().step_by(step) {
                let expected = caster.nearest(&ray, RayOrigin::FREE).map(|visible| visible.primitive);
                for origin_primitive in round.clone() {
                    let origin = RayOrigin::on(&world, Some(origin_primitive));
                    let found = caster.nearest(&ray, origin);
                    assert_eq!(found.map(|visible| visible.primitive), expected, "{ray:?}");
                    assert_eq!(caster.any(&ray, origin), expected.is_some());
                }
            }
        }
    }
}

/// Follows each ray from cell to cell, and counts the primitives of each cell up to the hit.
#[test]
fn steps_are_those_of_the_cells_up_to_the_hit() {
    let world = world(&OBJECTS.map(String::from), &[rabbit()]);
    let caster = Caster::new(&world, Some(FINE)).unwrap().counting(FINE, &Endless).unwrap();
    let planes = world.planes.len() as u64;
    let lattice = Lattice::new(bounds_of(&world), FINE);
    let mut counts = vec![0; lattice.index_count()];
    for id in 0..world.finite_count() as u32 {
        let mut cells = vec![];
        push_cells(&world, id, &lattice, &mut cells);
        cells.iter().for_each(|&cell| counts[cell as usize] += 1);
    }
    let mut compared = 0;
    for ray in rays().filter(|ray| ray.origin.abs().max_element() < 10.0) {
        let nearest = caster.nearest(&ray, RayOrigin::FREE);
        let steps = caster.course_steps(&ray, nearest);
        let t = nearest.map_or(ray.t_max, |visible| world.hit(&ray, visible).t);
        let Some((mut dda, [entry, _])) = Dda::of_ray(&lattice, &ray) else {
            assert_eq!((steps.tests, steps.cells), (planes, 0), "{ray:?}");
            continue;
        };
        let (mut tests, mut cells) = (planes, 0);
        loop {
            let at = lattice.cell_of(dda.index());
            if t < entry || at.min_element() < 0.0 || (0..3).any(|axis| at[axis] >= FINE[axis] as f64) {
                break;
            }
            tests += counts[dda.index()];
            if dda.fixed_t(t) <= dda.exit() {
                break;
            }
            cells += u64::from(3 - dda.step().count_ones());
        }
        assert_eq!((steps.tests, steps.cells), (tests, cells), "{ray:?}");
        compared += 1;
    }
    assert!(compared > 1000, "{compared}");
}
