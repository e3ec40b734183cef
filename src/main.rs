//! The program: command line in, pictures and statistics out. The only place that prints and exits.

mod at_start;
mod complete_files;
mod document;
mod error_reporting;
mod grading;
mod job;
mod merging;
#[cfg(target_os = "linux")]
mod pages;
mod preview;
mod products;
mod progress;
mod rendering;
mod signals;
mod standard_streams;
mod stopping;
mod threads;
mod warn;

use job::Outcome;
use raytracer::cli::{self, Command, Options};
use raytracer::distinct_files::SameFile;
use signals::{Interrupted, Signals};
use standard_streams::print;
use std::ffi::OsString;
use std::fmt::Display;
use std::io::Write;
use std::process::ExitCode;

/// The exit status of a run whose pictures differ by more than the tolerance.
const DIFFERENT: u8 = 3;

fn main() -> ExitCode {
    outlive_file_limit();
    let argv: Vec<OsString> = std::env::args_os().collect();
    let mut signals = match Signals::watch() {
        Ok(signals) => signals,
        Err(error) => {
            tell(&failed(error));
            return ExitCode::FAILURE;
        }
    };
    match cli::parse(argv.iter().cloned()) {
        Ok(Command::Help(text) | Command::Version(text)) => report(Ok(Outcome { text, passes: true })),
        Ok(Command::Render(options)) => render(&options, &argv, &mut signals),
        Ok(Command::Grade(options)) => report(grading::run(&options, &signals, &tell)),
        Ok(Command::Merge(options)) => report(merging::run(&options, &signals)),
        Ok(Command::ReportErrors(options)) => report(error_reporting::run(&options, &signals, &tell)),
        Err(error) => {
            tell(&failed(error));
            ExitCode::from(2)
        }
    }
}

/// Does what the options ask for, and then shows the scene's page if they ask for that.
fn render(options: &Options, argv: &[OsString], signals: &mut Signals) -> ExitCode {
    let outcome = job::run(options, argv, signals, &tell);
    let is_done = outcome.is_ok();
    let status = report(match options.has_standard_output() {
        true => outcome.map(|outcome| Outcome { text: told(outcome.text), ..outcome }),
        false => outcome,
    });
    match if is_done { preview::show(options, signals, &tell) } else { Ok(()) } {
        Ok(()) => status,
        Err(message) => {
            tell(&message);
            ExitCode::FAILURE
        }
    }
}

/// Why a run ends before it is complete.
pub enum End {
    /// The message that tells what has failed.
    Failed(String),
    /// The message that tells what the command line asks for and is not done.
    Refused(String),
    /// A signal has come.
    Interrupted(Interrupted),
}

impl From<String> for End {
    fn from(message: String) -> Self {
        Self::Failed(message)
    }
}

impl From<SameFile> for End {
    fn from(error: SameFile) -> Self {
        Self::Refused(failed(error))
    }
}

impl From<Interrupted> for End {
    fn from(interrupted: Interrupted) -> Self {
        Self::Interrupted(interrupted)
    }
}

/// Says what a run has to say.
fn report(outcome: Result<Outcome, End>) -> ExitCode {
    match outcome.and_then(|outcome| Ok(print(&outcome.text).map(|()| outcome.passes)?)) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(DIFFERENT),
        Err(End::Failed(message)) => {
            tell(&message);
            ExitCode::FAILURE
        }
        Err(End::Refused(message)) => {
            tell(&message);
            ExitCode::from(2)
        }
        Err(End::Interrupted(Interrupted(status))) => ExitCode::from(status),
    }
}

/// A file that grows beyond the limit of `ulimit -f` is an error of the write, and not the end of the program.
fn outlive_file_limit() {
    #[cfg(unix)]
    let _ = nix::sys::signal::SigSet::from(nix::sys::signal::SIGXFSZ).thread_block();
}

/// Prints a line to standard error. Where nobody reads it there is nobody to tell, and `eprintln!` would panic.
fn tell(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Prints the text of a run whose standard output has a picture to standard error, and leaves nothing to print.
fn told(text: String) -> String {
    let _ = std::io::stderr().write_all(text.as_bytes());
    String::new()
}

fn failed(error: impl Display) -> String {
    format!("error: {error}")
}
