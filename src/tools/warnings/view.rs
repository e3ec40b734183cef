//! Warns about pictures that show nothing of the scene, and says where to look.

use super::Warning;
use crate::diagnostic::Diagnostic;
use crate::math::aabb::Aabb;
use crate::math::robust::unit;
use crate::picture::Color;
use crate::render::renderer::Prepared;
use crate::render::{Layer, Request, Watch};
use crate::scene::Camera;
use glam::DVec2;
use std::ops::ControlFlow;

/// Warns if no ray through a pixel's centre hits anything. This takes as long as rendering such a picture up to the
/// first row with a hit, so call it only for a picture of one colour. Returns `None` if `watch` ends it.
pub fn nothing_visible(prepared: &Prepared, request: &Request, watch: Watch) -> Option<Diagnostic> {
    let renderer = prepared.renderer();
    let (world, at) = (renderer.world(), renderer.scene.positions.camera);
    let warning = |(why, hint)| Some(Diagnostic::from(Warning::NothingVisible { why, hint }).at(at));
    if world.ids().is_empty() {
        return warning((": the scene has no objects", None));
    }
    let centers =
        Request { layers: vec![Layer::SignedNormals], camera: request.camera, ..Request::new(request.size) };
    // Normals have unit length. They are zero where nothing is hit.
    let mut take_row = |_: usize, row: &[Color]| match row.iter().all(|&color| color == Color::ZERO) {
        true => ControlFlow::Continue(()),
        false => ControlFlow::Break(()),
    };
    prepared.render_rows(&centers, watch, &mut take_row).ok()?;
    // With planes, or gaps between objects, there is nothing to advise.
    let bounds = renderer.bounds().filter(|_| world.planes.is_empty());
    warning(bounds.map_or(("", None), |bounds| reason(prepared, &centers, bounds)))
}

/// Returns why nothing in these bounds is visible, as the end of a sentence, and advice.
fn reason(prepared: &Prepared, request: &Request, bounds: Aabb) -> (&'static str, Option<String>) {
    let [width, height] = request.size.map(|side| side as f64);
    let (middle, corners) = ((bounds.min + bounds.max) / 2.0, bounds.corners());
    let (center, is_perspective, ahead) = match request.camera.unwrap_or(prepared.renderer().scene.camera) {
        Camera::Perspective { center, direction, .. } => (center, true, unit(direction)),
        Camera::Orthographic { center, direction, .. } => (center, false, unit(direction)),
    };
    let hint = match is_perspective {
        true => {
            let way = middle - center;
            // Adding zero turns a negative zero into zero.
            let short = |x: f64| ((x * 1000.0).round() / 1000.0 + 0.0).to_string();
            let [x, y, z] = (way / way.abs().max_element()).to_array().map(short);
            format!("`direction {x} {y} {z}` looks at the middle of the scene")
        }
        false => "move the camera's `center`".into(),
    };
    if is_perspective && corners.iter().all(|corner| (corner - center).dot(ahead) <= 0.0) {
        return (": the scene is behind the camera", Some(hint));
    }
    // Two neighbouring corners of the picture span a plane that divides what may be seen from what is beside it.
    let camera = prepared.camera(request);
    let ray = |x: f64, y: f64| camera.ray(DVec2::new(x, y), DVec2::ZERO);
    let seen = ray((width - 1.0) / 2.0, (height - 1.0) / 2.0).at(1.0);
    let (right, top) = (width - 0.5, height - 0.5);
    let sides = [(-0.5, -0.5), (right, -0.5), (right, top), (-0.5, top)].map(|(x, y)| ray(x, y));
    let is_beside = |side: usize| {
        let (a, b) = (&sides[side], &sides[(side + 1) % 4]);
        let out = a.direction.cross(b.at(1.0) - a.origin);
        let out = if out.dot(seen - a.origin) > 0.0 { -out } else { out };
        corners.iter().all(|&corner| out.dot(corner - a.origin) > 0.0)
    };
    if (0..4).any(is_beside) {
        return (": the camera looks away from the scene", Some(hint));
    }
    // A step to the next pixel, as far away as the scene, is longer than the scene in its direction.
    let distance = (middle - center).length();
    let is_small = |x: f64, y: f64| {
        let step = ray(x, y).at(distance) - ray(0.0, 0.0).at(distance);
        unit(step).abs().dot(bounds.extent()) < step.length()
    };
    if is_small(1.0, 0.0) && is_small(0.0, 1.0) {
        let hint = "a smaller `angle` or `size` of the camera shows it larger";
        return (": the scene is smaller than a pixel", Some(hint.into()));
    }
    ("", None)
}
