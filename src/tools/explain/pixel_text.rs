//! Writes the tree of rays behind a pixel as text.

use super::objects::{MaterialPart, ObjectPart};
use super::pixel::{MaterialWords, PixelTree, SampleTree};
use super::ray_tree::{Crossing, LightBlocker, Lighting, NotFollowed, RayNode, Shadow, Surface};
use super::short::{Short, Triple};
use crate::picture::Color;
use crate::scene::material::Phong;
use crate::scene::{MaterialId, Position};
use crate::shading::light::unit_or_zero;
use crate::stats::{Counts, RULE};
use crate::trace::{PathEnd, Secondary};
use glam::DVec3;
use std::fmt::{Display, Formatter, Result};

/// The largest depth that is indented: in a mirror hall, rays may be nested thousands of levels deep.
const DEEPEST: usize = 20;

/// The largest number of rays shown for the first sample.
const SHOWN_RAYS: usize = 512;
/// The largest number of other samples shown, in a line each.
const SHOWN_SAMPLES: usize = 1024;

/// Lines with the same indentation.
struct Lines<'f, 'g> {
    f: &'f mut Formatter<'g>,
    indent: usize,
}

impl<'g> Lines<'_, 'g> {
    fn line(&mut self, text: impl Display) -> Result {
        writeln!(self.f, "{:1$}{text}", "", self.indent)
    }

    fn deeper(&mut self) -> Lines<'_, 'g> {
        Lines { f: &mut *self.f, indent: self.indent + 2 }
    }
}

impl Display for PixelTree {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let [x, y] = self.pixel;
        writeln!(f, "{RULE}\nPIXEL ({x}, {y})")?;
        let mut lines = Lines { f: &mut *f, indent: 2 };
        if let Some((first, others)) = self.samples.split_first() {
            write_sample(first, Style { has_grid: self.has_grid, words: self.words }, &mut lines)?;
            others.iter().take(SHOWN_SAMPLES).try_for_each(|sample| write_briefly(sample, &mut lines))?;
            let more = others.len().saturating_sub(SHOWN_SAMPLES) as u64 + self.more_samples;
            write_more(more, "samples", &mut lines)?;
        }
        let [red, green, blue] = self.bytes;
        let [r, g, b] = self.color.to_array();
        let mut line = |label: &str, value: String| writeln!(f, "  {label:<27}{value}");
        line("samples", (self.samples.len() as u64 + self.more_samples).to_string())?;
        line("counted", counted(self.counts(), self.has_grid))?;
        // All digits are shown, because the bytes are truncated from them.
        line("sum", format!("({r}, {g}, {b})"))?;
        line("bytes", format!("({red}, {green}, {blue})"))?;
        for name in self.close_channels() {
            line("close call", format!("255 times {name} is within roundings of a whole number"))?;
        }
        writeln!(f, "{RULE}")
    }
}

/// The settings for the text of a pixel.
#[derive(Clone, Copy)]
struct Style {
    has_grid: bool,
    words: MaterialWords,
}

fn write_sample(sample: &SampleTree, style: Style, lines: &mut Lines) -> Result {
    let SampleTree { color, rays, left_out, .. } = sample;
    lines.line(Head(sample))?;
    let mut waiting = if rays.is_empty() { vec![] } else { vec![0] };
    let mut shown = 0;
    while let Some(place) = waiting.pop().filter(|_| shown < SHOWN_RAYS) {
        shown += 1;
        let node = &rays[place];
        let indent = 4 + 2 * node.bounces.min(DEEPEST);
        write_ray(node, style, &mut Lines { f: &mut *lines.f, indent })?;
        waiting.extend(node.children.iter().rev());
    }
    let mut lines = lines.deeper();
    write_more((rays.len() - shown) as u64 + left_out.rays, "rays", &mut lines)?;
    lines.line(format_args!("the sample's colour {}", Triple(*color)))
}

/// Writes a sample in one line.
fn write_briefly(sample: &SampleTree, lines: &mut Lines) -> Result {
    let rays = sample.rays.len() as u64 + sample.left_out.rays;
    lines.line(format_args!("{}: colour {}, rays {}", Head(sample), Triple(sample.color), Grouped(rays)))
}

fn write_more(count: u64, what: &str, lines: &mut Lines) -> Result {
    if count == 0 { Ok(()) } else { lines.line(format_args!("and {} more {what}", Grouped(count))) }
}

/// The heading that identifies a sample.
struct Head<'s>(&'s SampleTree);

impl Display for Head<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let SampleTree { pixel: [x, y], number, offset, weight, .. } = self.0;
        let place = format!("({}, {})", Short(offset.x), Short(offset.y));
        let weight = Short(*weight);
        write!(f, "sample {number} of pixel ({x}, {y}) at {place} from its centre, weight {weight}")
    }
}

/// A number with its digits in groups of three.
struct Grouped(u64);

impl Display for Grouped {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let digits = self.0.to_string();
        digits.char_indices().try_for_each(|(at, digit)| {
            let is_group = at > 0 && (digits.len() - at).is_multiple_of(3);
            if is_group { write!(f, ",{digit}") } else { write!(f, "{digit}") }
        })
    }
}

fn write_ray(node: &RayNode, style: Style, lines: &mut Lines) -> Result {
    let Style { has_grid, words } = style;
    let ray = &node.ray;
    match node.kind {
        None => lines.line("camera ray")?,
        Some(kind) => lines.line(format_args!(
            "{} ray, bounce {}, weight {}, times {}",
            name(kind),
            node.bounces,
            Short(node.weight),
            Triple(node.filter)
        ))?,
    }
    let mut lines = lines.deeper();
    lines.line(format_args!("from {} along {}", Triple(ray.origin), Triple(ray.direction)))?;
    match (&node.surface, node.cube_face) {
        (None, None) => lines.line("sees nothing")?,
        (None, Some(face)) => lines.line(format_args!("sees nothing but the face {face} of the cube map"))?,
        (Some(surface), _) => write_surface(surface, words, &mut lines)?,
    }
    lines.line(format_args!("counted {}", counted(node.counts, has_grid)))?;
    node.close_calls.iter().try_for_each(|call| lines.line(call))?;
    if let Some(surface) = &node.surface {
        write_lights(surface, -ray.direction, style, &mut lines)?;
    }
    lines.line(format_args!("own colour {}", Triple(node.color)))?;
    node.ends.iter().try_for_each(|&NotFollowed { kind, end }| {
        lines.line(format_args!("no {} ray: {}", name(kind), Why(kind, end, words)))
    })
}

fn write_surface(surface: &Surface, words: MaterialWords, lines: &mut Lines) -> Result {
    let Surface { object, t, point, material_at, material, textures, parts, paint, .. } = surface;
    lines.line(format_args!("sees {} at t {}", Named(object), Short(*t)))?;
    lines.line(format_args!("point {}, normal {}", Triple(point.position), Triple(point.normal)))?;
    for texture in textures {
        let ([one, other], first) = (texture.children, texture.first);
        lines.line(format_args!(
            "{} is a {}: material {one} weighs {}, material {other} {}",
            NamedMaterial(texture.material, texture.at),
            texture.name,
            Short(first),
            Short(1.0 - first)
        ))?;
    }
    for MaterialPart { material, at, weight, phong } in parts {
        let (named, weight) = (NamedMaterial(*material, *at), Short(*weight));
        let colors = Colors { phong, has_exponent: true, paint: &None, words };
        lines.line(format_args!("{named} weighs {weight}: {colors}"))?;
    }
    // Highlights keep the exponents of their own materials.
    let (named, mixed) =
        (NamedMaterial(point.material, *material_at), if parts.is_empty() { "" } else { ", mixed" });
    let colors = Colors { phong: material, has_exponent: parts.is_empty(), paint, words };
    lines.line(format_args!("{named}{mixed}: {colors}"))
}

/// The colours of a material.
struct Colors<'p> {
    phong: &'p Phong,
    has_exponent: bool,
    /// The source of the diffuse colour, if it is not the material itself.
    paint: &'p Option<String>,
    words: MaterialWords,
}

impl Display for Colors<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let Phong { diffuse, specular, exponent, reflective, transparent, index_of_refraction } = *self.phong;
        let shown = if self.has_exponent { specular } else { Color::ZERO };
        let index = Power("index of refraction", transparent, index_of_refraction);
        write!(f, "diffuse {}", Triple(diffuse))?;
        if let Some(paint) = self.paint {
            write!(f, " of {paint}")?;
        }
        match self.words {
            MaterialWords::Reflective => write!(
                f,
                ", specular {}{}, reflective {}, transparent {}{index}",
                Triple(specular),
                Power("exponent", shown, exponent),
                Triple(reflective),
                Triple(transparent),
            ),
            MaterialWords::Specular => {
                let shininess = Power("shininess", shown, exponent);
                write!(f, ", specular {}{shininess}{index}", Triple(reflective))
            }
        }
    }
}

/// A material with its line in the scene's text.
struct NamedMaterial(MaterialId, Option<Position>);

impl Display for NamedMaterial {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "material {}", self.0)?;
        self.1.map_or(Ok(()), |at| write!(f, " in line {}", at.line))
    }
}

/// A number of a material that is shown only if this colour is not black.
struct Power(&'static str, Color, f64);

impl Display for Power {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        if self.1 == Color::ZERO { Ok(()) } else { write!(f, " with {} {}", self.0, Short(self.2)) }
    }
}

fn write_lights(surface: &Surface, to_viewer: DVec3, style: Style, lines: &mut Lines) -> Result {
    let Some(ambient) = surface.ambient else {
        return lines.line("seen from within, where it is black without -shade_back");
    };
    lines.line(format_args!("ambient {}", Triple(ambient)))?;
    for (number, light) in surface.lights.iter().enumerate() {
        write_light(number, light, style.words, lines)?;
        write_directions(surface, light, to_viewer, style.words, &mut lines.deeper())?;
        if let Some(shadow) = &light.shadow {
            write_shadow(light, shadow, style.has_grid, &mut lines.deeper())?;
        }
    }
    Ok(())
}

fn write_light(number: usize, light: &Lighting, words: MaterialWords, lines: &mut Lines) -> Result {
    let Lighting { incident, cosine, passed, parts: [diffuse, specular], .. } = light;
    let cosine = Short(*cosine);
    // In later editions, highlights appear there, too.
    let may_shine = words == MaterialWords::Specular && *specular != Color::ZERO;
    if light.cosine <= 0.0 && !may_shine {
        return lines.line(format_args!("light {number} is behind the surface, cosine {cosine}"));
    }
    if incident.color == Color::ZERO {
        return lines.line(format_args!("light {number} is dark here"));
    }
    let [diffuse, specular] = [diffuse, specular].map(|&part| Triple(*passed * part));
    lines.line(format_args!("light {number}: diffuse {diffuse}, specular {specular}, cosine {cosine}"))
}

/// Writes the vectors of the lighting formula: the direction to the light and, if there is a highlight, the direction
/// used for its cosine.
fn write_directions(
    surface: &Surface,
    light: &Lighting,
    to_viewer: DVec3,
    words: MaterialWords,
    lines: &mut Lines,
) -> Result {
    let (to_light, shown) = (light.incident.direction, Triple(light.incident.direction));
    let is_behind = words == MaterialWords::Reflective && light.cosine <= 0.0;
    if is_behind || light.parts[1] == Color::ZERO {
        return lines.line(format_args!("L {shown} towards the light"));
    }
    let normal = surface.point.normal;
    let normal = if normal.dot(to_viewer) < 0.0 { -normal } else { normal };
    match words {
        MaterialWords::Reflective => {
            let half_way = unit_or_zero(to_light + to_viewer);
            let cosine = Short(normal.dot(half_way));
            lines.line(format_args!(
                "L {shown} towards the light, half-way vector H {}, N.H {cosine}",
                Triple(half_way)
            ))
        }
        MaterialWords::Specular => {
            let mirrored = 2.0 * to_viewer.dot(normal) * normal - to_viewer;
            let cosine = Short(mirrored.dot(to_light));
            lines.line(format_args!(
                "L {shown} towards the light, mirrored view R {}, R.L {cosine}",
                Triple(mirrored)
            ))
        }
    }
}

fn write_shadow(light: &Lighting, shadow: &Shadow, has_grid: bool, lines: &mut Lines) -> Result {
    for Crossing { object, hit, tint, leaves } in &shadow.crossed {
        let (object, t) = (Named(object), Short(hit.t));
        match (*tint == Color::ZERO, leaves) {
            (true, _) => lines.line(format_args!("shadow ray blocked by {object} at t {t}"))?,
            (_, false) => lines.line(format_args!("shadow ray enters {object} at t {t}"))?,
            (_, true) => {
                let tint = Triple(*tint);
                lines.line(format_args!("shadow ray leaves {object} after t {t}, tinted {tint} per unit"))?
            }
        }
    }
    match &shadow.blocker {
        Some(LightBlocker { object, t }) => {
            lines.line(format_args!("shadow ray blocked by {} at t {}", Named(object), Short(*t)))?
        }
        None if light.passed == Color::ZERO && light.cosine > 0.0 && shadow.crossed.is_empty() => {
            lines.line("the light lies on a surface, which keeps it from all others")?
        }
        None if shadow.crossed.is_empty() => lines.line("shadow ray meets nothing")?,
        None => {}
    }
    lines.line(format_args!("counted {}", counted(shadow.counts, has_grid)))?;
    shadow.close_calls.iter().try_for_each(|call| lines.line(call))
}

/// An object, or "a surface" if it is unknown.
struct Named<'o>(&'o Option<ObjectPart>);

impl Display for Named<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match self.0 {
            Some(object) => object.fmt(f),
            None => f.write_str("a surface"),
        }
    }
}

fn counted(counts: Counts, has_grid: bool) -> String {
    let Counts { intersections, cells_traversed, .. } = counts;
    let cells = if has_grid { format!(", steps between cells {cells_traversed}") } else { String::new() };
    format!("tests {intersections}{cells}")
}

fn name(kind: Secondary) -> &'static str {
    match kind {
        Secondary::Reflected => "reflected",
        Secondary::Refracted => "refracted",
    }
}

/// The reason why there is no secondary ray of a kind.
struct Why(Secondary, PathEnd, MaterialWords);

impl Display for Why {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let Self(kind, end, words) = *self;
        f.write_str(match (end, kind, words) {
            (PathEnd::NoColor, Secondary::Reflected, MaterialWords::Reflective) => "no reflective colour",
            (PathEnd::NoColor, Secondary::Refracted, MaterialWords::Reflective) => "no transparent colour",
            (PathEnd::NoColor, Secondary::Reflected, MaterialWords::Specular) => "no specular colour",
            (PathEnd::NoColor, Secondary::Refracted, MaterialWords::Specular) => "the material is opaque",
            (PathEnd::Bounces, ..) => "no bounces left",
            (PathEnd::TotalReflection, ..) => "total internal reflection",
            (PathEnd::Weight { weight }, ..) => {
                return write!(f, "weight {} is too little", Short(weight));
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::ray::Ray;
    use crate::shading::light::Incident;

    struct OneShadow(Lighting);

    impl Display for OneShadow {
        fn fmt(&self, f: &mut Formatter) -> Result {
            let (ray, counts) = (Ray::new(DVec3::ZERO, DVec3::X), Counts::default());
            let shadow = Shadow { ray, crossed: vec![], blocker: None, counts, close_calls: vec![] };
            write_shadow(&self.0, &shadow, false, &mut Lines { f, indent: 0 })
        }
    }

    #[test]
    fn a_light_on_a_triangle_is_told_from_one_in_sight() {
        for (passed, cosine, expected) in [
            (Color::ONE, 0.5, "shadow ray meets nothing"),
            (Color::ZERO, -0.5, "shadow ray meets nothing"),
            (Color::ZERO, 0.5, "the light lies on a surface, which keeps it from all others"),
        ] {
            let incident = Incident { direction: DVec3::X, distance: 1.0, color: Color::ONE };
            let light = Lighting { incident, cosine, passed, parts: [Color::ONE; 2], shadow: None };
            assert_eq!(OneShadow(light).to_string().lines().next(), Some(expected));
        }
    }
}
