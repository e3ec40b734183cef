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

/// A ray that was followed, with what it met.
#[derive(Clone, Debug, Serialize)]
pub struct RayNode {
    /// How it left the surface where it starts; none for the camera ray.
    pub kind: Option<Secondary>,
    /// How many reflections and refractions lie between it and the camera.
    pub bounces: usize,
    /// The ray.
    pub ray: Ray,
    /// The triangle that it leaves, which it does not meet again.
    #[serde(skip)]
    pub exclude: Option<u32>,
    /// What its colour is multiplied by on the way to the picture.
    pub filter: Color,
    /// What it weighs.
    pub weight: f64,
    /// What it sees.
    #[serde(skip)]
    pub hit: Option<Hit>,
    /// The work of finding that.
    pub counts: Counts,
    /// The surface that it sees; none where it sees the background.
    pub surface: Option<Surface>,
    /// The face of the cube map that it sees where it meets nothing.
    #[serde(skip)]
    pub cube_face: Option<&'static str>,
    /// The colour of the surface by itself, or the background's.
    pub color: Color,
    /// The secondary rays that were not followed.
    pub ends: Vec<NotFollowed>,
    /// The rays that start where it ends, by their places in the tree.
    pub children: Vec<usize>,
    /// Decisions about it that other roundings could change.
    pub close_calls: Vec<CloseCall>,
}

/// A secondary ray that was not followed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NotFollowed {
    /// How it would have left the surface.
    pub kind: Secondary,
    /// Why it was not followed.
    #[serde(flatten)]
    pub end: PathEnd,
}

/// A surface that a ray has met, and how it is lit.
#[derive(Clone, Debug, Serialize)]
pub struct Surface {
    /// The object that it belongs to.
    pub object: Option<ObjectPart>,
    /// Where on the ray.
    pub t: f64,
    /// Where in the world.
    pub point: SurfacePoint,
    /// Where its material stands in the scene's text.
    pub material_at: Option<Position>,
    /// The material, with its textures evaluated.
    pub material: Phong,
    /// What the diffuse colour comes from, if not from the material itself.
    #[serde(skip)]
    pub paint: Option<String>,
    /// The textures of the material, each with the weight of its first child.
    pub textures: Vec<TextureWeight>,
    /// The materials that the textures mix; none where there is only one.
    pub parts: Vec<MaterialPart>,
    /// The ambient part of the colour; none where the surface is seen from within and black there.
    pub ambient: Option<Color>,
    /// The lights, in the order of the scene.
    pub lights: Vec<Lighting>,
}

/// What a light contributes to a surface's colour.
#[derive(Clone, Debug, Serialize)]
pub struct Lighting {
    /// What arrives where nothing is in the way.
    pub incident: Incident,
    /// Between the normal on the viewer's side and the direction to the light.
    pub cosine: f64,
    /// How much of the light passes what is in the way.
    pub passed: Color,
    /// The diffuse and the specular part of what an unobstructed light shows.
    pub parts: [Color; 2],
    /// The ray towards the light; none without shadows.
    pub shadow: Option<Shadow>,
}

/// A ray towards a light.
#[derive(Clone, Debug, Serialize)]
pub struct Shadow {
    /// The ray, which ends at the light.
    pub ray: Ray,
    /// The surfaces on its way, as far as it was followed; none for what casts an opaque shadow.
    pub crossed: Vec<Crossing>,
    /// What ends the way of an opaque shadow's ray.
    pub blocker: Option<LightBlocker>,
    /// The work of finding that.
    pub counts: Counts,
    /// Decisions about it that other roundings could change.
    pub close_calls: Vec<CloseCall>,
}

/// What ends the way of an opaque shadow's ray.
#[derive(Clone, Debug, Serialize)]
pub struct LightBlocker {
    /// The object that is in the way.
    pub object: Option<ObjectPart>,
    /// Where on the ray.
    pub t: f64,
}

/// A surface on the way to a light.
#[derive(Clone, Debug, Serialize)]
pub struct Crossing {
    /// The object that it belongs to.
    pub object: Option<ObjectPart>,
    /// Where, on the way from the last surface.
    #[serde(flatten)]
    pub hit: Hit,
    /// Its transparent colour; black where the way ends.
    pub tint: Color,
    /// Whether the light leaves the object there, and is tinted for its way inside.
    pub leaves: bool,
}

/// Records what becomes of one camera ray, as far as there is room.
#[derive(Debug, Default)]
pub struct Recorder {
    rays: Vec<RayNode>,
    /// How many rays are kept.
    room: usize,
    /// Those that are not.
    left_out: LeftOut,
    /// The places of the rays that wait, in step with those that wait in the tracer. A ray that is left out has none.
    waiting: Vec<Option<usize>>,
    current: Option<usize>,
    /// What has been counted since the last ray was finished.
    counts: Counts,
    /// The last ray towards a light, until the light's contribution is known.
    shadow: Option<Shadow>,
}

/// What is counted, but not kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Reflected and refracted rays.
    pub rays: u64,
    /// The work for them and their rays towards the lights.
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

    /// The work for this ray and its rays towards the lights.
    pub fn all_counts(&self) -> Counts {
        let lights = self.surface.iter().flat_map(|surface| &surface.lights);
        let shadows = lights.filter_map(|light| light.shadow.as_ref());
        shadows.fold(self.counts, |sum, shadow| sum.merge(shadow.counts))
    }

    /// About the number of lines that tell of this ray and of its rays towards the lights.
    pub(super) fn lines(&self) -> usize {
        let lights = self.surface.iter().flat_map(|surface| &surface.lights);
        1 + lights
            .map(|light| 1 + light.shadow.as_ref().map_or(0, |shadow| shadow.crossed.len()))
            .sum::<usize>()
    }
}

impl Recorder {
    /// Starts with a camera ray, and keeps as many rays as there is room for.
    pub fn of(ray: Ray, room: usize) -> Self {
        let rays = if room > 0 { vec![RayNode::new(None, 0, ray)] } else { vec![] };
        let current = (room > 0).then_some(0);
        Self { rays, room, current, ..Self::default() }
    }

    /// The rays, the camera's first and every other after the one that it left, and what was left out.
    pub fn finish(mut self) -> (Vec<RayNode>, LeftOut) {
        if self.rays.is_empty() {
            self.left_out.rays += 1;
        }
        self.leave_out();
        (self.rays, self.left_out)
    }

    /// Counts the work for a ray that is left out.
    fn leave_out(&mut self) {
        if self.current.is_none() {
            self.left_out.counts = self.left_out.counts.merge(std::mem::take(&mut self.counts));
        }
    }

    fn node(&mut self) -> Option<&mut RayNode> {
        self.rays.get_mut(self.current?)
    }

    /// A ray that follows, with the bounces of the current one.
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
