//! Why a scene could not be loaded.

use super::Source;
use crate::escape::quoted;
use crate::near_names::nearest_file;
use crate::scene::error::{SceneError, located};
use crate::scene::recovery::MAX_ERRORS;
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
    /// The scene's file is not UTF-8. Line and column of the first wrong byte count from 1.
    NotUtf8 {
        /// The file.
        path: PathBuf,
        /// Of the first wrong byte.
        line: usize,
        /// Of the first wrong byte.
        column: usize,
        /// Whether the file looks like UTF-16.
        is_utf16: bool,
    },
    /// Something is wrong with what the scene or its meshes say.
    Scene {
        /// The text.
        source: Source,
        /// What is wrong, and where: at least one error.
        errors: Vec<SceneError>,
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
            Self::NotUtf8 { path, line, column, is_utf16 } => {
                let hint =
                    if *is_utf16 { "\n  hint: this looks like UTF-16; save the file as UTF-8" } else { "" };
                let message = format!("the scene is not UTF-8 text{hint}");
                f.write_str(&located(path, &format!(":{line}:{column}"), &message))
            }
            Self::Scene { source, errors } => {
                for (index, error) in errors.iter().enumerate() {
                    let end = if index == 0 { "" } else { "\n" };
                    write!(f, "{end}{}", source.render(error))?;
                }
                match errors.len() {
                    MAX_ERRORS.. => write!(f, "\n{MAX_ERRORS} errors are shown; there may be more"),
                    _ => Ok(()),
                }
            }
        }
    }
}
