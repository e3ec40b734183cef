//! How the program was started: which standard streams were closed, and whether it outlives its terminal.

#[cfg(unix)]
pub use unix::{ignores_hangup, is_closed};

/// A standard stream.
#[derive(Clone, Copy)]
pub enum Stream {
    Input,
    Output,
}

/// Before `main` starts, the standard library opens `/dev/null` in place of a closed descriptor: nothing is read from
/// it, and writes to it vanish. So the descriptors are looked at before that.
#[cfg(unix)]
mod unix {
    use super::Stream;
    use libc::{STDIN_FILENO, STDOUT_FILENO};
    use std::sync::atomic::{AtomicBool, Ordering};

    static INPUT_IS_CLOSED: AtomicBool = AtomicBool::new(false);
    static OUTPUT_IS_CLOSED: AtomicBool = AtomicBool::new(false);
    static IGNORES_HANGUP: AtomicBool = AtomicBool::new(false);

    // SAFETY: the section holds pointers to functions of the C calling convention, which the loader calls once,
    // before `main` and before there are other threads. This one needs nothing that has to be initialized.
    #[used]
    #[cfg_attr(target_vendor = "apple", unsafe(link_section = "__DATA,__mod_init_func"))]
    #[cfg_attr(not(target_vendor = "apple"), unsafe(link_section = ".init_array"))]
    static LOOK: extern "C" fn() = look;

    extern "C" fn look() {
        // SAFETY: the calls read the flags of descriptors, whether or not these are open, and what becomes of a signal,
        // into a structure of which all zeros are a valid value. They change nothing.
        let (input, output, hangup) = unsafe {
            let is_closed = |descriptor| libc::fcntl(descriptor, libc::F_GETFD) == -1;
            let mut action: libc::sigaction = std::mem::zeroed();
            let is_known = libc::sigaction(libc::SIGHUP, std::ptr::null(), &mut action) == 0;
            let hangup = is_known && action.sa_sigaction == libc::SIG_IGN;
            (is_closed(STDIN_FILENO), is_closed(STDOUT_FILENO), hangup)
        };
        INPUT_IS_CLOSED.store(input, Ordering::Relaxed);
        OUTPUT_IS_CLOSED.store(output, Ordering::Relaxed);
        IGNORES_HANGUP.store(hangup, Ordering::Relaxed);
    }

    /// Whether the program was started without this stream.
    pub fn is_closed(stream: Stream) -> bool {
        match stream {
            Stream::Input => &INPUT_IS_CLOSED,
            Stream::Output => &OUTPUT_IS_CLOSED,
        }
        .load(Ordering::Relaxed)
    }

    /// Whether the program was started to ignore SIGHUP, as by `nohup`.
    pub fn ignores_hangup() -> bool {
        IGNORES_HANGUP.load(Ordering::Relaxed)
    }
}

/// Cannot be told.
#[cfg(not(unix))]
pub fn is_closed(_: Stream) -> bool {
    false
}
