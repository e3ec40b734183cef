//! The command line: `argv` to [`Options`], in two stages (raw flags, then checked values).
//!
//! The course's style: long flags with a single dash, in any order, each at most once, values as
//! separate words. A word of one or two dashes and a letter is a flag; any other word is a value,
//! so `-2` and `-.5` are numbers, and a file called `-a.tga` is written `./-a.tga`.

mod error;
mod flags;
mod help;
mod options;
mod raw;

pub use error::{CliError, Problem};
pub use options::{Options, Output};
use raw::{Raw, Stop};
use std::ffi::OsString;

/// What the command line asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Render as the options say.
    Render(Box<Options>),
    /// Print this text on standard output; it ends with a newline.
    Help(String),
    /// Like [`Command::Help`].
    Version(String),
}

/// Reads a command line; the first word of `argv` is the program's name.
///
/// Looks at no file. `-help` and `-version` win over every fault that comes later in the line.
pub fn parse(argv: impl IntoIterator<Item = OsString>) -> Result<Command, CliError> {
    match Raw::parse(argv.into_iter().skip(1).collect()) {
        Ok(raw) => Options::from_raw(&raw).map(|options| Command::Render(Box::new(options))),
        Err(Stop::Help) => Ok(Command::Help(help::text())),
        Err(Stop::Version) => Ok(Command::Version(help::version())),
        Err(Stop::Error(error)) => Err(error),
    }
}
