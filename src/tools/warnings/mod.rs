//! Warnings: valid input that is probably a mistake.
//!
//! Each function looks for one kind of mistake in the scene, its meshes and the flags. [`nothing_visible`] examines a
//! picture that shows only its background a second time.

mod filter;
mod flags;
mod scene;
mod view;

pub use flags::{about_colors, colors_not_asked_for};
pub use scene::{lights_without_effect, no_lights, triangles_without_area};
pub use view::nothing_visible;

use crate::diagnostic::{Diagnostic, Position, Severity};

/// A probable mistake. Positions refer to the scene's text; the caller adds the file.
enum Warning {
    NoLights,
    LightWithoutEffect {
        at: Position,
        why: &'static str,
    },
    FlatTriangles {
        at: Position,
        count: usize,
    },
    FlatTrianglesOfMesh {
        at: Position,
        count: usize,
        all: usize,
    },
    NothingVisible {
        at: Position,
        why: &'static str,
        hint: Option<String>,
    },
    /// `why` is the end of the sentence, with its punctuation.
    FlagsWithoutEffect {
        flags: Vec<String>,
        why: String,
    },
    NotFollowed {
        at: Position,
        is_transparent: bool,
    },
    BlackInside {
        at: Position,
    },
    NarrowFilter {
        flag: String,
        wide_enough: String,
    },
}

impl From<Warning> for Diagnostic {
    fn from(warning: Warning) -> Self {
        let have = |count: usize| if count == 1 { "has" } else { "have" };
        let located = |at: Position, message: String| Self::warning(message).at(at);
        let flat = "no ray hits a triangle whose corners lie on one line";
        match warning {
            // In the words of the course's program.
            Warning::NoLights => {
                Self { severity: Severity::CourseWarning, ..Self::warning("No lights specified") }
            }
            Warning::LightWithoutEffect { at, why } => located(at, format!("the light has no effect: {why}")),
            Warning::FlatTriangles { at, count: 1 } => {
                located(at, "the triangle has no area".into()).with_hint(flat)
            }
            Warning::FlatTriangles { at, count } => {
                located(at, format!("{count} triangles have no area; this is the first")).with_hint(flat)
            }
            Warning::FlatTrianglesOfMesh { at, count, all } => {
                let message = format!("{count} of the {all} triangles of the mesh {} no area", have(count));
                located(at, message).with_hint(flat)
            }
            Warning::NothingVisible { at, why, hint } => {
                Self { hint, ..located(at, format!("no ray hits anything{why}")) }
            }
            Warning::FlagsWithoutEffect { flags, why } => {
                let named: Vec<String> = flags.iter().map(|flag| format!("`{flag}`")).collect();
                Self::warning(format!("{} {} no effect{why}", named.join(", "), have(flags.len())))
            }
            Warning::NotFollowed { at, is_transparent } => {
                let way = if is_transparent { "transmits" } else { "reflects" };
                located(at, format!("the material {way} light, but without `-bounces` no ray is followed"))
                    .with_hint("add `-bounces 5`, or `-bounces 0` if that is meant")
            }
            Warning::BlackInside { at } => {
                let message =
                    "the material transmits light, but without `-shade_back` it is black from inside";
                located(at, message.into()).with_hint("add `-shade_back`")
            }
            Warning::NarrowFilter { flag, wide_enough } => Self::warning(format!(
                "`{flag}` is too narrow: pixels whose samples have no weight, or weights that nearly cancel, are wrong"
            ))
            .with_hint(format!("`{wide_enough}` is wide enough")),
        }
    }
}
