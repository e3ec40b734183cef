//! Parses the command line to [`Options`] with clap.
//!
//! The syntax is that of the course: long flags with a single dash, in any order, each at most once, with
//! values as separate words. A word that starts with one or two dashes and a letter is a flag, and any other
//! word is a value. So `-2` and `-.5` are numbers, and a file called `-a.tga` has to be written as
//! `./-a.tga`.

mod commands;
mod dashes;
mod error;
mod flags;
mod help;
mod options;
mod outputs;
mod rest;
mod runs;
mod values;

pub use commands::parse_commands;
pub use error::CliError;
pub use flags::command;
pub use options::{Comparison, LivePage, Options, ShowProgress};
pub use outputs::Output;
pub use rest::{command_of_merge, command_of_rest};
pub use runs::{Converting, ErrorReporting, Grading, Merging, References};

use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{ArgMatches, FromArgMatches};
use flags::{Flags, SHAPING};
use options::region;
use outputs::output_of_bytes;
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
    let mut words: Vec<OsString> = argv.into_iter().skip(1).map(|word| dashes::double(&word)).collect();
    let topic = help::topic(&mut words);
    let mut command = command();
    let matches = match command.try_get_matches_from_mut(&words) {
        Ok(matches) => matches,
        Err(error) => {
            return match error.kind() {
                ErrorKind::DisplayHelp => help::text(&words, topic).map(Command::Help),
                ErrorKind::DisplayVersion => Ok(Command::Version(error.to_string())),
                _ => Err(CliError::of(error, &words)),
            };
        }
    };
    let flags = Flags::from_arg_matches(&matches).map_err(|error| CliError::of(error, &words))?;
    if let Some(folder) = flags.grading.grade.clone() {
        return Grading::new(folder, flags).map(Command::Grade);
    }
    let progress = ShowProgress::new(&flags);
    if let Some(parts) = flags.pictures.merge.clone() {
        let region = flags.pictures.region.as_deref().map(region).transpose()?;
        return Ok(Command::Merge(Merging { parts, output: output_of_bytes(&flags)?, region, progress }));
    }
    if let Some(picture) = flags.pictures.convert.clone() {
        return Ok(Command::Convert(Converting { picture, output: output_of_bytes(&flags)?, progress }));
    }
    let (report, target) = (flags.error_reporting.error_report.clone(), flags.error_reporting.target);
    // clap does not require a flag that conflicts with one that is given.
    if flags.grading.commands.is_some() || flags.grading.report.is_some() {
        return Err(CliError::new("-commands and -report need '-grade <folder>'"));
    }
    if target.is_some() && report.is_none() {
        return Err(CliError::new("-target needs '-error_report <folder>'"));
    }
    let options = Options::new(flags, shaping_words(&command, &matches))?;
    Ok(match report {
        Some(folder) => Command::ReportErrors(Box::new(ErrorReporting { options, folder, target })),
        None => Command::Render(Box::new(options)),
    })
}

/// The flags that shape the colour picture, with their values, in the order of the help.
fn shaping_words(command: &clap::Command, matches: &ArgMatches) -> Vec<String> {
    let groups = command.get_groups().filter(|group| SHAPING.contains(&group.get_id().as_str()));
    let mut words = vec![];
    for flag in groups.flat_map(|group| group.get_args()).map(|flag| flag.as_str()) {
        if matches.value_source(flag) == Some(ValueSource::CommandLine) {
            words.push(format!("-{flag}"));
            // clap gives a value to flags that have none.
            let is_alone = matches!(matches.try_get_one::<bool>(flag), Ok(Some(_)));
            let values = matches.get_raw(flag).filter(|_| !is_alone).into_iter().flatten();
            words.extend(values.map(|value| value.to_string_lossy().into_owned()));
        }
    }
    words
}
