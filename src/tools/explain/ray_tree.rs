//! The tree of rays behind one sample, recorded while the tracer follows them.

use super::close_call::{CloseCall, CloseCallKind};
use super::objects::{MaterialPart, ObjectPart, TextureWeight};
use crate::math::ray::{Hit, Ray};
use crate::picture::Color;
use crate::scene::Position;
use crate::scene::material::Phong;
use crate::shading::light::Incident;
use crate::stats::{Counts, Probe};
use crate::trace::{Event, Observer, PathEnd, Secondary, is_critical};
use crate::world::SurfacePoint;
use serde::Serialize;

/// A ray that was followed, and its hit.
#[derive(Clone, Debug, Serialize)]
pub struct RayNode {
    /// How the ray left the surface at its origin. `None` for the camera ray.
    pub kind: Option<Secondary>,
    /// The number of reflections and refractions between it and the camera.
    pub bounces: usize,
    /// The ray.
    pub ray: Ray,
    /// The triangle that the ray leaves and cannot hit again.
    #[serde(skip)]
    pub exclude: Option<u32>,
    /// The factor of its colour in the picture.
    pub filter: Color,
    /// The weight of the ray.
    pub weight: f64,
    /// The nearest hit.
    #[serde(skip)]
    pub hit: Option<Hit>,
    /// The work of finding the hit.
    pub counts: Counts,
    /// The surface at the hit. `None` if the ray reaches the background.
    pub surface: Option<Surface>,
    /// The face of the cube map that the ray reaches if it hits nothing.
    #[serde(skip)]
    pub cube_face: Option<&'static str>,
    /// The surface's own colour, or the background's.
    pub color: Color,
    /// The secondary rays that were not followed.
    pub ends: Vec<NotFollowed>,
    /// The indices of the rays that start at its hit.
    pub children: Vec<usize>,
    /// Decisions about the ray that different rounding could reverse.
    pub close_calls: Vec<CloseCall>,
}

/// A secondary ray that was not followed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NotFollowed {
    /// How the ray would have left the surface.
    pub kind: Secondary,
    /// The reason why it was not followed.
    #[serde(flatten)]
    pub end: PathEnd,
}

/// A surface that a ray hits, and its lighting.
#[derive(Clone, Debug, Serialize)]
pub struct Surface {
    /// The object with the surface.
    pub object: Option<ObjectPart>,
    /// The position on the ray.
    pub t: f64,
    /// The point in the world.
    pub point: SurfacePoint,
    /// The position of its material in the scene's text.
    pub material_at: Option<Position>,
    /// The material, with its textures evaluated.
    pub material: Phong,
    /// The source of the diffuse colour, if it is not the material itself.
    #[serde(skip)]
    pub paint: Option<String>,
    /// The textures of the material, each with the weight of its first child.
    pub textures: Vec<TextureWeight>,
    /// The materials mixed by the textures. Empty if there is only one.
    pub parts: Vec<MaterialPart>,
    /// The ambient part of the colour. `None` if the surface is seen from inside and black there.
    pub ambient: Option<Color>,
    /// The lights, in the order of the scene.
    pub lights: Vec<Lighting>,
}

/// The contribution of a light to a surface's colour.
#[derive(Clone, Debug, Serialize)]
pub struct Lighting {
    /// The light that arrives without obstruction.
    pub incident: Incident,
    /// The cosine between the normal on the viewer's side and the direction to the light.
    pub cosine: f64,
    /// The fraction of the light that passes obstructions.
    pub passed: Color,
    /// The diffuse and the specular part for an unobstructed light.
    pub parts: [Color; 2],
    /// The ray towards the light. `None` without shadows.
    pub shadow: Option<Shadow>,
}

/// A ray towards a light.
#[derive(Clone, Debug, Serialize)]
pub struct Shadow {
    /// The ray, which ends at the light.
    pub ray: Ray,
    /// The surfaces that it crosses, as far as it was followed. Empty for opaque shadows.
    pub crossed: Vec<Crossing>,
    /// The obstruction that ends an opaque shadow's ray.
    pub blocker: Option<LightBlocker>,
    /// The work of finding the obstructions.
    pub counts: Counts,
    /// Decisions about the ray that different rounding could reverse.
    pub close_calls: Vec<CloseCall>,
}

/// The obstruction that ends an opaque shadow's ray.
#[derive(Clone, Debug, Serialize)]
pub struct LightBlocker {
    /// The obstructing object.
    pub object: Option<ObjectPart>,
    /// The position on the ray.
    pub t: f64,
}

/// A surface between a point and a light.
#[derive(Clone, Debug, Serialize)]
pub struct Crossing {
    /// The object with the surface.
    pub object: Option<ObjectPart>,
    /// The hit, with t measured from the last surface.
    #[serde(flatten)]
    pub hit: Hit,
    /// Its transparent colour. Black if it blocks the light.
    pub tint: Color,
    /// True if the light leaves the object there and is tinted for the distance inside.
    pub leaves: bool,
}

/// Records the descendants of one camera ray, as long as there is room.
#[derive(Debug, Default)]
pub struct Recorder {
    rays: Vec<RayNode>,
    /// The largest number of rays kept.
    room: usize,
    /// The rays that are not kept.
    left_out: LeftOut,
    /// The indices of pending rays, in the order of the tracer's pending rays. `None` for a ray that is not kept.
    waiting: Vec<Option<usize>>,
    current: Option<usize>,
    /// The work since the last ray was finished.
    counts: Counts,
    /// The last ray towards a light, until the light's contribution is known.
    shadow: Option<Shadow>,
}

/// Rays that are counted but not kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Reflected and refracted rays.
    pub rays: u64,
    /// The work for them and their rays towards lights.
    pub counts: Counts,
}

impl RayNode {
    fn new(kind: Option<Secondary>, bounces: usize, ray: Ray) -> Self {
        Self {
            kind,
            bounces,
            ray,
            exclude: None,
            filter: Color::ONE,
            weight: 1.0,
            hit: None,
            counts: Counts::default(),
            surface: None,
            cube_face: None,
            color: Color::ZERO,
            ends: vec![],
            children: vec![],
            close_calls: vec![],
        }
    }

    /// Returns the work for this ray and its rays towards lights.
    pub fn all_counts(&self) -> Counts {
        let lights = self.surface.iter().flat_map(|surface| &surface.lights);
        let shadows = lights.filter_map(|light| light.shadow.as_ref());
        shadows.fold(self.counts, |sum, shadow| sum.merge(shadow.counts))
    }

    /// Returns the approximate number of text lines for this ray and its rays towards lights.
    pub(super) fn lines(&self) -> usize {
        let lights = self.surface.iter().flat_map(|surface| &surface.lights);
        1 + lights
            .map(|light| 1 + light.shadow.as_ref().map_or(0, |shadow| shadow.crossed.len()))
            .sum::<usize>()
    }
}

impl Recorder {
    /// Starts a recorder with a camera ray. It keeps at most `room` rays.
    pub fn of(ray: Ray, room: usize) -> Self {
        let rays = if room > 0 { vec![RayNode::new(None, 0, ray)] } else { vec![] };
        let current = (room > 0).then_some(0);
        Self { rays, room, current, ..Self::default() }
    }

    /// Returns the rays, with the camera ray first and each ray after its parent, and the rays left out.
    pub fn finish(mut self) -> (Vec<RayNode>, LeftOut) {
        if self.rays.is_empty() {
            self.left_out.rays += 1;
        }
        self.leave_out();
        (self.rays, self.left_out)
    }

    /// Counts the work for a ray that is not kept.
    fn leave_out(&mut self) {
        if self.current.is_none() {
            self.left_out.counts = self.left_out.counts.merge(std::mem::take(&mut self.counts));
        }
    }

    fn node(&mut self) -> Option<&mut RayNode> {
        self.rays.get_mut(self.current?)
    }

    /// Adds a descendant of the current ray, given the current number of bounces.
    fn push(&mut self, follow: impl FnOnce(usize) -> RayNode) {
        let place = self.rays.len();
        let has_room = place < self.room;
        let bounces = self.node().filter(|_| has_room).map(|node| {
            node.children.push(place);
            node.bounces
        });
        match bounces {
            Some(bounces) => {
                self.rays.push(follow(bounces + 1));
                self.waiting.push(Some(place));
            }
            None => {
                self.left_out.rays += 1;
                self.waiting.push(None);
            }
        }
    }

    fn surface(&mut self) -> Option<&mut Surface> {
        self.node()?.surface.as_mut()
    }

    fn light(&mut self, light: Lighting) {
        if self.current.is_none() {
            return;
        }
        let counts = std::mem::take(&mut self.counts);
        let shadow = self.shadow.take().map(|shadow| Shadow { counts, ..shadow });
        if let Some(surface) = self.surface() {
            surface.lights.push(Lighting { shadow, ..light });
        }
    }
}

impl Probe for Recorder {
    const COUNTS: bool = true;

    fn intersections(&mut self, count: usize) {
        self.counts.intersections(count);
    }

    fn cell(&mut self) {
        self.counts.cell();
    }
}

impl Observer for Recorder {
    fn non_shadow_ray(&mut self) {
        self.counts.non_shadow_ray();
    }

    fn shadow_ray(&mut self) {
        self.counts.shadow_ray();
    }

    fn observe<'e>(&mut self, event: impl FnOnce() -> Event<'e>) {
        match event() {
            Event::Surface { point, material } => {
                if let Some(node) = self.node() {
                    node.surface = Some(Surface::new(point, material));
                }
            }
            Event::Pushed { kind, ray, exclude, filter, weight } => self.push(|bounces| RayNode {
                exclude,
                filter,
                weight,
                ..RayNode::new(Some(kind), bounces, ray)
            }),
            Event::NotFollowed { kind, end } => {
                if let Some(node) = self.node() {
                    node.ends.push(NotFollowed { kind, end });
                }
            }
            Event::Refracting { direction, normal, indices } => {
                if is_critical(direction, normal, indices)
                    && let Some(node) = self.node()
                {
                    node.close_calls.push(CloseCall { kind: CloseCallKind::Critical, object: None });
                }
            }
            Event::Ambient(color) => {
                if let Some(surface) = self.surface() {
                    surface.ambient = Some(color);
                }
            }
            Event::ShadowRay(ray) => self.shadow = self.current.map(|_| Shadow::new(ray)),
            Event::Crossed { hit, tint, leaves } => {
                if let Some(shadow) = &mut self.shadow {
                    shadow.crossed.push(Crossing { object: None, hit, tint, leaves });
                }
            }
            Event::Light { incident, cosine, passed, parts } => {
                self.light(Lighting { incident, cosine, passed, parts, shadow: None });
            }
            Event::Shaded(color) => {
                if let Some(node) = self.node() {
                    node.color = color;
                }
            }
            Event::Popped => {
                self.leave_out();
                self.current = self.waiting.pop().flatten();
            }
            Event::Met(hit) => {
                if self.current.is_none() {
                    return;
                }
                let counts = std::mem::take(&mut self.counts);
                if let Some(node) = self.node() {
                    (node.hit, node.counts) = (hit, counts);
                }
            }
        }
    }
}

impl Surface {
    fn new(point: &SurfacePoint, material: &Phong) -> Self {
        Self {
            object: None,
            t: 0.0,
            point: *point,
            material_at: None,
            material: *material,
            paint: None,
            textures: vec![],
            parts: vec![],
            ambient: None,
            lights: vec![],
        }
    }
}

impl Shadow {
    fn new(ray: Ray) -> Self {
        Self { ray, crossed: vec![], blocker: None, counts: Counts::default(), close_calls: vec![] }
    }
}
