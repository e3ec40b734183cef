//! What a scene says without an error, but hardly on purpose.

use super::excerpt;
use super::mesh::{self, MeshError};
use super::{Color, Position};
use crate::escape::quoted;
use std::fmt;

/// A doubtful place in a scene's text.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneWarning {
    /// The position.
    pub at: Position,
    /// What is doubtful.
    pub doubt: Doubt,
}

/// What is doubtful.
#[derive(Clone, Debug, PartialEq)]
pub enum Doubt {
    /// A block that takes the place of an earlier one.
    Replaces {
        /// What it is, as in `camera`.
        block: &'static str,
        /// The line of the earlier one.
        earlier: u32,
    },
    /// A colour above 1, the brightest that a picture shows.
    AboveOne {
        /// The name of the field.
        field: String,
        /// The colour.
        color: Color,
        /// How many further colours are above 1.
        others: usize,
    },
    /// Something in a mesh file.
    InMesh {
        /// The file.
        file: String,
        /// What it is.
        doubt: MeshError,
        /// The line of the file with a caret.
        excerpt: String,
    },
}

impl SceneWarning {
    pub(super) fn color_above_one(at: Position, field: &str, color: Color) -> Self {
        Self { at, doubt: Doubt::AboveOne { field: field.to_owned(), color, others: 0 } }
    }

    /// The warning about a mesh file with these contents, which the scene names at this position.
    pub(crate) fn in_mesh(at: Position, file: String, doubt: &MeshError, bytes: &[u8]) -> Self {
        let excerpt = doubt.at.map(|at| mesh::excerpt(bytes, at)).unwrap_or_default();
        Self { at, doubt: Doubt::InMesh { file, doubt: doubt.clone(), excerpt } }
    }

    /// The line of a mesh file that is meant, with a caret, after a line with the position; empty for a warning about
    /// the scene's own text.
    pub fn excerpt_of_mesh(&self) -> String {
        match &self.doubt {
            Doubt::InMesh { file, doubt, excerpt } => {
                doubt.at.map(|at| excerpt::of_file(file, at, excerpt)).unwrap_or_default()
            }
            Doubt::AboveOne { .. } | Doubt::Replaces { .. } => String::new(),
        }
    }

    /// Advice in one line, if there is any.
    pub fn hint(&self) -> Option<String> {
        match &self.doubt {
            Doubt::AboveOne { color, .. } if is_byte_like(*color) => Some("is it meant as 0 to 255?".into()),
            Doubt::AboveOne { .. } | Doubt::Replaces { .. } => None,
            Doubt::InMesh { doubt, .. } => doubt.hint.clone(),
        }
    }
}

/// Whether a colour has whole numbers up to 255.
pub(super) fn is_byte_like(color: Color) -> bool {
    color.to_array().iter().all(|channel| (0.0..=255.0).contains(channel) && channel.fract() == 0.0)
}

impl fmt::Display for SceneWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.doubt {
            Doubt::InMesh { file, doubt, .. } => write!(f, "in the mesh {}: {doubt}", quoted(file)),
            Doubt::Replaces { block, earlier } => {
                write!(f, "a second {block}: it replaces the one in line {earlier}")
            }
            Doubt::AboveOne { field, others, .. } => {
                write!(f, "`{field}` is above 1, the brightest that a picture shows")?;
                match others {
                    0 => Ok(()),
                    1 => write!(f, "; so is another colour"),
                    _ => write!(f, "; so are {others} more colours"),
                }
            }
        }
    }
}

/// The same warnings, with all colours above 1 in one, which stands at the first.
pub(super) fn merged(all: Vec<SceneWarning>) -> Vec<SceneWarning> {
    let is_color = |warning: &SceneWarning| matches!(warning.doubt, Doubt::AboveOne { .. });
    let colors = all.iter().filter(|warning| is_color(warning)).count();
    let mut merged = all;
    let mut is_first = true;
    merged.retain_mut(|warning| match &mut warning.doubt {
        Doubt::AboveOne { others, .. } => {
            *others = colors - 1;
            std::mem::take(&mut is_first)
        }
        Doubt::Replaces { .. } | Doubt::InMesh { .. } => true,
    });
    merged
}
