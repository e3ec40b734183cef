//! Standard output, where text goes unless a picture does, and standard input.

use crate::app::failed;
use crate::app::start::{Stream, is_closed};
use raytracer::cli::Options;
use raytracer::diagnostic::Diagnostic;
use std::io::{self, Write};
use std::path::Path;

/// Prints a text. A reader that went away has seen enough.
pub fn print(text: &str) -> Result<(), Diagnostic> {
    if text.is_empty() {
        return Ok(());
    }
    check_output()?;
    let mut output = io::stdout();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(unwritable(error)),
        _ => Ok(()),
    }
}

/// An error if the program was started without a standard output.
pub fn check_output() -> Result<(), Diagnostic> {
    if is_closed(Stream::Output) { Err(unwritable("it is closed")) } else { Ok(()) }
}

/// An error if the scene comes from standard input and the program was started without one.
pub fn check_input(options: &Options) -> Result<(), Diagnostic> {
    match options.input.as_deref() == Some(Path::new("-")) && is_closed(Stream::Input) {
        true => Err(failed("cannot read the scene: it is closed").in_file(Path::new("standard input"))),
        false => Ok(()),
    }
}

fn unwritable(reason: impl std::fmt::Display) -> Diagnostic {
    failed(format!("cannot write to standard output: {reason}"))
}
