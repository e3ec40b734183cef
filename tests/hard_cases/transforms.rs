//! Section E, cases 47, 49 and 52: nested and mirroring transforms, and the same scene without flattening the
//! hierarchy.

use crate::support::brute::Brute;
use crate::support::double_double::{self as dd, Dd, Dd3};
use crate::support::measure::{Failures, measure};
use crate::support::meshes::{Closed, bunny, icosphere, point_in};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::world_of_mesh;
use crate::support::textbook::{Edges, lower_triangle, woop};
use crate::support::{failed_ray, rays};
use glam::{DAffine3, DMat3, DVec3};
use raytracer::math::ray::{Ray, Visible};
use raytracer::scene::mesh::Mesh;
use raytracer::scene::parser::parse;
use raytracer::scene::{Object, Position, Scene};
use raytracer::world::World;
use raytracer::world::triangle;

/// The relative rounding error of a double, in which the targets are stated.
pub const ROUNDING: f64 = f64::EPSILON / 2.0;

pub fn rotation(rng: &mut Rng, degrees: f64) -> DMat3 {
    DMat3::from_axis_angle(rng.direction(), degrees.to_radians())
}

/// A scene of one object inside these transforms, with the outermost first.
pub fn nested(object: &str, transforms: &[DAffine3]) -> Scene {
    let text = format!(
        "PerspectiveCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 angle 30 }}
         Materials {{ numMaterials 1 Material {{ }} }}
         Group {{ numObjects 1 MaterialIndex 0 {object} }}"
    );
    let mut scene = parse(&text).expect("a scene of one object");
    for &matrix in transforms.iter().rev() {
        let child = scene.root;
        scene.objects.push(Object::Transform {
            matrix: matrix.into(),
            factors: Box::default(),
            child,
            at: Position { line: 1, column: 1 },
        });
        scene.root = scene.objects.len() - 1;
    }
    scene
}

const MESH: &str = "TriangleMesh { obj_file m.obj }";

/// The linear part times `v`, in double-double.
fn turned(m: &DMat3, v: &Dd3) -> Dd3 {
    let column = |k: usize| dd::scaled(&dd::vector(m.col(k)), v[k]);
    dd::add(&dd::add(&column(0), &column(1)), &column(2))
}

pub fn length(v: &Dd3) -> Dd {
    dd::dot(v, v).sqrt()
}

/// A level of case 47: rotated by 37 degrees, translated by 10, and scaled by 10 and back in turn.
fn level(rng: &mut Rng, i: usize, scaled: bool) -> DAffine3 {
    let scale = match (scaled, i % 2) {
        (false, _) => 1.0,
        (true, 0) => 10.0,
        (true, _) => 0.1,
    };
    DAffine3::from_mat3_translation(rotation(rng, 37.0) * scale, 10.0 * rng.direction())
}

#[test]
fn case_47_deep_nesting() {
    const SEED: u64 = 1047;
    let n = rays(400, 40_000);
    let mut worst = [0.0f64; 2];
    for depth in [1, 4, 16, 64, 256] {
        let one = |index: u64| {
            let rng = &mut Rng::at(SEED, index);
            let levels: Vec<_> = (0..depth).map(|i| level(rng, i, index.is_multiple_of(2))).collect();
            let mesh = Mesh {
                vertices: (0..60).map(|_| 10.0 * rng.in_cube()).collect(),
                triangles: vec![[0, 1, 2]],
            };
            let world = World::new(&nested(MESH, &levels), std::slice::from_ref(&mesh)).expect("a world");
            let whole = levels.iter().fold(glam::Affine3A::IDENTITY, |m, l| m * l.as_affine3a());
            let mut errors = [0.0f64; 2];
            for (v, placed) in mesh.vertices.iter().zip(&world.vertices) {
                let (exact, largest) = exactly_placed(&levels, *v);
                let in_f32 = whole.transform_point3(v.as_vec3()).as_dvec3();
                for (error, found) in errors.iter_mut().zip([*placed, in_f32]) {
                    let off = length(&dd::sub(&dd::vector(found), &exact)).value() / largest;
                    *error = error.max(off / (depth as f64 * 4.0 * ROUNDING));
                }
            }
            ([], errors)
        };
        let ([], errors) = measure(n, one);
        worst = [0, 1].map(|i| worst[i].max(errors[i]));
    }
    Record {
        case: 47,
        basis: Basis::Sampled,
        name: "transforms nested 1 to 256 deep",
        inputs: format!("{} points", 5 * 60 * n),
        measure: "error relative to the largest intermediate length, in 4 roundings a level",
        textbook: format!("matrices multiplied in f32: {:.1e}", worst[1]),
        ours: format!("{:.2}", worst[0]),
        target: "1",
    }
    .write();
    assert!(worst[0] <= 1.0, "{worst:?}");
    assert!(worst[1] > 1.0, "the case tests nothing");
}

/// The point after all levels, and the largest length on its way, measured outside.
fn exactly_placed(levels: &[DAffine3], v: DVec3) -> (Dd3, f64) {
    let mut point = dd::vector(v);
    let mut largest = v.length();
    for level in levels.iter().rev() {
        point = dd::add(&turned(&level.matrix3, &point), &dd::vector(level.translation));
        // In the outermost space lengths are scaled by the outer levels: here by at most 10.
        largest = largest.max(length(&point).value());
    }
    (point, largest)
}

/// A map that mirrors and shears by up to 1e3, in some order, and rotates.
fn mirroring(rng: &mut Rng, index: u64) -> DMat3 {
    let mirror = DMat3::from_diagonal(DVec3::new(if index % 3 < 2 { -1.0 } else { 1.0 }, 1.0, 1.0));
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(10f64.powf(rng.range(0.0, 3.0)), 1.0, 0.0), DVec3::Z);
    rotation(rng, 77.0) * mirror * shear * rotation(rng, 31.0)
}

#[test]
fn case_49_normals_of_mirrored_objects_point_outwards() {
    const SEED: u64 = 1049;
    let ball = icosphere(2, 1.0, DVec3::ZERO);
    let n = rays(400, 40_000);
    let one = |index| {
        let rng = &mut Rng::at(SEED, index);
        let transform = [DAffine3::from_mat3_translation(mirroring(rng, index), DVec3::new(1.0, -2.0, 0.5))];
        let [m] = transform;
        let world = World::new(&nested(MESH, &transform), std::slice::from_ref(&ball.mesh)).expect("a world");
        // The image of a ball is convex, so the image of its centre is behind every face.
        let outward = |t: [DVec3; 3]| triangle::normal(t).dot(t[0] - m.translation) > 0.0;
        let wrong = (0..world.triangles.len()).filter(|&i| !outward(world.corners(i))).count();
        let unturned =
            ball.mesh.triangles.iter().map(|t| t.map(|v| m.transform_point3(ball.mesh.vertices[v as usize])));
        let textbook = unturned.filter(|&t| !outward(t)).count();
        let sphere =
            World::new(&nested("Sphere { center 0 0 0 radius 1 }", &transform), &[]).expect("a world");
        let inside_out = (0..200).filter(|_| !is_outward_seen(&sphere, &m, rng)).count();
        ([world.triangles.len() as u64 + 200, (wrong + inside_out) as u64, textbook as u64], [])
    };
    let ([inputs, wrong, textbook], []) = measure(n, one);
    Record {
        case: 49,
        basis: Basis::Sampled,
        name: "mirrored and sheared by up to 1e3",
        inputs: format!("{inputs} triangles and rays at ellipsoids"),
        measure: "normals that point inwards",
        textbook: format!("vertices transformed without turning the winding: {textbook}"),
        ours: wrong.to_string(),
        target: "0",
    }
    .write();
    assert_eq!(wrong, 0);
    assert!(textbook > 0, "the case tests nothing");
}

/// Whether a ray from outside gets a normal turned towards it, and one from inside a normal turned away.
fn is_outward_seen(world: &World, m: &DAffine3, rng: &mut Rng) -> bool {
    let inside = m.transform_point3(0.5 * rng.in_ball());
    let outside = m.transform_point3(3.0 * rng.direction());
    let normal = |ray: &Ray| {
        let t = world.shapes[0].intersect(ray).expect("the line goes through the inside");
        world.visible_surface(ray, Visible { primitive: 0, t_bound: t }).normal
    };
    let (into, out) = (Ray::new(outside, inside - outside), Ray::new(inside, outside - inside));
    normal(&into).dot(into.direction) < 0.0 && normal(&out).dot(out.direction) > 0.0
}

#[test]
fn case_52_flattened_and_hierarchical() {
    const SEED: u64 = 1052;
    let mesh = Closed::new(bunny("1k"));
    let local = world_of_mesh(&mesh.mesh);
    let local_brute = Brute::new(&local);
    let n = rays(100_000, 10_000_000);
    let rng = &mut Rng::new(SEED);
    let levels: Vec<_> = (0..8).map(|i| level(rng, i, true)).collect();
    let world = World::new(&nested(MESH, &levels), std::slice::from_ref(&mesh.mesh)).expect("a world");
    let brute = Brute::new(&world);
    let failures = Failures::default();
    let one = |index| {
        let rng = &mut Rng::at(SEED, index);
        let i = rng.below(world.triangles.len());
        let target = point_in(world.corners(i), rng);
        let ray = Ray::new(target + rng.direction(), DVec3::ZERO);
        let ray = Ray { direction: target - ray.origin, ..ray };
        let flat = brute.closest(&ray).map(|h| h.primitive);
        let inward = levels.iter().fold(ray, |ray, level| {
            let inverse = level.inverse();
            Ray::new(inverse.transform_point3(ray.origin), inverse.transform_vector3(ray.direction))
        });
        let hierarchical = local_brute.closest(&inward).map(|h| h.primitive);
        let differs = flat != hierarchical;
        failures.note(differs, || failed_ray(52, SEED, index, ray.origin, ray.direction));
        ([differs as u64, (nearest_in_f32(&local, &local_brute, &levels, &ray) != flat) as u64], [])
    };
    let ([differ, textbook], []) = measure(n, one);
    Record {
        case: 52,
        basis: Basis::Sampled,
        name: "flattened and hierarchical",
        inputs: format!("{n} rays through eight levels"),
        measure: "rays that hit another triangle",
        textbook: format!("hierarchical in f32: {textbook}"),
        ours: differ.to_string(),
        target: "1 in 1e6",
    }
    .write();
    assert!(differ <= n / 1_000_000, "{differ}");
    assert!(textbook > 0, "the case tests nothing");
}

/// The primitive that a hierarchical tracer hits in single precision.
fn nearest_in_f32(local: &World, brute: &Brute, levels: &[DAffine3], ray: &Ray) -> Option<u32> {
    let (mut o, mut d) = (ray.origin.as_vec3(), ray.direction.as_vec3());
    for level in levels {
        let inverse = level.as_affine3a().inverse();
        (o, d) = (inverse.transform_point3(o), inverse.transform_vector3(d));
    }
    let ray = Ray::new(o.as_dvec3(), d.as_dvec3());
    let hit = |i: u32| {
        let t = woop(o.to_array(), d.to_array(), lower_triangle(local.corners(i as usize)), Edges::Inclusive);
        t.filter(|&t| t > 0.0).map(|t| (t, i))
    };
    brute.near(&ray).filter_map(hit).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
}
