//! The plan: the settings to measure for a scene, and their order. It contains only settings that the scene can show.

use super::setting::{Axis, Setting};
use crate::caster::choose::{Resolution, Structure};
use crate::render::Request;
use crate::render::adaptive::Adaptive;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::{Pattern, Sampler};
use crate::scene::Scene;
use crate::scene::material::Material;
use crate::tools::causes::has_secondary_rays;
use crate::trace::Effects;
use crate::world::World;

/// The numbers of samples for each pattern.
const COUNTS: [u32; 5] = [1, 4, 16, 64, 256];

/// The estimated errors of adaptive settings, in levels, and their largest number of samples.
const ADAPTIVE_ERRORS: [f64; 5] = [8.0, 4.0, 2.0, 1.0, 0.5];
const ADAPTIVE_MOST: u32 = 256;

/// The numbers of jittered samples used to measure bounces, weights and octaves, and to measure structures.
const EFFECTS_SAMPLES: u32 = 64;
const STRUCTURE_SAMPLES: u32 = 4;

const FILTERS: [Filter; 4] = [
    Filter::PIXEL,
    Filter::Tent { radius: 1.0 },
    Filter::Gaussian { sigma: 0.5 },
    Filter::Mitchell { radius: 2.0 },
];

const WEIGHTS: [f64; 4] = [0.01, 0.03, 0.1, 0.3];

/// The largest number of ray-primitive tests for which the list of all primitives is measured.
const MOST_TESTS: f64 = 5e10;

/// Returns the settings to measure, in a list for each filter. No list is empty. The first list has the filter of `own`,
/// the setting that defines the reference.
pub fn plan(scene: &Scene, world: &World, own: &Setting) -> Vec<Vec<Setting>> {
    let mut first = samples(own.clone());
    if !first.iter().any(|setting| setting.samples_flag() == own.samples_flag()) {
        first.push(own.clone());
    }
    first.extend(secondary(scene, own));
    first.extend(octaves(scene, own));
    first.extend(structures(world, own));
    let is_other =
        |filter: &Filter| std::mem::discriminant(filter) != std::mem::discriminant(&own.request.filter);
    let with_filter = |filter| Request { filter, ..own.request.clone() };
    let others = FILTERS.into_iter().filter(is_other);
    let others = others.map(|filter| samples(Setting { request: with_filter(filter), ..own.clone() }));
    std::iter::once(first).chain(others).collect()
}

/// Returns all kinds and numbers of samples, each kind from the cheapest on.
fn samples(base: Setting) -> Vec<Setting> {
    let rng = base.request.sampler.rng();
    let fixed = [Pattern::Random, Pattern::Uniform, Pattern::Jittered, Pattern::Sobol]
        .into_iter()
        .flat_map(|pattern| COUNTS.map(|count| (Sampler::new(pattern, count, rng), None)));
    let adaptive = ADAPTIVE_ERRORS.map(|error| Some(Adaptive { most: ADAPTIVE_MOST, error }));
    let adaptive = adaptive.map(|adaptive| (Sampler::of_adaptive(rng), adaptive));
    let request = |(sampler, adaptive)| Request { sampler, adaptive, ..base.request.clone() };
    fixed.chain(adaptive).map(|samples| Setting { request: request(samples), ..base.clone() }).collect()
}

/// Returns a request with this number of jittered samples.
fn jittered(own: &Setting, count: u32) -> Request {
    let sampler = Sampler::new(Pattern::Jittered, count, own.request.sampler.rng());
    Request { sampler, adaptive: None, ..own.request.clone() }
}

/// Returns settings with fewer bounces and larger weights than requested, if there are mirrors or glass.
fn secondary(scene: &Scene, own: &Setting) -> Vec<Setting> {
    let own_effects = own.request.effects;
    let Effects { bounces, min_weight, .. } = own_effects;
    if bounces == 0 || !has_secondary_rays(scene) {
        return vec![];
    }
    let fewer = std::iter::once(0).chain(powers_below(bounces));
    let fewer = fewer.map(|bounces| Effects { bounces, ..own_effects });
    let heavier = WEIGHTS.into_iter().filter(|&weight| weight > min_weight);
    let heavier = heavier.map(|min_weight| Effects { min_weight, ..own_effects });
    let request = |effects| Request { effects, ..jittered(own, EFFECTS_SAMPLES) };
    fewer
        .chain(heavier)
        .map(|effects| Setting { axis: Axis::Secondary, request: request(effects), ..own.clone() })
        .collect()
}

/// Returns the powers of two below a number.
fn powers_below(end: u32) -> impl Iterator<Item = u32> {
    std::iter::successors(Some(1u32), |n| n.checked_mul(2)).take_while(move |&n| n < end)
}

/// Returns settings with fewer octaves than the scene has, if it has noise.
fn octaves(scene: &Scene, own: &Setting) -> Vec<Setting> {
    let mut materials = scene.materials.clone();
    let most =
        materials.iter_mut().filter_map(Material::octaves_mut).map(|octaves| *octaves).max().unwrap_or(0);
    let request = jittered(own, EFFECTS_SAMPLES);
    let setting = |octaves| Setting { axis: Axis::Octaves(octaves), request: request.clone(), ..own.clone() };
    powers_below(most).map(setting).collect()
}

/// Returns the scene with each noise limited to `most` octaves.
pub fn with_octaves(scene: &Scene, most: u32) -> Scene {
    let mut changed = scene.clone();
    for octaves in changed.materials.iter_mut().filter_map(Material::octaves_mut) {
        *octaves = most.min(*octaves);
    }
    changed
}

/// Returns the other structures for tracing rays. For a world of planes only, there is nothing to build.
fn structures(world: &World, own: &Setting) -> Vec<Setting> {
    if world.finite_count() == 0 {
        return vec![];
    }
    let list =
        (brute_force_tests(world, &own.request, STRUCTURE_SAMPLES) <= MOST_TESTS).then_some(Structure::List);
    let grids = [Resolution::Auto, Resolution::Cells([10; 3]), Resolution::Cells([40; 3])];
    let others = list.into_iter().chain(grids.map(Structure::Grid));
    let request = |structure| Request { structure, ..jittered(own, STRUCTURE_SAMPLES) };
    others
        .filter(|&structure| structure != own.request.structure)
        .map(|structure| Setting { axis: Axis::Structure, request: request(structure), ..own.clone() })
        .collect()
}

/// Returns about how many ray-primitive tests brute force makes for a picture with this number of samples per pixel.
pub fn brute_force_tests(world: &World, request: &Request, samples: u32) -> f64 {
    let rays = 1 + world.lights.len() + request.effects.bounces as usize;
    let [width, height] = request.size.map(|side| side as f64);
    width * height * f64::from(samples) * rays as f64 * world.ids().len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::edition::Edition;
    use crate::scene::parser::parse;

    fn settings(materials: &str, bounces: u32) -> Vec<Setting> {
        let scene = parse(&format!(
            "OrthographicCamera {{ center 0 0 9 direction 0 0 -1 up 0 1 0 size 2 }}
             Materials {{ {materials} }}
             Group {{ numObjects 1 MaterialIndex 0 Sphere {{ center 0 0 0 radius 1 }} }}"
        ))
        .unwrap();
        let request = Request { effects: Effects { bounces, ..Effects::default() }, ..Request::new([4, 4]) };
        let world = World::new(&scene, &[]).unwrap();
        let own = Setting::new(request, Edition::Y2004);
        plan(&scene, &world, &own).concat()
    }

    fn of(axis: Axis, settings: &[Setting]) -> Vec<String> {
        settings.iter().filter(|setting| setting.axis == axis).map(Setting::label).collect()
    }

    #[test]
    fn only_what_the_scene_can_show_is_measured() {
        let matt = settings("numMaterials 1 Material { }", 5);
        assert_eq!(of(Axis::Samples, &matt).len(), 4 * 25, "four filters");
        assert!(of(Axis::Secondary, &matt).is_empty() && of(Axis::Octaves(1), &matt).is_empty());
        let structures = [" -grid none", " -grid auto", " -grid 10 10 10", " -grid 40 40 40"];
        assert_eq!(of(Axis::Structure, &matt), structures.map(|flag| format!("-jittered_samples 4{flag}")));
        let mirror = "numMaterials 1 Material { reflectiveColor 1 1 1 }";
        assert!(of(Axis::Secondary, &settings(mirror, 0)).is_empty());
        let flags = [" -bounces 0", " -bounces 1", " -bounces 2", " -bounces 4"].map(str::to_owned);
        let weights = [0.01, 0.03, 0.1, 0.3].map(|weight| format!(" -bounces 5 -weight {weight}"));
        let expected = flags.into_iter().chain(weights).map(|flags| format!("-jittered_samples 64{flags}"));
        assert_eq!(of(Axis::Secondary, &settings(mirror, 5)), expected.collect::<Vec<_>>());
        let noise =
            "numMaterials 3 Material { } Material { } Noise { materialIndex 0 materialIndex 1 octaves 3 }";
        let expected = [1, 2].map(|n| format!("-jittered_samples 64 with at most {n} octaves in the scene"));
        let found = [1, 2].map(|octaves| of(Axis::Octaves(octaves), &settings(noise, 5)));
        assert_eq!(found.concat(), expected);
    }
}
