//! Warns about a scene and its flags, or ends the run for it as `-strict` asks.

use super::End;
use super::log::Log;
use raytracer::cli::{Comparison, Options};
use raytracer::diagnostic::{Diagnostic, Severity};
use raytracer::render::{Layer, Request};
use raytracer::scene::edition::Edition;
use raytracer::scene::load::{LoadedScene, Source};
use raytracer::tools::warnings;
use raytracer::trace::Effects;

/// Tells these notes and warnings. With `-strict` warnings are errors, and end the run.
pub fn say(all: Vec<Diagnostic>, options: &Options, source: &Source, log: &Log) -> Result<(), End> {
    let mut ends = false;
    for mut found in all {
        if options.strict && found.severity != Severity::Note {
            (found.severity, ends) = (Severity::Error, true);
        }
        log.tell(if found.places.is_empty() { found } else { source.locate(found) });
    }
    if ends { Err(End { error: None, status: 1 }) } else { Ok(()) }
}

/// Returns the notes and warnings about a scene and the flags that it is rendered with.
pub fn about_scene(loaded: &mut LoadedScene, options: &Options) -> Vec<Diagnostic> {
    let scene = &loaded.scene;
    let mut found = std::mem::take(&mut loaded.warnings);
    found.extend(loaded.choice.remark());
    found.extend(warnings::no_lights(scene));
    if asks_for_nothing(options) {
        found.push(Diagnostic::warning("nothing is written: add `-output file.tga`"));
    }
    found.extend(warnings::triangles_without_area(scene, &loaded.meshes));
    // The user has not asked for the bounces of an edition.
    let effects = Effects { bounces: options.given.bounces.unwrap_or(0), ..options.effects };
    let request = Request { effects, ..options.request() };
    if !shows_colors(options) {
        found.extend(warnings::colors_not_asked_for(&request, options.edition.unwrap_or_default()));
        return found;
    }
    // `-bounces 0` is meant. In later editions every material with a highlight can mirror, so not to bounce is no
    // mistake.
    let is_meant = options.given.bounces == Some(0) || options.edition.unwrap_or_default() != Edition::Y2004;
    found.extend(warnings::about_colors(scene, &request, is_meant));
    found
}

/// Returns true if the run computes the colours of pixels for its pictures, its text or its page.
fn shows_colors(options: &Options) -> bool {
    let has_layer = |layer: &Layer| matches!(layer, Layer::Color | Layer::Samples { .. } | Layer::Cost(_));
    options.outputs.iter().any(|output| has_layer(&output.layer))
        || options.comparison.as_ref().is_some_and(Comparison::needs_scene)
        || options.stats
        || options.pixel.is_some()
        || options.page.is_some()
        || options.outputs.is_empty()
}

/// Returns true if a run would neither write nor print anything.
fn asks_for_nothing(options: &Options) -> bool {
    options.written().next().is_none() && !options.has_text() && !options.preview
}
