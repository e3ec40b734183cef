//! Every hit is the same for all instruction sets that the inner loop is compiled for, and for all
//! structures.

use super::support::{rabbit, random, world};
use glam::DVec3;
use raytracer::caster::choose::Layout;
use raytracer::caster::packet::PacketRay;
use raytracer::caster::{Caster, Instructions};
use raytracer::math::ray::{Hit, Ray, Visible};
use raytracer::stats::{Counts, Quiet};

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
    let reference = Caster::with(&world, Layout::List, Instructions::Portable).unwrap();
    let expected: Vec<(Ray, Option<Hit>)> =
        rays().map(|ray| (ray, reference.closest(&ray, &mut Quiet))).collect();
    assert!(expected.iter().filter(|(_, hit)| hit.is_some()).count() > 5000);
    for instructions in Instructions::available() {
        for layout in [
            Layout::List,
            Layout::Grid([1; 3]),
            Layout::Grid(FINE),
            Layout::Tree,
            Layout::Course(None),
            Layout::Course(Some([1; 3])),
            Layout::Course(Some(FINE)),
        ] {
            {
                let caster = Caster::with(&world, layout, instructions).unwrap();
                let is_fine = layout == Layout::Tree || layout.cells() == Some(FINE);
                // Where every ray is tested against all triangles, fewer do.
                let single = if is_fine { expected.len() } else { expected.len() / 10 };
                for (ray, hit) in &expected[..single] {
                    let context = (instructions, layout, ray);
                    assert_eq!(caster.closest(ray, &mut Quiet), *hit, "{context:?}");
                    assert_eq!(caster.closest(ray, &mut Counts::default()), *hit, "{context:?}");
                    assert_eq!(caster.any(ray, &mut Quiet), hit.is_some(), "{context:?}");
                }
                // Without a grid packets are traced as single rays, and in a single cell they are slow.
                let count = if is_fine { expected.len() } else { 300 };
                packets_have_the_hits_of_single_rays(&caster, &expected[..count]);
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
    for instructions in Instructions::available() {
        for layout in [Layout::List, Layout::Grid(FINE), Layout::Tree] {
            let caster = Caster::with(&world, layout, instructions).unwrap();
            let step = if layout == Layout::List { 50 } else { 1 };
            for ray in rays().step_by(step) {
                let expected = caster.nearest(&ray, None, &mut Quiet).map(|visible| visible.primitive);
                for leaves in round.clone() {
                    let found = caster.nearest(&ray, Some(leaves), &mut Quiet);
                    assert_eq!(found.map(|visible| visible.primitive), expected, "{ray:?}");
                    assert_eq!(caster.any_from(&ray, Some(leaves), &mut Quiet), expected.is_some());
                }
            }
        }
    }
}

#[test]
fn the_course_tests_a_sphere_where_it_comes_to_it() {
    let world = world(&OBJECTS.map(String::from), &[rabbit()]);
    let caster = Caster::with(&world, Layout::Grid(FINE), Instructions::available()[0]).unwrap();
    let sphere = world.triangles.len() as u32;
    for ray in rays().take(3000) {
        let [plain, leaving] = [None, Some(sphere)].map(|leaves| {
            let mut counts = Counts::default();
            (caster.nearest(&ray, leaves, &mut counts), counts)
        });
        assert_eq!(plain, leaving, "{ray:?}");
    }
}

/// A ray and its hit.
#[derive(Debug)]
struct Asked(Ray, Option<Visible>);

impl PacketRay for Asked {
    fn ray(&self) -> &Ray {
        &self.0
    }

    fn set_visible(&mut self, visible: Option<Visible>) {
        self.1 = visible;
    }
}

/// A ray that leaves a primitive, and its hit.
struct Leaving(Asked, Option<u32>);

impl PacketRay for Leaving {
    const LEAVES_A_SURFACE: bool = true;

    fn ray(&self) -> &Ray {
        self.0.ray()
    }

    fn leaves(&self) -> Option<u32> {
        self.1
    }

    fn set_visible(&mut self, visible: Option<Visible>) {
        self.0.set_visible(visible);
    }
}

/// Packets of all lengths, up to more rays than one packet holds.
fn packets_have_the_hits_of_single_rays(caster: &Caster, rays: &[(Ray, Option<Hit>)]) {
    let mut rest = rays;
    for length in (1..40).cycle() {
        let (now, later) = rest.split_at(rest.len().min(length));
        // A value that every packet must overwrite.
        let wrong = Some(Visible { primitive: u32::MAX, t_bound: 0.0 });
        let mut asked: Vec<Asked> = now.iter().map(|(ray, _)| Asked(*ray, wrong)).collect();
        caster.nearest_of_packet(&mut asked);
        for Asked(ray, visible) in asked {
            assert_eq!(visible, caster.nearest(&ray, None, &mut Quiet), "{ray:?}");
        }
        // The rays leave what they hit, or another triangle, or one of the primitives that are not triangles.
        let round = caster.world.triangles.len() as u32;
        let left = |k: usize, hit: &Option<Hit>| match k % 4 {
            0 => None,
            1 => Some(round + (k / 4 % 3) as u32),
            2 => Some(k as u32 % round),
            _ => hit.map(|hit| hit.primitive),
        };
        let leaving = now.iter().enumerate();
        let leaving = leaving.map(|(k, (ray, hit))| Leaving(Asked(*ray, wrong), left(k + rest.len(), hit)));
        let mut leaving: Vec<Leaving> = leaving.collect();
        caster.nearest_of_packet(&mut leaving);
        for Leaving(Asked(ray, visible), left) in leaving {
            assert_eq!(visible, caster.nearest(&ray, left, &mut Quiet), "{left:?} {ray:?}");
        }
        rest = later;
        if rest.is_empty() {
            break;
        }
    }
}
