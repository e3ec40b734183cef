//! Meshes that are cut or turned rather than modelled: a gem, a vase, and hollow shells of cut glass. Each is made
//! of rings of vertices, one above the other, with a band of faces between two rings.

use crate::topology::Mesh;
use glam::{DVec3, dvec3};
use std::f64::consts::TAU;

/// A gem in step cut: an octagon with long sides and cut corners, larger and smaller in parallel steps, so that
/// all facets are flat.
pub fn gem() -> Mesh {
    /// Half the width and depth of the girdle, and how far the corners are cut.
    const GIRDLE: [f64; 3] = [1.5, 1.1, 0.55];
    /// How far each ring lies within the girdle, and its height, from the small facet at the bottom to the table.
    const STEPS: [[f64; 2]; 7] =
        [[1.0, -1.13], [0.72, -0.93], [0.36, -0.56], [0.0, -0.06], [0.0, 0.04], [0.2, 0.27], [0.46, 0.42]];
    stack(STEPS.iter().map(|&[inset, height]| octagon(GIRDLE, inset, height)))
}

/// The octagon whose sides lie within those of the girdle by `inset`, counter-clockwise seen from above.
fn octagon([width, depth, corner]: [f64; 3], inset: f64, height: f64) -> Vec<DVec3> {
    let corner = (corner - inset * (2.0 - f64::sqrt(2.0))).max(0.02);
    let (x, z) = (width - inset, depth - inset);
    let quarter = [[x, z - corner], [x - corner, z]];
    let signs = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
    let corners = signs.iter().enumerate().flat_map(|(turn, sign)| {
        let [a, b] = quarter.map(|[x, z]| dvec3(x * sign[0], height, -z * sign[1]));
        // Each second quarter is a mirror image, which runs the other way round.
        if turn % 2 == 0 { [a, b] } else { [b, a] }
    });
    corners.collect()
}

/// A vase with a wall: its outside up to the rim, and down its inside to the bottom within.
pub fn vase() -> Mesh {
    const AROUND: usize = 40;
    /// The vase is thinner at the foot and the neck, and wide between.
    const OUTSIDE: usize = 26;
    const INSIDE: usize = 14;
    const WALL: f64 = 0.09;
    let radius = |t: f64| 0.62 + 0.5 * libm::sin((1.25 * t - 0.12) * 0.5 * TAU) + 0.16 * libm::pow(t, 6.0);
    let outside = (0..=OUTSIDE).map(|step| step as f64 / OUTSIDE as f64).map(|t| [radius(t), 3.6 * t]);
    let inside = (0..=INSIDE).map(|step| 1.0 - 0.95 * step as f64 / INSIDE as f64);
    let inside = inside.map(|t| [radius(t) - WALL, 3.6 * t]);
    stack(outside.chain(inside).map(|[radius, height]| circle(AROUND, radius, height, 0.0)))
}

/// A ball of flat facets; every second ring is turned by half a facet.
pub fn cut_ball(radius: f64, around: usize, rings: usize) -> Mesh {
    let ring = |step: usize| {
        let angle = (step as f64 + 0.5) / rings as f64 * 0.5 * TAU;
        let turn = if step.is_multiple_of(2) { 0.0 } else { 0.5 };
        circle(around, radius * libm::sin(angle), -radius * libm::cos(angle), turn)
    };
    stack((0..rings).map(ring))
}

/// A regular polygon in a level plane, counter-clockwise seen from above, turned by a part of a side.
fn circle(count: usize, radius: f64, height: f64, turn: f64) -> Vec<DVec3> {
    let corner = |index: usize| (index as f64 + turn) / count as f64 * TAU;
    let at = |angle: f64| dvec3(radius * libm::cos(angle), height, -radius * libm::sin(angle));
    (0..count).map(|index| at(corner(index))).collect()
}

/// The solid between rings of as many vertices each, the first of which is closed below and the last above.
fn stack(rings: impl Iterator<Item = Vec<DVec3>>) -> Mesh {
    let rings: Vec<_> = rings.collect();
    let count = rings[0].len() as u32;
    let last = (rings.len() as u32 - 1) * count;
    let cap = |first: u32, order: [u32; 2]| {
        (1..count - 1).map(move |index| [first, first + index + order[0], first + index + order[1]])
    };
    let band = |lower: u32| {
        (0..count).flat_map(move |index| {
            let [a, b] = [lower + index, lower + (index + 1) % count];
            [[a, b, b + count], [a, b + count, a + count]]
        })
    };
    let sides = (0..last).step_by(count as usize).flat_map(band);
    let faces = cap(0, [1, 0]).chain(sides).chain(cap(last, [0, 1])).collect();
    Mesh { positions: rings.concat(), faces }
}
