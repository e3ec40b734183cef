//! The letters R, A, Y and S, each a round brush stroke drawn out into the depth, with rounded edges.
//!
//! A letter stands on y = 0 and is one unit high from the first stroke's middle line to the last's. Distances
//! are negative inside. Distances to segments and arcs follow Quilez, "2D distance functions".

use glam::{DVec2, DVec3, dvec2};
use std::f64::consts::TAU;

/// The distance from a stroke's middle line to its edge.
const STROKE: f64 = 0.105;
/// Half the depth of a letter.
const DEPTH: f64 = 0.13;
/// The radius of the rounded edges.
const ROUNDING: f64 = 0.045;

/// The middle line of a stroke.
enum Stroke {
    Segment(DVec2, DVec2),
    /// A part of a circle, counter-clockwise from an angle over an extent, both in turns.
    Arc {
        centre: DVec2,
        radius: f64,
        from: f64,
        extent: f64,
    },
}

/// A letter, the number of holes in it, and how far to the right it reaches.
pub struct Letter {
    strokes: Vec<Stroke>,
    pub holes: i64,
    pub width: f64,
}

impl Letter {
    /// The letters of the word, in order.
    pub fn all() -> [Self; 4] {
        [letter_r(), letter_a(), letter_y(), letter_s()]
    }

    /// The distance from the letter's surface, a lower bound near its edges.
    pub fn distance(&self, point: DVec3) -> f64 {
        let flat = point.truncate();
        let line = self.strokes.iter().map(|stroke| stroke.distance(flat)).fold(f64::INFINITY, f64::min);
        let from_edge = dvec2(line - STROKE, point.z.abs() - DEPTH) + ROUNDING;
        from_edge.max(DVec2::ZERO).length() + from_edge.max_element().min(0.0) - ROUNDING
    }

    /// The corners of a box around the letter.
    pub fn bounds(&self) -> [DVec3; 2] {
        let margin = DVec3::new(STROKE, STROKE, DEPTH) + 0.04;
        [-margin, DVec3::new(self.width, 1.0, 0.0) + margin]
    }
}

impl Stroke {
    fn distance(&self, point: DVec2) -> f64 {
        match *self {
            Self::Segment(from, to) => {
                let along = ((point - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0);
                point.distance(from.lerp(to, along))
            }
            Self::Arc { centre, radius, from, extent } => {
                let offset = point - centre;
                let turn = (libm::atan2(offset.y, offset.x) / TAU - from).rem_euclid(1.0);
                if turn <= extent {
                    return (offset.length() - radius).abs();
                }
                let end = |turn: f64| centre + dvec2(libm::cos(turn * TAU), libm::sin(turn * TAU)) * radius;
                point.distance(end(from)).min(point.distance(end(from + extent)))
            }
        }
    }
}

fn segment(from: [f64; 2], to: [f64; 2]) -> Stroke {
    Stroke::Segment(from.into(), to.into())
}

fn letter_r() -> Letter {
    let strokes = vec![
        segment([0.0, 0.0], [0.0, 1.0]),
        segment([0.0, 1.0], [0.3, 1.0]),
        Stroke::Arc { centre: dvec2(0.3, 0.73), radius: 0.27, from: 0.75, extent: 0.5 },
        segment([0.0, 0.46], [0.3, 0.46]),
        segment([0.28, 0.46], [0.56, 0.0]),
    ];
    Letter { strokes, holes: 1, width: 0.57 }
}

fn letter_a() -> Letter {
    let strokes = vec![
        segment([0.0, 0.0], [0.37, 1.0]),
        segment([0.37, 1.0], [0.74, 0.0]),
        segment([0.12, 0.32], [0.62, 0.32]),
    ];
    Letter { strokes, holes: 1, width: 0.74 }
}

fn letter_y() -> Letter {
    let strokes = vec![
        segment([0.0, 1.0], [0.34, 0.48]),
        segment([0.68, 1.0], [0.34, 0.48]),
        segment([0.34, 0.48], [0.34, 0.0]),
    ];
    Letter { strokes, holes: 0, width: 0.68 }
}

fn letter_s() -> Letter {
    let strokes = vec![
        Stroke::Arc { centre: dvec2(0.28, 0.745), radius: 0.255, from: 0.07, extent: 0.68 },
        Stroke::Arc { centre: dvec2(0.28, 0.245), radius: 0.245, from: 0.57, extent: 0.68 },
    ];
    Letter { strokes, holes: 0, width: 0.54 }
}
