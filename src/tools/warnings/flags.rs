//! Warns about flags without effect, and about materials that need other flags.

use super::filter::narrow_filter;
use crate::diagnostic::{Diagnostic, Position};
use crate::render::{Layer, Request};
use crate::sampling::filter::Filter;
use crate::sampling::sampler::Pattern;
use crate::scene::Scene;
use crate::scene::edition::Edition;
use crate::scene::material::Material;
use crate::scene::model::Highlight;
use crate::trace::{Effects, Shadows};
use glam::DVec2;
use std::collections::BTreeSet;

/// Warns about the flags of a picture of colours. `says_no_bounces` is true if no bounces are meant, as by an explicit
/// `-bounces 0`, which the course's commands combine with `-weight`.
pub fn about_colors(scene: &Scene, request: &Request, says_no_bounces: bool) -> Vec<Diagnostic> {
    // No ray bounces if the cells of the grid are drawn.
    let rays =
        if request.draws_cells { vec![] } else { about_rays(scene, &request.effects, says_no_bounces) };
    rays.into_iter().chain(samples_without_effect(request)).chain(narrow_filter(request)).collect()
}

fn without_effect(flags: &[String], why: &str) -> Diagnostic {
    let named: Vec<String> = flags.iter().map(|flag| format!("`{flag}`")).collect();
    let have = if flags.len() == 1 { "has" } else { "have" };
    Diagnostic::warning(format!("{} {have} no effect{why}", named.join(", ")))
}

/// Warns about `-seed` without random numbers, and about a filter that weighs only one sample. A picture of the filter
/// still shows it.
fn samples_without_effect(request: &Request) -> impl Iterator<Item = Diagnostic> {
    let Request { sampler, filter, .. } = *request;
    let seed = sampler.rng().seed().filter(|_| sampler.pattern() == Pattern::Uniform);
    let why = ": no samples are random";
    let seed = seed.map(|seed| without_effect(&[format!("-seed {seed}")], why));
    let weighs_one = filter.support() == 0 || filter.weight(DVec2::X) == 0.0;
    let is_idle = filter != Filter::PIXEL && sampler.is_center() && weighs_one && !shows_filter(request);
    let filter = is_idle
        .then(|| without_effect(&[filter.flag()], ": only the sample at the pixel's centre has weight"));
    seed.into_iter().chain(filter)
}

/// Warns about an edition's flags that affect colours, if the request shows no colours.
pub fn colors_not_asked_for(request: &Request, edition: Edition) -> Option<Diagnostic> {
    let Request { effects, sampler, filter, .. } = *request;
    let Effects { shadows, shade_back, bounces, .. } = effects;
    let flags = [
        shade_back.then(|| "-shade_back".into()),
        shadows.flag().map(str::to_owned),
        (bounces > 0).then(|| format!("-bounces {bounces}")),
        request.weight_flag(edition),
        (!sampler.is_center()).then(|| request.samples_flag(edition)),
        sampler.rng().seed().map(|seed| format!("-seed {seed}")),
        (filter != Filter::PIXEL && !shows_filter(request)).then(|| filter.flag()),
    ];
    let flags: Vec<String> = flags.into_iter().flatten().collect();
    (!flags.is_empty()).then(|| without_effect(&flags, ": no colour picture is rendered"))
}

fn shows_filter(request: &Request) -> bool {
    request.layers.iter().any(|layer| matches!(layer, Layer::Filter { .. }))
}

/// Warns about flags that affect no ray, and about materials whose rays are not followed or are black from inside.
fn about_rays(scene: &Scene, effects: &Effects, says_no_bounces: bool) -> Vec<Diagnostic> {
    let Effects { bounces, min_weight, shadows, shade_back } = *effects;
    let used = used(scene);
    let heaviest = used.iter().map(|it| it.reflected.max(it.refracted)).fold(0.0, f64::max);
    let is_two_sided = scene.lighting.highlight == Highlight::Phong;
    let (bounced, weighed) = (format!("-bounces {bounces}"), format!("-weight {min_weight}"));
    let of_bounces = match bounces {
        0 if min_weight > 0.0 && !says_no_bounces => Some(without_effect(&[weighed], " without `-bounces`")),
        1.. if heaviest == 0.0 => Some(without_effect(&[bounced], ": no object reflects or transmits light")),
        1.. if heaviest <= min_weight => {
            let why = format!(": `{weighed}` ends all rays that are reflected or transmitted");
            Some(without_effect(&[bounced], &why))
        }
        _ => None,
    };
    let is_untinted = shadows == Shadows::Transparent && used.iter().all(|it| it.refracted == 0.0);
    let why = " beyond that of `-shadows`: no object transmits light";
    let of_shadows = is_untinted.then(|| without_effect(&["-transparent_shadows".into()], why));
    let why = " in this edition: surfaces look the same from both sides";
    let of_back = (shade_back && is_two_sided).then(|| without_effect(&["-shade_back".into()], why));
    let mut found: Vec<_> = [of_bounces, of_shadows, of_back].into_iter().flatten().collect();
    let missing = |it: &Secondary, without: &str, hint: &str| {
        let does = if it.refracted > 0.0 { "transmits" } else { "reflects" };
        let warning = Diagnostic::warning(format!("the material {does} light, but without {without}"));
        warning.with_hint(hint).at(it.at)
    };
    if bounces == 0 && !says_no_bounces {
        let first = used.iter().find(|it| it.reflected > 0.0 || it.refracted > 0.0);
        let hint = "add `-bounces 5`, or `-bounces 0` if that is meant";
        found.extend(first.map(|it| missing(it, "`-bounces` no ray is followed", hint)));
    } else if bounces > 0 && !shade_back && !is_two_sided {
        let first = used.iter().find(|it| it.refracted > min_weight);
        let without = "`-shade_back` it is black from inside";
        found.extend(first.map(|it| missing(it, without, "add `-shade_back`")));
    }
    found
}

/// The secondary rays at a material: the lengths of its reflective and its transparent colour, by which they multiply
/// the weights of rays.
#[derive(Clone, Copy)]
struct Secondary {
    at: Position,
    reflected: f64,
    refracted: f64,
}

/// Returns the secondary rays at each material used by an object.
fn used(scene: &Scene) -> Vec<Secondary> {
    let mut all: Vec<Secondary> = Vec::with_capacity(scene.materials.len());
    for (id, material) in scene.materials.iter().enumerate() {
        let [reflected, refracted] = match material {
            Material::Phong(phong) | Material::Painted(phong, _) => {
                [phong.reflective.length(), phong.transparent.length()]
            }
            // A texture comes after the materials that it mixes.
            Material::Texture(texture) => {
                let children = texture.children.map(|child| all[child]);
                [children.map(|it| it.reflected), children.map(|it| it.refracted)].map(|[a, b]| a.max(b))
            }
        };
        let at = scene.positions.material(id);
        all.push(Secondary { at, reflected, refracted });
    }
    let used: BTreeSet<usize> = scene.objects.iter().filter_map(|object| object.material()).collect();
    used.into_iter().map(|id| all[id]).collect()
}
