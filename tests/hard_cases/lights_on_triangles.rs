//! Case 65: point lights in the inside of a triangle, on its edges and at its corners.

use crate::support::exact::{cross, dot, exact3, sub};
use crate::support::measure::{Failures, measure};
use crate::support::rays;
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::scene_of;
use glam::{DAffine3, DMat3, DQuat, DVec3};
use num_traits::{Signed, Zero};
use raytracer::caster::Caster;
use raytracer::caster::choose::Layout;
use raytracer::math::instructions;
use raytracer::math::ray::Ray;
use raytracer::scene::mesh::Mesh;
use raytracer::scene::{Light, Object, Position};
use raytracer::stats::Counts;
use raytracer::trace::Quiet;
use raytracer::trace::{Effects, Observer, RayStack, Shadows, Tracer};
use raytracer::world::World;

/// A fan of four triangles around a corner, which is shared by all of them, and open at its rim.
fn fan() -> Mesh {
    let vertices = [[0, 0, 1], [4, 0, 0], [0, 4, 2], [-4, 0, 0], [0, -4, 1]];
    let vertices = vertices.map(|v| DVec3::from_array(v.map(f64::from))).to_vec();
    Mesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]] }
}

/// An object with corners of small whole numbers, and its triangles.
fn any_object(rng: &mut Rng) -> (Object, Vec<Mesh>) {
    let mut point = || DVec3::new(rng.integer(8), rng.integer(8), rng.integer(8));
    let (a, b, c) = (point(), point(), point());
    match rng.below(3) {
        0 => (Object::Triangle { vertices: [a, b, c], material: 0 }, vec![]),
        1 => (Object::Box { min: a.min(b), max: a.max(b) + DVec3::ONE, material: 0 }, vec![]),
        _ => (Object::Mesh { mesh: 0, material: 0 }, vec![fan()]),
    }
}

/// A light on a triangle: at a corner, on an edge or inside, and exactly so without a transform, since the weights are
/// eighths and the corners whole numbers.
fn point_on([a, b, c]: [DVec3; 3], rng: &mut Rng) -> DVec3 {
    let eighths = |k: usize| k as f64 / 8.0;
    match rng.below(3) {
        0 => a,
        1 => a + eighths(1 + rng.below(7)) * (b - a),
        _ => a + eighths(1 + rng.below(3)) * (b - a) + eighths(1 + rng.below(3)) * (c - a),
    }
}

fn any_map(rng: &mut Rng) -> DAffine3 {
    let scale = 10f64.powf(rng.range(-6.0, 6.0));
    let turn = DQuat::from_axis_angle(rng.direction(), rng.range(-3.0, 3.0));
    let matrix = DMat3::from_quat(turn) * scale;
    DAffine3 { matrix3: matrix, translation: scale * 10f64.powf(rng.range(-1.0, 2.0)) * rng.in_cube() }
}

/// Whether a point lies on a triangle, without rounding.
fn is_on(point: DVec3, corners: [DVec3; 3]) -> bool {
    let [a, b, c] = corners.map(exact3);
    let p = exact3(point);
    let normal = cross(&sub(&b, &a), &sub(&c, &a));
    let sides = [[&a, &b], [&b, &c], [&c, &a]].map(|[q, r]| dot(&cross(&sub(q, &p), &sub(r, &p)), &normal));
    !dot(&normal, &normal).is_zero()
        && dot(&sub(&p, &a), &normal).is_zero()
        && sides.iter().all(|side| !side.is_negative())
}

/// Whether the line segment between two points that lie on no triangle meets this one, without rounding. None if it
/// meets the triangle's edge, or lies in its plane.
fn crosses(from: DVec3, to: DVec3, corners: [DVec3; 3]) -> Option<bool> {
    let [a, b, c] = corners.map(exact3);
    let (from, to) = (exact3(from), exact3(to));
    let normal = cross(&sub(&b, &a), &sub(&c, &a));
    let heights = [&from, &to].map(|p| dot(&sub(p, &a), &normal));
    if heights.iter().any(Zero::is_zero) {
        return None;
    }
    if heights[0].is_positive() == heights[1].is_positive() {
        return Some(false);
    }
    let along = sub(&to, &from);
    let sides =
        [[&a, &b], [&b, &c], [&c, &a]].map(|[q, r]| dot(&cross(&sub(q, &from), &sub(r, &from)), &along));
    if sides.iter().any(Zero::is_zero) {
        return None;
    }
    Some(sides[0].is_positive() == sides[1].is_positive() && sides[1].is_positive() == sides[2].is_positive())
}

/// The points of a plane that are looked at for one light.
const POINTS: usize = 16;

/// The world of an object under a map and of a plane, with the light at `light`, and a normal of the plane.
struct Lit {
    world: World,
    plane: DVec3,
}

impl Lit {
    fn new(
        object: &Object,
        meshes: &[Mesh],
        map: Option<DAffine3>,
        plane: (DVec3, f64),
        light: DVec3,
    ) -> Self {
        let (normal, offset) = plane;
        let light = Light::Point { position: light, color: DVec3::ONE, attenuation: [1.0, 0.0, 0.0] };
        let plane = Object::Plane { normal, offset, material: 0 };
        let mut scene = scene_of(vec![object.clone(), plane], vec![light]);
        if let Some(matrix) = map {
            // The object moves to the end, and its transform takes its place.
            scene.objects.push(object.clone());
            let child = scene.objects.len() - 1;
            let at = Position { line: 1, column: 1 };
            scene.objects[0] =
                Object::Transform { matrix: matrix.into(), factors: Box::default(), child, at };
        }
        let world = World::new(&scene, meshes).expect("a valid scene");
        Self { world, plane: normal.normalize() }
    }

    /// Whether each of these points of the plane is lit, counted and not, and with all instructions; none where something
    /// else is in front of the plane.
    fn are_lit(&self, targets: &[DVec3], size: f64) -> Vec<Option<bool>> {
        let ray = |target: &DVec3| Ray::new(*target + 1e-3 * size * self.plane, -self.plane);
        let mut found = vec![];
        for level in instructions::available() {
            for cells in [Layout::List, Layout::Grid([4, 5, 6])] {
                let caster = Caster::with(&self.world, cells, level).expect("a grid");
                found.push(
                    targets.iter().map(|target| self.color(&caster, &ray(target), &mut Quiet)).collect(),
                );
                let counts = &mut Counts::default();
                found.push(targets.iter().map(|target| self.color(&caster, &ray(target), counts)).collect());
            }
        }
        let [first, others @ ..] = found.as_slice() else { unreachable!("some instructions") };
        assert!(others.iter().all(|one: &Vec<_>| one == first), "{found:?}");
        first.iter().map(|color| color.map(|color| color != DVec3::ZERO)).collect()
    }

    fn color(&self, caster: &Caster, ray: &Ray, observer: &mut impl Observer) -> Option<DVec3> {
        let effects = Effects { shadows: Shadows::Opaque, shade_back: true, bounces: 0, min_weight: 0.0 };
        let hit = caster.closest(ray)?;
        let is_plane = hit.primitive as usize == self.world.finite_count();
        is_plane.then(|| Tracer::new(caster, effects).color(ray, &mut RayStack::default(), observer))
    }
}

/// Counts for one light on a triangle: the points that were looked at, those that are lit although the light lies on the
/// triangle, and whether a tracer without the rule lights some and not others. Then the light is moved away, by a
/// billionth of the object's size or more, and the points are counted whose shadow is not the exact one.
fn one(index: u64, failures: &Failures) -> ([u64; 5], [f64; 0]) {
    let mut rng = Rng::at(65, index);
    let (object, meshes) = any_object(&mut rng);
    let map = (rng.below(2) == 0).then(|| any_map(&mut rng));
    let place = |p: DVec3| map.map_or(p, |map| map.transform_point3(p));
    let local = Lit::new(&object, &meshes, None, (DVec3::Z, -100.0), DVec3::ZERO).world;
    let triangle = rng.below(local.triangles.len());
    let on = point_on(local.corners(triangle), &mut rng);
    let size = (place(8.0 * DVec3::X) - place(DVec3::ZERO)).length();
    // A plane below the object as some direction sees it.
    let normal = rng.direction();
    let light = place(on);
    let offset = normal.dot(light) - size * rng.range(2.0, 5.0);
    let lit = Lit::new(&object, &meshes, map, (normal, offset), light);
    let corners = lit.world.corners(triangle);
    let has_area = is_on(corners[0], corners);
    if !has_area {
        return ([0; 5], []);
    }
    assert!(map.is_some() || is_on(light, corners), "{light} {corners:?}");
    let along = normal.cross(rng.direction()).normalize();
    let across = normal.cross(along);
    let foot = light + (offset - normal.dot(light)) * normal;
    let away = light + size * 10f64.powf(rng.range(-9.0, -1.0)) * rng.direction();
    let moved = Lit::new(&object, &meshes, map, (normal, offset), away);
    let (mut points, mut wrongly_lit, mut textbook_lit, mut wrong_away) = (0, 0, 0, 0);
    let mut target = || foot + size * (rng.range(-4.0, 4.0) * along + rng.range(-4.0, 4.0) * across);
    let targets: [DVec3; POINTS] = std::array::from_fn(|_| target());
    let (lit_at, moved_lit_at) = (lit.are_lit(&targets, size), moved.are_lit(&targets, size));
    for ((target, lit_at), moved_lit_at) in targets.into_iter().zip(lit_at).zip(moved_lit_at) {
        let Some(is_lit) = lit_at else { continue };
        points += 1;
        wrongly_lit += failures.note(is_lit, || format!("65 {index} {target} {light} {corners:?}"));
        textbook_lit += textbook_is_lit(&lit.world, target, light) as u64;
        let Some(is_lit) = moved_lit_at else { continue };
        let triangles = 0..moved.world.triangles.len();
        let met: Option<Vec<bool>> =
            triangles.map(|i| crosses(target, away, moved.world.corners(i))).collect();
        let Some(met) = met else { continue };
        let expected = !met.contains(&true);
        wrong_away += failures.note(is_lit != expected, || format!("65 {index} {target} {away} {expected}"));
    }
    let is_speckled = (textbook_lit > 0 && textbook_lit < points) as u64;
    ([1, points, wrongly_lit, is_speckled, wrong_away], [])
}

/// Whether nothing is found on the way to the light by Moeller and Trumbore's test in f64, before the light itself.
fn textbook_is_lit(world: &World, from: DVec3, light: DVec3) -> bool {
    let way = light - from;
    (0..world.triangles.len()).all(|i| {
        let [a, b, c] = world.corners(i);
        let (ab, ac, s) = (b - a, c - a, from - a);
        let p = way.cross(ac);
        let (det, q) = (ab.dot(p), s.cross(ab));
        let (u, v, t) = (s.dot(p) / det, way.dot(q) / det, ac.dot(q) / det);
        !(u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-4 && t < 1.0)
    })
}

#[test]
fn case_65_lights_on_triangles() {
    let inputs = rays(300, 200_000);
    let failures = Failures::default();
    let (counts, []) = measure(inputs, |index| one(index, &failures));
    let [lights, points, wrongly_lit, speckled, wrong_away] = counts;
    Record {
        case: 65,
        basis: Basis::Sampled,
        name: "light in a triangle, on its edge or at its corner, and close to it",
        inputs: format!("{lights} lights, {points} points"),
        measure: "points lit although the light lies on a triangle; points whose shadow is not the exact one for a light 1e-9 to 0.1 sizes away",
        textbook: format!("Moeller-Trumbore f64 up to the light: {speckled} lights have lit and dark points"),
        ours: format!("{wrongly_lit}; {wrong_away}"),
        target: "0; 0",
    }
    .write();
    assert!(speckled > 0, "the textbook method does not fail");
    assert!(lights > inputs / 2 && points > 10 * lights, "{counts:?}");
    assert_eq!([wrongly_lit, wrong_away], [0; 2]);
}
