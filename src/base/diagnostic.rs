//! Errors, warnings and notes for the user. They are built where the fault is found, and formatted once, at the end.

use super::escape::truncated;
use std::fmt;
use std::path::{Path, PathBuf};

/// How serious a diagnostic is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The run ends.
    Error,
    /// The run goes on, probably not as it was meant.
    Warning,
    /// A warning with the label of the course's program.
    CourseWarning,
    /// The run goes on as it was meant.
    Note,
}

impl Severity {
    fn label(self) -> &'static str {
        match self {
            Self::Error => "error:",
            Self::Warning => "warning:",
            Self::CourseWarning => "WARNING: ",
            Self::Note => "note:",
        }
    }

    /// Returns the parameter of the terminal's sequence for the colour of the label.
    fn color(self) -> Option<&'static str> {
        match self {
            Self::Error => Some("1;31"),
            Self::Warning | Self::CourseWarning => Some("1;33"),
            Self::Note => None,
        }
    }
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file, as the user named it.
    pub file: PathBuf,
    /// Line and column, from 1.
    pub position: Option<[u32; 2]>,
    /// Lines of the file with a caret; empty if there are none to show.
    pub excerpt: String,
}

/// An error, a warning or a note.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How serious it is.
    pub severity: Severity,
    /// Where the fault lies, if it lies in a file that was read.
    pub place: Option<Place>,
    /// The description in one line.
    pub message: String,
    /// Advice in one line.
    pub hint: Option<String>,
}

impl Diagnostic {
    /// Returns a diagnostic without a place and a hint.
    pub fn new(severity: Severity, message: impl fmt::Display) -> Self {
        Self { severity, place: None, message: message.to_string(), hint: None }
    }

    /// Returns an error without a place and a hint.
    pub fn error(message: impl fmt::Display) -> Self {
        Self::new(Severity::Error, message)
    }

    /// Returns a note.
    pub fn note(message: impl fmt::Display) -> Self {
        Self::new(Severity::Note, message)
    }

    /// Adds a place.
    #[must_use]
    pub fn at(mut self, file: &Path, position: Option<[u32; 2]>, excerpt: String) -> Self {
        self.place = Some(Place { file: file.to_owned(), position, excerpt });
        self
    }

    /// Adds advice, if there is any.
    #[must_use]
    pub fn with_hint(mut self, hint: Option<String>) -> Self {
        self.hint = hint;
        self
    }

    /// Returns the first line: the place, the label and the description.
    pub fn first_line(&self) -> String {
        self.line_labelled(self.severity.label())
    }

    /// Returns all lines, with the label in colour.
    pub fn in_color(&self) -> String {
        let label = self.severity.label();
        let colored = self.severity.color().map(|color| format!("\x1b[{color}m{label}\x1b[0m"));
        self.line_labelled(colored.as_deref().unwrap_or(label)) + &self.further_lines()
    }

    fn line_labelled(&self, label: &str) -> String {
        let place = match &self.place {
            None => String::new(),
            Some(Place { file, position: None, .. }) => format!("{}: ", truncated(file)),
            Some(Place { file, position: Some([line, column]), .. }) => {
                format!("{}:{line}:{column}: ", truncated(file))
            }
        };
        format!("{place}{label} {}", self.message)
    }

    fn further_lines(&self) -> String {
        let excerpt = self.place.as_ref().map(|place| &place.excerpt).filter(|excerpt| !excerpt.is_empty());
        let hint = self.hint.as_ref().map(|hint| format!("  hint: {hint}"));
        excerpt.into_iter().chain(&hint).map(|lines| format!("\n{lines}")).collect()
    }
}

/// All lines without a final line end, and without colours.
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.first_line(), self.further_lines())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_label_is_in_color() {
        let excerpt = "    1 | error: b\n      | ^".to_owned();
        let hint = Some("a: error: c".to_owned());
        let shown = Diagnostic::error("x").at(Path::new("a.txt"), Some([1, 2]), excerpt).with_hint(hint);
        let lines = "x\n    1 | error: b\n      | ^\n  hint: a: error: c";
        assert_eq!(shown.to_string(), format!("a.txt:1:2: error: {lines}"));
        assert_eq!(shown.in_color(), format!("a.txt:1:2: \x1b[1;31merror:\x1b[0m {lines}"));
        let warning = Diagnostic::new(Severity::CourseWarning, "No lights specified");
        assert_eq!(warning.to_string(), "WARNING:  No lights specified");
        let note = Diagnostic::note("an error: none");
        assert_eq!([note.to_string(), note.in_color()], ["note: an error: none"; 2]);
    }
}
