//! The kind of a difference that no known mistake explains.
//!
//! The largest connected region of wrong pixels is compared with pictures in which one thing is changed there: without
//! the object that is seen, without a light, without shadows, without highlights.

use super::Original;
use super::changes::{Part, drop_highlights, drop_shadows};
use super::mistakes::{Make, Mistake};
use super::regions::{largest_region, neighbours, window_around};
use super::rendering::RenderedPixel;
use super::speckles::unlike_neighbours;
use super::variant::{Thresholds, Variant, colors_at};
use crate::picture::Window;
use crate::render::Layer;
use crate::scene::ObjectId;
use crate::scene::material::Material;
use crate::tools::compare::{Rgb, largest_channel_difference};
use crate::trace::Shadows;
use glam::DVec2;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// The number of pixels of a region that are traced.
const SAMPLED: usize = 256;
/// The smallest share of these for which a changed picture must be right.
const MOST: f64 = 0.75;
/// The smallest share of a region beside other objects if it is an outline.
const OUTLINE: f64 = 0.6;
/// The smallest share of unlike neighbours among wrong pixels that differ at random. Rays that hit the surface that they
/// leave give 0.47 to 0.71 where they are reflected or refracted, and other mistakes at most 0.38 but in small regions.
const NOISE: f64 = 0.45;
/// The largest share of an object's pixels that are wrong outside of its highlights.
const FEW: f64 = 0.05;
/// The largest difference of a pixel that is right, in levels.
const CLOSE: u8 = 2;

/// The kind of a difference. `Display` writes it in a sentence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DifferenceKind {
    /// The number of pixels in the largest connected region that differs.
    pub pixels: usize,
    /// The smallest window around it.
    pub window: Window,
    /// Column and row of its pixel with the largest difference.
    pub worst: [usize; 2],
    /// That difference, in levels.
    pub levels: u8,
    /// The object that differs, if it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub object: Option<NamedObject>,
    /// The thing that differs.
    #[serde(flatten)]
    pub subject: Subject,
}

/// The subject of a difference in a region.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum Subject {
    /// The background.
    Background,
    /// The outline of the object.
    Outline,
    /// The object, in whose place others are seen.
    Missing,
    /// The pixels of the object, each in a way of its own.
    Scattered,
    /// The shadow of a light on the object.
    Shadow {
        /// The line of the light, unless all lights cast wrong shadows.
        light: Option<u32>,
    },
    /// The highlights of the object.
    Highlight,
    /// The diffuse or ambient light of the object.
    Diffuse,
    /// Reflected or refracted light.
    Secondary,
    /// Distances or normals of the object.
    Measure,
}

/// An object of the scene's text.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NamedObject {
    /// Its keyword.
    pub name: &'static str,
    /// Its line.
    pub line: u32,
}

impl fmt::Display for NamedObject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the {} in line {}", self.name, self.line)
    }
}

impl fmt::Display for DifferenceKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let object = self.object.as_ref().map_or(String::new(), ToString::to_string);
        match self.subject {
            Subject::Background => f.write_str("the background differs"),
            Subject::Outline => write!(f, "the outline of {object} is elsewhere"),
            Subject::Missing => write!(f, "{object} is missing"),
            Subject::Scattered => write!(
                f,
                "neighbouring pixels of {object} differ in different ways, as with an epsilon that is too small or \
                 with other random numbers"
            ),
            Subject::Shadow { light: Some(line) } => {
                write!(f, "the shadow of the light in line {line} differs on {object}")
            }
            Subject::Shadow { light: None } => write!(f, "shadows differ on {object}"),
            Subject::Highlight => write!(f, "the highlights of {object} differ"),
            Subject::Diffuse => write!(f, "the shading of {object} differs, also outside of highlights"),
            Subject::Secondary => f.write_str("only what is reflected or refracted differs"),
            Subject::Measure => write!(f, "the surface of {object} differs"),
        }?;
        let Window { x, y, width, height } = self.window;
        let [worst_x, worst_y] = self.worst;
        write!(
            f,
            ": the largest region has {} pixels in {width} x {height} at ({x}, {y}), the worst by {} levels at \
             ({worst_x}, {worst_y})",
            self.pixels, self.levels
        )
    }
}

/// An object that is seen in a pixel.
#[derive(Clone, Copy)]
struct Seen {
    primitive: u32,
    object: ObjectId,
    t: f64,
}

/// A region of wrong pixels.
struct Region<'o> {
    original: &'o Original<'o>,
    picture: &'o [Rgb],
    own: Vec<Rgb>,
    /// The object that is seen through the centre of each pixel of the picture, and its distance.
    seen: Vec<Option<Seen>>,
    /// The pixels of the region, and the ones that are traced.
    pixels: Vec<usize>,
    sample: Vec<usize>,
    size: [usize; 2],
}

/// Returns the kind of a difference with these wrong pixels, in ascending order. `None` if there are none, or if the
/// picture is reduced.
pub fn difference_kind(original: &Original, picture: &[Rgb], wrong: &[usize]) -> Option<DifferenceKind> {
    let size = original.colors.size;
    let pixels = largest_region(wrong, size);
    if pixels.is_empty() || original.request.is_reduced {
        return None;
    }
    let own: Vec<Rgb> = original.colors.colors.iter().map(|&color| RenderedPixel::new(color).bytes).collect();
    let levels = |at: &usize| largest_channel_difference(picture[*at], own[*at]);
    let worst = pixels.iter().copied().max_by_key(levels)?;
    let seen = |at| {
        let (primitive, t) = original.seen_at(at)?;
        Some(Seen { primitive, object: original.objects.of(primitive).id, t })
    };
    let seen = (0..picture.len()).into_par_iter().map(seen).collect();
    let sample = pixels.iter().copied().step_by(pixels.len().div_ceil(SAMPLED)).collect();
    let levels = levels(&worst);
    let region = Region { original, picture, own, seen, pixels, sample, size };
    let at_outlines = region.sample.iter().filter(|&&at| region.is_beside_another(at)).count();
    let is_outline = at_outlines as f64 >= OUTLINE * region.sample.len() as f64;
    let shown = |&at: &usize| if is_outline { region.nearest_around(at) } else { region.object_at(at) };
    let object = most_frequent(region.sample.iter().map(shown)).flatten();
    let subject = object.map_or(Subject::Background, |id| region.subject(id, is_outline, wrong));
    let scene = &original.renderer().scene;
    let named =
        |id: usize| NamedObject { name: scene.objects[id].name(), line: scene.positions.object(id).line };
    Some(DifferenceKind {
        pixels: region.pixels.len(),
        window: window_around(&region.pixels, size[0]),
        worst: [worst % size[0], worst / size[0]],
        levels,
        object: object.filter(|_| subject != Subject::Secondary).map(named),
        subject,
    })
}

impl Region<'_> {
    /// Returns what differs in the region of this object.
    fn subject(&self, id: usize, is_outline: bool, wrong: &[usize]) -> Subject {
        let is_it = |at: &usize| self.object_at(*at) == Some(id);
        let in_region = self.pixels.iter().copied().filter(is_it).count();
        let in_picture = (0..self.picture.len()).filter(is_it).count();
        let without = Make::Without(Part::Object(id));
        if in_region as f64 >= MOST * in_picture as f64 && self.is_right_with(without) {
            Subject::Missing
        } else if is_outline {
            Subject::Outline
        } else if unlike_neighbours(self.picture, &self.own, wrong, self.size[0]).among_wrong >= NOISE {
            Subject::Scattered
        } else if self.original.layer != Layer::Color {
            Subject::Measure
        } else if self.is_secondary(wrong) {
            Subject::Secondary
        } else if let Some(shadow) = self.shadow() {
            shadow
        } else if self.is_highlight(id, wrong) {
            Subject::Highlight
        } else {
            Subject::Diffuse
        }
    }

    /// Returns true if another object is seen beside a pixel, or if the object there ends.
    fn is_beside_another(&self, at: usize) -> bool {
        neighbours(at, self.size).any(|neighbour| self.object_at(neighbour) != self.object_at(at))
    }

    /// Returns the nearest object that is seen in a pixel or beside it. An outline is the one of the nearer object.
    fn nearest_around(&self, at: usize) -> Option<usize> {
        let seen = neighbours(at, self.size).filter_map(|at| self.seen[at]);
        Some(seen.min_by(|one, other| one.t.total_cmp(&other.t))?.object)
    }

    fn object_at(&self, at: usize) -> Option<usize> {
        Some(self.seen[at]?.object)
    }

    /// Returns true if this change makes most of the region right.
    fn is_right_with(&self, change: Make) -> bool {
        let Some(colors) = self.colors_with(change, &self.sample) else { return false };
        let is_right = |(at, pixel): (&usize, &Rgb)| {
            let levels = |own| largest_channel_difference(self.picture[*at], own);
            let (before, after) = (levels(self.own[*at]), levels(*pixel));
            after <= CLOSE && 2 * after < before
        };
        let right = self.sample.iter().zip(&colors).filter(|pair| is_right(*pair)).count();
        right as f64 >= MOST * self.sample.len() as f64
    }

    fn colors_with(&self, change: Make, pixels: &[usize]) -> Option<Vec<Rgb>> {
        let variant = Variant::new(self.original, &[Mistake::unnamed(change)])?;
        let colors = variant
            .with_painter(Thresholds::OWN, |painter| colors_at(painter, &variant, pixels, DVec2::ZERO))?;
        Some(colors.into_iter().map(|color| RenderedPixel::new(color).bytes).collect())
    }

    /// Returns true if all wrong pixels show surfaces that reflect or refract.
    fn is_secondary(&self, wrong: &[usize]) -> bool {
        let (world, effects) = (self.original.renderer().world(), self.original.request.effects);
        let is_split = |at: &usize| {
            let material = |seen: Seen| &world.materials[world.material_of(seen.primitive)];
            self.seen[*at].map(material).is_some_and(Material::has_secondary_rays)
        };
        let sample: Vec<usize> = wrong.iter().copied().step_by(wrong.len().div_ceil(SAMPLED)).collect();
        let others = sample.iter().filter(|at| !is_split(at)).count();
        effects.bounces > 0 && others as f64 <= FEW * sample.len() as f64
    }

    /// Returns the shadow that differs, if one does.
    fn shadow(&self) -> Option<Subject> {
        if self.original.request.effects.shadows == Shadows::None {
            return None;
        }
        let positions = &self.original.renderer().scene.positions;
        let lights = positions.lights.len();
        let without = |light: &usize| self.is_right_with(Make::Without(Part::Light(*light)));
        if let Some(light) = (0..lights).find(without) {
            return Some(Subject::Shadow { light: Some(positions.light(light).line) });
        }
        let light = (lights == 1).then(|| positions.light(0).line);
        self.is_right_with(Make::Request(drop_shadows)).then_some(Subject::Shadow { light })
    }

    /// Returns true if the object is wrong only where it has a highlight.
    fn is_highlight(&self, id: usize, wrong: &[usize]) -> bool {
        let on_object: Vec<usize> =
            (0..self.picture.len()).step_by(7).filter(|&at| self.object_at(at) == Some(id)).collect();
        let Some(plain) = self.colors_with(Make::Scene(drop_highlights), &on_object) else { return false };
        let is_plain = |(at, plain): &(&usize, &Rgb)| self.own[**at] == **plain;
        let outside: Vec<usize> = on_object.iter().zip(&plain).filter(is_plain).map(|(&at, _)| at).collect();
        let wrong_outside = outside.iter().filter(|at| wrong.binary_search(at).is_ok()).count();
        outside.len() < on_object.len() && wrong_outside as f64 <= FEW * outside.len() as f64
    }
}

fn most_frequent<T: Ord + Copy>(items: impl Iterator<Item = T>) -> Option<T> {
    let mut counts = BTreeMap::new();
    items.for_each(|item| *counts.entry(item).or_insert(0_usize) += 1);
    counts.into_iter().max_by_key(|(_, count)| *count).map(|(item, _)| item)
}
