//! Random small scenes: a grid of any resolution gives every ray the very hit that testing
//! everything gives, pictures are the same to the byte, and no colour is NaN.
//!
//! `PROPTEST_CASES` sets how many scenes are tried.

use glam::{DAffine3, DQuat, DVec3};
use proptest::prelude::*;
use raytracer::camera::Camera;
use raytracer::caster::{Caster, Insertion, Instructions};
use raytracer::math::ray::Ray;
use raytracer::render::{Request, View, render};
use raytracer::sampling::{filter::Filter, sampler::Sampler};
use raytracer::scene::material::{Material, Pattern, Phong, Texture};
use raytracer::scene::mesh::Mesh;
use raytracer::scene::{self, Background, Light, MeshFile, Object, ObjectId, Position, Scene};
use raytracer::stats::Quiet;
use raytracer::trace::{Effects, Shadows};
use raytracer::world::World;

const AT: Position = Position { line: 1, column: 1 };

/// Any coordinate, or a multiple of a quarter, so that things touch and coincide.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![-2.0..2.0, (-8..=8i32).prop_map(|n| f64::from(n) / 4.0)]
}

fn point() -> impl Strategy<Value = DVec3> {
    [coordinate(), coordinate(), coordinate()].prop_map(DVec3::from_array)
}

fn direction() -> impl Strategy<Value = DVec3> {
    point().prop_filter("a direction has a length", |v| v.length() > 0.1)
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

/// Two plain materials, a texture of them, and one of that texture and another.
fn materials() -> impl Strategy<Value = Vec<Material>> {
    (phong(), phong(), pattern(), affine(), pattern(), affine()).prop_map(|(a, b, p, p_map, q, q_map)| {
        let texture = |pattern, world_to_texture, children| {
            Material::Texture(Texture { pattern, world_to_texture, children })
        };
        vec![a, b, texture(p, p_map, [0, 1]), texture(q, q_map, [2, 0])]
    })
}

fn scale() -> impl Strategy<Value = DVec3> {
    let factor = || prop_oneof![0.2..2.0, -2.0..-0.2, Just(1.0)];
    prop_oneof![factor().prop_map(DVec3::splat), [factor(), factor(), factor()].prop_map(DVec3::from_array)]
}

fn affine() -> impl Strategy<Value = DAffine3> {
    (scale(), direction(), -4.0..4.0, point()).prop_map(|(scale, axis, angle, shift)| {
        let turn = DQuat::from_axis_angle(axis.normalize(), angle);
        DAffine3::from_scale_rotation_translation(scale, turn, shift)
    })
}

/// A primitive, material not chosen yet.
fn primitive() -> impl Strategy<Value = Object> {
    let sphere =
        (point(), 0.05..1.5).prop_map(|(center, radius)| Object::Sphere { center, radius, material: 0 });
    let plane = (direction(), coordinate()).prop_map(|(normal, offset)| Object::Plane {
        normal,
        offset,
        material: 0,
    });
    let corner_box =
        (point(), point()).prop_map(|(a, b)| Object::Box { min: a.min(b), max: a.max(b), material: 0 });
    let mesh = Just(Object::Mesh { mesh: 0, material: 0 });
    prop_oneof![4 => sphere, 1 => plane, 4 => triangle(), 1 => corner_box, 1 => mesh]
}

/// A triangle, every fourth without an area: a vertex twice, or three in a row.
fn triangle() -> impl Strategy<Value = Object> {
    (point(), point(), point(), 0..8, coordinate()).prop_map(|(a, b, c, kind, along)| {
        let vertices = match kind {
            0 => [a, a, b],
            1 => [a, b, a + along * (b - a)],
            _ => [a, b, c],
        };
        Object::Triangle { vertices, material: 0 }
    })
}

fn light() -> impl Strategy<Value = Light> {
    prop_oneof![
        (direction(), color()).prop_map(|(direction, color)| Light::Directional { direction, color }),
        (point(), color(), [0.0..1.0, 0.0..1.0, 0.0..1.0])
            .prop_map(|(position, color, attenuation)| Light::Point { position, color, attenuation }),
    ]
}

fn camera() -> impl Strategy<Value = scene::Camera> {
    let view = (point(), direction(), direction())
        .prop_filter("up is not along the view", |(_, d, up)| d.cross(*up).length() > 0.1);
    (view, any::<bool>(), 0.5..6.0).prop_map(|((center, direction, up), orthographic, size)| {
        if orthographic {
            scene::Camera::Orthographic { center, direction, up, size }
        } else {
            scene::Camera::Perspective { center: center * 3.0, direction, up, angle: size * 20.0 }
        }
    })
}

/// Each object with its material and up to three transforms around it.
fn scene() -> impl Strategy<Value = Scene> {
    let object = (primitive(), 0..4usize, prop::collection::vec(affine(), 0..3));
    let objects = prop::collection::vec(object, 1..14);
    let background = (color(), color()).prop_map(|(color, ambient)| Background { color, ambient });
    (objects, prop::collection::vec(light(), 0..3), materials(), camera(), background).prop_map(
        |(placed, lights, materials, camera, background)| {
            let (mut objects, mut children) = (vec![], vec![]);
            for (object, material, transforms) in placed {
                children.push(add(&mut objects, with_material(object, material), &transforms));
            }
            objects.push(Object::Group(children));
            let meshes = vec![MeshFile { name: "mesh.obj".into(), at: AT }];
            Scene { camera, background, lights, materials, root: objects.len() - 1, objects, meshes }
        },
    )
}

fn add(objects: &mut Vec<Object>, object: Object, transforms: &[DAffine3]) -> ObjectId {
    objects.push(object);
    for &matrix in transforms {
        objects.push(Object::Transform { matrix, child: objects.len() - 1, at: AT });
    }
    objects.len() - 1
}

fn with_material(mut object: Object, chosen: usize) -> Object {
    match &mut object {
        Object::Sphere { material, .. }
        | Object::Plane { material, .. }
        | Object::Triangle { material, .. }
        | Object::Box { material, .. }
        | Object::Mesh { material, .. } => *material = chosen,
        Object::Group(_) | Object::Transform { .. } => {}
    }
    object
}

fn tetrahedron() -> Mesh {
    Mesh {
        vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    }
}

/// Rays from anywhere: to random points, to vertices, along axes, from within; unit vectors or not.
fn rays() -> impl Strategy<Value = Vec<Ray>> {
    let ray = (point(), point(), 0..4, 0..3usize, any::<bool>(), 0.01..10.0).prop_map(
        |(origin, target, kind, axis, backwards, length)| {
            let mut direction = length * (target - origin);
            if kind == 0 {
                direction = DVec3::AXES[axis];
            }
            let t_min = if backwards { f64::NEG_INFINITY } else { 0.0 };
            Ray { t_min, ..Ray::new(if kind == 1 { 5.0 * origin } else { origin }, direction) }
        },
    );
    prop::collection::vec(ray.prop_filter("a ray has a direction", |r| r.direction != DVec3::ZERO), 600)
}

/// The same rays aimed at what the world is made of, where decisions are close.
fn aimed(rays: &[Ray], world: &World) -> Vec<Ray> {
    let spheres = world.spheres.iter().map(|s| s.center + s.radius * DVec3::X);
    let targets: Vec<DVec3> = world.vertices.iter().copied().chain(spheres).collect();
    let aim = |(ray, i): (&Ray, usize)| {
        let direction = *targets.get(i % targets.len().max(1))? - ray.origin;
        (direction != DVec3::ZERO).then_some(Ray { direction, ..*ray })
    };
    rays.iter().zip(0..).filter_map(aim).collect()
}

/// The colour picture of every effect, and how many of its colours are NaN.
fn picture(scene: &Scene, caster: &Caster) -> (Vec<u8>, u64) {
    let size = [12, 9];
    let effects = Effects { shadows: Shadows::Transparent, shade_back: true, bounces: 3, min_weight: 0.01 };
    let request = Request {
        size,
        view: View::Scene(effects),
        sampler: Sampler::CENTER,
        filter: Filter::PIXEL,
        color: true,
        depth: None,
        normals: true,
        samples: None,
    };
    let camera = Camera::new(&scene.camera, size);
    let (pictures, _) = render::<Quiet>(&camera, caster, &request).expect("a small picture");
    let bytes = [pictures.color, pictures.normals].into_iter().flatten().flat_map(|p| p.pixels().to_vec());
    (bytes.collect(), pictures.nans)
}

/// About five seconds' worth of scenes, where nobody asks for another number.
fn config() -> ProptestConfig {
    let default = ProptestConfig::default();
    let cases = if std::env::var_os("PROPTEST_CASES").is_some() { default.cases } else { 1500 };
    ProptestConfig { cases, ..default }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn a_grid_changes_nothing(scene in scene(), rays in rays(), cells in [1..9usize, 1..9usize, 1..9usize]) {
        let world = World::new(&scene, &[tetrahedron()]).expect("its transforms are not singular");
        let plain = Caster::new(&world, None).expect("no grid");
        let gridded = Caster::new(&world, Some(cells)).expect("a small grid");
        // Nearly every cell is a crowd then.
        let insertion = Insertion::Nested { crowd: 2 };
        let nested = Caster::with(&world, Some(cells.map(|n| n.div_ceil(3))), insertion, Instructions::available()[0]);
        let nested = nested.expect("small grids");
        for ray in rays.iter().chain(&aimed(&rays, &world)) {
            let hit = plain.closest(ray, &mut Quiet);
            prop_assert!(hit == gridded.closest(ray, &mut Quiet), "{ray:?}: without a grid {hit:?}");
            prop_assert!(hit == nested.closest(ray, &mut Quiet), "{ray:?}: without grids in cells {hit:?}");
            prop_assert_eq!(hit.is_some(), plain.any(ray, &mut Quiet));
            prop_assert_eq!(hit.is_some(), nested.any(ray, &mut Quiet));
            prop_assert_eq!(hit.is_some(), gridded.any(ray, &mut Quiet));
        }
        let (one, other) = (picture(&scene, &plain), picture(&scene, &gridded));
        prop_assert!(one.0 == other.0, "the pictures differ");
        prop_assert_eq!((one.1, other.1), (0, 0));
    }
}
