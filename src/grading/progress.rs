//! The progress of a grading: one line on standard error, if that is a terminal.

use std::io::{IsTerminal, Write, stderr};

/// Erases the line and returns to its start.
const ERASE: &str = "\r\x1b[2K";

/// Counts the pictures that are graded.
pub struct Progress {
    done: usize,
    all: usize,
    is_shown: bool,
}

impl Progress {
    pub fn new(all: usize) -> Self {
        Self { done: 0, all, is_shown: stderr().is_terminal() }
    }

    /// The next picture, with its name as it is printed.
    pub fn next(&mut self, name: &str) {
        self.done += 1;
        self.print(&format!("{ERASE}grading {} of {}: {name}", self.done, self.all));
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
