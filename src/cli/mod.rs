//! Parses the command line to [`Options`], in two stages: raw flags with their values as words, then checked
//! values.
//!
//! The syntax is that of the course: long flags with a single dash, in any order, each at most once, with
//! values as separate words. A word that starts with one or two dashes and a letter is a flag, and any other
//! word is a value. So `-2` and `-.5` are numbers, and a file called `-a.tga` has to be written as
//! `./-a.tga`.

mod commands;
mod comparison;
mod conversion;
pub mod completions;
mod error;
mod error_report;
mod flag;
mod flags;
mod grading;
mod help;
mod live_page;
pub mod man_page;
mod options;
mod outputs;
mod parts;
mod raw;
mod rest;
mod section;
pub mod table;
mod values;

pub use commands::{CommandsError, CommandsProblem, Rendering, parse_commands};
pub use comparison::Comparison;
pub use conversion::Converting;
pub use error::{CliError, Problem};
pub use error_report::ErrorReporting;
pub use grading::{Grading, References};
pub use live_page::LivePage;
pub use options::{JsonTarget, Options, ShowProgress};
pub use outputs::Output;
pub use parts::Merging;
use raw::{Raw, Stop};
pub use rest::{command_of_merge, command_of_rest};
use std::ffi::OsString;

/// The action that the command line requests.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Render with these options.
    Render(Box<Options>),
    /// Grade a folder with these options.
    Grade(Grading),
    /// Put parts of a picture together with these options.
    Merge(Merging),
    /// Write a picture in another format.
    Convert(Converting),
    /// Measure speed against error with these options.
    ReportErrors(Box<ErrorReporting>),
    /// Print this text, which ends with a newline, on standard output.
    Help(String),
    /// Print this text, which ends with a newline, on standard output.
    Version(String),
}

/// Parses a command line. The first word of `argv` is the program's name.
///
/// No file is accessed. `-h`, `-help` and `-version` take precedence over errors later in the line. Errors: the
/// first error found.
pub fn parse(argv: impl IntoIterator<Item = OsString>) -> Result<Command, CliError> {
    match Raw::parse(argv.into_iter().skip(1).collect()) {
        Ok(raw) => command(&raw),
        Err(Stop::Help(None)) => Ok(Command::Help(help::text())),
        Err(Stop::Usual) => Ok(Command::Help(help::usual())),
        Err(Stop::Help(Some(word))) => help::about(&word).map(Command::Help),
        Err(Stop::Version) => Ok(Command::Version(help::version())),
        Err(Stop::Error(error)) => Err(error),
    }
}

fn command(raw: &Raw) -> Result<Command, CliError> {
    if let Some(grading) = Grading::from_raw(raw)? {
        return Ok(Command::Grade(grading));
    }
    if let Some(merging) = Merging::from_raw(raw)? {
        return Ok(Command::Merge(merging));
    }
    if let Some(converting) = Converting::from_raw(raw)? {
        return Ok(Command::Convert(converting));
    }
    match ErrorReporting::from_raw(raw)? {
        Some(reporting) => Ok(Command::ReportErrors(Box::new(reporting))),
        None => Options::from_raw(raw).map(|options| Command::Render(Box::new(options))),
    }
}
