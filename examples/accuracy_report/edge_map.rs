//! The figure of the decision at an edge: two triangles share an edge, and rays from neighbouring floats pass
//! close to it. The colour shows which of the triangles each ray hits.

use crate::{Figure, panels};
use glam::DVec3;
use raytracer::math::ray::Ray;
use raytracer::world::triangle::Shear;

/// The number of neighbouring floats along each side of the map.
const SIDE: usize = 256;

/// The triangles have the end points of their edge at different indices, as in a mesh.
const LEFT: [DVec3; 3] =
    [DVec3::new(-12.0, -12.0, 3.0), DVec3::new(24.0, 24.0, 3.1), DVec3::new(-8.3, 17.1, 3.7)];
const RIGHT: [DVec3; 3] =
    [DVec3::new(19.2, -7.4, 2.6), DVec3::new(24.0, 24.0, 3.1), DVec3::new(-12.0, -12.0, 3.0)];

/// The colours of rays that hit the left triangle, the right one, both or none.
const COLORS: [[u8; 3]; 4] = [[70, 120, 190], [235, 150, 60], [255, 255, 255], [0, 0, 0]];

pub fn draw() -> Figure {
    let sides: [fn(usize, usize) -> usize; 3] = [textbook32, textbook64, ours];
    let color = |panel: usize, [x, y]: [usize; 2]| COLORS[sides[panel](x, SIDE - 1 - y)];
    let counts = sides.map(|side| {
        let all = (0..SIDE * SIDE).map(|i| side(i % SIDE, i / SIDE));
        all.fold([0; 4], |mut counts, s| {
            counts[s] += 1;
            counts
        })
    });
    let text = |[_, _, both, none]: [usize; 4]| format!("{none} leaks and {both} double hits");
    let caption = format!(
        "Two triangles share a diagonal edge, and rays start at {SIDE} x {SIDE} neighbouring floats around a point \
         beside it. Blue rays hit the left triangle, orange ones the right, white ones both, black ones none (a leak). \
         From left to right: Moeller-Trumbore in f32, {}; in f64, {}; ours, {}. \
         Our line is rounded too, but it is the same for both triangles.",
        text(counts[0]),
        text(counts[1]),
        text(counts[2])
    );
    Figure { picture: panels(1, sides.len(), SIDE, color), caption }
}

const DIRECTION: DVec3 = DVec3::new(0.3, -0.2, 1.0);

/// The index in [`COLORS`].
fn side(left: bool, right: bool) -> usize {
    match (left, right) {
        (true, false) => 0,
        (false, true) => 1,
        (true, true) => 2,
        (false, false) => 3,
    }
}

/// The origin from which a ray passes the edge near (0.5, 0.5).
fn middle() -> DVec3 {
    LEFT[0] + (12.5 / 36.0) * (LEFT[1] - LEFT[0]) - 3.0 * DIRECTION
}

fn origin64(x: usize, y: usize) -> DVec3 {
    let moved = |c: f64, by: usize| f64::from_bits((c.to_bits() as i64 + by as i64 - SIDE as i64 / 2) as u64);
    let m = middle();
    DVec3::new(moved(m.x, x), moved(m.y, y), m.z)
}

fn ours(x: usize, y: usize) -> usize {
    let ray = Ray::new(origin64(x, y), DIRECTION);
    let shear = Shear::new(&ray);
    side(shear.intersect(LEFT.each_ref()).is_some(), shear.intersect(RIGHT.each_ref()).is_some())
}

fn textbook64(x: usize, y: usize) -> usize {
    let hits = |[a, b, c]: [DVec3; 3]| {
        let (ab, ac, s) = (b - a, c - a, origin64(x, y) - a);
        let p = DIRECTION.cross(ac);
        let inverse = 1.0 / ab.dot(p);
        let (u, v) = (s.dot(p) * inverse, DIRECTION.dot(s.cross(ab)) * inverse);
        u >= 0.0 && v >= 0.0 && u + v <= 1.0
    };
    side(hits(LEFT), hits(RIGHT))
}

fn textbook32(x: usize, y: usize) -> usize {
    let moved = |c: f64, by: usize| {
        f32::from_bits(((c as f32).to_bits() as i32 + by as i32 - SIDE as i32 / 2) as u32)
    };
    let (m, d) = (middle(), DIRECTION.as_vec3());
    let origin = glam::Vec3::new(moved(m.x, x), moved(m.y, y), m.z as f32);
    let hits = |corners: [DVec3; 3]| {
        let [a, b, c] = corners.map(|v| v.as_vec3());
        let (ab, ac, s) = (b - a, c - a, origin - a);
        let p = d.cross(ac);
        let inverse = 1.0 / ab.dot(p);
        let (u, v) = (s.dot(p) * inverse, d.dot(s.cross(ab)) * inverse);
        u >= 0.0 && v >= 0.0 && u + v <= 1.0
    };
    side(hits(LEFT), hits(RIGHT))
}
