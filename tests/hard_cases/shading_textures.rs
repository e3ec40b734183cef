//! Section F, textures: checkerboards on their own planes and far away, and noise at its lattice points,
//! below zero and far away.

use crate::support::measure::{Failures, measure};
use crate::support::placed::{self, Transformations, scene_of, square};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::textbook_noise::{noise, noise32, truncated_noise};
use crate::support::{failed_ray, rays};
use glam::{DAffine3, DVec3};
use raytracer::caster::Caster;
use raytracer::math::instructions::Level;
use raytracer::math::ray::Ray;
use raytracer::math::robust::UNIT_ROUNDOFF;
use raytracer::scene::material::{Material, Pattern, Texture};
use raytracer::shading::checkerboard::error_bounds_to_boundary;
use raytracer::shading::texture::first_weight;
use raytracer::world::World;

fn checkerboard(world_to_texture: DAffine3) -> Texture {
    Texture {
        pattern: Pattern::Checkerboard,
        world_to_texture: world_to_texture.into(),
        factors: Box::default(),
        children: [0, 1],
    }
}

/// A surface that is itself a boundary between the cells of its checkerboard.
struct Board {
    world: World,
    texture: Texture,
    /// From the space in which the surface is level to world space.
    map: DAffine3,
    cell: f64,
    /// The index of the cells above the surface.
    layer: f64,
    /// The half width of the surface.
    half: f64,
}

/// A board of any kind of surface, under up to three transforms, whose texture is mapped by their inverse. The cells
/// measure 0.1 to 10.
fn board(rng: &mut Rng) -> Board {
    let cell = 10f64.powf(rng.range(-1.0, 1.0));
    let layer = [0.0, rng.below(41) as f64 - 20.0][rng.below(2)];
    let (half, height) = (cell * 10f64.powf(rng.range(0.0, 3.5)), layer * cell);
    let object = match rng.below(5) {
        0 => format!("Plane {{ normal 0 1 0 offset {height} }}"),
        1 => {
            let [a, b, c] = [0, 1, 2].map(|_| half * rng.in_cube());
            let text = |v: DVec3| format!("{} {height} {}", v.x, v.z);
            format!("Triangle {{ vertex0 {} vertex1 {} vertex2 {} }}", text(a), text(b), text(c))
        }
        2 => format!("Box {{ min -{half} {} -{half} max {half} {height} {half} }}", height - half),
        3 => "TriangleMesh { obj_file square.obj }".to_string(),
        _ => {
            // A sphere that is flattened to far below a rounding of its coordinates.
            let flat = 2f64.powi(-80);
            format!(
                "Transform {{ Scale 1 {flat} 1 Sphere {{ center 0 {} 0 radius {half} }} }}",
                height / flat
            )
        }
    };
    let may_distort = rng.below(2) == 0;
    let transformations = Transformations::any(rng, 3, may_distort);
    let texture = format!(
        "Checkerboard {{ Transform {{ UniformScale {} {} }} materialIndex 0 materialIndex 1 }}",
        1.0 / cell,
        if rng.below(3) == 0 { transformations.clone().after_detour(rng) } else { transformations.clone() }
            .inverse()
    );
    let placed =
        if rng.below(3) == 0 { transformations.clone().after_detour(rng) } else { transformations.clone() };
    let is_nested = rng.below(2) == 0;
    let scene = scene_of(&[placed.around(&object, is_nested)], &texture);
    let world = placed::world_of(&scene, &square(half, height, 1 + rng.below(4)));
    let Some(Material::Texture(texture)) = scene.materials.last() else { panic!("no texture") };
    Board { world, texture: texture.clone(), map: transformations.map(), cell, layer, half }
}

/// Counts over some rays: all that hit the surface away from lines along it, those wrong by ours, and those wrong for the
/// cell of o + t d in f64. And the largest part of the error bound that a point is off.
fn board_rays(rng: &mut Rng, rays: usize, failures: &Failures) -> ([u64; 3], [f64; 1]) {
    let Board { world, texture, map, cell, layer, half } = board(rng);
    let caster = Caster::new(&world, None).expect("no grid");
    let back = map.inverse();
    let (mut counts, mut largest_part) = ([0; 3], 0.0f64);
    for _ in 0..rays {
        let target = half * rng.in_cube().with_y(0.0) + layer * cell * DVec3::Y;
        let eye = target + half * rng.range(0.01, 3.0) * rng.direction();
        let [eye, target] = [eye, target].map(|p| map.transform_point3(p));
        let ray = Ray::new(eye, target - eye);
        let Some(hit) = caster.closest(&ray) else { continue };
        let surface = world.surface(&ray, &hit);
        // Across the surface the cell is known. Along it, it is unless the point is at a line of the board.
        let q = back.transform_point3(surface.position) / cell;
        let near_line = |x: f64| (x - x.round()).abs() < 1e-3 + 1e-7 * x.abs();
        let is_side = (map.matrix3.transpose() * surface.normal).normalize().y < 0.9;
        if near_line(q.x) || near_line(q.z) || is_side {
            continue;
        }
        let even = |sum: f64| if sum.rem_euclid(2.0) == 0.0 { 1.0 } else { 0.0 };
        let expected = even(q.x.floor() + layer + q.z.floor());
        let found =
            world.with_rounded_point(&surface, |point| first_weight(&texture, point, Level::baseline()));
        let part = world.with_rounded_point(&surface, |point| {
            error_bounds_to_boundary(&texture.world_to_texture, point).y
        });
        largest_part = largest_part.max(part);
        let plain = texture.world_to_texture.map.transform_point3(ray.at(hit.t)).floor();
        let wrong = failures
            .note(found != expected, || format!("{ray:?} at {q}: {:?}", world.primitive(hit.primitive)));
        counts[0] += 1;
        counts[1] += wrong;
        counts[2] += u64::from(even(plain.element_sum()) != expected);
    }
    (counts, [largest_part])
}

#[test]
fn case_56_checkerboard_on_its_own_surface() {
    const SEED: u64 = 56;
    let boards = rays(20_000, 2_000_000);
    let failures = Failures::default();
    let (counts, [part]) = measure(boards, |index| board_rays(&mut Rng::at(SEED, index), 40, &failures));
    let [points, ours, textbook] = counts;
    Record {
        case: 56,
        basis: Basis::Proved,
        name: "checkerboard on its own surface: planes, triangles, boxes, meshes and flat ellipsoids under transforms",
        inputs: format!("{points} points of {boards} surfaces"),
        measure: "points of the wrong colour; largest part of the error bound that a point is off",
        textbook: format!(
            "cell of o + t d in f64: {textbook} ({:.1}%)",
            100.0 * textbook as f64 / points as f64
        ),
        ours: format!("{ours}; {part:.2}"),
        target: "0; from 0.1 to 1",
    }
    .write();
    assert!(textbook > 0, "the textbook method does not fail");
    assert_eq!(ours, 0);
    assert!((0.1..=1.0).contains(&part), "{part}");
}

/// The textbook's checkerboard: coordinates truncated to 32-bit integers.
fn truncating_checkerboard(p: DVec3) -> f64 {
    let sum = p.to_array().map(|x| x as f32 as i32).into_iter().fold(0i32, i32::wrapping_add);
    if sum & 1 == 0 { 1.0 } else { 0.0 }
}

#[test]
fn case_57_checkerboard_far_away() {
    let inputs = rays(300_000, 50_000_000);
    let texture = checkerboard(DAffine3::IDENTITY);
    let failures = Failures::default();
    let (counts, []) = measure(inputs, |index| {
        let mut rng = Rng::at(57, index);
        // The last of the three distances is far beyond 32-bit integers.
        let reach = [(0.0, 6.0), (6.0, 9.0), (9.0, 15.0)][rng.below(3)];
        let p = rng.direction() * 10f64.powf(rng.range(reach.0, reach.1));
        let on_line = |x: f64| (x - x.round()).abs() <= 4.0 * UNIT_ROUNDOFF * x.abs();
        if p.to_array().into_iter().any(on_line) {
            return ([0; 3], []);
        }
        // This is exact: the floor of a float below 2^63 is a 64-bit integer.
        let sum: i64 = p.floor().to_array().map(|x| x as i64).into_iter().sum();
        let expected = if sum.rem_euclid(2) == 0 { 1.0 } else { 0.0 };
        let wrong = first_weight(&texture, &p.into(), Level::baseline()) != expected;
        failures.note(wrong, || failed_ray(57, 57, index, p, DVec3::ZERO));
        ([1, wrong as u64, (truncating_checkerboard(p) != expected) as u64], [])
    });
    let extremes = [1e16, 1e300, f64::MAX, -f64::MAX, f64::MIN_POSITIVE, -5e-324];
    let weights = extremes.map(|x| first_weight(&texture, &DVec3::splat(x).into(), Level::baseline()));
    let [tried, ours, textbook] = counts;
    Record {
        case: 57,
        basis: Basis::Sampled,
        name: "checkerboard far away, up to 1e15",
        inputs: format!("{tried} points farther than 4 roundings from the lines"),
        measure: "points of the wrong colour",
        textbook: format!("f32 cut to i32: {textbook}"),
        ours: ours.to_string(),
        target: "0; no NaN up to the largest float",
    }
    .write();
    assert!(textbook > 0, "the textbook method does not fail");
    assert_eq!(ours, 0);
    assert!(weights.iter().all(|&w| w == 0.0 || w == 1.0), "{weights:?}");
}

#[test]
fn case_58_noise_at_its_lattice() {
    let inputs = rays(200_000, 50_000_000);
    let near = (-5..=5).flat_map(|x| (-5..=5).flat_map(move |y| (-5..=5).map(move |z| [x, y, z])));
    for p in near {
        assert_eq!(noise(DVec3::from_array(p.map(f64::from))), 0.0, "{p:?}");
    }
    let failures = Failures::default();
    let (counts, []) = measure(inputs, |index| {
        let mut rng = Rng::at(58, index);
        let p = (rng.direction() * 2f64.powf(rng.range(0.0, 52.0))).round();
        let ours = noise(p) != 0.0;
        failures.note(ours, || failed_ray(58, 58, index, p, DVec3::ZERO));
        ([ours as u64, (truncated_noise(p) != 0.0) as u64], [])
    });
    Record {
        case: 58,
        basis: Basis::Sampled,
        name: "noise at whole numbers, up to 2^52",
        inputs: format!("{inputs} points, and all from -5 to 5"),
        measure: "points where it is not 0",
        textbook: format!("cell as an i32: {}", counts[1]),
        ours: counts[0].to_string(),
        target: "0",
    }
    .write();
    assert!(counts[1] > 0, "the textbook method does not fail");
    assert_eq!(counts[0], 0);
}

#[test]
fn case_59_noise_below_zero() {
    const STEP: f64 = 1e-9;
    let inputs = rays(100_000, 20_000_000);
    let failures = Failures::default();
    let (counts, [jump, range, textbook_jump, textbook_range]) = measure(inputs, |index| {
        let mut rng = Rng::at(59, index);
        // Multiples of 2^-40, so that adding 256 is exact.
        let grain = 2f64.powi(40);
        let p = (DVec3::splat(-2.0) + 2.0 * rng.in_cube()) * grain;
        let mut p = p.round() / grain;
        let axis = rng.below(3);
        if rng.below(2) == 0 {
            p[axis] = p[axis].round();
        }
        let mut step = DVec3::ZERO;
        step[axis] = STEP;
        let differs = |n: fn(DVec3) -> f64| (n(p) != n(p + 256.0)) as u64;
        let jump = |n: fn(DVec3) -> f64| (n(p + step) - n(p - step)).abs();
        failures.note(differs(noise) > 0, || failed_ray(59, 59, index, p, DVec3::ZERO));
        (
            [differs(noise), differs(truncated_noise)],
            [jump(noise), noise(p).abs(), jump(truncated_noise), truncated_noise(p).abs()],
        )
    });
    // Noise is differentiable with a slope below 4, so that twice the step changes it by less than 8 steps. A
    // bound of 2 steps, for a slope of 1, does not hold: the largest change shows a slope of 2.6.
    Record {
        case: 59,
        basis: Basis::Sampled,
        name: "noise below zero",
        inputs: format!("{inputs} points in [-4, 0]^3"),
        measure: "points unlike those 256 farther; largest change over 1e-9 to both sides; largest value",
        textbook: format!("cell cut, not floored: {}; {textbook_jump:.1e}; {textbook_range:.1e}", counts[1]),
        ours: format!("{}; {jump:.1e}; {range:.3}", counts[0]),
        target: "0; <= 8e-9 (2e-9 would need a slope below 1, and noise is steeper between its lattice points: see the change measured); <= 1.04",
    }
    .write();
    assert!(
        counts[1] > 0 && textbook_range > 1.04 && textbook_jump > 1e-3,
        "the textbook method does not fail"
    );
    assert_eq!(counts[0], 0);
    assert!(jump <= 8.0 * STEP && range <= 1.04);
}

#[test]
fn case_60_noise_far_away() {
    let inputs = rays(30_000, 5_000_000);
    let (mut ours, mut texts) = ([0.0f64; 2], vec![]);
    let mut textbook = 0.0f64;
    for (k, distance) in [1e2f64, 1e4, 1e6, 1e7].into_iter().enumerate() {
        let shift = (distance / 256.0).ceil() * 256.0;
        let (_, worst) = measure(inputs, |index| {
            let p = 128.0 * (Rng::at(6000 + k as u64, index).in_cube() + 1.0);
            let far = p + shift;
            // The shift is a whole number of periods, and subtracting it again is exact.
            let same = noise(far - shift);
            let moved = (noise(far) - noise(p)).abs();
            ([], [moved, (noise(far) - same).abs(), (noise32(far.as_vec3()) - noise(p)).abs()])
        });
        ours = [ours[0].max(worst[0]), ours[1].max(worst[1])];
        textbook = textbook.max(worst[2]);
        texts.push(format!("{distance:e}: {:.1e}", worst[2]));
    }
    Record {
        case: 60,
        basis: Basis::Sampled,
        name: "noise far away, 1e2 to 1e7",
        inputs: format!("{inputs} points at each of 4 distances"),
        measure: "largest change by whole periods, with the point's own rounding and without",
        textbook: format!("f32; {}", texts.join("; ")),
        ours: format!("{:.1e}, {:.1e}", ours[0], ours[1]),
        target: "<= 1e-8 at 1e7",
    }
    .write();
    assert!(textbook > 0.1, "the textbook method does not fail");
    assert!(ours[0] <= 1e-8 && ours[1] == 0.0);
}
