//! Why a scene could not be loaded.

use super::Source;
use super::near_names::nearest_file;
use crate::escape::quoted;
use crate::scene::Position;
use crate::scene::error::{SceneError, located};
use std::fmt;
use std::path::PathBuf;

/// Why a scene could not be loaded. `Display` gives the whole message, which may be of several lines.
#[derive(Debug)]
pub enum LoadError {
    /// The scene's file could not be read.
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        error: std::io::Error,
    },
    /// A word of the scene is not UTF-8. In comments any bytes may stand.
    NotUtf8 {
        /// The file.
        path: PathBuf,
        /// The position of the first wrong byte.
        at: Position,
        /// Whether the file is in UTF-16 or UTF-32.
        is_wide: bool,
    },
    /// Something is wrong with what the scene or its meshes say.
    Scene {
        /// The text.
        source: Source,
        /// What is wrong, and where.
        error: Box<SceneError>,
    },
}

impl std::error::Error for LoadError {}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable { path, error } => {
                let is_missing = error.kind() == std::io::ErrorKind::NotFound;
                let near = if is_missing { nearest_file(path) } else { None };
                let hint =
                    near.map_or(String::new(), |near| format!("\n  hint: did you mean {}?", quoted(near)));
                f.write_str(&located(path, "", &format!("cannot read the scene: {error}{hint}")))
            }
            Self::NotUtf8 { path, at, is_wide } => {
                let looks = if *is_wide { "this looks like UTF-16; " } else { "" };
                let message = format!("the scene is not UTF-8 text\n  hint: {looks}save the file as UTF-8");
                f.write_str(&located(path, &format!(":{}:{}", at.line, at.column), &message))
            }
            Self::Scene { source, error } => f.write_str(&source.render(error)),
        }
    }
}
