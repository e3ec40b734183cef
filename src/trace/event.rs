//! What happens while a ray is followed, for whoever wants to know.
//!
//! Whether anybody wants to is a type parameter, so that the code for the probes that only count makes no events.

use crate::math::ray::{Hit, Ray, Visible};
use crate::scene::Color;
use crate::scene::material::Phong;
use crate::shading::light::Incident;
use crate::stats::{Counts, Probe, Quiet, RayCount};
use crate::world::SurfacePoint;
use serde::Serialize;

/// A probe that may also be told what happens to each ray.
pub trait Observer: Probe {
    /// Whether it is told. If not, no events are made.
    const OBSERVES: bool = false;
    /// Takes an event.
    fn observe(&mut self, _: Event) {}
}

impl Observer for Quiet {}
impl Observer for RayCount {}
impl Observer for Counts {}

/// The way in which a ray leaves a surface to be followed further.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Secondary {
    /// Mirrored.
    Reflected,
    /// Through the surface.
    Refracted,
}

/// Why no secondary ray is followed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum PathEnd {
    /// The material lets nothing go this way.
    NoColor,
    /// The ray has been reflected or refracted as often as is allowed.
    Bounces,
    /// It would weigh no more than what is worth following.
    Weight {
        /// What it would weigh.
        weight: f64,
    },
    /// All light is reflected at this angle.
    TotalReflection,
}

impl Secondary {
    /// No ray of this kind is followed.
    pub(super) fn ends(self, end: PathEnd) -> Event<'static> {
        Event::NotFollowed { kind: self, end }
    }
}

impl PathEnd {
    /// The end of a way with this colour: for want of colour, else for `reason`.
    pub(super) fn of(color: Color, reason: Self) -> Self {
        if color == Color::ZERO { Self::NoColor } else { reason }
    }
}

/// A step of the tracer. The events of one ray follow each other, from its surface to its colour; then the next of the
/// secondary rays that wait is taken, which is the one that was pushed last.
#[derive(Clone, Copy, Debug)]
pub enum Event<'e> {
    /// The ray meets this surface, made of this material.
    Surface {
        /// Where it meets it.
        point: &'e SurfacePoint,
        /// The material there, with its textures evaluated.
        material: &'e Phong,
    },
    /// A secondary ray is to be followed.
    Pushed {
        /// How it leaves the surface.
        kind: Secondary,
        /// The ray.
        ray: Ray,
        /// The triangle that it starts at.
        exclude: Option<u32>,
        /// What its colour is multiplied by on the way to the picture.
        filter: Color,
        /// What it weighs.
        weight: f64,
    },
    /// No secondary ray is followed.
    NotFollowed {
        /// How it would have left the surface.
        kind: Secondary,
        /// Why it does not.
        end: PathEnd,
    },
    /// A few roundings could turn refraction into total reflection, or the reverse.
    Critical,
    /// The ambient light that the surface reflects.
    Ambient(Color),
    /// A ray is cast towards a light.
    ShadowRay(Ray),
    /// The way to the light meets a surface.
    Crossed {
        /// Where, on the way from the last surface.
        hit: Hit,
        /// The transparent colour there; black where the way ends.
        tint: Color,
        /// Whether the light leaves the object, and is tinted for its way inside.
        leaves: bool,
    },
    /// What a light contributes; the lights follow in the order of the scene.
    Light {
        /// What arrives where nothing is in the way.
        incident: Incident,
        /// Between the normal and the direction to the light.
        cosine: f64,
        /// How much of it passes what is in the way.
        passed: Color,
        /// The diffuse and the specular part of what an unobstructed light shows.
        parts: [Color; 2],
    },
    /// The colour of the surface by itself, or the background's.
    Shaded(Color),
    /// The next secondary ray is taken.
    Popped,
    /// The secondary ray has been cast.
    Met(Option<Visible>),
}
