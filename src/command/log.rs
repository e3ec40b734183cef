//! Messages on standard error, with colours on a terminal.

use raytracer::escape::quoted;
use std::cell::RefCell;
use std::io::{IsTerminal, Write, stderr};
use std::path::Path;
use std::time::Duration;

/// The words before a message, and their colours.
const LABELS: [(&str, &str); 3] = [("error:", "1;31"), ("warning:", "1;33"), ("WARNING:", "1;33")];

/// The messages of a run.
#[derive(Default)]
pub struct Log(RefCell<Vec<String>>);

impl Log {
    /// Writes a message to standard error. Where nobody reads it there is nobody to tell, and `eprintln!` would panic.
    pub fn tell(&self, message: &str) {
        let _ = writeln!(stderr(), "{}", in_color(message));
        self.0.borrow_mut().push(message.to_owned());
    }

    /// Tells a person at a terminal which files a run wrote in this time.
    pub fn tell_written(&self, written: &[impl AsRef<Path>], took: Duration) {
        if has_reader() && !written.is_empty() {
            self.tell(&finished(written, took));
        }
    }

    /// Returns the messages so far, without colours.
    pub fn messages(&self) -> Vec<String> {
        self.0.borrow().clone()
    }
}

/// Whether messages go to a person, at a terminal that understands control sequences.
pub fn has_reader() -> bool {
    stderr().is_terminal() && understands_sequences()
}

/// Whether the terminal of standard error understands control sequences: every one does.
#[cfg(not(windows))]
fn understands_sequences() -> bool {
    true
}

/// Whether the console of standard error understands control sequences: from Windows 10 on, if it is asked to.
#[cfg(windows)]
fn understands_sequences() -> bool {
    use std::os::windows::io::AsRawHandle;
    use windows_sys::Win32::System::Console::{
        ENABLE_VIRTUAL_TERMINAL_PROCESSING, GetConsoleMode, SetConsoleMode,
    };
    let console = stderr().as_raw_handle();
    let mut mode = 0;
    // SAFETY: the handle is that of standard error, which the program does not close, and only `mode` is written.
    unsafe {
        GetConsoleMode(console, &mut mode) != 0
            && SetConsoleMode(console, mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING) != 0
    }
}

/// A message with its labels in colour, where a terminal shows it and nobody has asked for none (no-color.org).
fn in_color(message: &str) -> String {
    let is_set = |name: &str, refusing: fn(&str) -> bool| {
        std::env::var_os(name).is_some_and(|value| refusing(&value.to_string_lossy()))
    };
    let refused = is_set("NO_COLOR", |value| !value.is_empty()) || is_set("TERM", |value| value == "dumb");
    if has_reader() && !refused { painted(message) } else { message.to_owned() }
}

fn painted(message: &str) -> String {
    message.split('\n').map(painted_line).collect::<Vec<_>>().join("\n")
}

/// A line with its label in colour. One that starts with a blank is a line of a file, or a hint.
fn painted_line(line: &str) -> String {
    let place = |label: &str| match line.starts_with(label) {
        true => Some(0),
        false => line.find(&format!(": {label} ")).map(|at| at + 2),
    };
    let labels = LABELS.iter().filter(|_| !line.starts_with(' '));
    let first = labels.filter_map(|&(label, color)| Some((place(label)?, label, color))).min();
    match first {
        Some((at, label, color)) => {
            let (before, after) = (&line[..at], &line[at + label.len()..]);
            format!("{before}\x1b[{color}m{label}\x1b[0m{after}")
        }
        None => line.to_owned(),
    }
}

/// Returns the line for a finished run.
fn finished(written: &[impl AsRef<Path>], took: Duration) -> String {
    let files: Vec<String> = written.iter().map(|file| quoted(file.as_ref())).collect();
    format!("wrote {} in {}", files.join(", "), time(took))
}

/// A time in the unit in which people read it.
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
    fn labels_are_in_colour_and_lines_of_files_are_not() {
        let (red, yellow) = ("\x1b[1;31merror:\x1b[0m", "\x1b[1;33mwarning:\x1b[0m");
        assert_eq!(painted("error: no scene"), format!("{red} no scene"));
        let text =
            "a.txt:1:2: error: x\n    1 | a: error: b\n  hint: a: error: c\nb.txt:3:4: warning: y: error: z";
        let expected = format!(
            "a.txt:1:2: {red} x\n    1 | a: error: b\n  hint: a: error: c\nb.txt:3:4: {yellow} y: error: z"
        );
        assert_eq!(painted(text), expected);
        assert_eq!(painted("note: an error: none"), "note: an error: none");
    }

    #[test]
    fn times_have_the_unit_in_which_people_read_them() {
        let shown = [12, 1_500, 61_000, 3_723_000].map(|ms| time(Duration::from_millis(ms)));
        assert_eq!(shown, ["12 ms", "1.5 s", "1 min 1 s", "1 h 2 min"]);
        assert_eq!(finished(&["a.png", "b c"], Duration::from_micros(7)), "wrote `a.png`, `b c` in 1 ms");
    }
}
