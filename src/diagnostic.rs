//! Errors, warnings and notes.
//!
//! A [`Diagnostic`] is built where a fault is found. The code that has read the file adds its name and the line of its
//! text. It is formatted once, where it is shown.

mod excerpt;

use crate::base::escape::truncated;
use excerpt::with_caret;
use serde::Serialize;
use std::error::Error;
use std::fmt;
use std::path::{Path, PathBuf};

/// An error, a warning or a note. `Display` formats all of it, without colour and without a final line end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// The severity, which decides the label and the colour.
    pub severity: Severity,
    /// The place of the fault. If it lies in a mesh, the place that names the mesh comes first. Empty if the fault is
    /// in no file.
    pub places: Vec<Place>,
    /// The problem in one line.
    pub message: String,
    /// Advice in one line.
    pub hint: Option<String>,
}

/// The severity of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The run ends.
    Error,
    /// The input is valid, but probably a mistake.
    Warning,
    /// A warning that the course's program has too. It is shown in its capitals.
    CourseWarning,
    /// A message about a valid run.
    Note,
}

/// A place in a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// The file. It is empty as long as only a position in some text is known.
    pub file: PathBuf,
    /// The position in the file; none for the file as a whole.
    pub at: Option<Position>,
    /// The line at the position, and a line with a caret below it.
    pub excerpt: String,
}

/// A position in a text. Lines and columns start with 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Position {
    /// The line. It is 0 for a part of a scene that was not read from text.
    pub line: u32,
    /// The column, counted in characters.
    pub column: u32,
}

impl Diagnostic {
    /// Makes an error without a place.
    pub fn error(message: impl Into<String>) -> Self {
        Self { severity: Severity::Error, places: vec![], message: message.into(), hint: None }
    }

    /// Makes a warning without a place.
    pub fn warning(message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(message) }
    }

    /// Makes a note without a place.
    pub fn note(message: impl Into<String>) -> Self {
        Self { severity: Severity::Note, ..Self::error(message) }
    }

    /// Adds advice in one line.
    #[must_use]
    pub fn with_hint(self, hint: impl Into<String>) -> Self {
        Self { hint: Some(hint.into()), ..self }
    }

    /// Sets the position in the text, unless its line is 0.
    #[must_use]
    pub fn at(mut self, position: Position) -> Self {
        if position.line > 0 {
            self.first_place().at = Some(position);
        }
        self
    }

    /// Sets the file.
    #[must_use]
    pub fn in_file(mut self, file: &Path) -> Self {
        self.first_place().file = file.to_owned();
        self
    }

    /// Sets the file, and shows the line of its text if there is a position.
    #[must_use]
    pub fn in_text(mut self, file: &Path, text: &str) -> Self {
        if let Some(at) = self.position() {
            self.first_place().excerpt = with_caret(text, at);
        }
        self.in_file(file)
    }

    /// Returns the position in the file.
    pub fn position(&self) -> Option<Position> {
        self.places.first().and_then(|place| place.at)
    }

    /// Formats the message and the hint in one line.
    pub fn in_one_line(&self) -> String {
        let hint = self.hint.as_ref().map(|hint| format!("; {hint}"));
        self.message.clone() + &hint.unwrap_or_default()
    }

    /// Formats the first line: the place, the severity and the message.
    pub fn headline(&self) -> String {
        self.line_with(self.severity.label())
    }

    /// Formats all of it for a terminal, with the severity in colour.
    pub fn colored(&self) -> String {
        let (label, color) = (self.severity.label(), self.severity.color());
        let label = color.map_or(label.into(), |color| format!("\x1b[{color}m{label}\x1b[0m"));
        self.line_with(&label) + &self.details()
    }

    fn first_place(&mut self) -> &mut Place {
        if self.places.is_empty() {
            self.places.push(Place::default());
        }
        &mut self.places[0]
    }

    fn line_with(&self, label: &str) -> String {
        let place = self.places.first().map(|place| format!("{place}: ")).unwrap_or_default();
        let space = if self.severity == Severity::CourseWarning { "  " } else { " " };
        format!("{place}{label}{space}{}", self.message)
    }

    /// Formats the lines after the first.
    fn details(&self) -> String {
        let mut lines = String::new();
        for (index, place) in self.places.iter().enumerate().filter(|(_, place)| !place.excerpt.is_empty()) {
            if index > 0 {
                lines += &format!("\n  {place}:");
            }
            lines += &format!("\n{}", place.excerpt);
        }
        lines + &self.hint.as_ref().map(|hint| format!("\n  hint: {hint}")).unwrap_or_default()
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&(self.headline() + &self.details()))
    }
}

/// Makes an error without a place. `Diagnostic` does not implement `Error`, which would make this overlap with
/// `From<T> for T`.
impl<E: Error> From<E> for Diagnostic {
    fn from(error: E) -> Self {
        Self::error(error.to_string())
    }
}

impl From<Diagnostic> for Box<dyn Error> {
    fn from(found: Diagnostic) -> Self {
        found.to_string().into()
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.at {
            Some(at) if self.file.as_os_str().is_empty() => {
                write!(f, "line {}, column {}", at.line, at.column)
            }
            Some(at) => write!(f, "{}:{}:{}", truncated(&self.file), at.line, at.column),
            None => f.write_str(&truncated(&self.file)),
        }
    }
}

impl Severity {
    fn label(self) -> &'static str {
        match self {
            Self::Error => "error:",
            Self::Warning => "warning:",
            Self::CourseWarning => "WARNING:",
            Self::Note => "note:",
        }
    }

    /// Returns the parameters of the terminal's control sequence.
    fn color(self) -> Option<&'static str> {
        match self {
            Self::Error => Some("1;31"),
            Self::Warning | Self::CourseWarning => Some("1;33"),
            Self::Note => None,
        }
    }
}

/// Keeps the first 20 warnings of one kind, followed by the number of the others.
pub fn limited(mut all: Vec<Diagnostic>) -> Vec<Diagnostic> {
    const MOST: usize = 20;
    if let Some(more) = all.len().checked_sub(MOST).filter(|&more| more > 0) {
        all.truncate(MOST);
        all.push(Diagnostic::warning(format!("{more} more like these")));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expected() -> Diagnostic {
        Diagnostic::error("expected a number, found `}`").at(Position { line: 2, column: 10 })
    }

    #[test]
    fn a_place_may_be_a_position_or_a_file_alone() {
        assert_eq!(expected().headline(), "line 2, column 10: error: expected a number, found `}`");
        let whole = Diagnostic::error("it is closed").in_text(Path::new("s\u{1b}.txt"), "text");
        assert_eq!(whole.to_string(), "s\\u{1b}.txt: error: it is closed");
        assert_eq!(Diagnostic::note("x").at(Position::default()).to_string(), "note: x");
    }

    #[test]
    fn the_severity_alone_is_in_colour() {
        let red = Diagnostic::error("a: error: b").in_file(Path::new("error: c"));
        assert_eq!(red.colored(), "error: c: \x1b[1;31merror:\x1b[0m a: error: b");
        let text = "warning: a";
        let yellow =
            Diagnostic::warning("x").at(Position { line: 1, column: 1 }).in_text(Path::new("f"), text);
        assert_eq!(yellow.colored(), "f:1:1: \x1b[1;33mwarning:\x1b[0m x\n    1 | warning: a\n      | ^");
        let course = Diagnostic { severity: Severity::CourseWarning, ..Diagnostic::error("No lights") };
        assert_eq!(course.colored(), "\x1b[1;33mWARNING:\x1b[0m  No lights");
        assert_eq!(Diagnostic::note("error: none").colored(), "note: error: none");
    }
}
