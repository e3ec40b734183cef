//! How the program was started: which standard streams were closed, and which signals are ignored.

#[cfg(target_os = "linux")]
pub use linux::{ignores, is_closed};

#[cfg(not(target_os = "linux"))]
pub use elsewhere::{ignores, is_closed};

/// A standard stream.
#[derive(Clone, Copy)]
pub enum Stream {
    Input,
    Output,
}

/// Before `main` starts, the standard library opens `/dev/null` in place of a closed descriptor: nothing is read from
/// it, and writes to it vanish. So the descriptors are looked at before that.
#[cfg(target_os = "linux")]
mod linux {
    use super::Stream;
    use libc::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, STDIN_FILENO, STDOUT_FILENO};
    use std::sync::atomic::{AtomicU64, Ordering};

    const DESCRIPTORS: [i32; 2] = [STDIN_FILENO, STDOUT_FILENO];
    const SIGNALS: [i32; 4] = [SIGHUP, SIGINT, SIGQUIT, SIGTERM];

    /// A bit for each closed descriptor.
    static CLOSED: AtomicU64 = AtomicU64::new(0);
    /// A bit for each of these signals that is ignored.
    static IGNORED: AtomicU64 = AtomicU64::new(0);

    // SAFETY: the section holds pointers to functions of the C calling convention, which the loader calls once,
    // before `main` and before there are other threads. This one needs nothing that has to be initialized.
    #[used]
    #[unsafe(link_section = ".init_array")]
    static LOOK: extern "C" fn() = look;

    extern "C" fn look() {
        // SAFETY: the calls read the flags of descriptors, whether or not these are open, and what becomes of signals,
        // into a structure of which every bit pattern of zeros is valid. They change nothing.
        let (is_closed, is_ignored) = unsafe {
            let is_closed = |descriptor| libc::fcntl(descriptor, libc::F_GETFD) == -1;
            let is_ignored = |signal| {
                let mut action: libc::sigaction = std::mem::zeroed();
                libc::sigaction(signal, std::ptr::null(), &mut action) == 0
                    && action.sa_sigaction == libc::SIG_IGN
            };
            (DESCRIPTORS.map(is_closed), SIGNALS.map(is_ignored))
        };
        CLOSED.store(bits(DESCRIPTORS, is_closed), Ordering::Relaxed);
        IGNORED.store(bits(SIGNALS, is_ignored), Ordering::Relaxed);
    }

    fn bits<const N: usize>(numbers: [i32; N], are_set: [bool; N]) -> u64 {
        let set = numbers.into_iter().zip(are_set).filter(|&(_, is_set)| is_set);
        set.fold(0, |bits, (number, _)| bits | 1 << number)
    }

    /// Whether the program was started without this stream.
    pub fn is_closed(stream: Stream) -> bool {
        let descriptor = match stream {
            Stream::Input => STDIN_FILENO,
            Stream::Output => STDOUT_FILENO,
        };
        CLOSED.load(Ordering::Relaxed) >> descriptor & 1 == 1
    }

    /// Whether the program was started to live through this signal, one of those that ask it to end, as by `nohup`.
    pub fn ignores(signal: i32) -> bool {
        IGNORED.load(Ordering::Relaxed) >> signal & 1 == 1
    }
}

#[cfg(not(target_os = "linux"))]
mod elsewhere {
    use super::Stream;

    /// Cannot be told.
    pub fn is_closed(_: Stream) -> bool {
        false
    }

    /// Cannot be told.
    pub fn ignores(_: i32) -> bool {
        false
    }
}
