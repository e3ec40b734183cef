//! Warnings: valid input that is probably a mistake.
//!
//! Each function looks for one kind of mistake in the scene, its meshes and the flags.

mod filter;
mod flags;
mod scene;

pub use flags::{about_colors, colors_not_asked_for};
pub use scene::{lights_without_effect, no_lights, nothing_visible, triangles_without_area};

use crate::diagnostic::{Diagnostic, Severity};

/// A probable mistake, without its place.
enum Warning {
    NoLights,
    LightWithoutEffect { why: &'static str },
    FlatTriangles { count: usize },
    FlatTrianglesOfMesh { count: usize, all: usize },
    NothingVisible { why: &'static str, hint: Option<String> },
    FlagsWithoutEffect { flags: Vec<String>, why: String },
    FlagMissing { does: &'static str, without: &'static str, hint: &'static str },
    NarrowFilter { flag: String, wide_enough: String },
}

impl From<Warning> for Diagnostic {
    fn from(warning: Warning) -> Self {
        let have = |count: usize| if count == 1 { "has" } else { "have" };
        let flat = Some("no ray hits a triangle whose corners lie on one line".to_owned());
        let (message, hint) = match warning {
            // In the words of the course's program.
            Warning::NoLights => {
                return Self { severity: Severity::CourseWarning, ..Self::warning("No lights specified") };
            }
            Warning::LightWithoutEffect { why } => (format!("the light has no effect: {why}"), None),
            Warning::FlatTriangles { count: 1 } => ("the triangle has no area".into(), flat),
            Warning::FlatTriangles { count } => {
                (format!("{count} triangles have no area; this is the first"), flat)
            }
            Warning::FlatTrianglesOfMesh { count, all } => {
                (format!("{count} of the {all} triangles of the mesh {} no area", have(count)), flat)
            }
            Warning::NothingVisible { why, hint } => (format!("no ray hits anything{why}"), hint),
            Warning::FlagsWithoutEffect { flags, why } => {
                let named: Vec<String> = flags.iter().map(|flag| format!("`{flag}`")).collect();
                (format!("{} {} no effect{why}", named.join(", "), have(flags.len())), None)
            }
            Warning::FlagMissing { does, without, hint } => {
                (format!("the material {does} light, but without {without}"), Some(hint.into()))
            }
            Warning::NarrowFilter { flag, wide_enough } => {
                let wrong = "in some pixels no sample has weight, or the weights nearly cancel";
                let problem = format!("`{flag}` is too narrow: {wrong}");
                (problem, Some(format!("`{wide_enough}` is wide enough")))
            }
        };
        Self { hint, ..Self::warning(message) }
    }
}
