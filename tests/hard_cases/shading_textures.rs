//! Section F, textures: checkerboards on their own planes and far away, and noise at its lattice points,
//! below zero and far away.

use crate::support::measure::{Failures, measure};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::world_of;
use crate::support::textbook_noise::{noise, noise32, truncated_noise};
use crate::support::{failed_ray, rays};
use glam::{DAffine3, DMat3, DVec3};
use raytracer::camera::Camera;
use raytracer::grid::Caster;
use raytracer::math::instructions::Instructions;
use raytracer::math::robust::UNIT_ROUNDOFF;
use raytracer::scene::material::{Pattern, Texture};
use raytracer::scene::{self, Object};
use raytracer::shading::texture::first_weight;
use raytracer::stats::Quiet;

fn checkerboard(world_to_texture: DAffine3) -> Texture {
    Texture { pattern: Pattern::Checkerboard, world_to_texture: world_to_texture.into(), children: [0, 1] }
}

/// A checkered plane that is itself a boundary between cells, and an eye that looks at it.
struct Board {
    texture: Texture,
    /// The map from world space to a space in which cells are unit cubes and the plane is y = `layer`.
    turn: DMat3,
    cell: f64,
    layer: f64,
    plane: Object,
    camera: scene::Camera,
}

/// Half of the boards are level, and half have any orientation. The cells measure 0.1 to 10.
fn board(rng: &mut Rng) -> Board {
    let cell = 10f64.powf(rng.range(-1.0, 1.0));
    let layer = (rng.below(41) as f64) - 20.0;
    let axis = rng.direction();
    let turn = if rng.below(2) == 0 {
        DMat3::IDENTITY
    } else {
        DMat3::from_axis_angle(axis, rng.range(0.0, std::f64::consts::TAU))
    };
    let back = turn.transpose();
    let plane = Object::Plane { normal: back * DVec3::Y, offset: layer * cell, material: 0 };
    let eye = DVec3::new(rng.range(-20.0, 20.0), layer + rng.range(0.5, 20.0), rng.range(-20.0, 20.0)) * cell;
    let target = DVec3::new(rng.range(-20.0, 20.0), layer, rng.range(-20.0, 20.0)) * cell;
    let (center, direction, up) = (back * eye, back * (target - eye), back * DVec3::new(0.1, 1.0, 0.2));
    let texture = checkerboard(DAffine3::from_scale(DVec3::splat(1.0 / cell)) * DAffine3::from_mat3(turn));
    let camera = scene::Camera::Perspective { center, direction, up, angle: 50.0 };
    Board { texture, turn, cell, layer, plane, camera }
}

/// Counts over the pixels of one eye: all, those wrong by ours, and those wrong for the cell of o + t d in
/// f64.
fn board_pixels(rng: &mut Rng, side: usize) -> [u64; 3] {
    let board = board(rng);
    let world = world_of(vec![board.plane.clone()]);
    let caster = Caster::new(&world, None).expect("no grid");
    let camera = Camera::new(&board.camera, [side, side]);
    let mut counts = [0; 3];
    for pixel in 0..side * side {
        let ray =
            camera.ray(glam::DVec2::new((pixel % side) as f64, (pixel / side) as f64), glam::DVec2::ZERO);
        let Some(hit) = caster.closest(&ray, &mut Quiet) else { continue };
        let point = world.surface(&ray, &hit).position;
        // Across the plane the cell is known. Along it, it is unless the point is at a line of the board.
        let q = board.turn * point / board.cell;
        let near_line = |x: f64| (x - x.round()).abs() < 1e-9 * (1.0 + x.abs());
        if near_line(q.x) || near_line(q.z) {
            continue;
        }
        let even = |sum: f64| if sum.rem_euclid(2.0) == 0.0 { 1.0 } else { 0.0 };
        let expected = even(q.x.floor() + board.layer + q.z.floor());
        let plain = board.texture.world_to_texture.map.transform_point3(ray.at(hit.t)).floor();
        counts[0] += 1;
        counts[1] += (first_weight(&board.texture, &point.into(), Instructions::Portable) != expected) as u64;
        counts[2] += (even(plain.element_sum()) != expected) as u64;
    }
    counts
}

#[test]
fn case_56_checkerboard_on_its_own_plane() {
    let eyes = rays(400, 10_000);
    let (counts, []) = measure(eyes, |index| (board_pixels(&mut Rng::at(56, index), 50), []));
    let [pixels, ours, textbook] = counts;
    Record {
        case: 56,
        basis: Basis::Sampled,
        name: "checkerboard on its own plane",
        inputs: format!("{pixels} pixels from {eyes} eyes"),
        measure: "pixels of the wrong colour",
        textbook: format!(
            "cell of o + t d in f64: {textbook} ({:.1}%)",
            100.0 * textbook as f64 / pixels as f64
        ),
        ours: ours.to_string(),
        target: "0",
    }
    .write();
    assert!(textbook > 0, "the textbook method does not fail");
    assert_eq!(ours, 0);
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
        let wrong = first_weight(&texture, &p.into(), Instructions::Portable) != expected;
        failures.note(wrong, || failed_ray(57, 57, index, p, DVec3::ZERO));
        ([1, wrong as u64, (truncating_checkerboard(p) != expected) as u64], [])
    });
    let extremes = [1e16, 1e300, f64::MAX, -f64::MAX, f64::MIN_POSITIVE, -5e-324];
    let weights = extremes.map(|x| first_weight(&texture, &DVec3::splat(x).into(), Instructions::Portable));
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
