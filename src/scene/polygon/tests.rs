//! The area of triangulated polygons, compared with the shoelace formula, for every first corner and both directions.

use super::*;
use crate::math::worst_case::Rng;
use glam::{DMat3, DQuat};
use std::f64::consts::TAU;

/// The triangles of a polygon as points.
fn triangles(corners: &[DVec3]) -> (Vec<[DVec3; 3]>, Triangulation) {
    let found = triangulate(corners);
    let point =
        |index: usize| *corners.get(index).unwrap_or_else(|| &found.new_points[index - corners.len()]);
    (found.triangles.iter().map(|triangle| triangle.map(point)).collect(), found)
}

/// Twice the area vector of an outline, or of a triangle (the shoelace formula in space).
fn area_vector(corners: &[DVec3]) -> DVec3 {
    let origin = corners[0];
    corners.windows(2).map(|edge| (edge[0] - origin).cross(edge[1] - origin)).sum()
}

/// The sum of the triangles' areas along `normal`, and the sum of their absolute values, both doubled.
fn areas(triangles: &[[DVec3; 3]], normal: DVec3) -> [f64; 2] {
    let areas = triangles.iter().map(|triangle| area_vector(triangle).dot(normal));
    areas.fold([0.0; 2], |[sum, size], area| [sum + area, size + area.abs()])
}

/// Every rotation of a polygon, in both directions; of a long one, some.
fn all_orders(corners: &[DVec3]) -> Vec<Vec<DVec3>> {
    let step = corners.len().div_ceil(16);
    let mut orders = vec![];
    for start in (0..corners.len()).step_by(step) {
        let mut order = corners.to_vec();
        order.rotate_left(start);
        orders.push(order.clone());
        order.reverse();
        orders.push(order);
    }
    orders
}

/// Asserts that a polygon without crossings is covered once, from every first corner and in both directions, by
/// triangles that turn as it does. The area may be off by the rounding of its corners.
fn check_simple(corners: &[DVec3], what: &str) {
    for order in all_orders(corners) {
        let whole = area_vector(&order);
        let normal = whole.normalize();
        let (triangles, found) = triangles(&order);
        let [sum, size] = areas(&triangles, normal);
        let extent = order.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let spread = order.iter().map(|p| (*p - order[0]).length()).fold(0.0, f64::max);
        let tolerance = 1e-14 * extent * spread * order.len() as f64;
        assert!(!found.crosses_itself && found.new_points.is_empty(), "{what}: {order:?}");
        assert!((sum - whole.length()).abs() <= tolerance, "{what}: {sum} for {}: {order:?}", whole.length());
        assert!(size - sum <= tolerance, "{what}: triangles overlap: {order:?}");
    }
}

fn flat(corners: &[[f64; 2]]) -> Vec<DVec3> {
    corners.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect()
}

/// A polygon of random radii around the origin, at random angles.
fn star(rng: &mut Rng, count: usize) -> Vec<[f64; 2]> {
    let mut angles: Vec<f64> =
        (0..count).map(|k| (k as f64 + 0.9 * rng.unit()) / count as f64 * TAU).collect();
    angles.sort_by(f64::total_cmp);
    let at = |angle: f64, radius: f64| [radius * libm::cos(angle), radius * libm::sin(angle)];
    angles.into_iter().map(|angle| at(angle, 0.05 + rng.unit())).collect()
}

/// Teeth of random lengths on a bar.
fn comb(rng: &mut Rng, teeth: usize) -> Vec<[f64; 2]> {
    let end = 2.0 * teeth as f64 - 1.0;
    let mut corners = vec![[end, -1.0], [0.0, -1.0]];
    for k in 0..teeth {
        let (x, height) = (2.0 * k as f64, 0.5 + rng.unit());
        corners.extend([[x, 0.0], [x, height], [x + 1.0, height], [x + 1.0, 0.0]]);
    }
    corners.remove(2);
    corners.pop();
    corners
}

/// A band that winds around the origin.
fn spiral(turns: usize) -> Vec<[f64; 2]> {
    let at = |k: usize, radius: f64| {
        let angle = k as f64 / 12.0 * TAU;
        [radius * libm::cos(angle), radius * libm::sin(angle)]
    };
    let radius = |k: usize| 1.0 + k as f64 / 12.0;
    let count = 12 * turns;
    let outside = (0..count).map(|k| at(k, radius(k) + 0.5));
    outside.chain((0..count).rev().map(|k| at(k, radius(k)))).collect()
}

/// A simple polygon through random points, from which crossings were removed by turning parts around (2-opt).
fn untangled(rng: &mut Rng, count: usize) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = (0..count).map(|_| [rng.signed(), rng.signed()]).collect();
    let turn = |[ax, ay]: [f64; 2], [bx, by]: [f64; 2], [cx, cy]: [f64; 2]| {
        (bx - ax) * (cy - ay) - (by - ay) * (cx - ax) > 0.0
    };
    loop {
        let crossing = (0..count).flat_map(|i| (i + 2..count).map(move |j| (i, j))).find(|&(i, j)| {
            let [a, b, c, d] = [i, i + 1, j, (j + 1) % count].map(|k| points[k]);
            (j + 1) % count != i && turn(a, b, c) != turn(a, b, d) && turn(c, d, a) != turn(c, d, b)
        });
        match crossing {
            Some((i, j)) => points[i + 1..=j].reverse(),
            None => return points,
        }
    }
}

/// The middle of some edges, and some corners twice.
fn with_more_corners(rng: &mut Rng, corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut more = vec![];
    for (k, &corner) in corners.iter().enumerate() {
        let next = corners[(k + 1) % corners.len()];
        more.push(corner);
        match rng.below(4) {
            0 => more.push(corner),
            1 => more.push([0, 1].map(|axis| (corner[axis] + next[axis]) / 2.0)),
            _ => {}
        }
    }
    more
}

/// Somewhere in space, of some size.
fn placed(rng: &mut Rng, corners: &[[f64; 2]]) -> Vec<DVec3> {
    let axis = rng.vector().normalize_or(DVec3::X);
    let size = libm::exp10(6.0 * rng.signed());
    let turn = DMat3::from_quat(DQuat::from_axis_angle(axis, TAU * rng.unit())) * size;
    let offset = size * 100.0 * rng.unit() * rng.vector();
    flat(corners).into_iter().map(|corner| turn * corner + offset).collect()
}

#[test]
fn random_polygons_are_covered_once() {
    let rng = &mut Rng(38);
    for round in 0..60 {
        let count = 4 + rng.below(14);
        let polygons = [
            ("star", star(rng, count)),
            ("comb", comb(rng, 2 + round % 5)),
            ("spiral", spiral(1 + round % 4)),
            ("untangled", untangled(rng, count)),
        ];
        for (what, corners) in polygons {
            check_simple(&flat(&corners), what);
            check_simple(&placed(rng, &corners), what);
            let more = with_more_corners(rng, &corners);
            check_simple(&flat(&more), what);
            check_simple(&placed(rng, &more), what);
        }
    }
}

/// Asserts that a polygon has this area in every order, and whether it crosses itself, and that the triangles do not
/// depend on the order but for their direction.
fn check_area(corners: &[[f64; 2]], area: f64, crosses: bool, what: &str) {
    let mut known: Option<Vec<Vec<[u64; 3]>>> = None;
    for order in all_orders(&flat(corners)) {
        let (triangles, found) = triangles(&order);
        assert_eq!(found.crosses_itself, crosses, "{what}: {order:?}");
        let [_, size] = areas(&triangles, DVec3::Z);
        assert!(
            (size / 2.0 - area).abs() <= 1e-13 * (1.0 + area),
            "{what}: {} for {area}: {order:?}",
            size / 2.0
        );
        let mut bits: Vec<Vec<[u64; 3]>> = triangles
            .iter()
            .map(|t| t.iter().map(|p| (*p + 0.0).to_array().map(f64::to_bits)).collect())
            .collect();
        bits.iter_mut().for_each(|triangle| triangle.sort_unstable());
        bits.sort_unstable();
        assert!(bits.windows(2).all(|pair| pair[0] != pair[1]), "{what}: a triangle twice: {order:?}");
        assert!(crosses || found.new_points.is_empty(), "{what}: {order:?}");
        for point in &found.new_points {
            // No gap is between trapezoids one above the other.
            let level = triangles.as_flattened().iter().filter(|p| p.y == point.y && p.x != point.x);
            assert!(level.count() > 0, "{what}: {point}");
        }
        if crosses {
            assert_eq!(known.get_or_insert_with(|| bits.clone()), &bits, "{what}: {order:?}");
        }
    }
}

#[test]
fn concave_polygons_have_their_area() {
    check_area(&[[0.0, 0.0], [4.0, 2.0], [0.0, 4.0], [1.5, 2.0]], 5.0, false, "dart");
    check_area(&[[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]], 5.0, false, "L");
    let u = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [2.0, 3.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
    check_area(&u, 7.0, false, "U");
}

#[test]
fn corners_on_a_line_and_repeated_corners_change_no_area() {
    let square =
        [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0], [0.0, 1.0]];
    check_area(&square, 4.0, false, "a square with corners within its edges");
    check_area(
        &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [0.0, 3.0]],
        4.5,
        false,
        "a triangle likewise",
    );
    check_area(
        &[[0.0, 0.0], [0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [2.0, 2.0], [2.0, 2.0]],
        2.0,
        false,
        "repeated",
    );
}

#[test]
fn an_outline_may_touch_itself() {
    let two =
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0], [1.0, 1.0], [0.0, 1.0]];
    check_area(&two, 2.0, false, "two squares with one corner in common");
    let inside = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 0.0], [2.0, 3.0], [3.0, 2.0]];
    check_area(&inside, 16.0 - 2.5, false, "a hole that touches a corner");
    let edge = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 0.0], [0.0, 4.0]];
    check_area(&edge, 8.0, false, "a corner on an edge");
    let ring = [
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 4.0],
        [0.0, 4.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [3.0, 3.0],
        [3.0, 1.0],
        [1.0, 1.0],
    ];
    check_area(&ring, 12.0, false, "a hole joined to the outside by an edge");
    let whisker = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [5.0, 1.0], [2.0, 1.0], [2.0, 2.0], [0.0, 2.0]];
    check_area(&whisker, 4.0, false, "an edge out and back");
    let back = [[0.0, 0.0], [3.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
    check_area(&back, 4.0, false, "an edge too far and back");
}

#[test]
fn an_outline_that_crosses_itself_covers_what_it_goes_around() {
    check_area(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]], 2.0, true, "a bow tie");
    check_area(&[[0.0, 0.0], [3.0, 2.0], [3.0, 0.0], [0.0, 1.0]], 2.5, true, "an uneven bow tie");
    check_area(
        &[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [2.0, 0.0], [1.0, 1.0], [0.0, 2.0]],
        2.0,
        true,
        "one with a corner in the middle",
    );
    let pentagram: Vec<[f64; 2]> = (0..5)
        .map(|k| [libm::cos(0.8 * TAU * k as f64 / 2.0), libm::sin(0.8 * TAU * k as f64 / 2.0)])
        .collect();
    // Ten triangles between the centre, a tip and an inner corner.
    let inner = libm::cos(TAU / 5.0) / libm::cos(TAU / 10.0);
    let star_area = 5.0 * inner * libm::sin(TAU / 10.0);
    check_area(&pentagram, star_area, true, "a pentagram");
    let fan = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 0.0], [4.0, 1.0], [3.0, 4.0]];
    // Two triangles of areas 6 and 13/2 have 52/15 in common.
    check_area(&fan, 271.0 / 30.0, true, "two triangles with a corner in common");
    let overlapping =
        [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [1.0, 3.0], [1.0, -1.0], [2.0, -1.0], [2.0, 2.0], [0.0, 2.0]];
    check_area(&overlapping, 9.0, true, "an outline that overlaps itself");
}

#[test]
fn an_outline_that_goes_around_twice_covers_once() {
    let twice = |corners: &[[f64; 2]]| [corners, corners].concat();
    check_area(&twice(&[[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]]), 2.0, true, "a triangle");
    let dart = [[0.0, 0.0], [4.0, 2.0], [0.0, 4.0], [1.5, 2.0]];
    check_area(&twice(&dart), 5.0, true, "a dart");
    let one_edge = [[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [0.0, 0.0], [2.0, 0.0], [1.0, 3.0]];
    check_area(&one_edge, 3.0, true, "two triangles with an edge in common");
    // The second time with one corner more.
    let more = [
        &[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]][..],
        &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 2.0]],
    ];
    check_area(&more.concat(), 4.0, true, "a square and a half of it");
}

#[test]
fn triangles_turn_as_the_outline_does() {
    let pentagram = [[0.0, 0.0], [3.0, 2.0], [-1.0, 2.0], [2.0, 0.0], [1.0, 3.0]];
    let dart = [[0.0, 0.0], [4.0, 2.0], [0.0, 4.0], [1.5, 2.0]];
    for corners in [&pentagram[..], &dart] {
        for order in all_orders(&flat(corners)) {
            let turn = area_vector(&order).z.signum();
            let (triangles, _) = triangles(&order);
            assert!(triangles.iter().all(|triangle| area_vector(triangle).z * turn > 0.0), "{order:?}");
        }
    }
    // Each half of an eight turns in its own direction.
    let (halves, _) = triangles(&flat(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]));
    assert!(halves.iter().all(|half| (area_vector(half).z > 0.0) == (half.iter().any(|p| p.x < 1.0))));
}

#[test]
fn corners_within_edges_are_corners_of_triangles() {
    let rng = &mut Rng(5);
    let u = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [2.0, 3.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
    let middle = |k: usize| [0, 1].map(|axis| (u[k][axis] + u[(k + 1) % 8][axis]) / 2.0);
    let more: Vec<[f64; 2]> = (0..8).flat_map(|k| [u[k], middle(k)]).collect();
    for order in all_orders(&flat(&more)).into_iter().chain(all_orders(&placed(rng, &more))) {
        let (triangles, _) = triangles(&order);
        assert_eq!(triangles.len(), order.len() - 2, "{order:?}");
        assert!(order.iter().all(|corner| triangles.as_flattened().contains(corner)), "{order:?}");
    }
}

/// A corner on an edge is off it by the rounding of a turned polygon, which is no crossing.
#[test]
fn rounding_makes_no_crossing() {
    let corner = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [1.0, 0.0], [0.0, 4.0]];
    let edge = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [3.0, 0.0], [1.0, 0.0], [0.0, 4.0]];
    for (touching, area) in [(&corner[..], 8.0), (&edge, 4.0)] {
        for k in 0..200 {
            let turn = DMat3::from_rotation_z(f64::from(k));
            let corners: Vec<DVec3> = flat(touching).into_iter().map(|corner| turn * corner).collect();
            let (triangles, found) = triangles(&corners);
            let [_, size] = areas(&triangles, DVec3::Z);
            assert!(!found.crosses_itself && (size / 2.0 - area).abs() < 1e-13, "{k}: {size}");
        }
    }
}

#[test]
fn the_smallest_crossing_has_triangles() {
    let (one, next) = (1.0, 1.0_f64.next_up());
    for order in all_orders(&flat(&[[one, one], [next, next], [next, one], [one, next]])) {
        assert!(!triangulate(&order).triangles.is_empty(), "{order:?}");
    }
}

#[test]
fn a_polygon_without_area_is_a_fan_without_area() {
    let [a, b, c] = [DVec3::ZERO, DVec3::new(0.125, 0.75, 0.375), DVec3::new(0.375, 2.25, 1.125)];
    assert!(predicate_is_zero([a, b, 3.0 * b]));
    for corners in
        [vec![a, a, a], vec![a, b, a, b], vec![a, b, 2.0 * b, 4.0 * b], vec![a, b, c], vec![a, b, b, a, a]]
    {
        let found = triangulate(&corners);
        assert_eq!((found.triangles.len(), found.crosses_itself), (corners.len() - 2, false), "{corners:?}");
    }
}

fn predicate_is_zero(corners: [DVec3; 3]) -> bool {
    crate::math::predicate::area_vector(corners).iter().all(|area| area.sign() == 0)
}

#[test]
fn nearly_flat_polygons_are_covered_once() {
    let rng = &mut Rng(2);
    for _ in 0..100 {
        let (count, axis) = (5 + rng.below(9), rng.vector().normalize());
        let turn = DMat3::from_quat(DQuat::from_axis_angle(axis, TAU * rng.unit()));
        for corners in [star(rng, count), comb(rng, 3)] {
            let corners: Vec<DVec3> =
                corners.iter().map(|&[x, y]| turn * DVec3::new(x, y, 0.01 * rng.signed())).collect();
            for order in all_orders(&corners) {
                let (triangles, found) = triangles(&order);
                // Seen along the plane's normal the outline has this area, whatever its corners' heights are.
                let normal = turn * DVec3::Z * area_vector(&order).dot(turn * DVec3::Z).signum();
                let [sum, size] = areas(&triangles, normal);
                assert!((sum - area_vector(&order).dot(normal)).abs() < 1e-12);
                assert!(size - sum <= 0.02 * sum && found.new_points.is_empty(), "{order:?}");
            }
        }
    }
}

#[test]
fn the_area_is_right_at_any_size_and_place() {
    let dart = [[0.0, 0.0], [4.0, 2.0], [0.0, 4.0], [1.5, 2.0]];
    for exponent in [-330, -40, 0, 40, 330] {
        let scale = libm::ldexp(1.0, exponent);
        for offset in [0.0, 1024.0, 1e15] {
            let corners: Vec<DVec3> =
                flat(&dart).into_iter().map(|p| (p + DVec3::new(offset, -offset, offset)) * scale).collect();
            for order in all_orders(&corners) {
                let (triangles, _) = triangles(&order);
                let [_, size] = areas(
                    &triangles
                        .iter()
                        .map(|t| t.map(|p| p / scale - DVec3::new(offset, -offset, offset)))
                        .collect::<Vec<_>>(),
                    DVec3::Z,
                );
                assert_eq!(size, if offset < 1e15 { 10.0 } else { size }, "{exponent} {offset}");
            }
        }
    }
}

#[test]
fn a_fan_stays_where_it_is_right() {
    // From its reflex corner the whole dart is seen.
    let dart = flat(&[[1.5, 2.0], [0.0, 0.0], [4.0, 2.0], [0.0, 4.0]]);
    assert_eq!(triangulate(&dart).triangles, [[0, 1, 2], [0, 2, 3]]);
    let hexagon: Vec<DVec3> =
        (0..6).map(|k| DVec3::new(libm::cos(k as f64), libm::sin(k as f64), 0.3)).collect();
    for order in all_orders(&hexagon) {
        assert_eq!(triangulate(&order).triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
    }
    // Its first corner is on an edge, so that the last is opposite to the second.
    let flat_corner = flat(&[[0.0, 0.0], [-1.0, 0.0], [-1.0, -1.0], [1.0, -1.0], [1.0, 0.0]]);
    assert_eq!(triangulate(&flat_corner).triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    // The second corner is behind the first, where no direction tells how far the others go around.
    let around: Vec<DVec3> =
        [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -0.5], [0.0, 1.0]]
            .iter()
            .enumerate()
            .map(|(k, &[x, y])| DVec3::new(x, y, if k == 1 { 0.1 } else { 0.0 }))
            .collect();
    assert!(triangulate(&around).crosses_itself);
    // A triangle of it without area is left out; one that is flat only in the projection is not.
    let square = |y: f64| {
        [DVec3::ZERO, DVec3::new(1.0, y, 0.0), 2.0 * DVec3::X, DVec3::new(2.0, 0.0, 2.0), 2.0 * DVec3::Z]
    };
    assert_eq!(triangulate(&square(0.0)).triangles, [[0, 2, 3], [0, 3, 4]]);
    assert_eq!(triangulate(&square(0.1)).triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
}

#[test]
fn thousands_of_corners_are_covered_once() {
    let rng = &mut Rng(3);
    for (what, corners) in [("star", star(rng, 5000)), ("comb", comb(rng, 1000)), ("spiral", spiral(200))] {
        let corners = flat(&corners);
        let (triangles, found) = triangles(&corners);
        let [sum, size] = areas(&triangles, DVec3::Z);
        let expected = area_vector(&corners).length();
        assert!((sum.abs() / expected - 1.0).abs() < 1e-10 && size - sum.abs() < 1e-10 * size, "{what}");
        assert!(!found.crosses_itself && found.new_points.is_empty(), "{what}");
    }
}

/// Where strips would have too many edges, the time is bounded.
#[test]
fn a_tangle_is_a_fan() {
    let rng = &mut Rng(4);
    let tangle: Vec<DVec3> = (0..3000).map(|_| rng.vector().with_z(0.0)).collect();
    let found = triangulate(&tangle);
    assert!(found.crosses_itself && found.triangles.len() == tangle.len() - 2 && found.new_points.is_empty());
}
