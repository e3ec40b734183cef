//! The area of triangulated polygons, compared with the shoelace formula, for every first corner and both directions.

use super::*;
use crate::math::worst_case::Rng;
use glam::{DMat3, DQuat};
use std::f64::consts::TAU;

/// Returns the triangles of a polygon as points, and its fault.
fn triangles(corners: &[DVec3]) -> (Vec<[DVec3; 3]>, Option<OutlineFault>) {
    let found = triangulate(corners);
    (found.triangles.iter().map(|triangle| triangle.map(|corner| corners[corner])).collect(), found.fault)
}

/// Returns twice the area vector of an outline or a triangle (the shoelace formula in space).
fn area_vector(corners: &[DVec3]) -> DVec3 {
    let origin = corners[0];
    corners.windows(2).map(|edge| (edge[0] - origin).cross(edge[1] - origin)).sum()
}

/// Returns the sum of the triangles' areas along `normal` and the sum of their absolute values, both doubled.
fn areas(triangles: &[[DVec3; 3]], normal: DVec3) -> [f64; 2] {
    let areas = triangles.iter().map(|triangle| area_vector(triangle).dot(normal));
    areas.fold([0.0; 2], |[sum, size], area| [sum + area, size + area.abs()])
}

/// Returns all rotations of a polygon in both directions. Of a long polygon, returns some.
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

/// Asserts that triangles cover a simple polygon once, with its orientation, for every first corner and both
/// directions. The area may differ by the rounding of the corners.
fn check_simple(corners: &[DVec3], what: &str) {
    for order in all_orders(corners) {
        let whole = area_vector(&order);
        let normal = whole.normalize();
        let (triangles, fault) = triangles(&order);
        let [sum, size] = areas(&triangles, normal);
        let extent = order.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let spread = order.iter().map(|p| (*p - order[0]).length()).fold(0.0, f64::max);
        let tolerance = 1e-14 * extent * spread * order.len() as f64;
        assert_eq!(fault, None, "{what}: {order:?}");
        assert!((sum - whole.length()).abs() <= tolerance, "{what}: {sum} for {}: {order:?}", whole.length());
        assert!(size - sum <= tolerance, "{what}: triangles overlap: {order:?}");
    }
}

fn flat(corners: &[[f64; 2]]) -> Vec<DVec3> {
    corners.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect()
}

/// Returns a polygon with random radii around the origin, at random angles.
fn star(rng: &mut Rng, count: usize) -> Vec<[f64; 2]> {
    let mut angles: Vec<f64> =
        (0..count).map(|k| (k as f64 + 0.9 * rng.unit()) / count as f64 * TAU).collect();
    angles.sort_by(f64::total_cmp);
    let at = |angle: f64, radius: f64| [radius * libm::cos(angle), radius * libm::sin(angle)];
    angles.into_iter().map(|angle| at(angle, 0.05 + rng.unit())).collect()
}

/// Returns a comb with teeth of random lengths.
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

/// Returns a band that winds around the origin.
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

/// Returns a simple polygon through random points, with crossings removed by reversing parts (2-opt).
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

/// Adds the middle of some edges, and repeats some corners.
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

/// Places a polygon in space with a random rotation, size and offset.
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

/// Asserts that a simple polygon has this area in every order, without duplicate triangles.
fn check_area(corners: &[[f64; 2]], area: f64, what: &str) {
    for order in all_orders(&flat(corners)) {
        let (triangles, fault) = triangles(&order);
        assert_eq!(fault, None, "{what}: {order:?}");
        let [_, size] = areas(&triangles, DVec3::Z);
        assert!((size / 2.0 - area).abs() <= 1e-13 * (1.0 + area), "{what}: {}: {order:?}", size / 2.0);
        let all = positions(&triangles);
        assert!(all.windows(2).all(|pair| pair[0] != pair[1]), "{what}: a triangle twice: {order:?}");
    }
}

/// Returns the corner positions of all triangles, sorted within each triangle and between triangles.
fn positions(triangles: &[[DVec3; 3]]) -> Vec<Vec<[u64; 3]>> {
    let bits = |corner: &DVec3| (*corner + 0.0).to_array().map(f64::to_bits);
    let mut all: Vec<Vec<_>> = triangles.iter().map(|triangle| triangle.iter().map(bits).collect()).collect();
    all.iter_mut().for_each(|triangle| triangle.sort_unstable());
    all.sort_unstable();
    all
}

#[test]
fn an_outline_may_touch_itself() {
    let two =
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0], [1.0, 1.0], [0.0, 1.0]];
    check_area(&two, 2.0, "two squares with one corner in common");
    let inside = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0], [0.0, 0.0], [2.0, 3.0], [3.0, 2.0]];
    check_area(&inside, 16.0 - 2.5, "a hole that touches a corner");
    let edge = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 0.0], [0.0, 4.0]];
    check_area(&edge, 8.0, "a corner on an edge");
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
    check_area(&ring, 12.0, "a hole joined to the outside by an edge");
    let whisker = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [5.0, 1.0], [2.0, 1.0], [2.0, 2.0], [0.0, 2.0]];
    check_area(&whisker, 4.0, "an edge out and back");
    let back = [[0.0, 0.0], [3.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
    check_area(&back, 4.0, "an edge too far and back");
}

#[test]
fn an_outline_that_crosses_itself_has_the_same_triangles_in_every_order() {
    let pentagram: Vec<[f64; 2]> = (0..5)
        .map(|k| [libm::cos(0.8 * TAU * k as f64 / 2.0), libm::sin(0.8 * TAU * k as f64 / 2.0)])
        .collect();
    let outlines: [&[[f64; 2]]; 6] = [
        &[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]],
        &[[0.0, 0.0], [3.0, 2.0], [3.0, 0.0], [0.0, 1.0]],
        &[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [2.0, 0.0], [1.0, 1.0], [0.0, 2.0]],
        &pentagram,
        &[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 0.0], [4.0, 1.0], [3.0, 4.0]],
        &[[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [1.0, 3.0], [1.0, -1.0], [2.0, -1.0], [2.0, 2.0], [0.0, 2.0]],
    ];
    for outline in outlines {
        let orders = all_orders(&flat(outline));
        let (first, fault) = triangles(&orders[0]);
        assert!(!first.is_empty() && fault == Some(OutlineFault::Crosses), "{outline:?}: {fault:?}");
        for order in orders {
            let (triangles, fault) = triangles(&order);
            assert_eq!((positions(&triangles), fault), (positions(&first), Some(OutlineFault::Crosses)));
        }
    }
}

#[test]
fn an_outline_that_goes_back_the_way_it_came_has_no_triangles() {
    let outlines: [&[[f64; 2]]; 4] = [
        &[[0.0, 0.0], [2.0, 0.0], [0.0, 2.0], [2.0, 0.0]],
        &[[-1.0, 0.0], [0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0]],
        &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.5], [1.0, 0.0], [1.0, 1.0], [1.0, 0.0]],
        &[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [4.0, 1.0], [4.0, 0.0], [3.0, 0.0], [1.0, 0.0]],
    ];
    for order in outlines.into_iter().flat_map(|outline| all_orders(&flat(outline))) {
        let (triangles, fault) = triangles(&order);
        assert_eq!((triangles, fault), (vec![], Some(OutlineFault::EnclosesNothing)), "{order:?}");
    }
}

/// Asserts that no corner of a polygon lies on an edge of a triangle, except its two ends.
fn check_seams(corners: &[DVec3], what: &str) {
    for order in all_orders(corners) {
        let Triangulation { triangles, fault } = triangulate(&order);
        assert_eq!((triangles.len(), fault), (order.len() - 2, None), "{what}: {order:?}");
        let edges = |[a, b, c]: [usize; 3]| [[a, b], [b, c], [c, a]];
        let all: Vec<[usize; 2]> = triangles.iter().copied().flat_map(edges).collect();
        let has = |edge: &[usize; 2]| all.contains(edge);
        let count = order.len();
        assert!((0..count).all(|k| has(&[k, (k + 1) % count])), "{what}: a corner is left out: {order:?}");
        let is_of_outline = |[from, to]: [usize; 2]| (from + 1) % count == to;
        assert!(
            all.iter().all(|&[from, to]| is_of_outline([from, to]) || has(&[to, from])),
            "{what}: {order:?}"
        );
    }
}

#[test]
fn a_corner_between_its_neighbours_is_left_out_from_no_first_corner() {
    let rng = &mut Rng(5);
    let house = [[-4.0, 0.0], [0.1, 0.0], [4.0, 0.0], [4.0, 4.0], [-4.0, 4.0]];
    let u = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [2.0, 3.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
    for (what, corners) in [("house", &house[..]), ("triangle", &house[1..4]), ("u", &u)] {
        // One, two and three corners within each edge.
        for more in 0..4 {
            let within = |k: usize, part: usize| {
                let part = part as f64 / (more + 1) as f64;
                let (from, to) = (corners[k], corners[(k + 1) % corners.len()]);
                [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * part)
            };
            let all = (0..corners.len()).flat_map(|k| (0..=more).map(move |part| within(k, part)));
            let all: Vec<[f64; 2]> = all.collect();
            check_seams(&flat(&all), what);
            (0..20).for_each(|_| check_seams(&placed(rng, &all), what));
        }
    }
}

/// Shapes made of unit squares, where corners of one part lie on the extended edges of another.
#[test]
fn shapes_on_a_lattice_have_no_corner_on_an_edge() {
    let rng = &mut Rng(11);
    for round in 0..100 {
        let heights: Vec<f64> = (0..3 + round % 6).map(|_| 1.0 + rng.below(4) as f64).collect();
        let depths: Vec<f64> = heights.iter().map(|_| -(rng.below(3) as f64)).collect();
        let ends = |k: usize, height: f64| [[k as f64, height], [k as f64 + 1.0, height]];
        let above = heights.iter().enumerate().flat_map(|(k, &height)| ends(k, height));
        let below = depths.iter().enumerate().flat_map(|(k, &depth)| ends(k, depth));
        let mut corners: Vec<[f64; 2]> = below.collect();
        corners.extend(above.rev());
        corners.dedup();
        check_seams(&flat(&corners), "skyline");
        check_seams(&placed(rng, &corners), "skyline");
    }
}

/// Rounding moves a corner off its edge in a rotated polygon. This is not a crossing.
#[test]
fn rounding_makes_no_crossing() {
    let corner = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [1.0, 0.0], [0.0, 4.0]];
    let edge = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [3.0, 0.0], [1.0, 0.0], [0.0, 4.0]];
    for (touching, area) in [(&corner[..], 8.0), (&edge, 4.0)] {
        for k in 0..200 {
            let turn = DMat3::from_rotation_z(f64::from(k));
            let corners: Vec<DVec3> = flat(touching).into_iter().map(|corner| turn * corner).collect();
            let (triangles, fault) = triangles(&corners);
            let [_, size] = areas(&triangles, DVec3::Z);
            assert!(fault.is_none() && (size / 2.0 - area).abs() < 1e-13, "{k}: {size}");
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
        assert_eq!((found.triangles.len(), found.fault), (corners.len() - 2, None), "{corners:?}");
    }
}

fn predicate_is_zero(corners: [DVec3; 3]) -> bool {
    crate::math::exact::area_vector(corners).iter().all(|area| area.sign() == 0)
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
                let (triangles, fault) = triangles(&order);
                // Seen along the plane's normal, the outline has this area for all heights of the corners.
                let normal = turn * DVec3::Z * area_vector(&order).dot(turn * DVec3::Z).signum();
                let [sum, size] = areas(&triangles, normal);
                assert!((sum - area_vector(&order).dot(normal)).abs() < 1e-12);
                assert!(size - sum <= 0.02 * sum && fault.is_none(), "{order:?}");
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
fn a_convex_polygon_is_a_fan() {
    let hexagon: Vec<DVec3> =
        (0..6).map(|k| DVec3::new(libm::cos(k as f64), libm::sin(k as f64), 0.3)).collect();
    for order in all_orders(&hexagon) {
        assert_eq!(triangulate(&order).triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
    }
    // The first corner lies on an edge, so the last corner is in the direction opposite to the second.
    let flat_corner = flat(&[[0.0, 0.0], [-1.0, 0.0], [-1.0, -1.0], [1.0, -1.0], [1.0, 0.0]]);
    assert_eq!(triangulate(&flat_corner).triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    // The second corner projects onto the first, so its direction is undefined.
    let around: Vec<DVec3> =
        [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -0.5], [0.0, 1.0]]
            .iter()
            .enumerate()
            .map(|(k, &[x, y])| DVec3::new(x, y, if k == 1 { 0.1 } else { 0.0 }))
            .collect();
    assert_eq!(triangulate(&around).triangles.len(), 4);
    // A triangle that is flat only in the projection stays.
    let square = |y: f64| {
        [DVec3::ZERO, DVec3::new(1.0, y, 0.0), 2.0 * DVec3::X, DVec3::new(2.0, 0.0, 2.0), 2.0 * DVec3::Z]
    };
    assert_eq!(triangulate(&square(0.0)).triangles, [[0, 1, 3], [1, 2, 3], [0, 3, 4]]);
    assert_eq!(triangulate(&square(0.1)).triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
}

#[test]
fn thousands_of_corners_are_covered_once() {
    let rng = &mut Rng(3);
    for (what, corners) in [("star", star(rng, 5000)), ("comb", comb(rng, 1000)), ("spiral", spiral(200))] {
        let corners = flat(&corners);
        let (triangles, fault) = triangles(&corners);
        let [sum, size] = areas(&triangles, DVec3::Z);
        let expected = area_vector(&corners).length();
        assert!((sum.abs() / expected - 1.0).abs() < 1e-10 && size - sum.abs() < 1e-10 * size, "{what}");
        assert_eq!(fault, None, "{what}");
    }
}

/// Every edge passes through nearly all corners. An outline of as many places as that would take minutes to cut.
#[test]
fn an_outline_that_goes_to_and_fro_on_a_line_is_cut_as_it_is() {
    let to_and_fro = (0..MOST_CORNERS - 4).map(|k| if k % 2 == 0 { k as f64 } else { -(k as f64) });
    let mut corners: Vec<DVec3> = to_and_fro.map(|x| 0.001 * DVec3::new(x, 0.3 * x, 0.0)).collect();
    corners.extend([[2.0, 1.0], [3.0, 2.0], [3.0, 1.0], [2.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 0.0)));
    assert_eq!(triangulate(&corners).fault, Some(OutlineFault::Crosses));
}
