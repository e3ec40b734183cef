//! Speckles: where a shadow ray hits the very surface that it leaves, the point lies in its own shadow.
//!
//! Which points do depends on every rounding, so that no picture of them can be made. But each is as dark as if a light
//! did not reach it, and most of them lie scattered, away from the edges where shadows differ for other reasons.

use super::Original;
use crate::picture::Picture;
use crate::render::Request;
use crate::scene::{Color, Light};
use crate::tools::compare::{EdgeMap, Rgb, colors, largest_channel_difference};
use crate::trace::Shadows;
use std::cell::OnceCell;

/// Fewer pixels may be in a shadow of their own by chance.
const MIN_PIXELS: f64 = 3.0;
/// The share of the differing pixels away from edges that must be speckles.
const MIN_SHARE: f64 = 0.6;
/// The share of all differing pixels that must be speckles away from edges.
const MIN_SHARE_OF_ALL: f64 = 0.25;
/// A pixel counts as scattered if no more of the eight pixels around it differ. At the border of a shadow that is a
/// region it is five, and inside eight.
const MAX_NEIGHBOURS: usize = 4;
/// Pictures are made for all combinations of so many lights that do not reach a point.
const MAX_LIGHTS: usize = 4;

/// The search for speckles.
pub struct Speckles<'o> {
    original: &'o Original<'o>,
    /// The whole picture with each combination of lights that reach nothing, once it is needed.
    shadowed: OnceCell<Vec<Picture>>,
}

impl<'o> Speckles<'o> {
    pub fn new(original: &'o Original<'o>) -> Self {
        Self { original, shadowed: OnceCell::new() }
    }

    /// How many of the pixels in which `a` differs from `b` are speckles, if that is what distinguishes `a`. Both are
    /// whole pictures.
    pub fn count(&self, a: &Picture, b: &Picture) -> Option<usize> {
        if !can_show(self.original) {
            return None;
        }
        count(self.original, || self.shadowed.get_or_init(|| shadowed(self.original)), a, b)
    }
}

fn count<'p>(
    original: &Original,
    shadowed: impl FnOnce() -> &'p Vec<Picture>,
    a: &Picture,
    b: &Picture,
) -> Option<usize> {
    let Differing { all, away_from_edges, scattered } = Differing::new(original, a, b);
    let is_enough = |count: usize| {
        let count = count as f64;
        count >= (MIN_SHARE * away_from_edges as f64).max(MIN_SHARE_OF_ALL * all as f64).max(MIN_PIXELS)
    };
    if !is_enough(scattered.len()) {
        return None;
    }
    let shadowed = shadowed();
    let is_shadowed =
        |&&at: &&usize| shadowed.iter().any(|picture| nearly(colors(picture)[at], colors(a)[at]));
    let speckles = scattered.iter().filter(is_shadowed).count();
    is_enough(speckles).then_some(speckles)
}

/// Whether speckles would be found. Where several samples share a pixel, it is darkened only in part.
pub fn can_show(original: &Original) -> bool {
    let request = &original.request;
    let lights = original.renderer().scene.lights.len();
    request.effects.shadows != Shadows::None
        && (1..=MAX_LIGHTS).contains(&lights)
        && request.sampler.is_center()
        && request.filter.support() == 0
}

/// The pixels that differ by more than one level.
struct Differing {
    all: usize,
    away_from_edges: usize,
    /// Those away from edges that are darker in A and scattered, as indices from the top left.
    scattered: Vec<usize>,
}

impl Differing {
    fn new(original: &Original, a: &Picture, b: &Picture) -> Self {
        let [width, height] = original.request.size;
        let (a, b, edges) = (colors(a), colors(b), EdgeMap::new(b));
        let differs = |at: usize| !nearly(a[at], b[at]);
        let neighbours = |x: usize, y: usize| {
            let columns = x.saturating_sub(1)..(x + 2).min(width);
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            // The pixel itself is among them.
            rows.flat_map(|row| columns.clone().map(move |column| row * width + column))
                .filter(|&at| differs(at))
                .count()
                - 1
        };
        let mut found = Self { all: 0, away_from_edges: 0, scattered: vec![] };
        for at in (0..width * height).filter(|&at| differs(at)) {
            let [x, y] = [at % width, at / width];
            found.all += 1;
            if !edges.is_near_edge(x, y) {
                found.away_from_edges += 1;
                let is_scattered = is_darker(a[at], b[at]) && neighbours(x, y) <= MAX_NEIGHBOURS;
                if is_scattered {
                    found.scattered.push(at);
                }
            }
        }
        found
    }
}

fn nearly(a: Rgb, b: Rgb) -> bool {
    largest_channel_difference(a, b) <= 1
}

fn is_darker(a: Rgb, b: Rgb) -> bool {
    a.iter().zip(b).all(|(&a, b)| a <= b)
}

/// The scene with each combination of lights that reach nothing.
fn shadowed(original: &Original) -> Vec<Picture> {
    let scene = &original.renderer().scene;
    let whole = Request { window: None, ..original.request.clone() };
    let combinations = 1..1_usize << scene.lights.len();
    let without = combinations.filter_map(|combination| {
        let mut scene = scene.clone();
        for (_, light) in scene.lights.iter_mut().enumerate().filter(|(n, _)| combination >> n & 1 != 0) {
            let (Light::Directional { color, .. } | Light::Point { color, .. }) = light;
            *color = Color::ZERO;
        }
        original.picture_of(scene, &whole)
    });
    without.collect()
}
