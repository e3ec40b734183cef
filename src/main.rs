//! The program: command line in, pictures and statistics out.

mod app;

use app::commands::{self, convert, grade, merge, report_errors};
use app::{End, Interrupted, Outcome, Signals, failed, say, tell};
use raytracer::cli::{self, Command, Options};
use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;
use std::time::Instant;

/// The exit status of a run whose pictures differ by more than the tolerance.
const DIFFERENT: u8 = 3;

fn main() -> ExitCode {
    let start = Instant::now();
    outlive_file_limit();
    let argv: Vec<OsString> = std::env::args_os().collect();
    let mut signals = match Signals::watch() {
        Ok(signals) => signals,
        Err(error) => {
            tell(&failed(error));
            return ExitCode::FAILURE;
        }
    };
    if let Some(status) = app::page_worker(&argv) {
        return status;
    }
    match cli::parse(argv.iter().cloned()) {
        Ok(Command::Help(text) | Command::Version(text)) => {
            report(start, Ok(Outcome { text, written: vec![], passes: true }))
        }
        Ok(Command::Render(options)) => render(start, &options, &argv, &mut signals),
        Ok(Command::Grade(options)) => report(start, grade::run(&options, &signals, &tell)),
        Ok(Command::Merge(options)) => report(start, merge::run(&options, &signals)),
        Ok(Command::Convert(options)) => report(start, convert::run(&options, &signals, &tell)),
        Ok(Command::ReportErrors(options)) => report(start, report_errors::run(&options, &signals, &tell)),
        Err(error) => {
            tell(&failed(error));
            ExitCode::from(2)
        }
    }
}

/// Does what the options ask for, and then shows the scene's page if they ask for that.
fn render(start: Instant, options: &Options, argv: &[OsString], signals: &mut Signals) -> ExitCode {
    let outcome = commands::render::run(options, argv, signals, &tell);
    let is_done = outcome.is_ok();
    let status = report(
        start,
        match options.has_standard_output() {
            true => outcome.map(|outcome| Outcome { text: told(outcome.text), ..outcome }),
            false => outcome,
        },
    );
    match if is_done { app::show_page(options, signals, &say) } else { Ok(()) } {
        Ok(()) => status,
        Err(message) => {
            say(&message);
            ExitCode::FAILURE
        }
    }
}

/// Says what a run has to say that has begun at this time.
fn report(start: Instant, outcome: Result<Outcome, End>) -> ExitCode {
    let say = |Outcome { text, written, passes }: Outcome| {
        app::print(&text)?;
        app::tell_written(&written, start.elapsed());
        Ok(passes)
    };
    match outcome.and_then(say) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(DIFFERENT),
        Err(End::Failed(errors)) => {
            errors.iter().for_each(tell);
            ExitCode::FAILURE
        }
        Err(End::Refused(error)) => {
            tell(&error);
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

/// Prints the text of a run whose standard output has a picture to standard error, and leaves nothing to print.
fn told(text: String) -> String {
    let _ = std::io::stderr().write_all(text.as_bytes());
    String::new()
}
