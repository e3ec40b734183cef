//! The steps of the tracer, for those who count or record them.

use crate::math::ray::{Hit, Ray};
use crate::picture::Color;
use crate::scene::material::Phong;
use crate::shading::light::Incident;
use crate::stats::{Counts, Probe, Quiet};
use crate::world::SurfacePoint;
use glam::DVec3;
use serde::Serialize;

/// Watches the tracer. By default it does not, which costs nothing. If it counts ([`Probe::COUNTS`]), the tracer takes all
/// steps of the course's program; otherwise it skips work that cannot change the picture.
pub trait Observer: Probe {
    /// A camera ray, or a reflected or refracted one.
    #[inline(always)]
    fn non_shadow_ray(&mut self) {}

    /// A ray towards a light.
    #[inline(always)]
    fn shadow_ray(&mut self) {}

    /// Is told what happens. The event is made only if it is asked for.
    #[inline(always)]
    fn observe<'e>(&mut self, _event: impl FnOnce() -> Event<'e>) {}
}

impl Observer for Quiet {}

impl Observer for Counts {
    #[inline(always)]
    fn non_shadow_ray(&mut self) {
        self.non_shadow_rays += 1;
    }

    #[inline(always)]
    fn shadow_ray(&mut self) {
        self.shadow_rays += 1;
    }
}

/// Counts rays of any kind, and nothing else, so that work may be skipped.
#[derive(Clone, Copy, Debug, Default)]
pub struct RayCount(pub u64);

impl Probe for RayCount {}

impl Observer for RayCount {
    #[inline(always)]
    fn non_shadow_ray(&mut self) {
        self.0 += 1;
    }

    #[inline(always)]
    fn shadow_ray(&mut self) {
        self.0 += 1;
    }
}

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
    /// The ray is refracted or totally reflected.
    Refracting {
        /// Where it comes from, as a unit vector.
        direction: DVec3,
        /// The unit normal, against the direction.
        normal: DVec3,
        /// The indices of refraction in front of the surface and behind it.
        indices: [f64; 2],
    },
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
    /// The ray has been cast.
    Met(Option<Hit>),
}
