//! Progress: one line on standard error, if that is a terminal.

use std::io::{IsTerminal, Write, stderr};

/// Erases the line and returns to its start.
const ERASE: &str = "\r\x1b[2K";

/// The line that tells how far a run has come.
pub struct Progress {
    is_shown: bool,
}

impl Progress {
    pub fn new() -> Self {
        Self { is_shown: stderr().is_terminal() }
    }

    /// Replaces the line. The text must be escaped.
    pub fn show(&self, text: &str) {
        self.print(&format!("{ERASE}{text}"));
    }

    /// Erases the line.
    pub fn end(&self) {
        self.print(ERASE);
    }

    /// Where nobody reads it there is nobody to tell.
    fn print(&self, text: &str) {
        if self.is_shown {
            let mut terminal = stderr();
            let _ = terminal.write_all(text.as_bytes()).and_then(|()| terminal.flush());
        }
    }
}
