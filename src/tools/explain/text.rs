//! Writes the tree of a pixel as text.

use super::tree::{Crossing, LightBlocker, Lighting, MaterialPart, NotFollowed, PixelTree, RayNode};
use super::tree::{SampleTree, Shadow, Surface, TextureWeight};
use crate::diagnostic::Position;
use crate::picture::Color;
use crate::scene::MaterialId;
use crate::scene::material::Phong;
use crate::scene::model::Highlight;
use crate::scene::texels::{FACES, face};
use crate::shading::light::unit_or_zero;
use crate::stats::{Counts, RULE};
use crate::trace::{PathEnd, Secondary};
use glam::DVec3;
use std::fmt;

/// The largest depth that is indented: in a mirror hall, rays may be nested thousands of levels deep.
const DEEPEST: usize = 20;
/// The largest number of rays shown for the first sample.
const SHOWN_RAYS: usize = 512;
/// The largest number of other samples shown, in a line each.
const SHOWN_SAMPLES: usize = 1024;

#[derive(Clone, Debug)]
pub struct Line {
    pub text: String,
    /// The index of the first sample's ray that the line describes, and the index of a light if it is about one.
    pub about: Option<(usize, Option<usize>)>,
}

impl fmt::Display for PixelTree {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.lines().iter().try_for_each(|line| writeln!(f, "{}", line.text))
    }
}

impl PixelTree {
    pub fn lines(&self) -> Vec<Line> {
        let mut text = Text { tree: self, lines: vec![], indent: 0, about: None };
        text.add(RULE);
        text.add(format!("PIXEL ({}, {})", self.pixel[0], self.pixel[1]));
        text.indent = 2;
        if let Some((first, others)) = self.samples.split_first() {
            text.sample(first);
            for sample in others.iter().take(SHOWN_SAMPLES) {
                let rays = grouped(sample.rays.len() as u64 + sample.left_out.rays);
                text.add(format!("{}: colour {}, rays {rays}", head(sample), triple(sample.color)));
            }
            text.more(others.len().saturating_sub(SHOWN_SAMPLES) as u64 + self.more_samples, "samples");
        }
        let [r, g, b] = self.color.to_array();
        let [red, green, blue] = self.bytes;
        text.labelled("samples", self.samples.len() as u64 + self.more_samples);
        text.labelled("counted", text.counted(self.counts()));
        // All digits are shown, because the bytes are truncated from them.
        text.labelled("sum", format!("({r}, {g}, {b})"));
        text.labelled("bytes", format!("({red}, {green}, {blue})"));
        for name in self.close_channels() {
            text.labelled("close call", format!("255 times {name} is within roundings of a whole number"));
        }
        text.indent = 0;
        text.add(RULE);
        text.lines
    }
}

/// Lines under construction.
struct Text<'t> {
    tree: &'t PixelTree,
    lines: Vec<Line>,
    indent: usize,
    /// The subject of the next lines.
    about: Option<(usize, Option<usize>)>,
}

impl Text<'_> {
    fn add(&mut self, text: impl fmt::Display) {
        self.lines.push(Line { text: format!("{:1$}{text}", "", self.indent), about: self.about });
    }

    fn labelled(&mut self, label: &str, value: impl fmt::Display) {
        self.add(format!("{label:<27}{value}"));
    }

    /// Adds the number of things that are not shown, if there are any.
    fn more(&mut self, count: u64, what: &str) {
        if count > 0 {
            self.add(format!("and {} more {what}", grouped(count)));
        }
    }

    fn counted(&self, Counts { intersections, cells_traversed, .. }: Counts) -> String {
        match self.tree.has_grid {
            true => format!("intersection tests {intersections}, steps between cells {cells_traversed}"),
            false => format!("intersection tests {intersections}"),
        }
    }

    fn sample(&mut self, sample: &SampleTree) {
        let SampleTree { color, rays, left_out, .. } = sample;
        self.add(head(sample));
        let mut waiting = if rays.is_empty() { vec![] } else { vec![0] };
        let mut shown = 0;
        while let Some(place) = waiting.pop().filter(|_| shown < SHOWN_RAYS) {
            shown += 1;
            self.indent = 4 + 2 * rays[place].bounces.min(DEEPEST);
            self.ray(place, &rays[place]);
            waiting.extend(rays[place].children.iter().rev());
        }
        (self.indent, self.about) = (4, None);
        self.more((rays.len() - shown) as u64 + left_out.rays, "rays");
        self.add(format!("the sample's colour {}", triple(*color)));
        self.indent = 2;
    }

    fn ray(&mut self, place: usize, node: &RayNode) {
        let RayNode { kind, bounces, ray, filter, weight, .. } = node;
        self.about = Some((place, None));
        self.add(match kind {
            None => "camera ray".into(),
            Some(kind) => format!(
                "{} ray, bounce {bounces}, weight {}, times {}",
                kind.name(),
                short(*weight),
                triple(*filter)
            ),
        });
        self.indent += 2;
        self.add(format!("from {} along {}", triple(ray.origin), triple(ray.direction)));
        match &node.surface {
            Some(surface) => self.surface(surface),
            None if self.tree.has_cube_map => {
                let face = FACES[face(ray.direction).0];
                self.add(format!("sees nothing but the face {face} of the cube map"));
            }
            None => self.add("sees nothing"),
        }
        self.add(self.counted(node.counts));
        node.close_calls.iter().for_each(|call| self.add(call));
        match &node.surface {
            Some(Surface { ambient: None, .. }) => {
                self.add("seen from behind, where it is black without -shade_back");
            }
            Some(surface @ Surface { ambient: Some(ambient), lights, .. }) => {
                self.add(format!("ambient {}", triple(*ambient)));
                for (number, light) in lights.iter().enumerate() {
                    self.about = Some((place, Some(number)));
                    self.light(number, light, surface, -ray.direction);
                }
                self.about = Some((place, None));
            }
            None => {}
        }
        self.add(format!("own colour {}", triple(node.color)));
        for &NotFollowed { kind, end } in &node.ends {
            self.add(format!("no {} ray: {}", kind.name(), self.why(kind, end)));
        }
    }

    fn surface(&mut self, surface: &Surface) {
        let Surface { object, t, point, material_at, material, textures, parts, paint, .. } = surface;
        self.add(format!("sees {object} at t {}", short(*t)));
        self.add(format!("point {}, normal {}", triple(point.position), triple(point.normal)));
        for TextureWeight { name, material, at, children: [one, other], first } in textures {
            let (texture, first, second) =
                (named_material(*material, *at), short(*first), short(1.0 - first));
            self.add(format!(
                "{texture} is a {name}: material {one} weighs {first}, material {other} {second}"
            ));
        }
        for MaterialPart { material, at, weight, phong } in parts {
            let (part, colors) = (named_material(*material, *at), self.colors(phong, true, ""));
            self.add(format!("{part} weighs {}: {colors}", short(*weight)));
        }
        // Highlights keep the exponents of their own materials.
        let mixed = if parts.is_empty() { "" } else { ", mixed" };
        let colors = self.colors(material, parts.is_empty(), paint);
        self.add(format!("{}{mixed}: {colors}", named_material(point.material, *material_at)));
    }

    /// Returns the colours of a material. `paint` is the source of the diffuse one, if it is not the material itself.
    fn colors(&self, phong: &Phong, has_exponent: bool, paint: &str) -> String {
        let [diffuse, specular, reflective, transparent] =
            [phong.diffuse, phong.specular, phong.reflective, phong.transparent].map(triple);
        // A number is shown only if the colour that it belongs to is not black.
        let number = |name: &str, color: Color, number: f64| match color == Color::ZERO {
            true => String::new(),
            false => format!(" with {name} {}", short(number)),
        };
        let shown = if has_exponent { phong.specular } else { Color::ZERO };
        let index = number("index of refraction", phong.transparent, phong.index_of_refraction);
        match self.tree.highlight {
            Highlight::Blinn => format!(
                "diffuse {diffuse}{paint}, specular {specular}{}, reflective {reflective}, \
                 transparent {transparent}{index}",
                number("exponent", shown, phong.exponent)
            ),
            Highlight::Phong => {
                let shininess = number("shininess", shown, phong.exponent);
                format!("diffuse {diffuse}{paint}, specular {reflective}{shininess}{index}")
            }
        }
    }

    /// Adds what a light contributes, the vectors of the lighting formula, and the ray towards the light.
    fn light(&mut self, number: usize, light: &Lighting, surface: &Surface, to_viewer: DVec3) {
        let Lighting { incident, cosine, passed, parts, shadow } = light;
        let (highlight, to_light) = (self.tree.highlight, incident.direction);
        let is_shiny = parts[1] != Color::ZERO;
        // In later editions, highlights appear behind the surface, too.
        let is_behind = *cosine <= 0.0 && !(highlight == Highlight::Phong && is_shiny);
        let [diffuse, specular] = parts.map(|part| triple(*passed * part));
        let cosine = short(*cosine);
        self.add(match (is_behind, incident.color == Color::ZERO) {
            (true, _) => format!("light {number} is behind the surface, cosine {cosine}"),
            (false, true) => format!("light {number} is dark here"),
            _ => format!("light {number}: diffuse {diffuse}, specular {specular}, cosine {cosine}"),
        });
        self.indent += 2;
        let normal = surface.point.normal;
        let normal = if normal.dot(to_viewer) < 0.0 { -normal } else { normal };
        let others = match highlight {
            _ if is_behind || !is_shiny => String::new(),
            Highlight::Blinn => {
                let half_way = unit_or_zero(to_light + to_viewer);
                format!(", half-way vector H {}, N.H {}", triple(half_way), short(normal.dot(half_way)))
            }
            Highlight::Phong => {
                let mirrored = 2.0 * to_viewer.dot(normal) * normal - to_viewer;
                format!(", mirrored view R {}, R.L {}", triple(mirrored), short(mirrored.dot(to_light)))
            }
        };
        self.add(format!("L {} towards the light{others}", triple(to_light)));
        if let Some(shadow) = shadow {
            self.shadow(light, shadow);
        }
        self.indent -= 2;
    }

    fn shadow(&mut self, light: &Lighting, shadow: &Shadow) {
        for Crossing { object, hit, tint, is_leaving } in &shadow.crossed {
            let t = short(hit.t);
            self.add(match is_leaving {
                _ if *tint == Color::ZERO => format!("shadow ray blocked by {object} at t {t}"),
                false => format!("shadow ray enters {object} at t {t}"),
                true => format!("shadow ray leaves {object} after t {t}, tinted {} per unit", triple(*tint)),
            });
        }
        match &shadow.blocker {
            Some(LightBlocker { object, t }) => {
                self.add(format!("shadow ray blocked by {object} at t {}", short(*t)));
            }
            None if !shadow.crossed.is_empty() => {}
            None if light.passed == Color::ZERO && light.cosine > 0.0 => {
                self.add("the light lies on a surface, which blocks it everywhere else");
            }
            None => self.add("shadow ray meets nothing"),
        }
        self.add(self.counted(shadow.counts));
        shadow.close_calls.iter().for_each(|call| self.add(call));
    }

    /// Returns the reason why there is no secondary ray of a kind.
    fn why(&self, kind: Secondary, end: PathEnd) -> String {
        let reason = match (end, kind, self.tree.highlight) {
            (PathEnd::NoColor, Secondary::Reflected, Highlight::Blinn) => "no reflective colour",
            (PathEnd::NoColor, Secondary::Refracted, Highlight::Blinn) => "no transparent colour",
            (PathEnd::NoColor, Secondary::Reflected, Highlight::Phong) => "no specular colour",
            (PathEnd::NoColor, Secondary::Refracted, Highlight::Phong) => "the material is opaque",
            (PathEnd::Bounces, ..) => "no bounces left",
            (PathEnd::TotalReflection, ..) => "total internal reflection",
            (PathEnd::Weight { weight }, ..) => return format!("weight {} is too little", short(weight)),
        };
        reason.into()
    }
}

/// Identifies a sample.
fn head(SampleTree { pixel: [x, y], number, offset, weight, .. }: &SampleTree) -> String {
    let (right, up, weight) = (short(offset.x), short(offset.y), short(*weight));
    format!("sample {number} of pixel ({x}, {y}) at ({right}, {up}) from its centre, weight {weight}")
}

/// Names a material with its line in the scene's text.
fn named_material(material: MaterialId, at: Position) -> String {
    format!("material {material} in line {}", at.line)
}

/// Formats a number with its digits in groups of three.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let separator = |at: usize| if at > 0 && (digits.len() - at).is_multiple_of(3) { "," } else { "" };
    digits.char_indices().map(|(at, digit)| format!("{}{digit}", separator(at))).collect()
}

/// Formats a number with nine significant digits, without trailing zeros.
fn short(number: f64) -> String {
    const PLAIN: std::ops::Range<f64> = 1e-4..1e9;
    let rounded: f64 = format!("{number:.8e}").parse().unwrap_or(number);
    // Adding zero turns a negative zero into a positive one.
    let rounded = rounded + 0.0;
    match rounded == 0.0 || PLAIN.contains(&rounded.abs()) || !rounded.is_finite() {
        true => rounded.to_string(),
        false => format!("{rounded:e}"),
    }
}

/// Formats three numbers in parentheses.
fn triple(vector: DVec3) -> String {
    format!("({})", vector.to_array().map(short).join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shading::light::Incident;

    #[test]
    fn nine_digits_are_shown_and_none_that_says_nothing() {
        for (number, text) in [
            (1.0 / 3.0, "0.333333333"),
            (0.1 + 0.2, "0.3"),
            (-0.0, "0"),
            (123456789.4, "123456789"),
            (-2.5e-7, "-2.5e-7"),
            (1e100, "1e100"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(short(number), text);
        }
        assert_eq!([7, 999, 1000, 1_234_567].map(grouped), ["7", "999", "1,000", "1,234,567"]);
    }

    #[test]
    fn a_light_on_a_triangle_is_told_from_one_in_sight() {
        for (passed, cosine, expected) in [
            (Color::ONE, 0.5, "shadow ray meets nothing"),
            (Color::ZERO, -0.5, "shadow ray meets nothing"),
            (Color::ZERO, 0.5, "the light lies on a surface, which blocks it everywhere else"),
        ] {
            let incident = Incident { direction: DVec3::X, distance: 1.0, color: Color::ONE };
            let light = Lighting { incident, cosine, passed, parts: [Color::ONE; 2], shadow: None };
            let tree = PixelTree::default();
            let mut text = Text { tree: &tree, lines: vec![], indent: 0, about: None };
            text.shadow(&light, &Shadow::default());
            assert_eq!(text.lines[0].text, expected);
        }
    }
}
