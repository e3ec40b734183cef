//! What each command of the program does, one file per command. Nothing else prints or ends the program.

mod allocator;
mod signals;
mod log;
mod progress;
mod threads;
mod outputs;
mod warnings;
mod parts;
mod products;
mod json;
mod report;
mod live;
mod compare;
mod render;
mod merge;
mod convert;
mod grade;
mod error_report;

use log::Log;
use outputs::Outputs;
use raytracer::cli::{self, Command, ShowProgress};
use raytracer::diagnostic::Diagnostic;
use raytracer::image_io::OutputFile;
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
    /// The error to tell; none if there is nothing more to say.
    error: Option<Diagnostic>,
    status: u8,
}

impl End {
    /// The end by a signal, with the status that shells give it.
    fn by_signal(signal: i32) -> Self {
        Self { error: None, status: (128 + signal) as u8 }
    }
}

impl<E: Into<Diagnostic>> From<E> for End {
    fn from(error: E) -> Self {
        Self { error: Some(error.into()), status: 1 }
    }
}

/// The end of a run whose command line asks for something that is not done.
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
    fn of_text(text: String) -> Self {
        Self { text, written: vec![], passes: true }
    }

    /// Leaves out standard output, and all files if the user wishes to see no progress.
    fn tell_of(self, written: impl IntoIterator<Item = PathBuf>, wish: ShowProgress) -> Self {
        let is_told = |file: &PathBuf| wish != ShowProgress::Never && file.as_os_str() != "-";
        Self { written: written.into_iter().filter(is_told).collect(), ..self }
    }
}

/// Runs the program with this command line, whose first word is the program's name.
pub fn run(argv: &[OsString]) -> ExitCode {
    let log = Log::default();
    match run_command(argv, &log) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(DIFFERENT),
        Err(End { error, status }) => {
            error.into_iter().for_each(|error| log.tell(error));
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
        Command::Print(text) => Outcome::of_text(text.clone()),
        Command::Render(options) => {
            live::note(options).iter().for_each(|note| log.tell(Diagnostic::note(*note)));
            match &options.input {
                Some(input) => render::run(options, input, argv, &signals, log)?,
                None => compare::run(options, &signals, log)?,
            }
        }
        Command::Grade(options) => grade::run(options, &signals, log)?,
        Command::Merge(options) => merge::run(options, &signals)?,
        Command::Convert(options) => convert::run(options, &signals, log)?,
        Command::ReportErrors(options) => error_report::run(options, &signals, log)?,
    };
    Outputs::default().add(OutputFile::standard_output().text(&text)?)?;
    log.tell_written(&written, start.elapsed());
    if let Command::Render(options) = &command {
        live::show(options, &signals, log)?;
    }
    Ok(passes)
}
