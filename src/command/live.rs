//! `-gui`: whether the scene is shown as a live page, and how it gets into a browser.

use super::log::Log;
use super::signals::Signals;
use raytracer::cli::{LivePage, Options};
use raytracer::diagnostic::Diagnostic;
use std::io::{IsTerminal, stderr, stdin};
use std::path::Path;

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
pub use server::show;

/// Shows nothing.
#[cfg(not(feature = "gui"))]
pub fn show(_: &Options, _: &Signals, _: &Log) -> Result<(), Diagnostic> {
    Ok(())
}

#[cfg(feature = "gui")]
mod server {
    use super::*;
    use raytracer::base::undisturbed::undisturbed;
    use raytracer::live::Server;
    use std::io::Write;
    use std::process::{Command, Stdio};
    use std::sync::{Arc, Mutex, PoisonError};
    use std::thread;
    use std::time::Duration;
    use tempfile::NamedTempFile;

    /// Serves the page, if there is one, until it is ended there.
    pub fn show(options: &Options, signals: &Signals, log: &Log) -> Result<(), Diagnostic> {
        let (Some(page), Some(input)) = (&options.page, scene_file(options)) else { return Ok(()) };
        if !is_shown(options) {
            return Ok(());
        }
        // The file from which the browser comes here would be left behind.
        let opened = Arc::new(Mutex::new(None));
        let to_remove = opened.clone();
        let remove = move || drop(to_remove.lock().unwrap_or_else(PoisonError::into_inner).take());
        signals.before_end(remove.clone());
        let server = Server::open(options, input, &page.words, page.port.unwrap_or(0))?;
        let url = server.url.clone();
        log.say(&format!("open {url}  (Ctrl-C ends)"));
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
