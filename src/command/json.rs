//! The JSON document of a run: everything that it reports, in the form that `docs/json.md` describes.

use super::compare::ComparisonResult;
use super::report::Report;
use raytracer::cli::Options;
use raytracer::render::Tracing;
use raytracer::render::renderer::Renderer;
use raytracer::scene::material::{Material, Pattern, Texture};
use raytracer::scene::{Light, Object};
use raytracer::tools::compare::Tolerance;
use raytracer::tools::explain::{CostMap, PixelTree};
use raytracer::world::shape::Shape;
use serde::Serialize;
use serde_json::{Value, json};

/// The version of the form. It changes when a member is removed, renamed, or gets another meaning, and stays when one
/// is added.
const FORMAT: u32 = 1;

/// Returns the document in one line. Numbers have all their digits; NaN and infinities are null.
pub fn document(report: &Report, options: &Options, warnings: &[String]) -> String {
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
    let ComparisonResult { comparison, cause, tolerance } = result;
    let above = |levels| comparison.pixels_differing_by_more_than(levels);
    let check = |tolerance: &Tolerance| {
        joined(tolerance, json!({ "pixels_above": above(tolerance.levels), "passes": result.passes() }))
    };
    json!({
        "size": comparison.size,
        "pixels": comparison.pixels(),
        "pixels_that_differ": comparison.pixels_that_differ(),
        "by_more_than_one_level": above(1),
        "largest": comparison.largest,
        "root_mean_square_error": comparison.root_mean_square_error,
        // In dB; null, for infinity, if the pictures are equal.
        "psnr": comparison.psnr(),
        "mean_flip": comparison.mean_flip,
        "differing_beside_an_edge": comparison.differing_near_edges,
        "tolerance": tolerance.as_ref().map(check),
        "cause": cause.as_ref().map(|cause| joined(cause, json!({ "text": cause.to_string() }))),
    })
}

/// Returns an object with the members of both.
fn joined(first: &impl Serialize, second: Value) -> Value {
    let mut all = json!(first);
    if let (Some(all), Value::Object(second)) = (all.as_object_mut(), second) {
        all.extend(second);
    }
    all
}
