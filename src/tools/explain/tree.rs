//! The tree of a pixel: everything that contributes to it. `Display` prints it as text, serde as JSON, whose members
//! `docs/json.md` describes.

use crate::base::escape::escape;
use crate::diagnostic::Position;
use crate::math::ray::{Hit, Ray};
use crate::math::robust::UNIT_ROUNDOFF;
use crate::picture::{CHANNELS, Color};
use crate::scene::MaterialId;
use crate::scene::material::Phong;
use crate::scene::model::Highlight;
use crate::shading::light::Incident;
use crate::stats::Counts;
use crate::trace::{PathEnd, Secondary};
use crate::world::SurfacePoint;
use glam::DVec2;
use serde::Serialize;
use std::fmt;

/// A pixel with everything that contributes to it.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PixelTree {
    pub pixel: [usize; 2],
    pub has_grid: bool,
    /// The model of highlights, which decides what the scene's language calls the colours of a material.
    #[serde(skip)]
    pub highlight: Highlight,
    #[serde(skip)]
    pub has_cube_map: bool,
    /// The first samples with nonzero weight.
    pub samples: Vec<SampleTree>,
    pub more_samples: u64,
    pub left_out: LeftOut,
    /// The pixel's colour: the sum of the weighted colours over the sum of the weights.
    pub color: Color,
    pub bytes: [u8; CHANNELS],
}

/// A sample with the rays behind it.
#[derive(Clone, Debug, Serialize)]
pub struct SampleTree {
    /// The pixel that contains the sample: column and row from the top left.
    pub pixel: [usize; 2],
    pub number: usize,
    /// The offset from that pixel's centre to the right and up, in pixels.
    pub offset: DVec2,
    pub weight: f64,
    pub color: Color,
    /// The camera ray and all its descendants. Each comes after its parent. If there are too many, only the first ones
    /// are kept.
    pub rays: Vec<RayNode>,
    pub left_out: LeftOut,
}

/// Rays that are counted but not kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    pub rays: u64,
    pub counts: Counts,
}

/// A ray that was followed, and its hit.
#[derive(Clone, Debug, Default, Serialize)]
pub struct RayNode {
    /// How the ray left the surface at its origin. `None` for the camera ray.
    pub kind: Option<Secondary>,
    pub bounces: usize,
    pub ray: Ray,
    /// The primitive that it leaves. `None` for the camera ray.
    #[serde(skip)]
    pub(super) origin_primitive: Option<u32>,
    #[serde(skip)]
    pub(super) hit: Option<Hit>,
    /// The factor of its colour in the picture.
    pub filter: Color,
    pub weight: f64,
    pub counts: Counts,
    pub surface: Option<Surface>,
    pub color: Color,
    pub ends: Vec<NotFollowed>,
    pub children: Vec<usize>,
    pub close_calls: Vec<CloseCall>,
}

/// A secondary ray that was not followed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NotFollowed {
    pub kind: Secondary,
    #[serde(flatten)]
    pub end: PathEnd,
}

/// A surface that a ray hits, and its lighting.
#[derive(Clone, Debug, Serialize)]
pub struct Surface {
    pub object: ObjectPart,
    pub t: f64,
    pub point: SurfacePoint,
    pub material_at: Position,
    pub material: Phong,
    /// The source of the diffuse colour, as in " of the noise". Empty if it is the material itself.
    #[serde(skip)]
    pub paint: String,
    /// The textures with nonzero weight, outermost first.
    pub textures: Vec<TextureWeight>,
    pub parts: Vec<MaterialPart>,
    /// The ambient part of the colour. `None` if the surface is seen from inside and black there.
    pub ambient: Option<Color>,
    pub lights: Vec<Lighting>,
}

/// The contribution of a light to a surface's colour.
#[derive(Clone, Debug, Serialize)]
pub struct Lighting {
    pub incident: Incident,
    /// The cosine between the normal on the viewer's side and the direction to the light.
    pub cosine: f64,
    pub passed: Color,
    /// The diffuse and the specular part for an unobstructed light.
    pub parts: [Color; 2],
    pub shadow: Option<Shadow>,
}

/// A ray towards a light.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Shadow {
    /// The ray, which ends at the light.
    pub ray: Ray,
    /// The surfaces that it crosses, as far as it was followed. Empty for opaque shadows.
    pub crossed: Vec<Crossing>,
    pub blocker: Option<LightBlocker>,
    pub counts: Counts,
    pub close_calls: Vec<CloseCall>,
}

/// The obstruction that ends an opaque shadow's ray.
#[derive(Clone, Debug, Serialize)]
pub struct LightBlocker {
    pub object: ObjectPart,
    pub t: f64,
}

/// A surface between a point and a light.
#[derive(Clone, Debug, Serialize)]
pub struct Crossing {
    pub object: ObjectPart,
    /// The hit, with t measured from the last surface.
    #[serde(flatten)]
    pub hit: Hit,
    /// Its transparent colour. Black if it blocks the light.
    pub tint: Color,
    /// True if the light leaves the object there and is tinted for the distance inside.
    #[serde(rename = "leaves")]
    pub is_leaving: bool,
}

/// A primitive, as a part of an object in the scene's text.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ObjectPart {
    /// The keyword of the object, and the name of its file if it has one.
    pub name: String,
    #[serde(flatten)]
    pub at: Position,
    /// The index of the triangle in the object. `None` if the object is a single primitive.
    pub triangle: Option<u32>,
}

/// How a texture mixes its two materials at a point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TextureWeight {
    pub name: &'static str,
    pub material: MaterialId,
    pub at: Position,
    pub children: [MaterialId; 2],
    /// The weight of the first material. The second has the rest.
    pub first: f64,
}

/// A material without parts, as a component of a mixture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MaterialPart {
    pub material: MaterialId,
    pub at: Position,
    pub weight: f64,
    pub phong: Phong,
}

/// The kind of a close call, which the sentences of [`CloseCall`] describe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CloseCallKind {
    Edge,
    Tangent,
    Parallel,
    SameT,
    Start,
    End,
    Cosine,
    Boundary,
    Critical,
}

/// A decision that a few roundings could reverse.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CloseCall {
    pub kind: CloseCallKind,
    pub object: Option<ObjectPart>,
}

impl PixelTree {
    /// Returns the work for all samples.
    pub fn counts(&self) -> Counts {
        let rays = self.samples.iter().flat_map(|sample| &sample.rays);
        rays.fold(self.left_out.counts, |sum, node| {
            node.shadows().fold(sum.merge(node.counts), |sum, shadow| sum.merge(shadow.counts))
        })
    }

    /// Returns the names of the channels whose byte a few roundings could change.
    pub fn close_channels(&self) -> impl Iterator<Item = &'static str> {
        const ROUNDINGS: f64 = 16.0;
        let channels = ["red", "green", "blue"].into_iter().zip(self.color.to_array());
        channels.filter_map(|(name, channel)| {
            let (level, whole) = (255.0 * channel, (255.0 * channel).round());
            let is_close = (level - whole).abs() <= ROUNDINGS * UNIT_ROUNDOFF * whole;
            (is_close && (1.0..=255.0).contains(&whole)).then_some(name)
        })
    }
}

impl RayNode {
    /// Returns the rays from its hit towards lights.
    fn shadows(&self) -> impl Iterator<Item = &Shadow> {
        let lights = self.surface.iter().flat_map(|surface| &surface.lights);
        lights.filter_map(|light| light.shadow.as_ref())
    }

    /// Returns the approximate number of text lines for this ray and its rays towards lights.
    pub(super) fn lines(&self) -> usize {
        let lights = self.surface.as_ref().map_or(0, |surface| surface.lights.len());
        1 + lights + self.shadows().map(|shadow| shadow.crossed.len()).sum::<usize>()
    }
}

impl fmt::Display for ObjectPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, at, triangle } = self;
        if let Some(triangle) = triangle {
            write!(f, "triangle {triangle} of ")?;
        }
        write!(f, "{} in line {}", escape(name), at.line)
    }
}

impl fmt::Display for CloseCall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let problem = match self.kind {
            CloseCallKind::Edge => "within roundings the ray passes through an edge",
            CloseCallKind::Tangent => "within roundings the ray is tangent",
            CloseCallKind::Parallel => "within roundings the ray lies in a plane",
            CloseCallKind::SameT => "within roundings something else is as near",
            CloseCallKind::Start => "within roundings the ray starts in a surface",
            CloseCallKind::End => "within roundings the ray ends in a surface",
            CloseCallKind::Cosine => "the cosine between normal and direction is 0 within roundings",
            CloseCallKind::Critical => "the angle is that of total internal reflection within roundings",
            CloseCallKind::Boundary => "the point lies in a boundary of the checkerboard within roundings",
        };
        write!(f, "close call: {problem}")?;
        self.object.as_ref().map_or(Ok(()), |object| write!(f, ": {object}"))
    }
}
