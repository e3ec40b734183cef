//! `-gui`: serves the scene as a live page, and opens it in a browser.

use super::log::Log;
use super::signals::Signals;
use crate::base::stdio::is_stdio;
use crate::cli::{LivePage, Options};
use crate::diagnostic::Diagnostic;
use std::io::{IsTerminal, stderr, stdin};
use std::path::Path;

/// Returns a note about flags of the course's preview that have no effect.
pub fn note(options: &Options) -> Option<&'static str> {
    match &options.page {
        Some(_) if is_shown(options) => None,
        Some(_) if cfg!(not(feature = "gui")) => Some("this build has no live page, so `-gui` shows nothing"),
        Some(_) if scene_file(options).is_none() => Some("`-gui` needs a scene in a file"),
        Some(_) => Some("`-gui` opens its page on a terminal; elsewhere it needs `-port n`"),
        None if options.preview => Some("`-tessellation` and `-gouraud` change nothing"),
        None => None,
    }
}

/// Returns true if the page is shown: there is a scene, and somebody to look at it.
pub fn is_shown(options: &Options) -> bool {
    let has_reader = |page: &LivePage| page.port.is_some() || stdin().is_terminal() && stderr().is_terminal();
    cfg!(feature = "gui") && scene_file(options).is_some() && options.page.as_ref().is_some_and(has_reader)
}

/// The scene's file, which can be read again; not standard input.
fn scene_file(options: &Options) -> Option<&Path> {
    options.input.as_deref().filter(|input| !is_stdio(input))
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
    use crate::base::lock;
    use crate::live::Server;
    use std::env;
    use std::io::{self, Write};
    use std::process::{Command, Stdio};
    use std::sync::{Arc, Mutex};
    use std::thread;
    use tempfile::NamedTempFile;

    /// Serves the page, if there is one, until it is ended there.
    pub fn show(options: &Options, signals: &Signals, log: &Log) -> Result<(), Diagnostic> {
        let (Some(page), Some(input)) = (&options.page, scene_file(options)) else { return Ok(()) };
        if !is_shown(options) {
            return Ok(());
        }
        let server = Server::open(options, input, page.port.unwrap_or(0))?;
        log.say(&format!("open {}  (Ctrl-C ends)", server.url));
        let opened = Arc::new(Mutex::new(None));
        let file = || lock(&opened);
        // A signal waits for the file, and removes it.
        let to_remove = opened.clone();
        signals.before_end(move || drop(lock(&to_remove).take()));
        if page.browser {
            // A browser that does not open is no error: the address stands on the terminal.
            let mut file = file();
            *file = open(&server.url).ok().flatten();
        }
        server.run();
        drop(file().take());
        Ok(())
    }

    /// Opens the address in the browser, if there is a desktop. Returns the file that leads there.
    ///
    /// Everybody on the machine can read the arguments of a process, so the key does not stand there: the browser opens
    /// a file that only its owner can read.
    fn open(url: &str) -> io::Result<Option<NamedTempFile>> {
        let Some(opener) = opener() else { return Ok(None) };
        let page = format!(
            "<!DOCTYPE html><title>raytracer</title><meta http-equiv=\"refresh\" content=\"0;url={url}\">\n"
        );
        let mut file = tempfile::Builder::new().prefix("raytracer-").suffix(".html").tempfile()?;
        file.write_all(page.as_bytes())?;
        let mut command = Command::new(opener);
        command.arg(file.path()).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let mut opening = command.spawn()?;
        thread::Builder::new().spawn(move || opening.wait())?;
        Ok(Some(file))
    }

    /// Returns the program that opens a file on this desktop; `None` without a desktop.
    fn opener() -> Option<&'static str> {
        match env::consts::OS {
            "macos" => Some("open"),
            "windows" => Some("explorer"),
            _ => ["DISPLAY", "WAYLAND_DISPLAY"].iter().find_map(env::var_os).map(|_| "xdg-open"),
        }
    }
}
