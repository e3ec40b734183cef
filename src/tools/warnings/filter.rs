//! Warns about filters so narrow that pixels get no samples and are black, or get samples whose weights cancel.
//!
//! Only a pixel's own samples matter, because those in its neighbours are farther away. Uniform samples have the same
//! positions in every pixel. Jittered and adaptive samples have a known stratum, so the farthest point of the strata
//! around the centre decides. Random samples may be anywhere, but at the same positions in each run. So they are
//! examined one by one, which takes a small fraction of the time to trace them.
//!
//! Mitchell's filter is negative beyond 4/7 of its radius. If the weights w of a pixel's samples nearly cancel, the
//! pixel is far outside the range of their colours. Colours between 0 and 1 give a pixel between (1 - M) / 2 and (1 +
//! M) / 2, where M is the sum of |w| divided by |the sum of w|.

use crate::diagnostic::Diagnostic;
use crate::render::Request;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::{Pattern, Sampler};
use glam::DVec2;
use std::collections::VecDeque;
use std::ops::Range;

/// The pixels that are wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lost {
    /// No pixel gets a sample.
    All,
    /// Some pixels may get no sample, depending on the random numbers.
    Some,
    /// This number of pixels get no sample.
    Number(usize),
    /// In some pixels the weights of the samples nearly cancel.
    Cancelled,
}

/// Returns the flag of a filter.
pub(super) fn flag_of(filter: &Filter) -> String {
    let name = match filter {
        Filter::Box { .. } => "-box_filter",
        Filter::Tent { .. } => "-tent_filter",
        Filter::Gaussian { .. } => "-gaussian_filter",
        Filter::Mitchell { .. } => "-mitchell_filter",
    };
    format!("{name} {}", filter.size())
}

/// Warns about a filter that is too narrow for the samples.
pub fn narrow_filter(request: &Request) -> Option<Diagnostic> {
    let (lost, smallest) = too_narrow(request)?;
    let lost = match lost {
        Lost::All => "no sample is within the filter, and every pixel is black",
        Lost::Some => "a pixel may have no sample within the filter, and is black then",
        Lost::Number(1) => "1 pixel has no sample within the filter, and is black",
        Lost::Number(pixels) => &format!("{pixels} pixels have no sample within the filter, and are black"),
        Lost::Cancelled => "weights nearly cancel in some pixels, which are far too dark or too bright",
    };
    let message = format!("`{}` is too narrow for the samples: {lost}", flag_of(&request.filter));
    let hint = format!("`{}` is the smallest that is wide enough", flag_of(&smallest));
    Some(Diagnostic::warning(message).with_hint(hint))
}

/// Returns which pixels are wrong, and the smallest filter of this kind that avoids it.
fn too_narrow(request: &Request) -> Option<(Lost, Filter)> {
    let Request { filter, sampler, .. } = *request;
    let (farthest, lost) = match sampler.pattern() {
        Pattern::Uniform => (nearest(filter, sampler.offsets(0))?, Lost::All),
        Pattern::Jittered => (surely_within(&sampler), Lost::Some),
        // Every pixel contains its sample.
        Pattern::Displaced => return None,
        // The filter reaches any sample.
        Pattern::Random if reaches(filter, DVec2::splat(0.5)) => (DVec2::ZERO, Lost::Number(0)),
        Pattern::Random => farthest_of_random(request)?,
    };
    let is_lost = !reaches(filter, farthest);
    if !is_lost && !cancels(request, filter.size()) {
        return None;
    }
    let (size, lost) =
        if is_lost { (smallest(filter, farthest), lost) } else { (filter.size(), Lost::Cancelled) };
    Some((lost, filter.with_size(smallest_that_adds_up(request, size))))
}

/// Returns the smallest radius, from the given one on and in thousandths of a pixel, whose weights do not cancel.
fn smallest_that_adds_up(request: &Request, radius: f64) -> f64 {
    if !cancels(request, radius) {
        return radius;
    }
    let is_enough = |thousandths: u32| !cancels(request, f64::from(thousandths) / 1000.0);
    const STEP: u32 = 50;
    let first = (radius * 1000.0).ceil() as u32;
    let mut enough = first.next_multiple_of(STEP);
    while !is_enough(enough) {
        enough += STEP;
    }
    let mut too_small = enough - STEP;
    while too_small + 1 < enough {
        let middle = too_small.midpoint(enough);
        *(if middle >= first && is_enough(middle) { &mut enough } else { &mut too_small }) = middle;
    }
    f64::from(enough) / 1000.0
}

/// Returns true if the weights of Mitchell's filter with this radius nearly cancel in some pixel (M is above 2).
fn cancels(request: &Request, radius: f64) -> bool {
    const MOST: f64 = 2.0;
    let Request { filter, sampler, adaptive, size: [width, height], .. } = *request;
    let is_random = matches!(sampler.pattern(), Pattern::Random | Pattern::Jittered) && adaptive.is_none();
    // From this radius on, M above 2 did not occur in a million pixels.
    let wide_enough = if sampler.count() > 2 { 2.0 } else { 3.0 };
    if !is_random || !matches!(filter, Filter::Mitchell { .. }) || radius >= wide_enough {
        return false;
    }
    let filter = filter.with_size(radius);
    let (columns, rows, support) = (request.columns(), request.rows(), filter.support());
    let reach = |range: &Range<usize>, end: usize| {
        range.start.saturating_sub(support)..(range.end + support).min(end)
    };
    // The sums of the weights and of their magnitudes, for the columns that may still get samples.
    let mut open: VecDeque<Vec<[f64; 2]>> = VecDeque::new();
    let mut first = columns.start;
    for column in reach(&columns, width) {
        let sampled = reach(&rows, height);
        let reached = reach(&(column..column + 1), width);
        while first + open.len() < reached.end.min(columns.end) {
            open.push_back(vec![[0.0; 2]; rows.len()]);
        }
        let mut pixels = sampler.pixels((column * height + sampled.start) as u64, 1);
        for row in sampled {
            let near = reach(&(row..row + 1), height);
            for offset in pixels.next_offsets() {
                // The pixel itself and at most three on either side, because the radius is below 3.
                let mut across = [0.0; 7];
                for (weight, other) in across.iter_mut().zip(near.clone()) {
                    *weight = filter.axis_term(offset.y + row as f64 - other as f64);
                }
                for other in reached.clone().filter(|other| columns.contains(other)) {
                    let along = filter.axis_term(offset.x + column as f64 - other as f64);
                    for (weight, other_row) in across.iter().zip(near.clone()) {
                        if rows.contains(&other_row) {
                            let [sum, magnitude] = &mut open[other - first][other_row - rows.start];
                            *sum += along * weight;
                            *magnitude += (along * weight).abs();
                        }
                    }
                }
            }
        }
        while first < columns.end && (first + support <= column || column + 1 == width) {
            let Some(sums) = open.pop_front() else { break };
            first += 1;
            // A sum of zero means that a pixel without weights is black.
            if sums.iter().any(|[sum, magnitude]| *sum == 0.0 || *magnitude > MOST * sum.abs()) {
                return true;
            }
        }
    }
    false
}

/// Returns the smallest size of the filter that reaches a position within the pixel. The current size must not reach
/// it.
fn smallest(filter: Filter, position: DVec2) -> f64 {
    // The pixel lies within every filter of its own width, and within much narrower Gaussians.
    let (mut too_small, mut enough) = (filter.size().to_bits(), 1.0_f64.to_bits());
    // Positive floats are in the order of their bits.
    while too_small + 1 < enough {
        let middle = too_small + (enough - too_small) / 2;
        if reaches(filter.with_size(f64::from_bits(middle)), position) {
            enough = middle;
        } else {
            too_small = middle;
        }
    }
    f64::from_bits(enough)
}

/// Returns true if a sample at this position counts. The weights of a Gaussian end at subnormal numbers.
fn reaches(filter: Filter, position: DVec2) -> bool {
    filter.weight(position).abs() >= f64::MIN_POSITIVE
}

/// Returns the sample that the narrowest filter of this kind reaches.
fn nearest(filter: Filter, offsets: impl Iterator<Item = DVec2>) -> Option<DVec2> {
    offsets.min_by(|a, b| distance(filter, *a).total_cmp(&distance(filter, *b)))
}

/// Returns the distance of a sample from the centre in the filter's own norm.
fn distance(filter: Filter, offset: DVec2) -> f64 {
    match filter {
        Filter::Box { .. } | Filter::Mitchell { .. } => offset.abs().max_element(),
        Filter::Tent { .. } | Filter::Gaussian { .. } => offset.length_squared(),
    }
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

/// Returns the farthest among all pixels' nearest samples, and the number of pixels without a sample in the filter.
fn farthest_of_random(request: &Request) -> Option<(DVec2, Lost)> {
    let Request { filter, sampler, size: [_, height], .. } = *request;
    let (mut farthest, mut lost): (Option<DVec2>, usize) = (None, 0);
    for column in request.columns() {
        let rows = request.rows();
        let mut pixels = sampler.pixels((column * height + rows.start) as u64, 1);
        for _ in rows {
            let nearest = nearest(filter, pixels.next_offsets())?;
            lost += usize::from(!reaches(filter, nearest));
            if farthest.is_none_or(|farthest| distance(filter, nearest) > distance(filter, farthest)) {
                farthest = Some(nearest);
            }
        }
    }
    Some((farthest?, Lost::Number(lost)))
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
        too_narrow(&request(pattern, count, filter(1e-5))).expect("it is far too narrow").1.size()
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
                let warns = |size: f64| too_narrow(&request(pattern, count, filter(size))).is_some();
                assert!(
                    !warns(size) && warns(size.next_down()) && warns(0.99 * size),
                    "{pattern:?} {count} {size}"
                );
            }
        }
    }

    #[test]
    fn sizes_for_uniform_and_jittered_samples_by_geometry() {
        // Four uniform samples are a quarter of a pixel from the centre along both axes.
        let [square, disk, _, cubic] = FILTERS.map(|filter| named(Pattern::Uniform, 4, filter));
        assert_eq!([square, cubic], [0.25, 0.25_f64.next_up()]);
        assert_eq!(disk, (2.0 * 0.25_f64 * 0.25).sqrt().next_up());
        // One of four jittered samples is at most as far as a corner of the pixel.
        let [square, disk, ..] = FILTERS.map(|filter| named(Pattern::Jittered, 4, filter));
        assert_eq!(square, 0.5);
        assert!((disk - 0.5_f64.sqrt()).abs() < 1e-15);
        // Nine jittered samples have one in the middle stratum. Eight have none there along one axis.
        assert_eq!(named(Pattern::Jittered, 9, FILTERS[0]), 1.0 / 6.0);
        assert_eq!(named(Pattern::Jittered, 8, FILTERS[0]), 0.5);
        assert!(too_narrow(&request(Pattern::Uniform, 9, Filter::Tent { radius: 1e-6 })).is_none());
    }

    #[test]
    fn the_default_filter_is_wide_enough_for_any_samples() {
        for pattern in [Pattern::Uniform, Pattern::Jittered, Pattern::Random] {
            assert!((1..70).all(|count| too_narrow(&request(pattern, count, Filter::PIXEL)).is_none()));
        }
        let adaptive = Sampler::of_adaptive(Drand48::UNSEEDED);
        assert!(too_narrow(&Request { sampler: adaptive, ..Request::new([9, 9]) }).is_none());
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
                    assert_eq!(cancels(&all, radius), worst > 2.0, "{radius} {pattern:?} {count} {worst}");
                    found[usize::from(worst > 2.0)] += 1;
                }
            }
        }
        assert!(found.iter().all(|&count| count > 20), "{found:?}");
    }

    #[test]
    fn the_named_radius_is_the_smallest_whose_weights_do_not_cancel() {
        for (pattern, count) in [(Pattern::Random, 1), (Pattern::Random, 4), (Pattern::Jittered, 4)] {
            let of = |radius: f64| request(pattern, count, Filter::Mitchell { radius });
            let Some((Lost::Cancelled, smallest)) = too_narrow(&of(0.9)) else {
                unreachable!("weights cancel")
            };
            let radius = smallest.size();
            assert!(too_narrow(&of(radius)).is_none() && (0.9..=3.0).contains(&radius));
            let twentieths = (19..).map(|n| f64::from(n) / 20.0).take_while(|&less| less < radius);
            let less = twentieths.chain([radius - 0.001]);
            assert!(less.into_iter().all(|less| too_narrow(&of(less)).is_some()), "{radius}");
        }
        let none = [
            (Pattern::Uniform, 1, 0.6),
            (Pattern::Uniform, 4, 0.8),
            (Pattern::Random, 4, 2.0),
            (Pattern::Jittered, 16, 1.0),
        ];
        for (pattern, count, radius) in none {
            assert!(
                too_narrow(&request(pattern, count, Filter::Mitchell { radius })).is_none(),
                "{pattern:?} {count}"
            );
        }
        let adaptive = Sampler::of_adaptive(Drand48::UNSEEDED);
        let request =
            Request { filter: Filter::Mitchell { radius: 0.8 }, sampler: adaptive, ..Request::new([40, 30]) };
        let adaptive = Some(crate::sampling::adaptive::Adaptive { most: 16, error: 2.0 });
        assert!(too_narrow(&Request { adaptive, ..request }).is_none());
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
            let expected = (0..1200).filter(is_lost).count();
            assert_eq!(too_narrow(&request).map(|(lost, _)| lost), Some(Lost::Number(expected)));
            // The pixels of one column and five rows.
            let window = Some(Window { x: 7, y: 3, width: 1, height: 5 });
            let expected = (7 * 30 + 22..7 * 30 + 27).filter(is_lost).count();
            let lost = too_narrow(&Request { window, ..request }).map(|(lost, _)| lost);
            assert_eq!(lost, (expected > 0).then_some(Lost::Number(expected)));
        }
    }
}
