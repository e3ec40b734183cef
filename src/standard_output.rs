//! Standard output: text goes there, unless a picture does.

use std::io::{self, Write};

/// Prints a text. A reader that went away has seen enough.
pub fn print(text: &str) -> Result<(), String> {
    if text.is_empty() {
        return Ok(());
    }
    check()?;
    let mut output = io::stdout();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(failed(error)),
        _ => Ok(()),
    }
}

/// An error if the program was started without a standard output.
pub fn check() -> Result<(), String> {
    if at_start::is_closed() { Err(failed("it is closed")) } else { Ok(()) }
}

fn failed(reason: impl std::fmt::Display) -> String {
    crate::failed(format!("cannot write to standard output: {reason}"))
}

/// Before `main` starts, the standard library opens `/dev/null` in place of a closed descriptor, and writes to it
/// vanish. So the descriptor is looked at before that.
#[cfg(target_os = "linux")]
mod at_start {
    use std::sync::atomic::{AtomicBool, Ordering};

    static IS_CLOSED: AtomicBool = AtomicBool::new(false);

    // SAFETY: the section holds pointers to functions of the C calling convention, which the loader calls once,
    // before `main` and before there are other threads. This one needs nothing that has to be initialized.
    #[used]
    #[unsafe(link_section = ".init_array")]
    static LOOK: extern "C" fn() = look;

    extern "C" fn look() {
        // SAFETY: the call reads the flags of a descriptor, whether or not that is open.
        let flags = unsafe { libc::fcntl(libc::STDOUT_FILENO, libc::F_GETFD) };
        IS_CLOSED.store(flags == -1, Ordering::Relaxed);
    }

    pub fn is_closed() -> bool {
        IS_CLOSED.load(Ordering::Relaxed)
    }
}

#[cfg(not(target_os = "linux"))]
mod at_start {
    /// Cannot be told.
    pub fn is_closed() -> bool {
        false
    }
}
