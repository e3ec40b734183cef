//! Mistakes that this program makes if it is asked for them: other effects, another camera.

use crate::picture::Color;
use crate::render::Request;
use crate::scene::material::{Material, Phong};
use crate::scene::model::Screen;
use crate::scene::{Camera, Scene};
use crate::trace::{Effects, Shadows};
use serde::Serialize;
use std::fmt;

/// A change of what is rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "name", rename_all = "snake_case")]
pub enum RequestChange {
    /// The axis to the right is up x direction, which turns the picture by 180 degrees.
    OtherHandedness,
    /// The camera's angle or size is taken for the shorter side of the picture.
    AngleOfShorterSide,
    /// The tangent of the camera's whole angle is taken instead of that of half of it.
    AngleNotHalved,
    /// The degrees of the camera's angle are taken for radians.
    AngleInRadians,
    /// Nothing casts shadows.
    NoShadows,
    /// Shadows that were not asked for.
    Shadows,
    /// Opaque shadows of transparent things.
    OpaqueShadows,
    /// Tinted shadows of transparent things.
    TransparentShadows,
    /// Surfaces seen from behind are black.
    NoShadeBack,
    /// Surfaces seen from behind are lit.
    ShadeBack,
    /// One bounce is missing.
    OneBounceFewer,
    /// There is one bounce too many.
    OneBounceMore,
    /// Rays are followed whatever they weigh.
    WeightIgnored,
}

impl RequestChange {
    pub(super) const ALL: [Self; 13] = [
        Self::OtherHandedness,
        Self::AngleOfShorterSide,
        Self::AngleNotHalved,
        Self::AngleInRadians,
        Self::NoShadows,
        Self::Shadows,
        Self::OpaqueShadows,
        Self::TransparentShadows,
        Self::NoShadeBack,
        Self::ShadeBack,
        Self::OneBounceFewer,
        Self::OneBounceMore,
        Self::WeightIgnored,
    ];

    /// Whether it is the camera that changes.
    pub(super) fn is_camera(self) -> bool {
        matches!(
            self,
            Self::OtherHandedness | Self::AngleOfShorterSide | Self::AngleNotHalved | Self::AngleInRadians
        )
    }

    /// The changed request; none where the change cannot show.
    pub(super) fn apply(self, scene: &Scene, request: &Request) -> Option<Request> {
        let effects = request.effects;
        match self {
            Self::OtherHandedness => return Some(with_camera(turned(scene.camera), request)),
            // A view that is stretched has no longer side.
            Self::AngleOfShorterSide if scene.model.screen != Screen::LongerSide => return None,
            Self::AngleOfShorterSide => {
                return Some(with_camera(widened(scene.camera, request.size)?, request));
            }
            Self::AngleNotHalved => {
                let camera = with_half_angle(scene.camera, f64::to_radians)?;
                return Some(with_camera(camera, request));
            }
            Self::AngleInRadians => {
                let camera = with_half_angle(scene.camera, |angle| angle / 2.0)?;
                return Some(with_camera(camera, request));
            }
            _ => {}
        }
        let changed = self.effects(effects, scene);
        (changed != effects).then(|| Request { effects: changed, ..request.clone() })
    }

    /// The changed effects, which are the same where the change cannot show.
    fn effects(self, effects: Effects, scene: &Scene) -> Effects {
        let bounces = effects.bounces;
        match (self, effects.shadows) {
            (Self::NoShadows, _) => Effects { shadows: Shadows::None, ..effects },
            (Self::Shadows, Shadows::None) | (Self::OpaqueShadows, Shadows::Transparent) => {
                Effects { shadows: Shadows::Opaque, ..effects }
            }
            (Self::TransparentShadows, _) if has(scene, |phong| phong.transparent) => {
                Effects { shadows: Shadows::Transparent, ..effects }
            }
            (Self::NoShadeBack, _) => Effects { shade_back: false, ..effects },
            (Self::ShadeBack, _) => Effects { shade_back: true, ..effects },
            (Self::OneBounceFewer, _) if has_secondary_rays(scene) => {
                Effects { bounces: bounces.saturating_sub(1), ..effects }
            }
            (Self::OneBounceMore, _) if has_secondary_rays(scene) => {
                Effects { bounces: bounces.saturating_add(1), ..effects }
            }
            (Self::WeightIgnored, _) if bounces > 0 && has_secondary_rays(scene) => {
                Effects { min_weight: 0.0, ..effects }
            }
            _ => effects,
        }
    }
}

/// Whether any material reflects or lets through.
pub fn has_secondary_rays(scene: &Scene) -> bool {
    scene.materials.iter().any(Material::has_secondary_rays)
}

/// Whether any material has a colour of this kind that is not black.
pub fn has(scene: &Scene, color: impl Fn(&Phong) -> Color) -> bool {
    scene.materials.iter().any(|material| match material {
        Material::Phong(phong) | Material::Painted(phong, _) => color(phong) != Color::ZERO,
        Material::Texture(_) => false,
    })
}

fn with_camera(camera: Camera, request: &Request) -> Request {
    Request { camera: Some(camera), ..request.clone() }
}

/// The same camera upside down.
fn turned(mut camera: Camera) -> Camera {
    let (Camera::Orthographic { up, .. } | Camera::Perspective { up, .. }) = &mut camera;
    *up = -*up;
    camera
}

/// The camera whose screen spans the shorter side; none of a square picture.
fn widened(camera: Camera, size: [usize; 2]) -> Option<Camera> {
    let [shorter, longer] = [size[0].min(size[1]), size[0].max(size[1])].map(|side| side as f64);
    let ratio = longer / shorter;
    (ratio > 1.0).then_some(match camera {
        Camera::Orthographic { center, direction, up, size } => {
            Camera::Orthographic { center, direction, up, size: size * ratio }
        }
        Camera::Perspective { center, direction, up, angle } => {
            let half = libm::atan(ratio * libm::tan(angle.to_radians() / 2.0));
            Camera::Perspective { center, direction, up, angle: 2.0 * half.to_degrees() }
        }
    })
}

/// The camera whose screen spans the tangent of another half angle, which may be negative; none of a camera without an
/// angle.
fn with_half_angle(camera: Camera, radians: impl Fn(f64) -> f64) -> Option<Camera> {
    let Camera::Perspective { center, direction, up, angle } = camera else { return None };
    let half = libm::atan(libm::tan(radians(angle)));
    Some(Camera::Perspective { center, direction, up, angle: 2.0 * half.to_degrees() })
}

impl fmt::Display for RequestChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OtherHandedness => "by a camera of the other handedness (turned by 180 degrees)",
            Self::AngleOfShorterSide => "with the camera's angle or size over the shorter side",
            Self::AngleNotHalved => "with the tangent of the camera's whole angle instead of half of it",
            Self::AngleInRadians => "with the degrees of the camera's angle taken for radians",
            Self::NoShadows => "without -shadows",
            Self::Shadows => "with -shadows",
            Self::OpaqueShadows => "with -shadows in place of -transparent_shadows",
            Self::TransparentShadows => "with -transparent_shadows",
            Self::NoShadeBack => "without -shade_back",
            Self::ShadeBack => "with -shade_back",
            Self::OneBounceFewer => "with one bounce fewer",
            Self::OneBounceMore => "with one bounce more",
            Self::WeightIgnored => "without -weight",
        })
    }
}
