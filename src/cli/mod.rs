//! Parses the command line to [`Options`] with clap.
//!
//! The syntax is that of the course: long flags with a single dash, in any order, each at most once, with
//! values as separate words. A word that starts with one or two dashes and a letter is a flag, and any other
//! word is a value. So `-2` and `-.5` are numbers, and a file called `-a.tga` has to be written as
//! `./-a.tga`.

mod commands;
mod error;
mod flags;
mod help;
mod options;
mod outputs;
mod runs;
mod values;
mod words;

pub use commands::parse_commands;
pub use flags::command;
pub use options::{Comparison, Given, LivePage, Options, ShowProgress};
pub use outputs::Output;
pub use runs::{Converting, ErrorReporting, Grading, Merging, References};
pub use words::{command_of_merge, command_of_rest};

use crate::diagnostic::Diagnostic;
use clap::FromArgMatches;
use clap::error::ErrorKind;
use error::{fail, of_clap};
use flags::Flags;
use outputs::output_of_bytes;
use std::ffi::OsString;

/// The action that the command line requests.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    Render(Box<Options>),
    Grade(Grading),
    Merge(Merging),
    Convert(Converting),
    ReportErrors(Box<ErrorReporting>),
    /// Print this text, which ends with a newline, on standard output.
    Print(String),
}

/// Parses a command line. The first word of `argv` is the program's name.
///
/// No file is accessed. `-h` and `-help` take precedence over all errors, and `-version` over those later in the line.
/// Errors: the first error found.
pub fn parse(argv: impl IntoIterator<Item = OsString>) -> Result<Command, Diagnostic> {
    let words: Vec<OsString> = argv.into_iter().skip(1).map(|word| words::double(&word)).collect();
    if let Some(place) = words.iter().position(|word| word == "--h" || word == "--help") {
        return help::text(&words[place..]).map(Command::Print);
    }
    let mut command = command();
    let matches = match command.try_get_matches_from_mut(&words) {
        Err(error) if error.kind() == ErrorKind::DisplayVersion => {
            return Ok(Command::Print(error.to_string()));
        }
        matches => matches.map_err(|error| of_clap(error, &words))?,
    };
    let flags = Flags::from_arg_matches(&matches).map_err(|error| of_clap(error, &words))?;
    if let Some(folder) = flags.grade.clone() {
        return Grading::new(folder, &flags).map(Command::Grade);
    }
    if let Some(parts) = flags.merge.clone() {
        return Merging::new(parts, &flags).map(Command::Merge);
    }
    if let Some(picture) = flags.convert.clone() {
        let (output, progress) = (output_of_bytes(&flags)?, ShowProgress::new(&flags));
        return Ok(Command::Convert(Converting { picture, output, progress }));
    }
    let (report, target) = (flags.error_report.clone(), flags.target);
    // clap does not require a flag that conflicts with one that is given.
    if flags.commands.is_some() || flags.report.is_some() {
        return fail("-commands and -report need '-grade <folder>'");
    }
    if target.is_some() && report.is_none() {
        return fail("-target needs '-error_report <folder>'");
    }
    let options = Options::new(flags, words::shaping_words(&command, &matches))?;
    Ok(match report {
        Some(folder) => Command::ReportErrors(Box::new(ErrorReporting { options, folder, target })),
        None => Command::Render(Box::new(options)),
    })
}
