//! The commands of the program, one file per command. No other module prints or ends the program.

mod signals;
mod log;
mod progress;
mod threads;
mod outputs;
mod parts;
mod products;
mod report;
mod live;
mod compare;
mod render;
mod convert;
mod grade;
mod error_report;

use crate::base::stdio::is_stdio;
use crate::cli::{self, Command, ShowProgress};
use crate::diagnostic::Diagnostic;
use crate::image_io::OutputFile;
use log::Log;
use outputs::Outputs;
use signals::Signals;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// The exit status of a command line that cannot be followed.
const REFUSED: u8 = 2;
/// The exit status of a run whose pictures differ by more than the tolerance.
const DIFFERENT: u8 = 3;

/// Why a run ends before it is complete.
#[derive(Debug)]
pub struct End {
    /// `None` if there is no error to write.
    error: Option<Diagnostic>,
    status: u8,
}

impl<E: Into<Diagnostic>> From<E> for End {
    fn from(error: E) -> Self {
        Self { error: Some(error.into()), status: 1 }
    }
}

/// The end of a run whose command line cannot be followed.
fn refused(error: impl Into<Diagnostic>) -> End {
    End { status: REFUSED, ..End::from(error) }
}

/// The result of a complete run.
pub struct Outcome {
    /// The text for standard output.
    text: String,
    /// The written files that a person at a terminal is told of.
    written: Vec<PathBuf>,
    /// False if pictures differ by more than the tolerance.
    passes: bool,
}

impl Outcome {
    /// The result of a run that has written these files. It leaves out standard output, and all files if the user wants
    /// to see no progress.
    fn new(text: String, written: impl IntoIterator<Item = PathBuf>, progress: ShowProgress) -> Self {
        let is_told = |file: &PathBuf| progress != ShowProgress::Never && !is_stdio(file);
        Self { text, written: written.into_iter().filter(is_told).collect(), passes: true }
    }
}

/// Runs the program with this command line, whose first word is the program's name.
pub fn run(argv: &[OsString]) -> ExitCode {
    let log = Log::default();
    match run_command(argv, &log) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(DIFFERENT),
        Err(End { error, status }) => {
            error.into_iter().for_each(|error| log.log(error));
            ExitCode::from(status)
        }
    }
}

/// Returns false if pictures differ by more than the tolerance.
fn run_command(argv: &[OsString], log: &Log) -> Result<bool, End> {
    let start = Instant::now();
    let signals = Signals::watch()?;
    let command = cli::parse(argv.iter().cloned()).map_err(refused)?;
    let Outcome { text, written, passes } = match &command {
        Command::Print(text) => Outcome::new(text.clone(), [], ShowProgress::Never),
        Command::Render(options) => {
            live::note(options).iter().for_each(|note| log.log(Diagnostic::note(*note)));
            if options.input.is_some() {
                render::run(options, argv, &signals, log)?
            } else {
                compare::run(options, &signals, log)?
            }
        }
        Command::Grade(options) => grade::run(options, &signals, log)?,
        Command::Convert(options) => convert::run(options, &signals, log)?,
        Command::ReportErrors(options) => error_report::run(options, &signals, log)?,
    };
    Outputs::default().add(OutputFile::standard_output().text(&text)?)?;
    log.log_written(&written, start.elapsed());
    if let Command::Render(options) = &command {
        live::show(options, &signals, log)?;
    }
    Ok(passes)
}
