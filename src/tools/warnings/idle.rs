//! Flags that change nothing, as far as the other flags tell.

use super::Warning;
use super::filter::flag_of;
use crate::render::{Layer, Request};
use crate::sampling::filter::Filter;
use crate::sampling::sampler::Pattern;
use crate::scene::edition::Edition;
use crate::trace::{Effects, Shadows};
use glam::DVec2;
use std::fmt;

/// Why a flag changes nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Idle {
    /// `-bounces`: no object reflects or transmits light.
    NothingBounces,
    /// `-bounces`: no ray weighs more than this value of `-weight`.
    EndedByWeight(f64),
    /// `-weight`: there is no `-bounces`.
    NoBounces,
    /// `-transparent_shadows`: no object transmits light.
    NothingTransmits,
    /// `-seed`: there are no random numbers.
    NothingRandom,
    /// A filter: it weighs nothing but the only sample of a pixel.
    OneSample,
    /// All that shapes colours: only other pictures are asked for.
    NoColors,
    /// `-shade_back`: surfaces are lit as from outside, whichever side is seen.
    LitAsOutside,
}

impl fmt::Display for Idle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NothingBounces => f.write_str("effect: no object reflects or transmits light"),
            Self::EndedByWeight(weight) => {
                write!(f, "effect: `-weight {weight}` ends all rays that are reflected or transmitted")
            }
            Self::NoBounces => f.write_str("effect without `-bounces`"),
            Self::NothingTransmits => {
                f.write_str("effect beyond that of `-shadows`: no object transmits light")
            }
            Self::NothingRandom => f.write_str("effect: no samples are random, jittered or adaptive"),
            Self::OneSample => f.write_str("effect: it weighs only the sample at the pixel's centre"),
            Self::LitAsOutside => {
                f.write_str("effect in this edition: surfaces look the same from both sides")
            }
            Self::NoColors => f.write_str("effect: no picture of colours is asked for"),
        }
    }
}

/// Warnings about `-seed` without random numbers, and about a filter that weighs only one sample. A picture of the
/// filter shows it all the same.
pub fn sampling_without_effect(request: &Request) -> Vec<Warning> {
    let Request { sampler, filter, .. } = *request;
    let idle = |flag: String, reason: Idle| Warning::IdleFlags { flags: vec![flag], reason };
    let seed = sampler.rng().seed().filter(|_| sampler.pattern() == Pattern::Uniform);
    let is_shown = request.layers.iter().any(|layer| matches!(layer, Layer::Filter { .. }));
    let weighs_one = filter.support() == 0 || filter.weight(DVec2::X) == 0.0;
    let is_idle = filter != Filter::PIXEL && sampler.is_center() && weighs_one && !is_shown;
    seed.map(|seed| idle(format!("-seed {seed}"), Idle::NothingRandom))
        .into_iter()
        .chain(is_idle.then(|| idle(flag_of(&filter), Idle::OneSample)))
        .collect()
}

/// A warning about the flags that shape colours, for a request that shows none. They are those of an edition of the course.
pub fn colors_not_asked_for(request: &Request, edition: Edition) -> Option<Warning> {
    let Request { effects, sampler, adaptive, filter, .. } = *request;
    let Effects { shadows, shade_back, bounces, min_weight } = effects;
    let is_shown = request.layers.iter().any(|layer| matches!(layer, Layer::Filter { .. }));
    let samples = match (adaptive, sampler.pattern()) {
        (Some(adaptive), _) => Some(format!("-adaptive_samples {} {}", adaptive.most, adaptive.error)),
        (None, Pattern::Displaced) => Some("-jitter".into()),
        (None, Pattern::Uniform) if sampler.is_center() => None,
        (None, pattern) => Some(format!("-{} {}", pattern.flag(edition), sampler.count())),
    };
    let flags: Vec<String> = [
        shade_back.then(|| "-shade_back".into()),
        match shadows {
            Shadows::None => None,
            Shadows::Opaque => Some("-shadows".into()),
            Shadows::Transparent => Some("-transparent_shadows".into()),
        },
        (bounces > 0).then(|| format!("-bounces {bounces}")),
        (min_weight != edition.default_weight()).then(|| format!("-weight {min_weight}")),
        samples,
        sampler.rng().seed().map(|seed| format!("-seed {seed}")),
        (filter != Filter::PIXEL && !is_shown).then(|| flag_of(&filter)),
    ]
    .into_iter()
    .flatten()
    .collect();
    (!flags.is_empty()).then_some(Warning::IdleFlags { flags, reason: Idle::NoColors })
}
