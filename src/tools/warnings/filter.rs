//! Warns about filters so narrow that pixels get no samples and are black, or get samples whose weights cancel.
//!
//! Only a pixel's own samples matter for the first, because those in its neighbours are farther away. Uniform samples
//! have the same positions in every pixel. Jittered and adaptive samples have a known stratum, so the farthest point of
//! the strata around the centre decides. Random samples may be anywhere, but at the same positions in each run. So they
//! are examined one by one, which takes a small fraction of the time to trace them.
//!
//! Mitchell's filter is negative beyond 4/7 of its radius. If the weights w of a pixel's samples nearly cancel, the
//! pixel is far outside the range of their colours. Colours between 0 and 1 give a pixel between (1 - M) / 2 and (1 +
//! M) / 2, where M is the sum of |w| divided by |the sum of w|. The pixels in the picture's middle stand for all.

use super::Warning;
use crate::diagnostic::Diagnostic;
use crate::render::Request;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::{Pattern, Sampler};
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
/// The columns and rows in the middle of a picture that are examined for weights that cancel.
const EXAMINED: usize = 64;

/// Warns about a filter that is too narrow for the samples.
pub fn narrow_filter(request: &Request) -> Option<Diagnostic> {
    let lost = lost(request)?;
    let wide_enough = wide_enough(request).flag();
    Some(Warning::NarrowFilter { flag: request.filter.flag(), lost, wide_enough }.into())
}

/// Returns the smallest filter of this kind, in thousandths of a pixel, that is not too narrow.
fn wide_enough(request: &Request) -> Filter {
    let of_size = |thousandths: u32| request.filter.with_size(f64::from(thousandths) / 1000.0);
    let is_enough =
        |thousandths| lost(&Request { filter: of_size(thousandths), ..request.clone() }).is_none();
    let (mut narrow, mut wide) = ((1000.0 * request.filter.size()) as u32, (1000.0 * WIDE_ENOUGH) as u32);
    while narrow + 1 < wide {
        let middle = narrow.midpoint(wide);
        *(if is_enough(middle) { &mut wide } else { &mut narrow }) = middle;
    }
    of_size(wide)
}

/// Returns which pixels are wrong, as the end of a sentence, if the filter is too narrow.
fn lost(request: &Request) -> Option<String> {
    let Request { filter, sampler, .. } = *request;
    let lost = match sampler.pattern() {
        // Every pixel contains its sample.
        Pattern::Displaced => return None,
        Pattern::Uniform if !sampler.offsets(0).any(|offset| reaches(filter, offset)) => {
            Some("no sample is within the filter, and every pixel is black".into())
        }
        Pattern::Jittered if !reaches(filter, surely_within(&sampler)) => {
            Some("a pixel may have no sample within the filter, and is black then".into())
        }
        Pattern::Random if !reaches(filter, DVec2::splat(0.5)) => match lost_of_random(request) {
            0 => None,
            1 => Some("1 pixel has no sample within the filter, and is black".into()),
            pixels => Some(format!("{pixels} pixels have no sample within the filter, and are black")),
        },
        _ => None,
    };
    let cancelled = "weights nearly cancel in some pixels, which are far too dark or too bright";
    lost.or_else(|| cancels(request).then(|| cancelled.into()))
}

/// Returns true if the weights of Mitchell's filter nearly cancel in some pixel.
fn cancels(request: &Request) -> bool {
    let Request { filter, sampler, adaptive, size: [width, height], .. } = *request;
    let is_random = matches!(sampler.pattern(), Pattern::Random | Pattern::Jittered) && adaptive.is_none();
    let wide_enough = if sampler.count() > 2 { WIDE_ENOUGH_FOR_MANY } else { WIDE_ENOUGH };
    if !is_random || !matches!(filter, Filter::Mitchell { .. }) || filter.size() >= wide_enough {
        return false;
    }
    let support = filter.support();
    let near = |at: usize, end: usize| at.saturating_sub(support)..(at + support + 1).min(end);
    let middle = |all: Range<usize>| {
        let start = all.start + all.len().saturating_sub(EXAMINED) / 2;
        start..all.end.min(start + EXAMINED)
    };
    let is_wrong = |x: usize, y: usize| {
        let (mut sum, mut magnitude) = (0.0_f64, 0.0);
        for column in near(x, width) {
            let rows = near(y, height);
            let mut pixels = sampler.pixels((column * height + rows.start) as u64, 1);
            for row in rows {
                let moved = DVec2::new(column as f64 - x as f64, row as f64 - y as f64);
                for offset in pixels.next_offsets() {
                    let weight = filter.weight(offset + moved);
                    sum += weight;
                    magnitude += weight.abs();
                }
            }
        }
        // A pixel whose weights have no sum is black.
        sum == 0.0 || magnitude > MOST_CANCELLED * sum.abs()
    };
    middle(request.columns()).into_par_iter().any(|x| middle(request.rows()).any(|y| is_wrong(x, y)))
}

/// Returns true if a sample at this position counts. The weights of a Gaussian end at subnormal numbers.
fn reaches(filter: Filter, position: DVec2) -> bool {
    filter.weight(position).abs() >= f64::MIN_POSITIVE
}

/// Returns the largest possible distance along each axis of the nearest jittered sample from the centre.
fn surely_within(sampler: &Sampler) -> DVec2 {
    let farthest = |strata: u32| {
        // An odd number of strata includes a middle one.
        let halves = if strata.is_multiple_of(2) { 2.0 } else { 1.0 };
        halves / (2.0 * f64::from(strata))
    };
    DVec2::from_array(sampler.strata().map(farthest))
}

/// Returns the number of pixels without a random sample in the filter.
fn lost_of_random(request: &Request) -> usize {
    let Request { filter, sampler, size: [_, height], .. } = *request;
    let rows = request.rows();
    let lost_in = |column: usize| {
        let mut pixels = sampler.pixels((column * height + rows.start) as u64, 1);
        let is_lost = |_: &usize| !pixels.next_offsets().any(|offset| reaches(filter, offset));
        rows.clone().filter(is_lost).count()
    };
    request.columns().map(lost_in).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Window;
    use crate::sampling::drand48::Drand48;

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
        assert!(lost(&request).is_some());
        wide_enough(&request).size()
    }

    #[test]
    fn the_named_size_is_the_smallest_without_a_warning() {
        for (filter, count) in
            FILTERS.into_iter().flat_map(|filter| [2, 4, 7, 8, 16, 64].map(|n| (filter, n)))
        {
            for pattern in [Pattern::Uniform, Pattern::Jittered, Pattern::Random] {
                // An odd number of uniform samples has one at the centre. Cancelling weights are tested elsewhere.
                let is_uniform = pattern == Pattern::Uniform;
                if is_uniform && count == 7 || !is_uniform && matches!(filter(1.0), Filter::Mitchell { .. }) {
                    continue;
                }
                let size = named(pattern, count, filter);
                let warns = |size: f64| lost(&request(pattern, count, filter(size))).is_some();
                assert!(!warns(size) && warns(size - 0.001), "{pattern:?} {count} {size}");
            }
        }
    }

    #[test]
    fn sizes_for_uniform_and_jittered_samples_by_geometry() {
        // Four uniform samples are a quarter of a pixel from the centre along both axes.
        assert_eq!(FILTERS.map(|filter| named(Pattern::Uniform, 4, filter)), [0.25, 0.354, 0.01, 0.251]);
        // One of four jittered samples is at most as far as a corner of the pixel.
        let [square, disk, ..] = FILTERS;
        assert_eq!([square, disk].map(|filter| named(Pattern::Jittered, 4, filter)), [0.5, 0.708]);
        // Nine jittered samples have one in the middle stratum. Eight have none there along one axis.
        assert_eq!([8, 9].map(|count| named(Pattern::Jittered, count, square)), [0.5, 0.167]);
        assert_eq!(lost(&request(Pattern::Uniform, 9, Filter::Tent { radius: 1e-6 })), None);
    }

    #[test]
    fn the_default_filter_is_wide_enough_for_any_samples() {
        for pattern in [Pattern::Uniform, Pattern::Jittered, Pattern::Random] {
            assert!((1..70).all(|count| lost(&request(pattern, count, Filter::PIXEL)).is_none()));
        }
        let adaptive = Sampler::of_adaptive(Drand48::UNSEEDED);
        assert_eq!(lost(&Request { sampler: adaptive, ..Request::new([9, 9]) }), None);
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
    fn weights_cancel_where_their_sum_is_below_half_of_their_magnitudes() {
        let window = Some(Window { x: 3, y: 4, width: 5, height: 7 });
        let mut found = [0; 2];
        for radius in [0.45, 0.7, 0.9, 1.0, 1.1, 1.3, 1.6, 1.95, 2.4, 2.9] {
            for (pattern, count) in [
                (Pattern::Random, 1),
                (Pattern::Random, 3),
                (Pattern::Random, 16),
                (Pattern::Jittered, 1),
                (Pattern::Jittered, 4),
                (Pattern::Jittered, 9),
            ] {
                for window in [None, window] {
                    let all = Request { window, ..request(pattern, count, Filter::Mitchell { radius }) };
                    let all = Request { size: [12, 14], ..all };
                    let pixels = all.columns().flat_map(|x| all.rows().map(move |y| [x, y]));
                    let worst = pixels
                        .map(|pixel| amplification(&all, pixel))
                        .fold(0.0, |worst: f64, x| if x.is_nan() { f64::INFINITY } else { worst.max(x) });
                    assert_eq!(cancels(&all), worst > 2.0, "{radius} {pattern:?} {count} {worst}");
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
            assert!(lost(&of(0.9)).is_some_and(|lost| lost.starts_with("weights nearly cancel")));
            let radius = wide_enough(&of(0.9)).size();
            assert!(lost(&of(radius)).is_none() && (0.9..=3.0).contains(&radius));
            assert!(lost(&of(radius - 0.001)).is_some(), "{radius}");
        }
        let none = [
            (Pattern::Uniform, 1, 0.6),
            (Pattern::Uniform, 4, 0.8),
            (Pattern::Random, 4, 2.0),
            (Pattern::Jittered, 16, 1.0),
        ];
        for (pattern, count, radius) in none {
            assert_eq!(
                lost(&request(pattern, count, Filter::Mitchell { radius })),
                None,
                "{pattern:?} {count}"
            );
        }
        let adaptive = Sampler::of_adaptive(Drand48::UNSEEDED);
        let request =
            Request { filter: Filter::Mitchell { radius: 0.8 }, sampler: adaptive, ..Request::new([40, 30]) };
        let adaptive = Some(crate::sampling::adaptive::Adaptive { most: 16, error: 2.0 });
        assert_eq!(lost(&Request { adaptive, ..request }), None);
    }

    #[test]
    fn random_pixels_are_counted_whose_samples_have_no_weight() {
        for filter in
            [Filter::Box { radius: 0.3 }, Filter::Tent { radius: 0.6 }, Filter::Gaussian { sigma: 0.01 }]
        {
            let request = request(Pattern::Random, 2, filter);
            let is_lost = |pixel: &u64| {
                request.sampler.offsets(*pixel).all(|offset| filter.weight(offset) < f64::MIN_POSITIVE)
            };
            assert_eq!(lost_of_random(&request), (0..1200).filter(is_lost).count());
            // The pixels of one column and five rows.
            let window = Some(Window { x: 7, y: 3, width: 1, height: 5 });
            let expected = (7 * 30 + 22..7 * 30 + 27).filter(is_lost).count();
            assert_eq!(lost_of_random(&Request { window, ..request }), expected);
        }
    }
}
