//! Rounding, shown pixel by pixel.
//!
//! At an edge, a ray in single precision may fall on the other side. Then so does a ray moved by a tenth of a pixel. So
//! a pixel is explained by rounding if its colour is one that this program sees along a ray moved by at most that, and
//! if the moved views differ from the right one by about as much. Smaller differences, of one level, are rounding if
//! they have both signs and are not in most pixels.

use super::rendering::{RenderedPixel, Rendering};
use super::rules::RayKind;
use super::self_hits::possible_colors;
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
    let views = variant.map(|variant| Views { picture, rendering, variant });
    let by_more = match &views {
        Some(views) => views.examine(visible.clone()),
        None => Unexplained::all(visible.clone()),
    };
    // A level is so little that many wrong pictures are as close to a moved view. Rays that graze do not move.
    let by_a_level = match &views {
        Some(views) if !is_balanced(picture, rendering, &by_a_level) => views.examine_grazing(by_a_level),
        _ => Unexplained::all(by_a_level),
    };
    let mut unexplained = by_more.pixels;
    if !is_balanced(picture, rendering, &by_a_level.pixels) {
        unexplained.extend(by_a_level.pixels);
        unexplained.sort_unstable();
    }
    Residual { differing, unexplained, visible, epsilon: by_a_level.epsilon.or(by_more.epsilon) }
}

/// Returns true if rounding may change these pixels by one level: in both directions, and not most pixels.
fn is_balanced(picture: &[Rgb], rendering: &Rendering, by_a_level: &[usize]) -> bool {
    let above = by_a_level.iter().filter(|&&at| rendering.pixels[at].is_below(picture[at])).count();
    let rarer = above.min(by_a_level.len() - above) as f64;
    let has_both_signs = by_a_level.len() < MIN_SIGNED || rarer >= RARER_SIGN * by_a_level.len() as f64;
    has_both_signs && by_a_level.len() as f64 <= MOST_BY_A_LEVEL * picture.len() as f64
}

/// Pixels that views leave unexplained.
struct Unexplained {
    pixels: Vec<usize>,
    /// The course's own epsilon, if it explains some others.
    epsilon: Option<f64>,
}

impl Unexplained {
    /// Leaves all of these pixels.
    fn all(pixels: Vec<usize>) -> Self {
        Self { pixels, epsilon: None }
    }

    /// Returns what the better one of the course's epsilons leaves of this number of pixels.
    fn by_better_epsilon(count: usize, left: impl Fn(f64) -> Vec<usize>) -> Self {
        let [one, other] =
            COURSE_EPSILONS.map(|epsilon| Self { pixels: left(epsilon), epsilon: Some(epsilon) });
        let better = if one.pixels.len() <= other.pixels.len() { one } else { other };
        Self { epsilon: better.epsilon.filter(|_| better.pixels.len() < count), ..better }
    }
}

/// A picture, and the variant from which it differs.
struct Views<'v> {
    picture: &'v [Rgb],
    rendering: &'v Rendering,
    variant: &'v Variant<'v>,
}

impl Views<'_> {
    /// Returns which of these pixels no moved view explains. If they are many, a sample decides whether all are examined.
    fn examine(&self, pixels: Vec<usize>) -> Unexplained {
        let variant = self.variant;
        let most = (MAX_VIEW_RAYS / variant.rays_per_pixel()).clamp(SAMPLED, MAX_EXAMINED);
        if pixels.len() > SAMPLED {
            let step = pixels.len() / SAMPLED;
            let sample: Vec<usize> = pixels.iter().copied().step_by(step).collect();
            let left = self.unexplained(&sample, Thresholds::OWN);
            if pixels.len() > most && 2 * left.len() > sample.len() || pixels.len() > 2 * most {
                return Unexplained::all(pixels);
            }
        }
        let mut left = self.unexplained(&pixels, Thresholds::OWN);
        if left.is_empty() || left.len() > most || !variant.has_secondary_rays() {
            return Unexplained::all(left);
        }
        if variant.weighs_rays() {
            for weight in [1.0 - WEIGHT_ROUNDING, 1.0 + WEIGHT_ROUNDING] {
                left = self.unexplained(&left, Thresholds { epsilon: None, weight });
            }
        }
        let moves: Vec<[f64; 2]> = moves(true).collect();
        Unexplained::by_better_epsilon(left.len(), |epsilon| {
            let left = self.unexplained(&left, Thresholds { epsilon: Some(epsilon), weight: 1.0 });
            self.unexplained_by_grazing(left, epsilon, &moves)
        })
    }

    /// Returns which of these pixels, which differ by one level, no ray explains that grazes a surface.
    fn examine_grazing(&self, pixels: Vec<usize>) -> Unexplained {
        if pixels.len() > MAX_EXAMINED || !self.variant.has_secondary_rays() {
            return Unexplained::all(pixels);
        }
        Unexplained::by_better_epsilon(pixels.len(), |epsilon| {
            self.unexplained_by_grazing(pixels.clone(), epsilon, &[[0.0; 2]])
        })
    }

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
        let grazes = |kind, surface: &SurfacePoint, direction: DVec3| {
            kind != RayKind::Onwards && surface.normal.dot(direction).abs() <= largest_cosine
        };
        let thresholds = Thresholds { epsilon: Some(epsilon), weight: 1.0 };
        let left = self.variant.with_painter(thresholds, |painter| {
            let is_left = |at: &usize| {
                let source = self.variant.pixel_changes().source(*at, self.variant.size());
                let is_explained = |&[x, y]: &[f64; 2]| {
                    let mut views = possible_colors(painter, source, DVec2::new(x, y), &grazes);
                    views.any(|view| self.explains(*at, view))
                };
                !moves.iter().any(is_explained)
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
