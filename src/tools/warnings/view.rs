//! Warns about pictures that show nothing of the scene.

use crate::diagnostic::Diagnostic;
use crate::math::robust::unit;
use crate::picture::Color;
use crate::render::renderer::Prepared;
use crate::render::{Layer, Request, Watch};
use crate::scene::Camera;
use crate::scene::model::Screen;
use glam::DVec3;
use std::ops::ControlFlow;

/// The reason why no ray hits anything, as the end of a sentence, and advice.
type Reason = (&'static str, Option<String>);

/// Formats a coordinate with at most three decimals.
fn short(x: f64) -> String {
    // Adding zero turns a negative zero into zero.
    ((x * 1000.0).round() / 1000.0 + 0.0).to_string()
}

/// Warns if no ray through a pixel's centre hits anything. This takes as long as rendering such a picture up to the
/// first row with a hit, so call it only for a picture that shows nothing but the background. Returns `None` if `watch`
/// ends it.
pub fn nothing_visible(prepared: &Prepared, request: &Request, watch: Watch) -> Option<Diagnostic> {
    let warning = |(reason, hint): Reason| {
        let message = format!("no ray hits anything{reason}");
        Diagnostic { hint, ..Diagnostic::warning(message) }.at(prepared.renderer().scene.positions.camera)
    };
    let world = prepared.renderer().world();
    if world.finite_count() == 0 && world.planes.is_empty() {
        return Some(warning((": the scene has no objects", None)));
    }
    let centers =
        Request { layers: vec![Layer::SignedNormals], camera: request.camera, ..Request::new(request.size) };
    // Normals have unit length. They are zero where nothing is hit.
    let mut take_row = |_: usize, row: &[Color]| match row.iter().all(|&color| color == Color::ZERO) {
        true => ControlFlow::Continue(()),
        false => ControlFlow::Break(()),
    };
    let sees_nothing = prepared.render_rows(&centers, watch, &mut take_row).is_ok();
    sees_nothing.then(|| warning(reason(prepared, &centers)))
}

/// Returns why nothing is visible, judged by the bounds of the objects.
fn reason(prepared: &Prepared, request: &Request) -> Reason {
    let renderer = prepared.renderer();
    // The camera looks at gaps between objects, or there are planes.
    let Some(bounds) = renderer.bounds().filter(|_| renderer.world().planes.is_empty()) else {
        return ("", None);
    };
    let camera = request.camera.unwrap_or(renderer.scene.camera);
    let spread = renderer.scene.model.screen;
    View::new(&camera, request.size, spread).reason(bounds.corners(), (bounds.min + bounds.max) / 2.0)
}

/// Advises a direction to look at.
fn looking_along(direction: DVec3) -> Option<String> {
    let [x, y, z] = (direction / direction.abs().max_element()).to_array().map(short);
    Some(format!("`direction {x} {y} {z}` looks at the middle of the scene"))
}

/// The visible region of a camera, in coordinates to the right, up and ahead.
struct View {
    center: DVec3,
    /// The axes. A vector's coordinates are its products with them.
    axes: [DVec3; 3],
    is_perspective: bool,
    /// Half of the screen's width and height, at distance 1 for a perspective camera.
    half: [f64; 2],
    /// The width and height of a pixel.
    pixel: [f64; 2],
}

impl View {
    fn new(camera: &Camera, size: [usize; 2], spread: Screen) -> Self {
        let (Camera::Orthographic { center, direction, up, .. }
        | Camera::Perspective { center, direction, up, .. }) = *camera;
        let ahead = unit(direction);
        let right = unit(ahead.cross(unit(up)));
        let (is_perspective, screen) = match *camera {
            Camera::Orthographic { size, .. } => (false, size),
            Camera::Perspective { angle, .. } => (true, 2.0 * libm::tan((angle / 2.0).to_radians())),
        };
        let across = right.cross(ahead);
        let longer = size[0].max(size[1]);
        let (spans, axes) = match spread {
            Screen::BothSides { up_as_written } if is_perspective => {
                let up = if up_as_written { up } else { across };
                // `up` may lean. Coordinates along such axes are products with the dual basis.
                let (rise, lean) = (across.dot(up), ahead.dot(up));
                (size.map(|n| (n - 1).max(1)), [right, across / rise, ahead - across * (lean / rise)])
            }
            _ => ([longer; 2], [right, across, ahead]),
        };
        let pixel = spans.map(|span| screen / span as f64);
        let half = [0, 1].map(|axis| size[axis] as f64 * pixel[axis] / 2.0);
        Self { center, axes, is_perspective, half, pixel }
    }

    /// Returns why a box with these corners is not visible.
    fn reason(&self, corners: [DVec3; 8], middle: DVec3) -> Reason {
        let corners = corners.map(|corner| self.axes.map(|axis| axis.dot(corner - self.center)));
        let middle = middle - self.center;
        if self.is_perspective && corners.iter().all(|&[_, _, ahead]| ahead <= 0.0) {
            return (": the scene is behind the camera", looking_along(middle));
        }
        let distance = |ahead: f64| if self.is_perspective { ahead } else { 1.0 };
        let is_beyond = |axis: usize, sign: f64| {
            corners.iter().all(|corner| sign * corner[axis] > self.half[axis] * distance(corner[2]))
        };
        if [0, 1].into_iter().any(|axis| is_beyond(axis, 1.0) || is_beyond(axis, -1.0)) {
            let hint = match self.is_perspective {
                true => looking_along(middle),
                false => Some("move the camera's `center`".into()),
            };
            return (": the camera looks away from the scene", hint);
        }
        let is_ahead = !self.is_perspective || corners.iter().all(|&[_, _, ahead]| ahead > 0.0);
        let is_small = [0, 1].into_iter().all(|axis| {
            let seen = corners.map(|corner| corner[axis] / distance(corner[2]));
            let (min, max) = seen.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), &x| {
                (f64::min(min, x), f64::max(max, x))
            });
            max - min < self.pixel[axis]
        });
        if !(is_ahead && is_small) {
            return ("", None);
        }
        let hint = "a smaller `angle` or `size` of the camera shows it larger";
        (": the scene is smaller than a pixel", Some(hint.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point's coordinates are the factors of the right, up (as in the picture) and ahead vectors.
    #[test]
    fn coordinates_are_those_of_the_picture() {
        let up = DVec3::new(0.0, 2.0, -1.0);
        let camera =
            Camera::Perspective { center: DVec3::ZERO, direction: DVec3::NEG_Z * 3.0, up, angle: 90.0 };
        for (spread, up, half) in [
            (Screen::BothSides { up_as_written: true }, up, [11.0 / 10.0, 6.0 / 5.0]),
            (Screen::BothSides { up_as_written: false }, DVec3::Y, [11.0 / 10.0, 6.0 / 5.0]),
            (Screen::LongerSide, DVec3::Y, [1.0, 6.0 / 11.0]),
        ] {
            let view = View::new(&camera, [11, 6], spread);
            let point = 3.0 * (DVec3::NEG_Z + 0.1 * DVec3::X + 0.2 * up);
            let found = DVec3::from_array(view.axes.map(|axis| axis.dot(point)));
            assert!((found - DVec3::new(0.3, 0.6, 3.0)).length() < 1e-14, "{found}");
            let difference = DVec3::new(view.half[0] - half[0], view.half[1] - half[1], 0.0);
            assert!(difference.length() < 1e-14, "{:?}", view.half);
        }
    }
}
