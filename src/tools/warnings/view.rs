//! Pictures that show nothing of the scene.

use super::{Warning, known};
use crate::math::robust::unit;
use crate::render::{Layer, Request, Watch};
use crate::renderer::Prepared;
use crate::scene::parser::Places;
use crate::scene::{Camera, Color};
use crate::world::World;
use glam::DVec3;
use std::fmt;
use std::ops::ControlFlow;

/// Where the scene is, if no ray hits it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sight {
    /// There are no objects.
    Empty,
    /// All objects are behind a perspective camera.
    Behind {
        /// The direction to their middle.
        middle: DVec3,
    },
    /// All objects are to a side of what the camera sees.
    Aside {
        /// The direction to their middle, for a perspective camera.
        middle: Option<DVec3>,
    },
    /// All objects together are smaller than a pixel.
    TooSmall,
    /// There are gaps between the objects, or planes, where the camera looks.
    Unknown,
}

impl fmt::Display for Sight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Empty => ": the scene has no objects",
            Self::Behind { .. } => ": the scene is behind the camera",
            Self::Aside { .. } => ": the camera looks away from the scene",
            Self::TooSmall => ": the scene is smaller than a pixel",
            Self::Unknown => "",
        })
    }
}

impl Sight {
    /// What would show the scene.
    pub(super) fn hint(&self) -> Option<String> {
        match self {
            Self::Behind { middle } | Self::Aside { middle: Some(middle) } => {
                let [x, y, z] = (*middle / middle.abs().max_element()).to_array().map(short);
                Some(format!("`direction {x} {y} {z}` looks at the middle of the scene"))
            }
            Self::Aside { middle: None } => Some("move the camera's `center`".into()),
            Self::TooSmall => Some("a smaller `angle` or `size` of the camera shows it larger".into()),
            Self::Empty | Self::Unknown => None,
        }
    }
}

/// A coordinate with at most three decimals.
fn short(x: f64) -> String {
    // The sum turns a negative zero into zero.
    ((x * 1000.0).round() / 1000.0 + 0.0).to_string()
}

/// A warning if no ray through a pixel's centre hits anything. That takes as long as rendering such a picture,
/// or else until the first row of pixels with a hit, so it is only asked of a picture that shows nothing but
/// the background. If `watch` ends it there is no warning.
pub fn nothing_visible(
    prepared: &Prepared,
    request: &Request,
    places: &Places,
    watch: Watch,
) -> Option<Warning> {
    let at = known(Some(&places.camera));
    if is_empty(prepared.renderer().world()) {
        return Some(Warning::NothingVisible { at, sight: Sight::Empty });
    }
    let centers =
        Request { layers: vec![Layer::Normals], camera: request.camera, ..Request::new(request.size) };
    // Normals have unit length, and where nothing is hit the picture is black.
    let mut take_row = |_: usize, row: &[Color]| match row.iter().all(|&color| color == Color::ZERO) {
        true => ControlFlow::Continue(()),
        false => ControlFlow::Break(()),
    };
    let sees_nothing = prepared.render_rows_fast(&centers, watch, &mut take_row).is_ok();
    sees_nothing.then(|| Warning::NothingVisible { at, sight: sight(prepared, &centers) })
}

fn is_empty(world: &World) -> bool {
    world.finite_count() == 0 && world.planes.is_empty()
}

/// Why nothing is seen, as far as the bounds of the objects tell.
fn sight(prepared: &Prepared, request: &Request) -> Sight {
    let renderer = prepared.renderer();
    let world = renderer.world();
    let Some(bounds) = renderer.bounds().filter(|_| world.planes.is_empty()) else {
        return Sight::Unknown;
    };
    let camera = request.camera.unwrap_or(renderer.scene.camera);
    Screen::new(&camera, request.size).sight(bounds.corners(), (bounds.min + bounds.max) / 2.0)
}

/// A camera's screen, in coordinates to the right, up and ahead.
struct Screen {
    center: DVec3,
    /// Right, up and ahead.
    axes: [DVec3; 3],
    is_perspective: bool,
    /// Half of the screen's width and height: at distance 1 for a perspective camera.
    half: [f64; 2],
    /// The side of a pixel.
    pixel: f64,
}

impl Screen {
    fn new(camera: &Camera, size: [usize; 2]) -> Self {
        let (Camera::Orthographic { center, direction, up, .. }
        | Camera::Perspective { center, direction, up, .. }) = *camera;
        let ahead = unit(direction);
        let right = unit(ahead.cross(unit(up)));
        let (is_perspective, longer) = match *camera {
            Camera::Orthographic { size, .. } => (false, size),
            Camera::Perspective { angle, .. } => (true, 2.0 * libm::tan((angle / 2.0).to_radians())),
        };
        let pixel = longer / size[0].max(size[1]) as f64;
        let half = size.map(|n| n as f64 * pixel / 2.0);
        Self { center, axes: [right, right.cross(ahead), ahead], is_perspective, half, pixel }
    }

    /// Where a box with these corners is seen.
    fn sight(&self, corners: [DVec3; 8], middle: DVec3) -> Sight {
        let corners = corners.map(|corner| self.axes.map(|axis| axis.dot(corner - self.center)));
        let middle = middle - self.center;
        if self.is_perspective && corners.iter().all(|&[_, _, ahead]| ahead <= 0.0) {
            return Sight::Behind { middle };
        }
        let distance = |ahead: f64| if self.is_perspective { ahead } else { 1.0 };
        let is_beyond = |axis: usize, sign: f64| {
            corners.iter().all(|corner| sign * corner[axis] > self.half[axis] * distance(corner[2]))
        };
        if [0, 1].into_iter().any(|axis| is_beyond(axis, 1.0) || is_beyond(axis, -1.0)) {
            return Sight::Aside { middle: self.is_perspective.then_some(middle) };
        }
        let is_ahead = !self.is_perspective || corners.iter().all(|&[_, _, ahead]| ahead > 0.0);
        let is_small = [0, 1].into_iter().all(|axis| {
            let seen = corners.map(|corner| corner[axis] / distance(corner[2]));
            let (min, max) = seen.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), &x| {
                (f64::min(min, x), f64::max(max, x))
            });
            max - min < self.pixel
        });
        if is_ahead && is_small { Sight::TooSmall } else { Sight::Unknown }
    }
}
