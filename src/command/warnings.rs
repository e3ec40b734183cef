//! Warns of what is doubtful about a scene and its flags, or ends the run for it as `-strict` asks.

use super::log::Log;

use raytracer::cli::{Comparison, Options};
use raytracer::render::{Layer, Request};
use raytracer::scene::edition::Edition;
use raytracer::scene_io::{LoadedScene, Source};
use raytracer::tools::warnings::{self, Severity, Warning};
use raytracer::trace::Effects;

/// Prints these warnings. With `-strict` they are the error that ends the program.
pub fn say(found: &[Warning], options: &Options, source: &Source, log: &Log) -> Result<(), String> {
    let severity = if options.strict { Severity::Error } else { Severity::Warning };
    let lines = warnings::render_all(found, source, severity);
    if options.strict && !lines.is_empty() {
        return Err(lines.join("\n"));
    }
    lines.iter().for_each(|line| log.tell(line));
    Ok(())
}

/// Returns what is doubtful about a scene and the flags that it is rendered with.
pub fn about_scene(loaded: &mut LoadedScene, options: &Options) -> Vec<Warning> {
    let scene = &loaded.scene;
    // Nobody has asked for the bounces of an edition.
    let effects = &Effects { bounces: options.given.bounces.unwrap_or(0), ..options.effects };
    let mut found: Vec<Warning> =
        std::mem::take(&mut loaded.warnings).into_iter().map(Warning::Text).collect();
    found.extend(loaded.choice.doubt().map(Warning::OpenEdition));
    if scene.lights.is_empty() {
        found.push(Warning::NoLights);
    }
    if asks_for_nothing(options) {
        found.push(Warning::NoPicture);
    }
    found.extend(warnings::triangles_without_area(scene, &loaded.meshes));
    let request = Request { effects: *effects, ..options.request() };
    if !shows_colors(options) {
        found.extend(warnings::colors_not_asked_for(&request, options.edition.unwrap_or_default()));
        return found;
    }
    // `-bounces 0` is meant. In later editions every material with a highlight mirrors if it is asked to, and is not
    // doubtful without.
    let is_meant = options.given.bounces == Some(0) || options.edition.unwrap_or_default() != Edition::Y2004;
    // Where the cells of the grid are drawn no ray bounces.
    if !options.visualize_grid {
        found.extend(warnings::rays_without_effect(scene, effects, is_meant));
        found.extend(warnings::rays_not_followed(scene, effects, is_meant));
        found.extend(warnings::black_inside(scene, effects));
        found.extend(warnings::too_many_rays(scene, effects));
    }
    found.extend(warnings::sampling_without_effect(&request));
    found.extend(warnings::narrow_filter(&request));
    found
}

/// Whether the colours of pixels are computed for anything that the run leaves behind, or shows.
fn shows_colors(options: &Options) -> bool {
    let has_layer = |layer: &Layer| matches!(layer, Layer::Color | Layer::Samples { .. } | Layer::Cost(_));
    options.outputs.iter().any(|output| has_layer(&output.layer))
        || options.comparison.as_ref().is_some_and(Comparison::needs_scene)
        || options.stats
        || options.pixel.is_some()
        || options.page.is_some()
        || options.outputs.is_empty()
}

/// Whether a run would leave nothing behind.
fn asks_for_nothing(options: &Options) -> bool {
    let prints =
        options.stats || options.repeat.is_some() || options.pixel.is_some() || options.json.is_some();
    options.outputs.is_empty() && options.comparison.is_none() && !prints && !options.preview
}
