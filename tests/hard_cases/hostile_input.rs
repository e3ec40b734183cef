//! Section F, hostile input: NaNs and infinities, vectors without length, pictures without pixels.

use crate::support::measure::{Failures, measure};
use crate::support::meshes::{mesh, unit_icosphere};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::{layers_and_nans, render_picture, scene_of};
use crate::support::{failed_ray, rays};
use glam::{DAffine3, DMat3, DVec3};
use raytracer::base::patience::Endless;
use raytracer::camera::Camera;
use raytracer::caster::{Caster, LazyCaster, RayOrigin};
use raytracer::math::ray::Ray;
use raytracer::render::{Layer, Request, Shot, Tracing, View, render_in_memory};
use raytracer::scene::material::{Material, Phong};
use raytracer::scene::{self, Light, Object, Position, Scene};
use raytracer::trace::{Effects, Shadows};
use raytracer::world::World;
use std::ops::ControlFlow;

const HOSTILE: [f64; 18] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    0.0,
    -0.0,
    1e-320,
    1e-200,
    -1e-160,
    1e160,
    -1e200,
    f64::MAX,
    1e-90,
    -1e90,
    1e-30,
    1e29,
    1e-9,
    1e9,
    -1.0,
];

/// An ordinary number, or with the given probability a hostile one.
fn number(rng: &mut Rng, hostility: f64) -> f64 {
    if rng.unit() < hostility { HOSTILE[rng.below(HOSTILE.len())] } else { rng.range(-3.0, 3.0) }
}

fn vector(rng: &mut Rng, hostility: f64) -> DVec3 {
    DVec3::from_array([0; 3].map(|_| number(rng, hostility)))
}

/// A scene with one object of each kind, and a mesh.
fn ordinary_scene() -> Scene {
    let place = |child, scale| {
        let matrix =
            DAffine3::from_scale_rotation_translation(scale, glam::DQuat::from_rotation_x(0.4), DVec3::Y);
        Object::Transform {
            matrix: matrix.into(),
            factors: Box::default(),
            child,
            at: Position { line: 1, column: 1 },
        }
    };
    let sphere = |center| Object::Sphere { center, radius: 0.5, material: 0 };
    let mut scene = scene_of(
        vec![
            sphere(DVec3::X),
            Object::Mesh { mesh: 0, material: 0 },
            Object::Plane { normal: DVec3::Y, offset: -1.0, material: 0 },
            Object::Triangle { vertices: [DVec3::X, DVec3::Y, DVec3::Z], material: 0 },
        ],
        vec![Light::Directional { direction: DVec3::new(-1.0, -2.0, -3.0), color: DVec3::ONE }],
    );
    scene.objects.push(sphere(DVec3::ZERO));
    scene.objects.push(place(scene.objects.len() - 1, DVec3::new(1.0, 0.3, 0.6)));
    let group = Object::Group(vec![scene.root, scene.objects.len() - 1]);
    scene.objects.push(group);
    scene.root = scene.objects.len() - 1;
    scene
}

/// Casts hostile rays. Counts the hits without a finite t and the hits of rays with a NaN.
fn cast_hostile_rays(inputs: u64) -> [u64; 3] {
    let world = World::new(&ordinary_scene(), &[unit_icosphere(0)]).expect("a sound scene");
    let casters = [None, Some([6, 5, 4])].map(|cells| Caster::new(&world, cells).expect("a small grid"));
    let failures = Failures::default();
    let (counts, []) = measure(inputs, |index| {
        let mut rng = Rng::at(61, index);
        let (origin, direction) = (vector(&mut rng, 0.3), vector(&mut rng, 0.4));
        let t_min = if rng.below(2) == 0 { 0.0 } else { f64::NEG_INFINITY };
        let ray = Ray { t_min, ..Ray::new(origin, direction) };
        let hits = casters.each_ref().map(|caster| caster.closest(&ray));
        let broken = !origin.is_finite() || !direction.is_finite() || direction == DVec3::ZERO;
        let not_finite = hits.iter().flatten().filter(|hit| !hit.t.is_finite()).count() as u64;
        let of_broken = if broken { hits.iter().flatten().count() as u64 } else { 0 };
        failures.note(not_finite + of_broken > 0, || failed_ray(61, 61, index, origin, direction));
        for caster in &casters {
            std::hint::black_box(caster.any(&ray, RayOrigin::FREE));
        }
        ([not_finite, of_broken, broken as u64], [])
    });
    counts
}

/// The number of tests and cells for hostile rays over that for ordinary ones, with a grid.
fn extra_work() -> f64 {
    let world = World::new(&ordinary_scene(), &[mesh("bunny_5k.obj")]).expect("a sound scene");
    let caster = Caster::of_planes(&world).counting([20; 3], &Endless).expect("a grid");
    let nearest = Caster::new(&world, Some([20; 3])).expect("a grid");
    let work = |is_hostile: bool| {
        let mut sum = 0;
        for index in 0..1500 {
            let mut rng = Rng::at(610, index);
            // The rays go towards the middle, where the mesh is.
            let origin = 2.0 * rng.direction();
            let mut direction = 0.5 * rng.in_cube() - origin;
            if is_hostile {
                direction[rng.below(3)] = HOSTILE[rng.below(5)];
            }
            let ray = Ray::new(origin, direction);
            let steps = caster.course_steps(&ray, nearest.nearest(&ray, RayOrigin::FREE));
            sum += steps.tests + steps.cells;
        }
        sum as f64
    };
    work(true) / work(false)
}

/// A scene of a few random objects with hostile numbers in any position.
fn hostile_scene(rng: &mut Rng) -> Scene {
    // Only a few of the many numbers of a scene are hostile.
    let h = [0.002, 0.01, 0.05][rng.below(3)];
    let mut objects = vec![];
    for _ in 0..1 + rng.below(4) {
        objects.push(match rng.below(5) {
            0 => Object::Sphere { center: vector(rng, h), radius: number(rng, h), material: 0 },
            1 => Object::Plane { normal: vector(rng, h), offset: number(rng, h), material: 0 },
            2 => Object::Box { min: vector(rng, h), max: vector(rng, h), material: 0 },
            3 => Object::Mesh { mesh: 0, material: 0 },
            _ => Object::Triangle { vertices: [0; 3].map(|_| vector(rng, h)), material: 0 },
        });
    }
    let lights = (0..rng.below(3)).map(|_| match rng.below(2) {
        0 => Light::Directional { direction: vector(rng, h), color: vector(rng, h) },
        _ => Light::Point {
            position: vector(rng, h),
            color: vector(rng, h),
            attenuation: vector(rng, h).to_array(),
        },
    });
    let lights = lights.collect();
    let mut scene = scene_of(objects, lights);
    scene.meshes.truncate(1);
    let matrix = DAffine3::from_mat3_translation(
        DMat3::from_cols(vector(rng, h), vector(rng, h), vector(rng, h)),
        vector(rng, h),
    );
    let at = Position { line: 1, column: 1 };
    scene.objects.push(Object::Transform {
        matrix: matrix.into(),
        factors: Box::default(),
        child: scene.root,
        at,
    });
    scene.root = scene.objects.len() - 1;
    scene.materials = vec![Material::Phong(Phong {
        diffuse: vector(rng, h),
        specular: vector(rng, h),
        reflective: vector(rng, h),
        transparent: vector(rng, h),
        exponent: number(rng, h),
        index_of_refraction: number(rng, h),
    })];
    let (center, direction, up) = (vector(rng, h), vector(rng, h), vector(rng, h));
    scene.camera = scene::Camera::Perspective { center, direction, up, angle: number(rng, h) };
    scene
}

/// Renders hostile scenes. Counts the scenes that are refused, those with a picture, the colours, depths and
/// normals of these that are NaN, and the scenes that end in a panic.
fn render_hostile_scenes(inputs: u64) -> [u64; 4] {
    let failures = Failures::default();
    let (counts, []) = measure(inputs, |index| {
        let result = std::panic::catch_unwind(|| nans_of_hostile_scene(index));
        failures
            .note(!matches!(result, Ok(None | Some(0))), || format!("case 61, scene {index}: {result:?}"));
        match result {
            Ok(None) => ([1, 0, 0, 0], []),
            Ok(Some(nans)) => ([0, 1, nans, 0], []),
            Err(_) => ([0, 0, 0, 1], []),
        }
    });
    counts
}

/// The number of NaNs in the pictures of a hostile scene; none where the scene is refused.
fn nans_of_hostile_scene(index: u64) -> Option<u64> {
    let tetrahedron = scene::mesh::Mesh {
        vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    };
    let scene = hostile_scene(&mut Rng::at(611, index));
    let world = World::new(&scene, &[tetrahedron]).ok()?;
    let caster = Caster::new(&world, Some([3, 2, 4])).ok()?;
    let effects = Effects { shadows: Shadows::Transparent, shade_back: true, bounces: 3, min_weight: 0.01 };
    let layers = vec![Layer::Color, Layer::Depth { near: 1.0, far: 5.0 }, Layer::Normals];
    let request = Request { effects, layers, ..Request::new([3, 3]) };
    Some(layers_and_nans(&Camera::new(&scene.camera, [3, 3]), &caster, &request, Tracing::Fast).1)
}

/// The number of pictures that change when every vector of which only the direction matters is scaled to an
/// extreme length.
fn extreme_lengths() -> usize {
    let picture = |scale: f64| {
        let mut scene = ordinary_scene();
        scene.camera = scene::Camera::Perspective {
            center: DVec3::new(0.0, 1.0, 5.0),
            direction: scale * DVec3::new(0.0, -0.25, -1.0),
            up: scale * DVec3::Y,
            angle: 40.0,
        };
        for light in &mut scene.lights {
            if let Light::Directional { direction, .. } = light {
                *direction *= scale;
            }
        }
        for object in &mut scene.objects {
            if let Object::Plane { normal, .. } = object {
                *normal *= scale;
            }
        }
        render_picture(&scene, &[mesh("bunny_200.obj")], None, [60, 60], Effects::default())
    };
    let usual = picture(1.0);
    // The factors are powers of two, which cause no rounding.
    [-1000, -600, 600, 1000].into_iter().filter(|&k| picture(2f64.powi(k)) != usual).count()
}

#[test]
fn case_61_hostile_input() {
    let inputs = rays(200_000, 20_000_000);
    let scenes = rays(20_000, 2_000_000);
    let [not_finite, of_broken, broken] = cast_hostile_rays(inputs);
    let [refused, rendered, nans, panics] = render_hostile_scenes(scenes);
    let lengths = extreme_lengths();
    let plain = [-1000, -600, 600, 1000].map(|k| (2f64.powi(k) * DVec3::new(1.0, 2.0, 3.0)).normalize());
    let lost = plain.iter().filter(|v| (v.length() - 1.0).abs() > 1e-9 || !v.is_finite()).count();
    let work = extra_work();
    Record {
        case: 61,
        basis: Basis::Sampled,
        name: "hostile input: NaN, infinities, zero directions, extreme lengths",
        inputs: format!("{inputs} rays, {broken} of them no rays; {scenes} scenes"),
        measure: "hits at no finite t / of rays that are none; pictures changed by the length of directions; panics; \
                  values of pictures that are not numbers; work",
        textbook: format!("plain normalisation of 4 extreme vectors: {lost} lost"),
        ours: format!(
            "{not_finite} / {of_broken}; {lengths}; {panics}; {nans} in {rendered} scenes, {refused} refused; \
             {work:.2} times the tests and cells of ordinary rays"
        ),
        target: "0 / 0; 0; 0; 0; <= 1 times",
    }
    .write();
    assert!(lost > 0, "the textbook method does not fail");
    assert_eq!((not_finite, of_broken, lengths), (0, 0, 0));
    assert_eq!((panics, nans), (0, 0));
    assert!(rendered >= scenes / 10, "{rendered}: the case tests little");
    assert!(work <= 1.0, "{work}");
    a_picture_without_size_is_an_error();
    a_background_that_is_nan_is_refused_and_counted();
    without_lights_the_ambient_light_is_white();
}

fn a_picture_without_size_is_an_error() {
    let world = World::new(&ordinary_scene(), &[mesh("bunny_200.obj")]).expect("a sound scene");
    let caster = LazyCaster::from(Caster::new(&world, None).expect("no grid"));
    for size in [[0, 5], [5, 0], [0, 0], [u32::MAX as usize; 2]] {
        let (camera, view) = (Camera::new(&ordinary_scene().camera, size), View::Scene);
        let rendered =
            render_in_memory(&Shot { camera, caster: &caster, view }, &Request::new(size), &|_| {
                ControlFlow::Continue(())
            });
        assert!(rendered.is_err(), "{size:?}");
    }
}

fn a_background_that_is_nan_is_refused_and_counted() {
    let mut scene = scene_of(vec![], vec![]);
    let mut world = World::new(&scene, &[]).expect("an empty scene");
    scene.background.color = DVec3::new(0.5, f64::NAN, 0.5);
    assert!(World::new(&scene, &[]).is_err());
    // A NaN that no check prevented would still be counted.
    world.background = scene.background.color;
    let caster = Caster::new(&world, Some([2; 3])).expect("no grid is built");
    let camera = Camera::new(&scene.camera, [7, 5]);
    assert_eq!(layers_and_nans(&camera, &caster, &Request::new([7, 5]), Tracing::Fast).1, 35);
}

fn without_lights_the_ambient_light_is_white() {
    let mut scene =
        scene_of(vec![Object::Sphere { center: -2.0 * DVec3::Z, radius: 9.0, material: 0 }], vec![]);
    scene.background.color = DVec3::ZERO;
    let bytes = render_picture(&scene, &[], None, [4, 4], Effects { shade_back: true, ..Effects::default() });
    assert!(bytes.iter().all(|&b| b == 255));
}
