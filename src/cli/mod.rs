//! Parses the command line to [`Options`] with clap.
//!
//! The syntax is the course's: long flags with a single dash, in any order, each at most once, with
//! values as separate words. A word that starts with one or two dashes and a letter is a flag, and any other
//! word is a value. So `-2` and `-.5` are numbers, and a file called `-a.tga` has to be written as
//! `./-a.tga`.

// Each imports only from those before it.
mod values;
mod flags;
mod words;
mod error;
mod help;
mod outputs;
mod options;
mod from_flags;

pub use flags::command;
pub use options::{ComparisonOptions, Given, LivePage, Options, ShowProgress};
pub use outputs::Output;
pub use words::{command_of_merge, command_of_rest};

use crate::diagnostic::Diagnostic;
use crate::render::Window;
use crate::tools::compare::Tolerance;
use clap::FromArgMatches;
use clap::error::ErrorKind;
use error::{fail, of_clap};
use flags::Flags;
use from_flags::{region, tolerance};
use outputs::output_of_bytes;
use std::ffi::OsString;
use std::path::PathBuf;

/// The action that the command line requests.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    Render(Box<Options>),
    Grade(Grading),
    Convert(Converting),
    ReportErrors(Box<ErrorReporting>),
    /// Print this text, which ends with a newline, on standard output.
    Print(String),
}

/// A folder with a folder of pictures for every name, and the references to grade them by.
#[derive(Clone, Debug, PartialEq)]
pub struct Grading {
    pub folder: PathBuf,
    pub references: References,
    /// The only name to grade; `None` for all.
    pub student: Option<OsString>,
    /// The page, whose name ends in `.html`, and the table beside it.
    pub report: Option<[PathBuf; 2]>,
    /// The file for a JSON document of the results; `-` prints it in place of the text.
    pub json: Option<PathBuf>,
    pub tolerance: Option<Tolerance>,
    pub threads: Option<usize>,
    pub progress: ShowProgress,
}

/// The reference pictures: the files of a folder, or the renderings of command lines in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum References {
    Folder(PathBuf),
    Commands(PathBuf),
}

/// A picture to write in a format of bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct Converting {
    pub source: Source,
    pub output: Output,
    pub progress: ShowProgress,
}

/// The pixels of a picture to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    Picture(PathBuf),
    /// At least one part in a file that ends in `.tga` or `.png`, and the part of the picture that they become; none for
    /// the whole.
    Parts(Vec<PathBuf>, Option<Window>),
}

/// A report on the time and the error of settings.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorReporting {
    /// The options of the rendering, which has a scene.
    pub options: Options,
    /// The folder for the report. It need not exist.
    pub folder: PathBuf,
    /// The error to reach, in levels, not negative.
    pub target: Option<f64>,
}

/// Parses a command line. The first word of `argv` is the program's name.
///
/// No file is accessed. `-h` and `-help` take precedence over all errors, and `-version` over those later in the line.
/// Errors: the first error found.
pub fn parse(argv: impl IntoIterator<Item = OsString>) -> Result<Command, Diagnostic> {
    let words: Vec<OsString> = argv.into_iter().skip(1).map(|word| words::double(&word)).collect();
    if let Some(place) = words.iter().position(|word| word == "--h" || word == "--help") {
        return help::text(&words[place..], help::width()).map(Command::Print);
    }
    let mut command = command();
    let matches = match command.try_get_matches_from_mut(&words) {
        Err(error) if error.kind() == ErrorKind::DisplayVersion => {
            return Ok(Command::Print(error.to_string()));
        }
        matches => matches.map_err(|error| of_clap(error, &words))?,
    };
    let flags = Flags::from_arg_matches(&matches).map_err(|error| of_clap(error, &words))?;
    let progress = ShowProgress::new(&flags);
    if let Some(folder) = flags.grade.clone() {
        let tolerance = tolerance(&flags)?;
        let references = match (flags.reference, flags.commands) {
            (Some(folder), _) => References::Folder(folder),
            (None, Some(commands)) => References::Commands(commands),
            (None, None) => return fail("-grade needs -reference or -commands"),
        };
        let Flags { student, report, json, threads, .. } = flags;
        let report = report.map(|page| [page.clone(), page.with_extension("csv")]);
        let grading = Grading { folder, references, student, report, json, tolerance, threads, progress };
        return Ok(Command::Grade(grading));
    }
    let source = match (flags.merge.clone(), flags.convert.clone()) {
        (Some(parts), _) => Some(Source::Parts(parts, flags.region.as_deref().map(region).transpose()?)),
        (None, picture) => picture.map(Source::Picture),
    };
    if let Some(source) = source {
        let output = output_of_bytes(&flags)?;
        return Ok(Command::Convert(Converting { source, output, progress }));
    }
    let (report, target) = (flags.error_report.clone(), flags.target);
    // clap does not require a flag that conflicts with one that is given.
    if flags.commands.is_some() || flags.report.is_some() || flags.student.is_some() {
        return fail("-commands, -student and -report need '-grade <folder>'");
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
