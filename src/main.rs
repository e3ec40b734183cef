//! The program: command line in, pictures and statistics out. The only place that prints and exits.

mod document;
mod error_reporting;
mod grading;
mod job;
#[cfg(target_os = "linux")]
mod pages;
mod products;
mod progress;
mod rendering;
mod threads;

use job::Outcome;
use raytracer::cli::{self, Command};
use std::fmt::Display;
use std::io::Write;
use std::process::ExitCode;

/// The exit status of a run whose pictures differ by more than the tolerance.
const DIFFERENT: u8 = 3;

fn main() -> ExitCode {
    match cli::parse(std::env::args_os()) {
        Ok(Command::Help(text) | Command::Version(text)) => print(&text),
        Ok(Command::Render(options)) => report(job::run(&options, &tell)),
        Ok(Command::Grade(options)) => report(grading::run(&options, &tell)),
        Ok(Command::ReportErrors(options)) => report(error_reporting::run(&options, &tell)),
        Err(error) => {
            tell(&failed(error));
            ExitCode::from(2)
        }
    }
}

/// Says what a run has to say.
fn report(outcome: Result<Outcome, String>) -> ExitCode {
    match outcome {
        Ok(outcome) if outcome.passes => print(&outcome.text),
        Ok(outcome) => {
            print(&outcome.text);
            ExitCode::from(DIFFERENT)
        }
        Err(message) => {
            tell(&message);
            ExitCode::FAILURE
        }
    }
}

/// Prints to standard output. A reader that went away is no reason to panic.
fn print(text: &str) -> ExitCode {
    match std::io::stdout().write_all(text.as_bytes()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) => ExitCode::FAILURE,
    }
}

/// Prints a line to standard error. Where nobody reads it there is nobody to tell, and `eprintln!` would panic.
fn tell(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

fn failed(error: impl Display) -> String {
    format!("error: {error}")
}
