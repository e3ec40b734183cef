//! The flags about samples and filters.

use super::error::{CliError, Problem};
use super::flags;
use super::raw::Raw;
use super::values::{bad, finite, whole, wholes};
use crate::sampling::adaptive::Adaptive;
use crate::sampling::drand48::Drand48;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::{Pattern, Sampler};

const SAMPLE_RANGE: (u32, u32) = (1, 65536);
/// The range of the largest number of adaptive samples. A pixel is not divided into more strata.
const ADAPTIVE_RANGE: (u32, u32) = (Adaptive::BASE, Adaptive::LIMIT);
/// The range of filter sizes, in pixels.
const MIN_FILTER: f64 = 1e-6;
const MAX_FILTER: f64 = 1e6;

pub(super) fn sampler(raw: &Raw) -> Result<Sampler, CliError> {
    let seed = raw
        .values(&flags::SEED)?
        .map(|[word]| whole(word, (0, u32::MAX)).map_err(|problem| bad(&flags::SEED, word, problem)));
    let rng = seed.transpose()?.map_or(Drand48::UNSEEDED, Drand48::seeded);
    for (flag, pattern) in [
        (&flags::RANDOM_SAMPLES, Pattern::Random),
        (&flags::UNIFORM_SAMPLES, Pattern::Uniform),
        (&flags::JITTERED_SAMPLES, Pattern::Jittered),
    ] {
        if let Some([count]) = wholes(raw, flag, SAMPLE_RANGE)? {
            return Ok(Sampler::new(pattern, count, rng));
        }
    }
    // The first samples of each pixel.
    Ok(match raw.given(&flags::ADAPTIVE_SAMPLES) {
        true => Sampler::first_of_adaptive(rng),
        false => Sampler::new(Pattern::Uniform, 1, rng),
    })
}

pub(super) fn adaptive(raw: &Raw) -> Result<Option<Adaptive>, CliError> {
    let flag = &flags::ADAPTIVE_SAMPLES;
    let Some([most, error]) = raw.values(flag)? else { return Ok(None) };
    let most = whole(most, ADAPTIVE_RANGE).map_err(|problem| bad(flag, most, problem))?;
    match finite(flag, error)? {
        level if level < 0.0 => Err(bad(flag, error, Problem::Negative)),
        error => Ok(Some(Adaptive { most, error })),
    }
}

pub(super) fn filter(raw: &Raw) -> Result<Filter, CliError> {
    for (flag, filter) in [
        (&flags::BOX_FILTER, (|radius| Filter::Box { radius }) as fn(f64) -> Filter),
        (&flags::TENT_FILTER, |radius| Filter::Tent { radius }),
        (&flags::GAUSSIAN_FILTER, |sigma| Filter::Gaussian { sigma }),
        (&flags::MITCHELL_FILTER, |radius| Filter::Mitchell { radius }),
    ] {
        let Some([word]) = raw.values(flag)? else { continue };
        let size = finite(flag, word)?;
        // The weights are computed with divisions by the size and its square, which must not underflow.
        let is_usable = (MIN_FILTER..=MAX_FILTER).contains(&size);
        return if is_usable { Ok(filter(size)) } else { Err(bad(flag, word, Problem::NotFilterSize)) };
    }
    Ok(Filter::PIXEL)
}
