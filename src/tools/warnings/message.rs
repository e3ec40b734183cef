//! The words of warnings.

use super::Warning;
use super::filter::flag_of;
use crate::diagnostic::{Diagnostic, Severity};
use crate::scene::Position;
use crate::scene::excerpt::with_caret;
use crate::scene_io::Source;
use std::collections::HashMap;
use std::mem::discriminant;

/// Returns the diagnostics of warnings in a scene's text. Of each kind only the first 20 are shown, and then the number of
/// those that are not. `severity` is `Warning`, or `Error` as `-strict` asks.
pub fn diagnostics(found: &[Warning], source: &Source, severity: Severity) -> Vec<Diagnostic> {
    const MOST: usize = 20;
    let kind = |warning: &Warning| match warning {
        Warning::Text(text) => (discriminant(warning), Some(discriminant(&text.doubt))),
        _ => (discriminant(warning), None),
    };
    let mut counts = HashMap::new();
    found.iter().for_each(|warning| *counts.entry(kind(warning)).or_insert(0) += 1);
    let (mut all, mut shown) = (vec![], HashMap::new());
    for warning in found {
        let kind = kind(warning);
        let place = shown.entry(kind).or_insert(0);
        *place += 1;
        match *place {
            1..=MOST => all.push(warning.diagnostic(source, severity)),
            place if place == MOST + 1 => {
                all.push(Diagnostic::new(severity, format!("{} more like these", counts[&kind] - MOST)))
            }
            _ => {}
        }
    }
    all
}

impl Warning {
    /// Returns the warning for the user, with the line of the scene at its place if it has one.
    pub fn diagnostic(&self, source: &Source, severity: Severity) -> Diagnostic {
        if (self, severity) == (&Self::NoLights, Severity::Warning) {
            // The words of the course's program.
            return Diagnostic::new(Severity::CourseWarning, "No lights specified");
        }
        let shown = Diagnostic::new(severity, self.description()).with_hint(self.hint());
        let Some(at) = self.at() else { return shown };
        let in_mesh = if let Self::Text(warning) = self { warning.excerpt_of_mesh() } else { String::new() };
        shown.at(&source.path, Some([at.line, at.column]), with_caret(&source.text, at) + &in_mesh)
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
