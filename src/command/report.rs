//! The results of a run that renders or compares, as a text and as a JSON document, whose form `docs/json.md` describes.

use super::compare::ComparisonResult;
use super::log::Log;
use super::outputs::Outputs;
use super::{End, Outcome};
use crate::cli::{Options, Output};
use crate::image_io::OutputFile;
use crate::render::Tracing;
use crate::render::renderer::Renderer;
use crate::scene::material::{Material, Pattern, Texture};
use crate::scene::{Light, Object};
use crate::stats::{self, Repeats};
use crate::tools::compare::{Brightness, Difference, Tolerance};
use crate::tools::explain::{CostMap, PixelTree};
use crate::world::shape::Shape;
use serde::Serialize;
use serde_json::{Value, json};
use std::fmt::Display;
use std::io::{Write, stderr};
use std::path::Path;

/// The results of a run. A comparison of two files has no scene.
#[derive(Default)]
pub struct Report<'r> {
    pub renderer: Option<&'r Renderer>,
    pub statistics: Option<stats::Report>,
    /// The times of all renderings, if there are several.
    pub repeats: Option<Repeats>,
    pub costs: Option<CostMap>,
    /// The rays behind the pixel in question.
    pub pixel: Option<PixelTree>,
    pub comparison: Option<ComparisonResult>,
}

impl Report<'_> {
    /// Writes the document to this file, gives all files their names, and returns the outcome with the text to print.
    pub fn finish(
        &self,
        options: &Options,
        file: Option<OutputFile>,
        outputs: &Outputs,
        log: &Log,
    ) -> Result<Outcome, End> {
        if let Some(file) = file {
            outputs.add(file.text(&document(self, options, &log.messages()))?)?;
        }
        outputs.name_all()?;
        let mut text = if options.prints_json() { String::new() } else { self.text(options) };
        if options.outputs.iter().any(Output::is_standard_output) {
            let _ = stderr().write_all(text.as_bytes());
            text.clear();
        }
        let passes = self.comparison.as_ref().is_none_or(|compared| compared.passes() != Some(false));
        let written = options.written().map(Path::to_owned);
        Ok(Outcome { passes, ..Outcome::new(text, written, options.progress) })
    }

    fn text(&self, options: &Options) -> String {
        let blocks: [Option<&dyn Display>; 5] = [
            self.statistics.as_ref().filter(|_| options.stats).map(|statistics| statistics as _),
            self.repeats.as_ref().map(|repeats| repeats as _),
            self.costs.as_ref().map(|costs| costs as _),
            self.pixel.as_ref().map(|pixel| pixel as _),
            self.comparison.as_ref().map(|comparison| comparison as _),
        ];
        blocks.into_iter().flatten().map(ToString::to_string).collect()
    }
}

/// The version of the form. It changes when a member is removed, renamed, or gets another meaning, and stays when one
/// is added.
pub const FORMAT: u32 = 1;

/// Returns the document in one line. Numbers have all their digits; NaN and infinities are null.
fn document(report: &Report, options: &Options, warnings: &[String]) -> String {
    let statistics = report.statistics.as_ref();
    let is_counted = options.tracing() == Tracing::Counted;
    let document = json!({
        "format": FORMAT,
        "version": env!("CARGO_PKG_VERSION"),
        "options": options,
        "threads": rayon::current_num_threads(),
        "written": options.pictures().map(|file| file.to_string_lossy()).collect::<Vec<_>>(),
        "warnings": warnings,
        "scene": report.renderer.map(scene),
        "grid": statistics.and_then(|found| found.grid).map(|cells| json!({ "cells": cells })),
        "timings": statistics.map(|found| &found.timings),
        "repeats": report.repeats,
        "statistics": statistics.filter(|_| is_counted).map(|found| &found.counts),
        "standard_error": statistics.and_then(|found| found.standard_error),
        "cost_map": report.costs.as_ref().map(cost_map),
        "pixel": report.pixel.as_ref().map(pixel),
        "comparison": report.comparison.as_ref().map(comparison),
    });
    format!("{document}\n")
}

/// Counts the parts of a scene.
fn scene(renderer: &Renderer) -> Value {
    let (scene, world) = (&renderer.scene, renderer.world());
    let spheres = world.shapes.iter().filter(|shape| matches!(shape, Shape::Sphere(_))).count();
    json!({
        "file": renderer.source.path.to_string_lossy(),
        "lights": counts(&scene.lights, &[
            ("directional", |one| matches!(one, Light::Directional { .. })),
            ("point", |one| matches!(one, Light::Point { .. })),
        ]),
        "materials": counts(&scene.materials, &[
            ("phong", |one| matches!(one, Material::Phong(_) | Material::Painted(..))),
            ("checkerboard", |one| matches!(one, Material::Texture(Texture { pattern: Pattern::Checkerboard, .. }))),
            ("noise", |one| matches!(one, Material::Texture(Texture { pattern: Pattern::Noise { .. }, .. }))),
            ("marble", |one| matches!(one, Material::Texture(Texture { pattern: Pattern::Marble { .. }, .. }))),
            ("wood", |one| matches!(one, Material::Texture(Texture { pattern: Pattern::Wood { .. }, .. }))),
        ]),
        // The nodes of the tree.
        "objects": counts(&scene.objects, &[
            ("groups", |one| matches!(one, Object::Group(_))),
            ("transforms", |one| matches!(one, Object::Transform { .. })),
            ("spheres", |one| matches!(one, Object::Sphere { .. })),
            ("planes", |one| matches!(one, Object::Plane { .. })),
            ("triangles", |one| matches!(one, Object::Triangle { .. })),
            ("boxes", |one| matches!(one, Object::Box { .. })),
            ("meshes", |one| matches!(one, Object::Mesh { .. } | Object::Grid { .. })),
        ]),
        "primitives": {
            "triangles": world.triangles.len(),
            "spheres": spheres,
            "ellipsoids": world.shapes.len() - spheres,
            "planes": world.planes.len(),
        },
        "bounds": renderer.bounds(),
    })
}

/// The name of a kind, and a test for it.
type Kind<T> = (&'static str, fn(&T) -> bool);

/// Counts each kind, by its name.
fn counts<T>(all: &[T], kinds: &[Kind<T>]) -> Value {
    let count = |is: fn(&T) -> bool| all.iter().filter(|one| is(one)).count();
    kinds.iter().map(|&(name, is)| (name.to_owned(), Value::from(count(is)))).collect()
}

fn cost_map(map: &CostMap) -> Value {
    let (pixel, count) = map.most_expensive();
    let full_cell = |&(cell, primitives): &_| -> Value { json!({ "cell": cell, "primitives": primitives }) };
    let cells = map.cells.as_ref().map(|cells| {
        let fullest: Vec<Value> = cells.fullest.iter().map(full_cell).collect();
        json!({ "all": cells.cells, "empty": cells.empty, "fullest": fullest })
    });
    let costs = json!({
        "total": map.total(),
        "most_expensive": { "pixel": pixel, "count": count },
        "cells": cells,
    });
    joined(&map.cost, costs)
}

fn pixel(tree: &PixelTree) -> Value {
    let close: Vec<&str> = tree.close_channels().collect();
    joined(tree, json!({ "counts": tree.counts(), "close_channels": close }))
}

fn comparison(result: &ComparisonResult) -> Value {
    let ComparisonResult { difference, drawn, cause, tolerance } = result;
    let above = |levels| difference.pixels_differing_by_more_than(levels);
    let check = |tolerance: &Tolerance| {
        joined(tolerance, json!({ "pixels_above": above(tolerance.levels), "passes": result.passes() }))
    };
    let of_both = json!({
        "pixels": difference.pixels(),
        "pixels_that_differ": difference.pixels_that_differ(),
        "difference_picture": drawn.as_ref().map(brightness),
        "tolerance": tolerance.as_ref().map(check),
        "cause": cause.as_ref().map(|cause| joined(cause, json!({ "text": cause.to_string() }))),
    });
    let of_kind = match difference {
        Difference::Levels(comparison) => json!({
            "kind": "levels",
            "size": comparison.size,
            "by_more_than_one_level": above(1.0),
            "largest": comparison.largest,
            "root_mean_square_error": comparison.root_mean_square_error,
            // In dB; null, for infinity, if the pictures are equal.
            "psnr": comparison.psnr(),
            "mean_flip": comparison.mean_flip,
            "differing_beside_an_edge": comparison.differing_near_edges,
        }),
        Difference::Numbers(comparison) => json!({
            "kind": "numbers",
            "size": comparison.size,
            "largest": comparison.largest,
            "largest_relative": comparison.largest_relative,
            "root_mean_square_error": comparison.root_mean_square_error,
            "not_finite": {
                "a": comparison.not_finite[0],
                "b": comparison.not_finite[1],
                "in_one": comparison.pixels_not_finite_in_one(),
                "first": comparison.first_not_finite.map(|first| first.at),
            },
        }),
    };
    joined(&of_kind, of_both)
}

fn brightness(drawn: &Brightness) -> Value {
    match drawn {
        Brightness::Amplified(factor) => json!({ "amplification": factor }),
        Brightness::Scaled(scale, largest) => joined(scale, json!({ "white_difference": largest })),
    }
}

/// Returns an object with the members of both.
fn joined(first: &impl Serialize, second: Value) -> Value {
    let mut all = json!(first);
    if let (Some(all), Value::Object(second)) = (all.as_object_mut(), second) {
        all.extend(second);
    }
    all
}
