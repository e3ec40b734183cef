//! The words of warnings.

use super::Warning;
use super::filter::flag_of;
use crate::scene::Position;
use crate::scene::error::labelled;
use crate::scene::excerpt::with_caret;
use crate::scene_io::Source;
use std::collections::HashMap;
use std::mem::discriminant;

/// How serious a warning is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The run goes on.
    Warning,
    /// The run ends, as `-strict` asks for.
    Error,
}

impl Severity {
    fn label(self) -> &'static str {
        match self {
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// The messages of warnings, as [`Warning::render`] gives them. Of each kind only the first 20 are shown, and then the
/// number of those that are not.
pub fn render_all(found: &[Warning], source: &Source, severity: Severity) -> Vec<String> {
    const MOST: usize = 20;
    let kind = |warning: &Warning| match warning {
        Warning::Text(text) => (discriminant(warning), Some(discriminant(&text.doubt))),
        _ => (discriminant(warning), None),
    };
    let mut counts = HashMap::new();
    found.iter().for_each(|warning| *counts.entry(kind(warning)).or_insert(0) += 1);
    let (mut lines, mut shown) = (vec![], HashMap::new());
    for warning in found {
        let kind = kind(warning);
        let place = shown.entry(kind).or_insert(0);
        *place += 1;
        match *place {
            1..=MOST => lines.push(warning.render(source, severity)),
            place if place == MOST + 1 => {
                lines.push(format!("{}: {} more like these", severity.label(), counts[&kind] - MOST))
            }
            _ => {}
        }
    }
    lines
}

impl Warning {
    /// The whole message without a final line end: file, line and column with the line of the scene, if the
    /// warning has a position, what is wrong, and the hint if there is one.
    pub fn render(&self, source: &Source, severity: Severity) -> String {
        if (self, severity) == (&Self::NoLights, Severity::Warning) {
            // The words of the course's program.
            return "WARNING:  No lights specified".into();
        }
        let hint = self.hint().map(|hint| format!("\n  hint: {hint}")).unwrap_or_default();
        let description = self.description();
        match self.at() {
            None => format!("{}: {description}{hint}", severity.label()),
            Some(at) => {
                let position = format!(":{}:{}", at.line, at.column);
                let in_mesh =
                    if let Self::Text(warning) = self { warning.excerpt_of_mesh() } else { String::new() };
                let message = format!("{description}\n{}{in_mesh}{hint}", with_caret(&source.text, at));
                labelled(&source.path, &position, severity.label(), &message)
            }
        }
    }

    fn at(&self) -> Option<Position> {
        match self {
            Self::Text(warning) => Some(warning.at),
            Self::BlackInside { at }
            | Self::FlatTriangles { at, .. }
            | Self::IdleLight { at, .. }
            | Self::ManyRays { at, .. }
            | Self::NoBounces { at, .. }
            | Self::NothingVisible { at, .. } => *at,
            Self::OpenEdition(_) | Self::NoLights | Self::NoPicture => None,
            Self::IdleFlags { .. } | Self::NarrowFilter { .. } => None,
            Self::NotNumbers { .. } | Self::NanInFile { .. } | Self::BeyondSingle { .. } => None,
        }
    }

    fn description(&self) -> String {
        match self {
            Self::Text(warning) => warning.to_string(),
            Self::OpenEdition([problem, _]) => problem.clone(),
            Self::BlackInside { .. } => {
                "the material transmits light, but without `-shade_back` it is black from inside".into()
            }
            Self::NoLights => "the scene has no lights".into(),
            Self::NoPicture => "no picture is asked for: add `-output file.tga`".into(),
            Self::FlatTriangles { count, of: Some(all), .. } => {
                format!("{count} of the {all} triangles of the mesh {} no area", have(*count as u64))
            }
            Self::FlatTriangles { count: 1, of: None, .. } => "the triangle has no area".into(),
            Self::FlatTriangles { count, of: None, .. } => {
                format!("{count} triangles have no area; this is the first")
            }
            Self::IdleLight { reason, .. } => format!("the light has no effect: {reason}"),
            Self::IdleFlags { flags, reason } => {
                let flags: Vec<String> = flags.iter().map(|flag| format!("`{flag}`")).collect();
                format!("{} {} no {reason}", flags.join(", "), have(flags.len() as u64))
            }
            Self::NarrowFilter { filter, lost, .. } => {
                format!("`{}` is too narrow for the samples: {lost}", flag_of(filter))
            }
            Self::NoBounces { transmits, .. } => {
                let way = if *transmits { "transmits" } else { "reflects" };
                format!("the material {way} light, but without `-bounces` no ray is followed")
            }
            Self::ManyRays { bounces, .. } => format!(
                "`-bounces {bounces}` allows more than a million rays for each sample of a pixel, \
                 since this material both reflects and transmits"
            ),
            Self::NothingVisible { sight, .. } => format!("no ray hits anything{sight}"),
            Self::NotNumbers { pixels: 1 } => "the colour of 1 pixel is not a number; it is black".into(),
            Self::NotNumbers { pixels } => {
                format!("the colours of {pixels} pixels are not numbers; they are black")
            }
            Self::NanInFile { pixels } => format!("pixels that are not numbers, also in the file: {pixels}"),
            Self::BeyondSingle { pixels } => {
                format!("pixels beyond single precision, infinite or 0 in the file: {pixels}")
            }
        }
    }

    fn hint(&self) -> Option<String> {
        match self {
            Self::Text(warning) => warning.hint(),
            Self::OpenEdition([_, hint]) => Some(hint.clone()),
            Self::BlackInside { .. } => Some("add `-shade_back`".into()),
            Self::ManyRays { remedy, .. } => Some(remedy.to_string()),
            Self::NarrowFilter { smallest, .. } => {
                Some(format!("`{}` is the smallest that is wide enough", flag_of(smallest)))
            }
            Self::NoBounces { .. } => Some("add `-bounces 5`, or `-bounces 0` if that is meant".into()),
            Self::NothingVisible { sight, .. } => sight.hint(),
            Self::FlatTriangles { .. } => Some("no ray hits a triangle whose corners lie on one line".into()),
            _ => None,
        }
    }
}

fn have(count: u64) -> &'static str {
    if count == 1 { "has" } else { "have" }
}
