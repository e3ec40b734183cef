//! `-gui`: whether the scene is shown as a live page, and how it gets into a browser.

use crate::app::signals::Signals;
use raytracer::cli::{LivePage, Options};
use std::ffi::OsString;
use std::io::{IsTerminal, stderr, stdin};
use std::path::Path;
use std::process::ExitCode;

/// What there is to say about the flags of the course's preview, unless the page is shown.
pub fn note(options: &Options) -> Option<&'static str> {
    match &options.page {
        Some(_) if is_shown(options) => None,
        Some(_) if cfg!(not(feature = "gui")) => Some("this build has no live page, so `-gui` shows nothing"),
        Some(_) if scene_file(options).is_none() => Some("`-gui` shows a scene in a file, and there is none"),
        Some(_) => Some("`-gui` opens its page on a terminal; elsewhere it needs `-port n`"),
        None if options.preview => Some("`-tessellation` and `-gouraud` change nothing"),
        None => None,
    }
}

/// Whether there is a page for the options: a scene, and somebody to look at it.
pub fn is_shown(options: &Options) -> bool {
    let has_reader = |page: &LivePage| page.port.is_some() || stdin().is_terminal() && stderr().is_terminal();
    cfg!(feature = "gui") && scene_file(options).is_some() && options.page.as_ref().is_some_and(has_reader)
}

/// The scene's file, which can be read again; not standard input.
fn scene_file(options: &Options) -> Option<&Path> {
    options.input.as_deref().filter(|input| *input != Path::new("-"))
}

#[cfg(feature = "gui")]
pub use server::{show, worker};

/// There are no workers.
#[cfg(not(feature = "gui"))]
pub fn worker(_: &[OsString]) -> Option<ExitCode> {
    None
}

/// Shows nothing.
#[cfg(not(feature = "gui"))]
pub fn show(_: &Options, _: &mut Signals, _: &dyn Fn(&str)) -> Result<(), String> {
    Ok(())
}

#[cfg(feature = "gui")]
mod server {
    use super::*;
    use raytracer::cli;
    use raytracer::live::{Server, Setup, work};
    use raytracer::undisturbed::undisturbed;
    use std::env;
    use std::io::{self, Write};
    use std::process::{Command, Stdio};
    use std::sync::{Arc, Mutex, PoisonError};
    use std::thread;
    use std::time::Duration;
    use tempfile::NamedTempFile;

    /// The first argument of a process that works for a page. The others are those of the page's program.
    const WORKER: &str = "--work-for-page";

    /// Does the work of a page's worker, if the program was started as one.
    pub fn worker(argv: &[OsString]) -> Option<ExitCode> {
        if argv.get(1).is_none_or(|word| word != WORKER) {
            return None;
        }
        let line = argv.iter().take(1).chain(&argv[2..]).cloned();
        let Ok(cli::Command::Render(options)) = cli::parse(line) else { return Some(ExitCode::FAILURE) };
        let (Some(page), Some(input)) = (&options.page, scene_file(&options)) else {
            return Some(ExitCode::FAILURE);
        };
        work(&Setup { options: &options, input, words: &page.words });
        Some(ExitCode::SUCCESS)
    }

    /// The command that starts a worker.
    fn worker_command() -> io::Result<Command> {
        // The file may have been replaced since.
        let program = if cfg!(target_os = "linux") { "/proc/self/exe".into() } else { env::current_exe()? };
        let mut command = Command::new(program);
        command.arg(WORKER).args(env::args_os().skip(1));
        Ok(command)
    }

    /// Serves the page, if there is one, until it is ended there.
    pub fn show(options: &Options, signals: &mut Signals, say: &dyn Fn(&str)) -> Result<(), String> {
        let Some(page) = &options.page else { return Ok(()) };
        if !is_shown(options) {
            return Ok(());
        }
        // The file from which the browser comes here would be left behind.
        let opened = Arc::new(Mutex::new(None));
        let to_remove = opened.clone();
        let remove = move || drop(to_remove.lock().unwrap_or_else(PoisonError::into_inner).take());
        if signals.end_after(remove.clone()).is_err() {
            return Ok(());
        }
        let port = page.port.unwrap_or(0);
        let server = Server::open(port, worker_command)?;
        let url = server.url();
        say(&format!("open {url}  (Ctrl-C ends)"));
        if page.browser {
            open_browser(&url, opened);
        }
        server.run();
        remove();
        Ok(())
    }

    /// Opens the address in the browser of the desktop, if there is one.
    ///
    /// Everybody on the machine can read the arguments of a process, so the key does not stand there: the browser
    /// opens a file that only its owner can read, which leads to the page and is removed after a while.
    fn open_browser(url: &str, opened: Arc<Mutex<Option<NamedTempFile>>>) {
        let Some(opener) = opener() else { return };
        let Ok(file) = undisturbed(|| {
            let mut opened = opened.lock().unwrap_or_else(PoisonError::into_inner);
            redirection(url).map(|file| opened.insert(file).path().to_owned())
        }) else {
            return;
        };
        let mut command = Command::new(opener);
        command.arg(file).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let Ok(mut opening) = command.spawn() else { return };
        const LOADING: Duration = Duration::from_secs(20);
        let wait = move || {
            let _ = opening.wait();
            thread::sleep(LOADING);
            drop(opened.lock().unwrap_or_else(PoisonError::into_inner).take());
        };
        let _ = thread::Builder::new().spawn(wait);
    }

    fn redirection(url: &str) -> std::io::Result<NamedTempFile> {
        let mut file = tempfile::Builder::new().prefix("raytracer-").suffix(".html").tempfile()?;
        writeln!(
            file,
            "<!DOCTYPE html><title>raytracer</title><meta http-equiv=\"refresh\" content=\"0;url={url}\">"
        )?;
        Ok(file)
    }

    /// The program that opens a file on this desktop; none where there is no desktop.
    fn opener() -> Option<&'static str> {
        if cfg!(target_os = "macos") {
            Some("open")
        } else if cfg!(target_os = "windows") {
            Some("explorer")
        } else {
            let has_desktop =
                ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some());
            has_desktop.then_some("xdg-open")
        }
    }
}
