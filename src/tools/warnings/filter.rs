//! Warns about filters so narrow that pixels get no samples and are black, or get samples whose weights cancel.
//!
//! Samples have the same positions in each run, so the weights w of each pixel's samples are summed. This takes a small
//! fraction of the time to trace them. Adaptive samples are chosen by their colours, so the filter must cover the pixel.
//!
//! Mitchell's filter is negative beyond 4/7 of its radius. If the weights nearly cancel, the pixel is far outside the
//! range of its samples' colours. Colours between 0 and 1 give a pixel between (1 - M) / 2 and (1 + M) / 2, where M is
//! the sum of |w| divided by |the sum of w|.
//! Computing it takes the samples of neighbouring pixels, so the pixels in the picture's middle stand for all.

use crate::diagnostic::Diagnostic;
use crate::render::Request;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::Pattern;
use glam::DVec2;
use rayon::prelude::*;
use std::ops::Range;

/// A filter of this size reaches a sample of every pixel, and its weights do not cancel: in a million pixels, M above
/// [`MOST_CANCELLED`] did not occur.
const WIDE_ENOUGH: f64 = 3.0;
/// With more than two samples in a pixel, weights do not cancel from this radius on.
const WIDE_ENOUGH_FOR_MANY: f64 = 2.0;
/// The largest M without a warning.
const MOST_CANCELLED: f64 = 2.0;
/// The columns and rows in the middle of a picture that stand for all if the filter is Mitchell's, or if all pixels have
/// equal samples.
const EXAMINED: usize = 64;

/// Warns about a filter that is too narrow for the samples.
pub fn narrow_filter(request: &Request) -> Option<Diagnostic> {
    if !is_too_narrow(request) {
        return None;
    }
    let wrong = "in some pixels no sample has weight, or the weights nearly cancel";
    let warning = Diagnostic::warning(format!("`{}` is too narrow: {wrong}", request.filter.flag()));
    Some(warning.with_hint(format!("`{}` is wide enough", wide_enough(request).flag())))
}

/// Returns the smallest filter of this kind, in thousandths of a pixel, that is not too narrow.
fn wide_enough(request: &Request) -> Filter {
    let of_size = |thousandths: u32| request.filter.with_size(f64::from(thousandths) / 1000.0);
    let is_enough =
        |thousandths| !is_too_narrow(&Request { filter: of_size(thousandths), ..request.clone() });
    let (mut narrow, mut wide) = ((1000.0 * request.filter.size()) as u32, (1000.0 * WIDE_ENOUGH) as u32);
    while narrow + 1 < wide {
        let middle = narrow.midpoint(wide);
        *(if is_enough(middle) { &mut wide } else { &mut narrow }) = middle;
    }
    of_size(wide)
}

/// Returns true if a pixel has no samples with weight, or samples whose weights nearly cancel.
fn is_too_narrow(request: &Request) -> bool {
    let Request { filter, sampler, adaptive, size: [width, height], .. } = *request;
    let covers_pixel = has_weight(filter.weight(DVec2::splat(0.5)).abs());
    let radius = if sampler.count() > 2 { WIDE_ENOUGH_FOR_MANY } else { WIDE_ENOUGH };
    let is_negative = matches!(filter, Filter::Mitchell { .. });
    let may_cancel = is_negative && filter.size() < radius && adaptive.is_none();
    // Every pixel contains its displaced sample.
    if sampler.pattern() == Pattern::Displaced || covers_pixel && !may_cancel {
        return false;
    }
    if adaptive.is_some() {
        return true;
    }
    let support = filter.support();
    let near = |at: usize, end: usize| at.saturating_sub(support)..(at + support + 1).min(end);
    let examined = |all: Range<usize>| {
        let is_part = is_negative || sampler.pattern() == Pattern::Uniform;
        let count = if is_part { EXAMINED } else { all.len() };
        let start = all.start + all.len().saturating_sub(count) / 2;
        start..all.end.min(start + count)
    };
    // Returns the sum of the weights that samples in these pixels have in a pixel, and of their magnitudes.
    let sums = |[x, y]: [usize; 2], columns: Range<usize>, rows: Range<usize>| {
        let (mut sum, mut magnitude) = (0.0_f64, 0.0);
        for column in columns {
            let mut pixels = sampler.pixels((column * height + rows.start) as u64, 1);
            for row in rows.clone() {
                let moved = DVec2::new(column as f64 - x as f64, row as f64 - y as f64);
                for offset in pixels.next_offsets() {
                    let weight = filter.weight(offset + moved);
                    sum += weight;
                    magnitude += weight.abs();
                }
            }
        }
        (sum, magnitude)
    };
    let is_wrong = |x: usize, y: usize| {
        // Mostly a pixel's own samples suffice.
        if !is_negative && has_weight(sums([x, y], x..x + 1, y..y + 1).1) {
            return false;
        }
        let (sum, magnitude) = sums([x, y], near(x, width), near(y, height));
        !has_weight(magnitude) || magnitude > MOST_CANCELLED * sum.abs()
    };
    examined(request.columns()).into_par_iter().any(|x| examined(request.rows()).any(|y| is_wrong(x, y)))
}

/// Returns true if a weight counts. The weights of a Gaussian end at subnormal numbers.
fn has_weight(weight: f64) -> bool {
    weight >= f64::MIN_POSITIVE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Window;
    use crate::sampling::drand48::Drand48;
    use crate::sampling::sampler::Sampler;

    const FILTERS: [fn(f64) -> Filter; 4] = [
        |radius| Filter::Box { radius },
        |radius| Filter::Tent { radius },
        |sigma| Filter::Gaussian { sigma },
        |radius| Filter::Mitchell { radius },
    ];

    fn request(pattern: Pattern, count: u32, filter: Filter) -> Request {
        let sampler = Sampler::new(pattern, count, Drand48::UNSEEDED);
        Request { sampler, filter, ..Request::new([40, 30]) }
    }

    /// Returns the size suggested for a filter that is far too narrow.
    fn named(pattern: Pattern, count: u32, filter: fn(f64) -> Filter) -> f64 {
        let request = request(pattern, count, filter(1e-5));
        assert!(is_too_narrow(&request));
        wide_enough(&request).size()
    }

    #[test]
    fn sizes_for_uniform_samples_by_geometry() {
        // Four uniform samples are a quarter of a pixel from the centre along both axes.
        assert_eq!(FILTERS.map(|filter| named(Pattern::Uniform, 4, filter)), [0.25, 0.354, 0.01, 0.251]);
        assert!(!is_too_narrow(&request(Pattern::Uniform, 9, Filter::Tent { radius: 1e-6 })));
    }

    #[test]
    fn the_default_filter_is_wide_enough_for_any_samples() {
        for pattern in [Pattern::Uniform, Pattern::Jittered, Pattern::Random] {
            assert!((1..70).all(|count| !is_too_narrow(&request(pattern, count, Filter::PIXEL))));
        }
    }

    #[test]
    fn a_filter_for_adaptive_samples_covers_the_pixel() {
        let adaptive = Some(crate::render::adaptive::Adaptive { most: 16, error: 2.0 });
        let sampler = Sampler::of_adaptive(Drand48::UNSEEDED);
        let warns = |filter| is_too_narrow(&Request { filter, sampler, adaptive, ..Request::new([40, 30]) });
        let [square, disk, _, cubic] = FILTERS;
        assert_eq!([0.499, 0.5].map(|radius| warns(square(radius))), [true, false]);
        assert_eq!([0.707, 0.708].map(|radius| warns(disk(radius))), [true, false]);
        assert_eq!([0.5, 0.501, 0.8].map(|radius| warns(cubic(radius))), [true, false, false]);
    }

    /// Returns the sum of the magnitudes of the weights of a pixel's samples, divided by the magnitude of their sum.
    fn amplification(request: &Request, [x, y]: [usize; 2]) -> f64 {
        let [width, height] = request.size;
        let samples = (0..width).flat_map(|column| (0..height).map(move |row| [column, row]));
        let weights = samples.flat_map(|[column, row]| {
            let moved = DVec2::new(column as f64 - x as f64, row as f64 - y as f64);
            let offsets = request.sampler.offsets((column * height + row) as u64);
            offsets.map(move |offset| request.filter.weight(offset + moved))
        });
        let [sum, magnitude] = weights.fold([0.0; 2], |[sum, all], w| [sum + w, all + w.abs()]);
        magnitude / sum.abs()
    }

    #[test]
    fn a_pixel_is_wrong_where_the_sum_of_weights_is_zero_or_below_half_of_their_magnitudes() {
        let window = Some(Window { x: 3, y: 4, width: 5, height: 7 });
        let mut found = [0; 2];
        let [square, disk, _, cubic] = FILTERS;
        let cubic = [0.45, 0.7, 0.9, 1.0, 1.1, 1.3, 1.6, 1.95, 2.4, 2.9].map(cubic);
        let others =
            [0.2, 0.3, 0.4, 0.45, 0.48, 0.55, 0.6, 0.65].map(|radius| [square(radius), disk(radius)]);
        for filter in cubic.into_iter().chain(others.into_iter().flatten()) {
            for (pattern, count) in [
                (Pattern::Random, 1),
                (Pattern::Random, 3),
                (Pattern::Random, 16),
                (Pattern::Jittered, 1),
                (Pattern::Jittered, 4),
                (Pattern::Jittered, 9),
                (Pattern::Uniform, 4),
                (Pattern::Uniform, 6),
            ] {
                for window in [None, window] {
                    let all = Request { window, size: [12, 14], ..request(pattern, count, filter) };
                    let pixels = all.columns().flat_map(|x| all.rows().map(move |y| [x, y]));
                    let worst = pixels
                        .map(|pixel| amplification(&all, pixel))
                        .fold(0.0, |worst: f64, x| if x.is_nan() { f64::INFINITY } else { worst.max(x) });
                    assert_eq!(is_too_narrow(&all), worst > 2.0, "{filter:?} {pattern:?} {count} {worst}");
                    found[usize::from(worst > 2.0)] += 1;
                }
            }
        }
        assert!(found.iter().all(|&count| count > 20), "{found:?}");
    }

    #[test]
    fn the_named_radius_has_weights_that_do_not_cancel() {
        for (pattern, count) in [(Pattern::Random, 1), (Pattern::Random, 4), (Pattern::Jittered, 4)] {
            let of = |radius: f64| request(pattern, count, Filter::Mitchell { radius });
            assert!(is_too_narrow(&of(0.9)));
            let radius = wide_enough(&of(0.9)).size();
            assert!(!is_too_narrow(&of(radius)) && (0.9..=3.0).contains(&radius));
            assert!(is_too_narrow(&of(radius - 0.001)), "{radius}");
        }
    }
}
