//! Covers what an outline goes around, also where it crosses itself: the plane is cut into strips at the height of
//! every corner and every crossing. Within a strip the edges do not cross, and those from left to right tell how often
//! the outline goes around what is between them.

use super::Triangulation;
use super::outline::{Corner, Ring};
use super::projection::DroppedAxis;
use crate::math::robust::UNIT_ROUNDOFF;
use glam::DVec3;

/// The number of edges in all strips, and of pairs of edges, after which an outline counts as too tangled: then a fan
/// around its first corner stands for it. That bounds the time by a second or two.
const MOST_WORK: usize = 1 << 25;

/// The trapezoids with a winding number other than zero, as triangles. New points are numbered from `corners`, the
/// number of the polygon's corners, on.
pub fn triangulation(ring: &Ring, projection: DroppedAxis, corners: usize) -> Triangulation {
    let plane = Plane::new(&ring.corners, projection);
    let edges = plane.edges(&ring.corners);
    let Some(heights) = heights(&edges, projection) else { return fan(&ring.corners) };
    let (open, place_above) = (vec![], vec![None; edges.len()]);
    let found = Triangulation::default();
    let mut cover = Cover { plane, edges: &edges, ring, corners, open, place_above, found };
    let mut wrong = Wrong::default();
    let (mut active, mut coming, mut work) = (vec![], edges.iter().enumerate().peekable(), 0);
    for strip in heights.windows(2) {
        let strip = [strip[0], strip[1]];
        active.retain(|&edge: &usize| edges[edge].high[1] > strip[0]);
        while let Some((edge, _)) = coming.next_if(|(_, edge)| edge.low[1] <= strip[0]) {
            active.push(edge);
        }
        work += active.len();
        if work > MOST_WORK {
            return fan(&ring.corners);
        }
        let middle = strip[0] + (strip[1] - strip[0]) / 2.0;
        active.sort_by(|&a, &b| edges[a].at(middle).total_cmp(&edges[b].at(middle)));
        let inside = intervals(&active, &edges, strip, &mut wrong);
        cover.go_on(inside, strip[0]);
    }
    cover.go_on(vec![], heights.last().copied().unwrap_or(0.0));
    let length: f64 =
        edges.iter().map(|edge| edge.high[1] - edge.low[1] + (edge.high[0] - edge.low[0]).abs()).sum();
    // A corner may be off by a rounding of each coordinate, and an edge within a strip by eleven, of magnitudes below 1.
    let rounding = 32.0 * UNIT_ROUNDOFF * length;
    Triangulation { crosses_itself: wrong.area() > rounding, ..cover.found }
}

/// A fan around the first corner of an outline, for one that is too tangled.
fn fan(corners: &[Corner]) -> Triangulation {
    let count = corners.len().max(2) - 2;
    let triangles = (0..count).map(|k| [0, k + 1, k + 2].map(|corner| corners[corner].index)).collect();
    Triangulation { triangles, new_points: vec![], crosses_itself: true }
}

/// An edge that is not level, from its lower to its higher end.
struct Edge {
    low: [f64; 2],
    high: [f64; 2],
    ends: [Corner; 2],
    /// What crossing it from left to right adds to the winding number: 1 if the outline goes down along it.
    winding: i32,
}

impl Edge {
    /// Where between its ends, from 0 to 1, it has this height.
    fn fraction(&self, height: f64) -> f64 {
        (height - self.low[1]) / (self.high[1] - self.low[1])
    }

    fn at(&self, height: f64) -> f64 {
        let t = self.fraction(height);
        (1.0 - t) * self.low[0] + t * self.high[0]
    }
}

/// The projection, scaled by a power of two so that all coordinates are below 1 and no product overflows.
#[derive(Clone, Copy)]
struct Plane {
    projection: DroppedAxis,
    exponent: i32,
}

impl Plane {
    fn new(corners: &[Corner], projection: DroppedAxis) -> Self {
        let sizes = corners.iter().flat_map(|corner| projection.of(corner.point)).map(f64::abs);
        Self { projection, exponent: libm::frexp(sizes.fold(0.0, f64::max)).1 }
    }

    fn of(self, point: DVec3) -> [f64; 2] {
        self.projection.of(point).map(|x| libm::ldexp(x, -self.exponent))
    }

    /// The edges of an outline by the height of their lower ends, and then in the order of the outline.
    fn edges(self, corners: &[Corner]) -> Vec<Edge> {
        let mut edges = Vec::with_capacity(corners.len());
        for (k, &from) in corners.iter().enumerate() {
            let to = corners[(k + 1) % corners.len()];
            let (p, q) = (self.of(from.point), self.of(to.point));
            if p[1] < q[1] {
                edges.push(Edge { low: p, high: q, ends: [from, to], winding: -1 });
            } else if p[1] > q[1] {
                edges.push(Edge { low: q, high: p, ends: [to, from], winding: 1 });
            }
        }
        edges.sort_by(|a, b| a.low[1].total_cmp(&b.low[1]));
        edges
    }
}

/// The heights of all corners and crossings, from the lowest to the highest. None if there are too many.
fn heights(edges: &[Edge], projection: DroppedAxis) -> Option<Vec<f64>> {
    let (mut heights, mut work) = (vec![], 0);
    for (k, edge) in edges.iter().enumerate() {
        heights.push(edge.low[1]);
        heights.push(edge.high[1]);
        for other in edges[k + 1..].iter().take_while(|other| other.low[1] < edge.high[1]) {
            work += 1;
            if let Some(height) = crossing(edge, other, projection) {
                heights.push(height);
                // Of one strip more.
                work += edges.len() / 4;
            }
            if work > MOST_WORK {
                return None;
            }
        }
    }
    heights.sort_by(f64::total_cmp);
    heights.dedup();
    Some(heights)
}

/// The height where two edges cross, rounded. None where they only touch.
fn crossing(one: &Edge, other: &Edge, projection: DroppedAxis) -> Option<f64> {
    let is_left_of = |a: &Edge, b: &Edge| a.low[0].max(a.high[0]) < b.low[0].min(b.high[0]);
    if is_left_of(one, other) || is_left_of(other, one) {
        return None;
    }
    let sides = |a: &Edge, b: &Edge| {
        b.ends.map(|end| projection.orientation([a.ends[0].point, a.ends[1].point, end.point]))
    };
    let do_cross = |[a, b]: [i32; 2]| a * b < 0;
    if !do_cross(sides(one, other)) || !do_cross(sides(other, one)) {
        return None;
    }
    let minus = |a: [f64; 2], b: [f64; 2]| [a[0] - b[0], a[1] - b[1]];
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let (along, across) = (minus(one.high, one.low), minus(other.high, other.low));
    let t = cross(minus(other.low, one.low), across) / cross(along, across);
    // A NaN, from edges that are nearly parallel, becomes the lower bound.
    let height = one.low[1] + t * along[1];
    Some(height.max(one.low[1]).max(other.low[1]).min(one.high[1]).min(other.high[1]))
}

/// A part of a strip that the outline goes around.
#[derive(Clone, Copy, PartialEq)]
struct Interval {
    left: usize,
    right: usize,
    is_positive: bool,
}

/// The areas that an outline goes around to the left, to the right, and more than once. Only one of the first two is
/// not zero, and the third is zero, unless the outline crosses itself.
#[derive(Default)]
struct Wrong {
    left: f64,
    right: f64,
    repeated: f64,
}

impl Wrong {
    fn area(&self) -> f64 {
        self.left.min(self.right) + self.repeated
    }
}

/// The parts of a strip that the outline goes around, given the edges from left to right.
fn intervals(active: &[usize], edges: &[Edge], strip: [f64; 2], wrong: &mut Wrong) -> Vec<Interval> {
    let (mut found, mut winding, mut start) = (vec![], 0, None);
    let middle = strip[0] + (strip[1] - strip[0]) / 2.0;
    let is_same = |&a: &usize, &b: &usize| edges[a].at(middle) == edges[b].at(middle);
    let mut groups = active.chunk_by(is_same).peekable();
    while let Some(group) = groups.next() {
        let before: i32 = winding;
        winding += group.iter().map(|&edge| edges[edge].winding).sum::<i32>();
        if let Some(left) = start
            && before.signum() != winding.signum()
        {
            found.push(Interval { left, right: group[0], is_positive: before > 0 });
        }
        start = match winding {
            0 => None,
            _ if before.signum() == winding.signum() => start,
            _ => Some(group[0]),
        };
        if let Some(next) = groups.peek() {
            let width = edges[next[0]].at(middle) - edges[group[0]].at(middle);
            let area = width * (strip[1] - strip[0]);
            match winding {
                0 => {}
                1.. => wrong.left += area,
                _ => wrong.right += area,
            }
            wrong.repeated += if winding.abs() > 1 { area } else { 0.0 };
        }
    }
    found
}

/// The trapezoids as they grow from strip to strip.
struct Cover<'a> {
    plane: Plane,
    edges: &'a [Edge],
    ring: &'a Ring,
    corners: usize,
    /// The intervals of the strip below, and the heights where they began.
    open: Vec<(Interval, f64)>,
    /// By the left edge of an interval, its place in the strip above; none but while they are compared.
    place_above: Vec<Option<usize>>,
    found: Triangulation,
}

impl Cover<'_> {
    /// Goes on with the strip above a height: intervals between the same edges as below grow, others end or begin.
    fn go_on(&mut self, inside: Vec<Interval>, height: f64) {
        let below = std::mem::take(&mut self.open);
        let mut above: Vec<_> = inside.into_iter().map(|interval| (interval, height)).collect();
        for (place, (interval, _)) in above.iter().enumerate() {
            self.place_above[interval.left] = Some(place);
        }
        for (interval, start) in below {
            let same = self.place_above[interval.left].filter(|&place| above[place].0 == interval);
            match same {
                Some(place) => above[place].1 = start,
                None => self.end(interval, [start, height]),
            }
        }
        above.iter().for_each(|(interval, _)| self.place_above[interval.left] = None);
        self.open = above;
    }

    /// Adds the triangles of a trapezoid between two heights.
    fn end(&mut self, Interval { left, right, is_positive }: Interval, [low, high]: [f64; 2]) {
        let [a, b] = [left, right].map(|edge| self.vertex(edge, low));
        let [d, c] = [left, right].map(|edge| self.vertex(edge, high));
        let quad = [a, b, c, d];
        for corners in [[0, 1, 2], [0, 2, 3]].map(|places| places.map(|place: usize| quad[place])) {
            if self.plane.projection.orientation(corners.map(|(_, point)| point)) > 0 {
                let mut triangle = corners.map(|(index, _)| index);
                if is_positive == self.ring.is_backwards {
                    triangle.reverse();
                }
                self.found.triangles.push(triangle);
            }
        }
    }

    /// The vertex of an edge at a height: one of its ends, or a new point.
    fn vertex(&mut self, edge: usize, height: f64) -> (usize, DVec3) {
        let edge = &self.edges[edge];
        let end = match height {
            _ if height == edge.low[1] => Some(edge.ends[0]),
            _ if height == edge.high[1] => Some(edge.ends[1]),
            _ => None,
        };
        if let Some(Corner { index, point }) = end {
            return (index, point);
        }
        let t = edge.fraction(height);
        let point = (1.0 - t) * edge.ends[0].point + t * edge.ends[1].point;
        // All vertices of a strip's border are on one line.
        let point = self.plane.projection.with_second(point, libm::ldexp(height, self.plane.exponent));
        self.found.new_points.push(point);
        (self.corners + self.found.new_points.len() - 1, point)
    }
}
