//! The steps of the tracer, to count or record them.

use crate::caster::CourseSteps;
use crate::math::ray::{Hit, Ray};
use crate::picture::Color;
use crate::scene::material::Phong;
use crate::shading::light::Incident;
use crate::stats::Counts;
use crate::world::SurfacePoint;
use glam::DVec3;
use serde::Serialize;

/// Observes the tracer. The default methods do nothing and cost nothing.
pub trait Observer {
    /// True if the observer counts. Then the tracer takes all steps of the course's program. Otherwise it skips work that
    /// cannot change the picture.
    const COUNTS: bool = false;

    /// Notes a camera ray, or a reflected or refracted one.
    #[inline(always)]
    fn non_shadow_ray(&mut self) {}

    /// Notes a ray towards a light.
    #[inline(always)]
    fn shadow_ray(&mut self) {}

    /// Notes the steps of a ray, if the observer counts.
    fn steps(&mut self, _steps: CourseSteps) {}

    /// Notes an event. Observers that do not need the event never call `event`.
    #[inline(always)]
    fn observe<'e>(&mut self, _event: impl FnOnce() -> Event<'e>) {}
}

/// Counts nothing and costs nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Quiet;

impl Observer for Quiet {}

impl Observer for Counts {
    const COUNTS: bool = true;

    #[inline(always)]
    fn non_shadow_ray(&mut self) {
        self.non_shadow_rays += 1;
    }

    #[inline(always)]
    fn shadow_ray(&mut self) {
        self.shadow_rays += 1;
    }

    #[inline(always)]
    fn steps(&mut self, CourseSteps { tests, cells }: CourseSteps) {
        self.intersections += tests;
        self.cells_traversed += cells;
    }
}

/// Counts rays of any kind and nothing else. So the tracer may skip work.
#[derive(Clone, Copy, Debug, Default)]
pub struct RayCount(pub u64);

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

/// The kind of a secondary ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Secondary {
    /// The reflected ray.
    Reflected,
    /// The refracted ray.
    Refracted,
}

impl Secondary {
    /// Returns the word for the ray in texts.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reflected => "reflected",
            Self::Refracted => "refracted",
        }
    }
}

/// The reason why a secondary ray is not traced.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum PathEnd {
    /// The colour that would multiply the ray is black.
    NoColor,
    /// The path has the maximum number of bounces.
    Bounces,
    /// The weight of the ray is not above the minimum.
    Weight {
        /// The weight.
        weight: f64,
    },
    /// All light is reflected at this angle.
    TotalReflection,
}

/// A step of the tracer. The events of one ray follow each other, from its surface to its colour. Then the next
/// secondary ray is popped from the stack: the ray that was pushed last.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub enum Event<'e> {
    /// The ray hits this surface, whose material has its textures evaluated.
    Surface { point: &'e SurfacePoint, material: &'e Phong },
    /// A secondary ray is pushed to the stack.
    Pushed {
        kind: Secondary,
        ray: Ray,
        /// The factor by which its colour contributes to the picture.
        filter: Color,
        weight: f64,
    },
    /// A secondary ray is not traced.
    NotFollowed { kind: Secondary, end: PathEnd },
    /// The ray is refracted or totally reflected. `normal` points against `direction`, and both are unit vectors.
    Refracting {
        direction: DVec3,
        normal: DVec3,
        /// The indices of refraction in front of the surface and behind it.
        indices: [f64; 2],
    },
    /// The ambient light that the surface reflects.
    Ambient(Color),
    /// A ray is cast towards a light.
    ShadowRay(Ray),
    /// The shadow ray hits a surface.
    Crossed {
        /// The hit, with the distance from the last surface.
        hit: Hit,
        /// The transparent colour there; black if the ray ends there.
        tint: Color,
        /// True if the ray leaves the object. Then the light is tinted for the distance inside.
        is_leaving: bool,
    },
    /// The contribution of a light. The lights follow in the order of the scene.
    Light {
        /// The light that arrives if nothing blocks it.
        incident: Incident,
        /// The cosine of the angle between the normal and the direction to the light.
        cosine: f64,
        /// The fraction of the light, per channel, that passes the objects in between.
        passed: Color,
        /// The diffuse and the specular part of the reflected light, as if nothing blocked the light.
        parts: [Color; 2],
    },
    /// The colour of the surface without secondary rays, or the background.
    Shaded(Color),
    /// The next secondary ray is popped from the stack.
    Popped,
    /// The ray has been cast, with this nearest hit.
    Met(Option<Hit>),
}
