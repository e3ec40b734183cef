//! Rounding, shown pixel by pixel.
//!
//! At an edge, a ray in single precision may fall on the other side. Then so does a ray moved by a tenth of a pixel. So
//! a pixel is explained by rounding if its colour is one that this program sees along a ray moved by at most that, and
//! if the moved views differ from the right one by about as much. Smaller differences, of one level, are rounding if
//! they have both signs and are not in most pixels.

use super::rendering::{RenderedPixel, Rendering};
use super::self_hits::is_made;
use super::student::Departure;
use super::variant::{Thresholds, Variant, colors_at};
use crate::picture::Color;
use crate::tools::compare::{Rgb, largest_channel_difference};
use crate::world::SurfacePoint;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// The distances of the moved views from the centre along each axis, in pixels.
const MOVES: [f64; 4] = [-0.075, -0.025, 0.025, 0.075];
/// The largest difference of a pixel from a moved view, in levels of each channel.
const CLOSE: u8 = 2;
/// The epsilons of the course's own programs.
const COURSE_EPSILONS: [f64; 2] = [0.0001, 0.001];
/// The largest share of all pixels that rounding changes by one level.
const MOST_BY_A_LEVEL: f64 = 0.5;
/// The smallest share of these with the rarer sign.
const RARER_SIGN: f64 = 0.1;
/// Fewer pixels than this may all have one sign.
const MIN_SIGNED: usize = 8;
/// The largest number of pixels that are examined one by one.
const MAX_EXAMINED: usize = 1 << 12;
/// The largest number of camera rays of one view of these pixels. [`SAMPLED`] pixels are always examined.
const MAX_VIEW_RAYS: usize = 1 << 16;
/// If more pixels than this differ, about as many are sampled.
const SAMPLED: usize = 1 << 7;
/// The relative rounding of a ray's weight in single precision.
const WEIGHT_ROUNDING: f64 = 1e-5;

/// The pixels in which a picture differs from one that this program makes, and which of them rounding explains.
#[derive(Clone, Debug)]
pub struct Residual {
    /// The number of pixels whose bytes differ.
    pub differing: usize,
    /// The pixels that rounding does not explain, in ascending order.
    pub unexplained: Vec<usize>,
    /// The pixels that differ by more than a level, in ascending order.
    pub visible: Vec<usize>,
    /// The course's own epsilon, if it explains some pixels.
    pub epsilon: Option<f64>,
}

/// Returns what rounding leaves unexplained of the difference between a picture and a variant with this rendering.
/// Without a variant no pixel can be seen again, so rounding explains one level only.
pub fn residual(picture: &[Rgb], rendering: &Rendering, variant: Option<&Variant>) -> Residual {
    let pairs = || picture.iter().zip(&rendering.pixels).enumerate();
    let differing = pairs().filter(|(_, (pixel, own))| **pixel != own.bytes).count();
    let visible: Vec<usize> =
        pairs().filter(|(_, (pixel, own))| own.differs_visibly(**pixel)).map(|(at, _)| at).collect();
    let is_by_a_level = |at: &usize| {
        let (pixel, own) = (picture[*at], &rendering.pixels[*at]);
        own.levels(pixel) > 0 && !own.differs_visibly(pixel)
    };
    let by_a_level: Vec<usize> = (0..picture.len()).filter(is_by_a_level).collect();
    let mut residual = Residual { differing, unexplained: visible.clone(), visible, epsilon: None };
    let views = variant.map(|variant| Views { picture, rendering, variant });
    if let Some(views) = &views {
        residual.unexplained = residual.examine(views, residual.visible.clone());
    }
    // A level is so little that many wrong pictures are as close to a moved view. Rays that graze do not move.
    let left = match &views {
        Some(views) if !is_balanced(picture, rendering, &by_a_level) => {
            residual.examine_grazing(views, by_a_level)
        }
        _ => by_a_level,
    };
    if !is_balanced(picture, rendering, &left) {
        residual.unexplained.extend(left);
        residual.unexplained.sort_unstable();
    }
    residual
}

/// Returns true if rounding may change these pixels by one level: in both directions, and not most pixels.
fn is_balanced(picture: &[Rgb], rendering: &Rendering, by_a_level: &[usize]) -> bool {
    let above = by_a_level.iter().filter(|&&at| rendering.pixels[at].is_below(picture[at])).count();
    let rarer = above.min(by_a_level.len() - above) as f64;
    let has_both_signs = by_a_level.len() < MIN_SIGNED || rarer >= RARER_SIGN * by_a_level.len() as f64;
    has_both_signs && by_a_level.len() as f64 <= MOST_BY_A_LEVEL * picture.len() as f64
}

impl Residual {
    /// Returns which of these pixels no moved view explains. If they are many, a sample decides whether all are examined.
    fn examine(&mut self, views: &Views, pixels: Vec<usize>) -> Vec<usize> {
        let variant = views.variant;
        let most = (MAX_VIEW_RAYS / variant.rays_per_pixel()).clamp(SAMPLED, MAX_EXAMINED);
        if pixels.len() > SAMPLED {
            let step = pixels.len() / SAMPLED;
            let sample: Vec<usize> = pixels.iter().copied().step_by(step).collect();
            let left = views.unexplained(&sample, Thresholds::OWN);
            if pixels.len() > most && 2 * left.len() > sample.len() || pixels.len() > 2 * most {
                return pixels;
            }
        }
        let mut left = views.unexplained(&pixels, Thresholds::OWN);
        if left.is_empty() || left.len() > most || !variant.has_secondary_rays() {
            return left;
        }
        if variant.weighs_rays() {
            for weight in [1.0 - WEIGHT_ROUNDING, 1.0 + WEIGHT_ROUNDING] {
                left = views.unexplained(&left, Thresholds { epsilon: None, weight });
            }
        }
        let by_epsilon = |epsilon| {
            let left = views.unexplained(&left, Thresholds { epsilon: Some(epsilon), weight: 1.0 });
            let moves: Vec<[f64; 2]> = moves(true).collect();
            views.unexplained_by_grazing(left, epsilon, &moves)
        };
        self.better_epsilon(left.len(), by_epsilon)
    }

    /// Returns which of these pixels, which differ by one level, no ray explains that grazes a surface.
    fn examine_grazing(&mut self, views: &Views, pixels: Vec<usize>) -> Vec<usize> {
        if pixels.len() > MAX_EXAMINED || !views.variant.has_secondary_rays() {
            return pixels;
        }
        let by_epsilon = |epsilon| views.unexplained_by_grazing(pixels.clone(), epsilon, &[[0.0; 2]]);
        self.better_epsilon(pixels.len(), by_epsilon)
    }

    /// Returns the pixels that the better one of the course's epsilons leaves, of this number of pixels.
    fn better_epsilon(&mut self, pixels: usize, left: impl Fn(f64) -> Vec<usize>) -> Vec<usize> {
        let [one, other] = COURSE_EPSILONS.map(left);
        let (epsilon, left) =
            if one.len() <= other.len() { (COURSE_EPSILONS[0], one) } else { (COURSE_EPSILONS[1], other) };
        if left.len() < pixels {
            self.epsilon = Some(epsilon);
        }
        left
    }
}

/// A picture, and the variant from which it differs.
struct Views<'v> {
    picture: &'v [Rgb],
    rendering: &'v Rendering,
    variant: &'v Variant<'v>,
}

impl Views<'_> {
    /// Returns true if a view explains a pixel.
    fn explains(&self, at: usize, view: Color) -> bool {
        let view = self.variant.pixel_changes().color(view, at, self.variant.size());
        is_explained(self.picture[at], self.rendering.colors[at], view)
    }

    /// Returns which of these pixels no moved view explains of a tracer with these thresholds.
    fn unexplained(&self, pixels: &[usize], thresholds: Thresholds) -> Vec<usize> {
        let left = self.variant.with_painter(thresholds, |painter| {
            let mut left = pixels.to_vec();
            for [x, y] in moves(thresholds != Thresholds::OWN) {
                let views = colors_at(painter, self.variant, &left, DVec2::new(x, y));
                let pairs = left.iter().zip(views);
                left = pairs.filter(|(at, view)| !self.explains(**at, *view)).map(|(&at, _)| at).collect();
                if left.is_empty() {
                    break;
                }
            }
            left
        });
        left.unwrap_or_else(|| pixels.to_vec())
    }

    /// Returns which of these pixels are not explained by rays that graze the surface that they leave. In single
    /// precision such a ray may start below the surface, and hit it beyond the epsilon. A pixel with several samples
    /// has too many of them.
    fn unexplained_by_grazing(&self, pixels: Vec<usize>, epsilon: f64, moves: &[[f64; 2]]) -> Vec<usize> {
        if self.variant.rays_per_pixel() > 1 {
            return pixels;
        }
        let largest_cosine = self.variant.depth() / epsilon;
        let grazes = |why, surface: &SurfacePoint, direction: DVec3| {
            why != Departure::Onwards && surface.normal.dot(direction).abs() <= largest_cosine
        };
        let thresholds = Thresholds { epsilon: Some(epsilon), weight: 1.0 };
        let left = self.variant.with_painter(thresholds, |painter| {
            let is_left = |at: &usize| {
                let source = self.variant.pixel_changes().source(*at, self.variant.size());
                let accepts = |view| self.explains(*at, view);
                !moves.iter().any(|&[x, y]| is_made(painter, source, DVec2::new(x, y), &grazes, &accepts))
            };
            pixels.par_iter().copied().filter(is_left).collect()
        });
        left.unwrap_or(pixels)
    }
}

/// Returns the moves of the views, along x and y.
fn moves(with_centre: bool) -> impl Iterator<Item = [f64; 2]> {
    let around = MOVES.into_iter().flat_map(|x| MOVES.map(|y| [x, y]));
    with_centre.then_some([0.0; 2]).into_iter().chain(around)
}

/// Returns true if a moved view explains why a pixel differs from the right colour.
fn is_explained(pixel: Rgb, right: Color, view: Color) -> bool {
    let (right_pixel, view_pixel) = (RenderedPixel::new(right), RenderedPixel::new(view));
    let difference = largest_channel_difference(pixel, right_pixel.bytes);
    let shown = |color: Color| (255.0 * color).clamp(Color::ZERO, Color::splat(255.0));
    let moved = (shown(view) - shown(right)).abs().max_element();
    let is_close = match difference {
        0..=1 => view_pixel.levels(pixel) == 0,
        _ => largest_channel_difference(pixel, view_pixel.bytes) <= CLOSE,
    };
    is_close && moved >= if difference > 1 { 0.5 * f64::from(difference) } else { 0.0 }
}
