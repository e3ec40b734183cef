//! Warns about flags without effect, judged by the other flags.

use super::filter::flag_of;
use super::have;
use crate::diagnostic::Diagnostic;
use crate::render::{Layer, Request};
use crate::sampling::filter::Filter;
use crate::sampling::sampler::Pattern;
use crate::scene::edition::Edition;
use crate::trace::{Effects, Shadows};
use glam::DVec2;

/// Warns about `-seed` without random numbers, and about a filter that weighs only one sample. A picture of the filter
/// still shows it.
pub fn sampling_without_effect(request: &Request) -> Vec<Diagnostic> {
    let Request { sampler, filter, .. } = *request;
    let seed = sampler
        .rng()
        .seed()
        .filter(|_| sampler.pattern() == Pattern::Uniform)
        .map(|seed| format!("`-seed {seed}` has no effect: no samples are random, jittered or adaptive"));
    let weighs_one = filter.support() == 0 || filter.weight(DVec2::X) == 0.0;
    let is_idle = filter != Filter::PIXEL && sampler.is_center() && weighs_one && !shows_filter(request);
    let filter = is_idle.then(|| {
        format!("`{}` has no effect: it weighs only the sample at the pixel's centre", flag_of(&filter))
    });
    seed.into_iter().chain(filter).map(Diagnostic::warning).collect()
}

/// Warns about an edition's flags that affect colours, if the request shows no colours.
pub fn colors_not_asked_for(request: &Request, edition: Edition) -> Option<Diagnostic> {
    let Request { effects, sampler, adaptive, filter, .. } = *request;
    let Effects { shadows, shade_back, bounces, min_weight } = effects;
    let samples = match (adaptive, sampler.pattern()) {
        (Some(adaptive), _) => Some(format!("-adaptive_samples {} {}", adaptive.most, adaptive.error)),
        (None, Pattern::Displaced) => Some("-jitter".into()),
        (None, Pattern::Uniform) if sampler.is_center() => None,
        (None, pattern) => Some(format!("-{} {}", pattern.flag(edition), sampler.count())),
    };
    let flags = [
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
        (filter != Filter::PIXEL && !shows_filter(request)).then(|| flag_of(&filter)),
    ];
    let flags: Vec<String> = flags.into_iter().flatten().map(|flag| format!("`{flag}`")).collect();
    let message =
        || format!("{} {} no effect: no colour picture is rendered", flags.join(", "), have(flags.len()));
    (!flags.is_empty()).then(|| Diagnostic::warning(message()))
}

fn shows_filter(request: &Request) -> bool {
    request.layers.iter().any(|layer| matches!(layer, Layer::Filter { .. }))
}
