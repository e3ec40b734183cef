//! The errors that a scene can have, and their messages.

use super::Position;
use super::edition::Edition;
use super::excerpt;
use super::mesh::{self, MeshError};
use crate::escape::{self, escape};
use crate::memory::NoMemory;
use std::fmt;
use std::path::Path;

/// An error in a scene, with its position in the text.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneError {
    /// The position of the error.
    pub at: Position,
    /// The kind of the error.
    pub problem: Problem,
    /// Advice in one line, in addition to the description of the error.
    pub hint: Option<String>,
}

/// The kind of an error. Names and words are quoted as the scene's author wrote them.
#[derive(Clone, Debug, PartialEq)]
pub enum Problem {
    /// A word that the grammar does not allow at this position.
    Expected {
        /// A description of the words that are allowed.
        what: String,
        /// The word in the text; empty at the end of the text.
        found: String,
    },
    /// A value that violates a rule.
    BadValue {
        /// The name of the field.
        field: String,
        /// The rule, for example "must be positive".
        rule: &'static str,
        /// The word in the text; empty at the end of the text.
        found: String,
    },
    /// A number whose magnitude exceeds [`limits::LARGEST`](super::limits::LARGEST).
    NumberTooLarge {
        /// The number as written.
        found: String,
    },
    /// A zero vector where a direction is needed.
    ZeroVector {
        /// The name of the field.
        field: String,
    },
    /// A camera whose up vector is parallel to its direction.
    UpAlongDirection,
    /// A list is shorter than its announced length.
    TooFew {
        /// The name of the field with the length.
        field: &'static str,
        /// The length that the text announces.
        announced: u64,
        /// The actual length of the list.
        found: u64,
    },
    /// A list is longer than its announced length.
    TooMany {
        /// The name of the field with the length.
        field: &'static str,
        /// The length that the text announces.
        announced: u64,
        /// The actual length of the list.
        found: u64,
    },
    /// A material index beyond the declared materials.
    NoSuchMaterial {
        /// The index that the text gives.
        index: u64,
        /// The number of declared materials.
        declared: usize,
    },
    /// A texture names itself or a later material.
    NotAnEarlierMaterial {
        /// The index that the text gives.
        index: u64,
        /// The texture's own index.
        own: usize,
    },
    /// An object before any material has been chosen.
    NoMaterial {
        /// The keyword of the object.
        object: String,
    },
    /// A choice of material with no object after it.
    MaterialAfterLastObject {
        /// The word as written.
        word: String,
    },
    /// `Materials` after a `Group`, whose indices it would change.
    MaterialsAfterGroup,
    /// A scene without one of the mandatory blocks.
    Missing {
        /// The keyword of the block.
        block: &'static str,
    },
    /// A point light whose brightness is infinite in this edition.
    NoFalloff {
        /// The edition.
        edition: Edition,
    },
    /// The last row of a `Matrix` is not 0 0 0 1.
    NotAffine,
    /// A transform or texture map in which a number overflows.
    TransformOverflow,
    /// An object with a coordinate in world space that exceeds [`limits::LARGEST`](super::limits::LARGEST).
    CoordinatesTooLarge,
    /// A sphere or ellipsoid with a semi-axis in world space below
    /// [`limits::SMALLEST_RADIUS`](super::limits::SMALLEST_RADIUS).
    RadiusTooSmall,
    /// A plane without a normal.
    NoNormal,
    /// A number outside the [`limits`](super::limits), in a scene that was not read from text.
    NumbersOutOfRange,
    /// A singular transform around an object that needs its inverse.
    SingularTransform,
    /// More primitives than 32-bit ids can tell apart.
    TooManyPrimitives,
    /// The system has too little memory for the scene.
    Memory(NoMemory),
    /// A mesh file that could not be read.
    MeshUnreadable {
        /// The name as written.
        name: String,
        /// The paths that were tried, and for each the reason why the file could not be read.
        tried: Vec<(String, String)>,
    },
    /// A picture that could not be read.
    ImageUnreadable {
        /// The name as written, with that of the face for a cube map.
        name: String,
        /// Why.
        reason: String,
    },
    /// A mesh file with an error in its contents.
    BadMesh {
        /// The file.
        file: String,
        /// The error in it.
        error: Box<MeshError>,
        /// The line of the file with a caret; empty for an error of the whole file.
        excerpt: String,
    },
}

impl SceneError {
    /// An error without a hint.
    pub fn new(at: Position, problem: Problem) -> Self {
        Self { at, problem, hint: None }
    }

    /// The same error with advice attached.
    #[must_use]
    pub fn with_hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// The whole message in several lines, without a final line end: file, line and column, the description,
    /// the line of `text` with a caret under the position, and the hint if there is one. Too little memory is a
    /// line without a position.
    pub fn render(&self, path: &Path, text: &str) -> String {
        let Position { line, column } = self.at;
        if let Problem::Memory(_) = self.problem {
            // No word of the text is wrong.
            return located(path, "", &self.problem.to_string());
        }
        let shown = excerpt::with_caret(text, self.at);
        let in_mesh = self.problem.in_mesh().unwrap_or_default();
        let hint = self.hint.as_ref().map(|hint| format!("\n  hint: {hint}")).unwrap_or_default();
        let message = format!("{}\n{shown}{in_mesh}{hint}", self.problem);
        located(path, &format!(":{line}:{column}"), &message)
    }
}

impl Problem {
    /// The problem of a mesh file with these contents.
    pub fn of_mesh(file: String, error: MeshError, bytes: &[u8]) -> Self {
        let excerpt = error.at.map(|at| mesh::excerpt(bytes, at)).unwrap_or_default();
        Self::BadMesh { file, error: Box::new(error), excerpt }
    }

    /// Advice in one line on what is wrong in a mesh file, if there is any.
    pub fn mesh_hint(&self) -> Option<String> {
        match self {
            Self::BadMesh { error, .. } => error.hint.clone(),
            _ => None,
        }
    }

    /// The line of a mesh file that is in error, with a caret, after a line with the position.
    fn in_mesh(&self) -> Option<String> {
        let Self::BadMesh { file, error, excerpt } = self else { return None };
        error.at.map(|at| excerpt::of_file(file, at, excerpt))
    }
}

impl std::error::Error for SceneError {}

/// No position is to blame, so it is the start of the text.
impl From<NoMemory> for SceneError {
    fn from(refused: NoMemory) -> Self {
        Self::new(Position { line: 1, column: 1 }, Problem::Memory(refused))
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, column {}: {}", self.at.line, self.at.column, self.problem)
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Expected { what, found } => write!(f, "expected {what}, found {}", quoted(found)),
            Self::BadValue { field, rule, found } => write!(f, "`{field}` {rule}, found {}", quoted(found)),
            Self::NumberTooLarge { found } => {
                write!(f, "the number {} is too large: the largest is 1e100", quoted(found))
            }
            Self::ZeroVector { field } => write!(f, "`{field}` must not be the zero vector"),
            Self::UpAlongDirection => write!(f, "`up` must not be parallel to `direction`"),
            Self::TooFew { field, announced, found } => {
                write!(f, "`{field}` announces {announced}, but only {found} found")
            }
            Self::TooMany { field, announced, found } => {
                write!(f, "`{field}` announces {announced}, but {found} found")
            }
            Self::NoSuchMaterial { index, declared } => {
                write!(f, "there is no material {index}: {}", declared_materials(*declared))
            }
            Self::NotAnEarlierMaterial { index, own } => {
                write!(f, "texture {own} may mix only materials before it, found index {index}")
            }
            Self::NoMaterial { object } => write!(f, "the `{object}` has no material"),
            Self::MaterialAfterLastObject { word } => {
                write!(f, "`{word}` must stand before an object, but the group's last object is past")
            }
            Self::MaterialsAfterGroup => write!(f, "`Materials` must come before the `Group`"),
            Self::Missing { block } => write!(f, "the scene has no {block}"),
            Self::NoFalloff { edition } => {
                write!(f, "without `falloff` the light is infinitely bright in the edition {edition}")
            }
            Self::NotAffine => write!(f, "the last row of a `Matrix` must be 0 0 0 1"),
            Self::TransformOverflow => write!(f, "the transformation's numbers grow too large"),
            Self::CoordinatesTooLarge => write!(f, "the object has coordinates beyond 1e100"),
            Self::RadiusTooSmall => write!(f, "the object has a radius below 1e-100"),
            Self::NoNormal => write!(f, "the plane has no normal"),
            Self::NumbersOutOfRange => write!(f, "a number in the scene is out of range"),
            Self::SingularTransform => {
                write!(f, "the transformation is singular: it flattens the object")
            }
            Self::TooManyPrimitives => write!(f, "the scene has too many primitives for 32-bit ids"),
            Self::Memory(refused) => refused.fmt(f),
            Self::MeshUnreadable { name, tried } => write_unreadable(f, name, tried),
            Self::ImageUnreadable { name, reason } => {
                write!(f, "cannot read the picture {}: {}", quoted(name), escape(reason))
            }
            Self::BadMesh { file, error, .. } => write!(f, "in the mesh {}: {error}", quoted(file)),
        }
    }
}

/// A message about a file: its path, the `position` in it (`:line:column` or nothing), and the description.
pub fn located(path: &Path, position: &str, message: &str) -> String {
    labelled(path, position, "error", message)
}

/// The same with another word than `error`.
pub fn labelled(path: &Path, position: &str, label: &str, message: &str) -> String {
    format!("{}{position}: {label}: {message}", escape::truncated(path))
}

fn declared_materials(count: usize) -> String {
    match count {
        0 => "none is declared".to_owned(),
        1 => "only material 0 is declared".to_owned(),
        _ => format!("materials 0 to {} are declared", count - 1),
    }
}

fn write_unreadable(f: &mut fmt::Formatter<'_>, name: &str, tried: &[(String, String)]) -> fmt::Result {
    write!(f, "cannot read the mesh {}: tried ", quoted(name))?;
    for (index, (path, reason)) in tried.iter().enumerate() {
        let separator = if index == 0 { "" } else { ", then " };
        write!(f, "{separator}{} ({})", quoted(path), escape(reason))?;
    }
    Ok(())
}

/// A word as messages show it. An empty word stands for the end of the file.
fn quoted(word: &str) -> String {
    if word.is_empty() { "the end of the file".to_owned() } else { escape::quoted(word) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expected(line: u32, column: u32, found: &str) -> SceneError {
        let problem = Problem::Expected { what: "a number for `radius`".into(), found: found.into() };
        SceneError::new(Position { line, column }, problem)
    }

    #[test]
    fn the_bare_error_is_one_line() {
        assert_eq!(
            expected(12, 9, "}").to_string(),
            "line 12, column 9: expected a number for `radius`, found `}`"
        );
    }

    #[test]
    fn the_rendered_error_points_at_the_position() {
        let rendered =
            expected(2, 10, "}").with_hint("try 1").render(Path::new("a.txt"), "Sphere {\n  radius }\n}");
        let wanted = "a.txt:2:10: error: expected a number for `radius`, found `}`\n    \
                      2 |   radius }\n      |          ^\n  hint: try 1";
        assert_eq!(rendered, wanted);
    }

    #[test]
    fn long_words_are_truncated_and_unprintable_ones_escaped() {
        let message = expected(1, 1, &"x".repeat(100_000)).to_string();
        assert!(message.len() < 300);
        assert!(expected(1, 1, "a\u{1b}[31m").to_string().ends_with("found `a\\u{1b}[31m`"));
    }

    #[test]
    fn the_end_of_the_file_is_named() {
        assert!(expected(1, 1, "").to_string().ends_with("found the end of the file"));
    }

    #[test]
    fn both_paths_of_a_missing_mesh_are_named() {
        let tried =
            vec![("a.obj".to_owned(), "absent".to_owned()), ("b/a.obj".to_owned(), "absent".to_owned())];
        let message = Problem::MeshUnreadable { name: "a.obj".into(), tried }.to_string();
        assert_eq!(message, "cannot read the mesh `a.obj`: tried `a.obj` (absent), then `b/a.obj` (absent)");
    }

    #[test]
    fn the_declared_materials_are_named() {
        let message = |declared| Problem::NoSuchMaterial { index: 7, declared }.to_string();
        assert_eq!(message(0), "there is no material 7: none is declared");
        assert_eq!(message(1), "there is no material 7: only material 0 is declared");
        assert_eq!(message(3), "there is no material 7: materials 0 to 2 are declared");
    }

    #[test]
    fn only_a_word_that_is_too_long_is_truncated() {
        assert_eq!(quoted(&"x".repeat(200)), format!("`{}`", "x".repeat(200)));
        assert_eq!(quoted(&"x".repeat(201)), format!("`{}...`", "x".repeat(200)));
    }
}
