//! Strategies for random scenes and rays, with ordinary numbers and with extreme ones.

use glam::{DAffine3, DQuat, DVec3};
use proptest::prelude::*;
use raytracer::math::ray::Ray;
use raytracer::math::robust::unit;
use raytracer::scene::limits::SMALLEST_RADIUS;
use raytracer::scene::material::{Material, Pattern, Phong, Texture};
use raytracer::scene::model::{Lighting, MeasureColors, MeshNormals, Screen, Shows};
use raytracer::scene::{self, Background, Light, MeshFile, Object, ObjectId, Position, Scene};

const AT: Position = Position { line: 1, column: 1 };

/// The range of the numbers in a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    Ordinary,
    /// Numbers of any size, including zero.
    Extreme,
}

/// The magnitudes of extreme numbers. For some of them squares or cubes overflow or underflow, or almost do.
/// The largest are those that a scene allows.
const SIZES: [f64; 18] = [
    5e-324, 1e-300, 1e-200, 1e-150, 1e-108, 1e-100, 1e-77, 1e-46, 1e-38, 1e-20, 1e-16, 1e-9, 1e9, 1e20, 1e50,
    1e77, 1e99, 0.0,
];

fn extreme() -> impl Strategy<Value = f64> {
    (prop::sample::select(&SIZES[..]), -9.0..9.0).prop_map(|(size, factor): (f64, f64)| size * factor)
}

/// A number that is extreme now and then, if the range has extreme numbers.
fn sometimes_extreme(range: Range, usual: impl Strategy<Value = f64> + 'static) -> BoxedStrategy<f64> {
    match range {
        Range::Ordinary => usual.boxed(),
        Range::Extreme => prop_oneof![7 => usual, 1 => extreme()].boxed(),
    }
}

/// Any coordinate, or a multiple of a quarter, so that objects touch and coincide.
fn coordinate(range: Range) -> BoxedStrategy<f64> {
    let usual = prop_oneof![-2.0..2.0, (-8..=8i32).prop_map(|n| f64::from(n) / 4.0)];
    sometimes_extreme(range, usual)
}

fn point(range: Range) -> impl Strategy<Value = DVec3> {
    [coordinate(range), coordinate(range), coordinate(range)].prop_map(DVec3::from_array)
}

fn direction(range: Range) -> impl Strategy<Value = DVec3> {
    point(range).prop_filter("a direction has a length", move |v| match range {
        Range::Ordinary => v.length() > 0.1,
        Range::Extreme => *v != DVec3::ZERO,
    })
}

fn color() -> impl Strategy<Value = DVec3> {
    prop_oneof![Just(DVec3::ZERO), [0.0..1.0, 0.0..1.0, 0.0..1.0].prop_map(DVec3::from_array)]
}

fn phong() -> impl Strategy<Value = Material> {
    (color(), color(), 0.0..50.0, color(), color(), 0.5..2.5).prop_map(
        |(diffuse, specular, exponent, reflective, transparent, index_of_refraction)| {
            Material::Phong(Phong {
                diffuse,
                specular,
                exponent,
                reflective,
                transparent,
                index_of_refraction,
            })
        },
    )
}

fn pattern() -> impl Strategy<Value = Pattern> {
    let wave = || (0..5u32, 0.1..10.0, 0.0..5.0);
    prop_oneof![
        Just(Pattern::Checkerboard),
        (0..6u32).prop_map(|octaves| Pattern::Noise { octaves }),
        wave().prop_map(|(octaves, frequency, amplitude)| Pattern::Marble { octaves, frequency, amplitude }),
        wave().prop_map(|(octaves, frequency, amplitude)| Pattern::Wood { octaves, frequency, amplitude }),
    ]
}

/// Two plain materials, a texture of them, and a texture of that texture and another material.
fn materials(range: Range) -> impl Strategy<Value = Vec<Material>> {
    (phong(), phong(), pattern(), affine(range), pattern(), affine(range)).prop_map(
        |(a, b, p, p_map, q, q_map)| {
            let texture = |pattern, map: DAffine3, children| {
                Material::Texture(Texture {
                    pattern,
                    world_to_texture: map.into(),
                    factors: Box::default(),
                    children,
                })
            };
            vec![a, b, texture(p, p_map, [0, 1]), texture(q, q_map, [2, 0])]
        },
    )
}

fn scale(range: Range) -> impl Strategy<Value = DVec3> {
    let factor = || sometimes_extreme(range, prop_oneof![0.2..2.0, -2.0..-0.2, Just(1.0)]);
    prop_oneof![factor().prop_map(DVec3::splat), [factor(), factor(), factor()].prop_map(DVec3::from_array)]
}

fn affine(range: Range) -> impl Strategy<Value = DAffine3> {
    (scale(range), direction(Range::Ordinary), -4.0..4.0, point(range)).prop_map(
        |(scale, axis, angle, shift)| {
            let turn = DQuat::from_axis_angle(axis.normalize(), angle);
            DAffine3::from_scale_rotation_translation(scale, turn, shift)
        },
    )
}

/// A primitive whose material has not been chosen yet.
fn primitive(range: Range) -> impl Strategy<Value = Object> {
    let point = || point(range);
    let radius = sometimes_extreme(range, 0.05..1.5).prop_map(|radius| radius.abs().max(SMALLEST_RADIUS));
    let sphere =
        (point(), radius).prop_map(|(center, radius)| Object::Sphere { center, radius, material: 0 });
    let plane = (direction(range), coordinate(range)).prop_map(|(normal, offset)| Object::Plane {
        normal,
        offset,
        material: 0,
    });
    let corner_box =
        (point(), point()).prop_map(|(a, b)| Object::Box { min: a.min(b), max: a.max(b), material: 0 });
    let mesh = (0..2usize).prop_map(|mesh| Object::Mesh { mesh, material: 0 });
    prop_oneof![4 => sphere, 1 => plane, 4 => triangle(range), 1 => corner_box, 1 => mesh]
}

/// A triangle. Every fourth has no area: two vertices are equal, or all three are collinear.
fn triangle(range: Range) -> impl Strategy<Value = Object> {
    let point = || point(range);
    (point(), point(), point(), 0..8, coordinate(Range::Ordinary)).prop_map(|(a, b, c, kind, along)| {
        let vertices = match kind {
            0 => [a, a, b],
            1 => [a, b, a + along * (b - a)],
            _ => [a, b, c],
        };
        Object::Triangle { vertices, material: 0 }
    })
}

fn light(range: Range) -> impl Strategy<Value = Light> {
    let attenuation = || sometimes_extreme(range, 0.0..1.0);
    prop_oneof![
        (direction(range), color()).prop_map(|(direction, color)| Light::Directional { direction, color }),
        (point(range), color(), [attenuation(), attenuation(), attenuation()])
            .prop_map(|(position, color, attenuation)| Light::Point { position, color, attenuation }),
    ]
}

fn camera(range: Range) -> impl Strategy<Value = scene::Camera> {
    let view = (point(range), direction(range), direction(range))
        .prop_filter("up is not along the view", |(_, d, up)| unit(*d).cross(unit(*up)).length() > 0.02);
    (view, any::<bool>(), 0.5..6.0).prop_map(|((center, direction, up), orthographic, size)| {
        if orthographic {
            scene::Camera::Orthographic { center, direction, up, size }
        } else {
            scene::Camera::Perspective { center: center * 3.0, direction, up, angle: size * 20.0 }
        }
    })
}

/// Objects with their materials, each with up to three transforms around it.
pub fn scene(range: Range) -> impl Strategy<Value = Scene> {
    let object = (primitive(range), 0..4usize, prop::collection::vec(affine(range), 0..3));
    let objects = prop::collection::vec(object, 1..14);
    let background = (color(), color()).prop_map(|(color, ambient)| Background { color, ambient });
    let lights = prop::collection::vec(light(range), 0..3);
    (objects, lights, materials(range), camera(range), background).prop_map(
        |(placed, lights, materials, camera, background)| {
            let (mut objects, mut children) = (vec![], vec![]);
            for (object, material, transforms) in placed {
                children.push(add(&mut objects, with_material(object, material), &transforms));
            }
            objects.push(Object::Group(children));
            // Their contents are `fuzz_findings::checks::meshes`.
            let meshes = vec![MeshFile { name: "mesh.obj".into(), at: AT, ..MeshFile::default() }; 2];
            Scene {
                camera,
                background,
                lights,
                materials,
                root: objects.len() - 1,
                objects,
                positions: Default::default(),
                meshes,
                images: vec![],
                cube_map: None,
                screen: Screen::default(),
                lighting: Lighting::default(),
                mesh_normals: MeshNormals::default(),
                measure_colors: MeasureColors::default(),
                shows: Shows::default(),
            }
        },
    )
}

fn add(objects: &mut Vec<Object>, object: Object, transforms: &[DAffine3]) -> ObjectId {
    objects.push(object);
    for &matrix in transforms {
        objects.push(Object::Transform {
            matrix: matrix.into(),
            factors: Box::default(),
            child: objects.len() - 1,
            at: AT,
        });
    }
    objects.len() - 1
}

fn with_material(mut object: Object, chosen: usize) -> Object {
    match &mut object {
        Object::Sphere { material, .. }
        | Object::Plane { material, .. }
        | Object::Triangle { material, .. }
        | Object::Box { material, .. }
        | Object::Grid { material, .. }
        | Object::Mesh { material, .. } => *material = chosen,
        Object::Group(_) | Object::Transform { .. } => {}
    }
    object
}

/// Rays of any origin: to random points, to vertices, parallel to the axes or from inside, with unit vectors
/// or others as directions.
pub fn rays(range: Range) -> impl Strategy<Value = Vec<Ray>> {
    let ray = (point(range), point(range), 0..4, 0..3usize, any::<bool>(), 0.01..10.0).prop_map(
        |(origin, target, kind, axis, backwards, length)| {
            let mut direction = length * (target - origin);
            if kind == 0 {
                direction = DVec3::AXES[axis];
            }
            let t_min = if backwards { f64::NEG_INFINITY } else { 0.0 };
            Ray { t_min, ..Ray::new(if kind == 1 { 5.0 * origin } else { origin }, direction) }
        },
    );
    let count = if range == Range::Ordinary { 600 } else { 100 };
    prop::collection::vec(ray.prop_filter("a ray has a direction", |r| r.direction != DVec3::ZERO), count)
}
