//! What is wrong in a mesh file, or doubtful.

use super::Position;
use crate::diagnostic::Diagnostic;
use std::fmt;

/// An error in a mesh file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshError {
    /// The position of the error; none for an error of the whole file.
    pub at: Option<Position>,
    /// What is wrong, in one line.
    pub message: String,
    /// Advice in one line.
    pub hint: Option<String>,
}

impl std::error::Error for MeshError {}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.at {
            Some(at) => write!(f, "line {}: {}", at.line, self.message),
            None => f.write_str(&self.message),
        }
    }
}

/// Something in a mesh file that is no error, but probably a mistake. It stands for all of its kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshDoubt {
    /// The position of the first.
    pub at: Position,
    /// What it is, and how many others there are, in one line.
    pub message: String,
    /// Advice in one line.
    pub hint: Option<String>,
}

impl fmt::Display for MeshDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.at.line, self.message)
    }
}

impl MeshError {
    /// Returns the error with its position in the mesh.
    pub(crate) fn diagnostic(self) -> Diagnostic {
        Diagnostic { hint: self.hint, ..Diagnostic::error(self.message) }.at(self.at.unwrap_or_default())
    }
}

impl MeshDoubt {
    /// Returns the warning with its position in the mesh.
    pub(crate) fn diagnostic(&self) -> Diagnostic {
        Diagnostic { hint: self.hint.clone(), ..Diagnostic::warning(self.message.clone()) }.at(self.at)
    }
}

const BACKSLASH: &str = "a backslash continues a statement only at the end of a line";
const ZERO_BYTE: &str = "the word has a zero byte: the file may be damaged";

/// Advice on a word of a vertex that is no number.
pub fn number_hint(word: &str) -> Option<&'static str> {
    let is_number = |word: &str| word.parse::<f64>().is_ok();
    match word {
        "\\" => Some(BACKSLASH),
        _ if word.contains('\0') => Some(ZERO_BYTE),
        _ if word.matches(',').count() == 1 && !word.ends_with(',') && is_number(&word.replace(',', ".")) => {
            Some("a decimal point is needed, not a comma")
        }
        _ if word.split([',', ';']).all(|part| part.is_empty() || is_number(part)) => {
            Some("numbers are separated by blanks")
        }
        _ if is_number(&word.replace(['d', 'D'], "e")) => Some("an exponent is written with `e`, as in 1e-5"),
        _ => None,
    }
}

/// Advice on a word of a face that is no corner.
pub fn corner_hint(word: &str) -> Option<&'static str> {
    match word {
        "\\" => Some(BACKSLASH),
        _ if word.contains('\0') => Some(ZERO_BYTE),
        _ if word.contains([',', ';']) => Some("indices are separated by blanks"),
        _ if word.matches('/').count() > 2 => {
            Some("a corner has at most three indices: of its position, texture coordinate and normal")
        }
        _ if word.starts_with('/') => Some("the index of the position comes first"),
        _ if word.parse::<f64>().is_ok() => Some("indices are whole numbers"),
        _ => None,
    }
}
