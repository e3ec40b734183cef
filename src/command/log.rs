//! Messages on standard error, with colours on a terminal.

use super::End;
use crate::base::escape::quoted;
use crate::diagnostic::{Diagnostic, Severity};
use crate::scene::load::Source;
use std::cell::RefCell;
use std::io::{IsTerminal, Write, stderr};
use std::path::PathBuf;
use std::time::Duration;

/// The diagnostics of a run.
#[derive(Default)]
pub struct Log(RefCell<Vec<String>>);

impl Log {
    /// Writes a diagnostic to standard error, in colour on a terminal.
    pub fn log(&self, found: Diagnostic) {
        let (plain, colored) = (found.to_string(), found.colored());
        self.say(if has_reader() && has_color() { &colored } else { &plain });
        self.0.borrow_mut().push(plain);
    }

    /// Writes a line to standard error. An error is ignored: without a reader, `eprintln!` would panic.
    pub fn say(&self, line: &str) {
        let _ = writeln!(stderr(), "{line}");
    }

    /// Writes these notes and warnings, with places in `source`. If `is_strict`, warnings are errors, and end the run.
    pub fn warn(&self, all: Vec<Diagnostic>, is_strict: bool, source: &Source) -> Result<(), End> {
        let mut ends = false;
        for mut found in all {
            if is_strict && found.severity != Severity::Note {
                (found.severity, ends) = (Severity::Error, true);
            }
            self.log(if found.places.is_empty() { found } else { source.locate(found) });
        }
        if ends { Err(End { error: None, status: 1 }) } else { Ok(()) }
    }

    /// Tells a person at a terminal which files a run wrote in this time.
    pub fn log_written(&self, written: &[PathBuf], took: Duration) {
        if has_reader() && !written.is_empty() {
            let files: Vec<String> = written.iter().map(quoted).collect();
            self.say(&format!("wrote {} in {}", files.join(", "), time(took)));
        }
    }

    /// Returns the diagnostics so far, formatted without colours.
    pub fn messages(&self) -> Vec<String> {
        self.0.borrow().clone()
    }
}

/// Returns true if standard error is a terminal that understands control sequences.
pub fn has_reader() -> bool {
    stderr().is_terminal() && understands_sequences()
}

/// Returns true, because every terminal understands control sequences.
#[cfg(not(windows))]
fn understands_sequences() -> bool {
    true
}

/// Asks the console of standard error to understand control sequences. From Windows 10 on, it does.
#[cfg(windows)]
fn understands_sequences() -> bool {
    use std::os::windows::io::AsRawHandle;
    use windows_sys::Win32::System::Console::{
        ENABLE_VIRTUAL_TERMINAL_PROCESSING, GetConsoleMode, SetConsoleMode,
    };
    let console = stderr().as_raw_handle();
    let mut mode = 0;
    // SAFETY: `console` is the handle of standard error, which the program does not close, and only `mode` is written.
    unsafe {
        GetConsoleMode(console, &mut mode) != 0
            && SetConsoleMode(console, mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING) != 0
    }
}

/// Returns true unless the environment asks for no colours (no-color.org).
fn has_color() -> bool {
    let variable = |name| std::env::var_os(name).unwrap_or_default();
    variable("NO_COLOR").is_empty() && variable("TERM") != "dumb"
}

/// Formats a time with one or two units.
fn time(time: Duration) -> String {
    let seconds = time.as_secs();
    match seconds {
        // No run takes no time.
        0 => format!("{:.0} ms", (time.as_secs_f64() * 1e3).ceil()),
        1..60 => format!("{:.1} s", time.as_secs_f64()),
        60..3600 => format!("{} min {} s", seconds / 60, seconds % 60),
        _ => format!("{} h {} min", seconds / 3600, seconds / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_the_unit_in_which_people_read_them() {
        let shown =
            [7, 12_000, 1_500_000, 61_000_000, 3_723_000_000].map(|us| time(Duration::from_micros(us)));
        assert_eq!(shown, ["1 ms", "12 ms", "1.5 s", "1 min 1 s", "1 h 2 min"]);
    }
}
