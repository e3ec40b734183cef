//! Work that no signal cuts short.

use std::sync::{Mutex, PoisonError};

/// Held by the thread whose work must not be cut short. The thread that takes the signals ends the program while it
/// holds this.
static AT_WORK: Mutex<()> = Mutex::new(());

/// Does work in whose course no signal ends the program.
pub fn undisturbed<T>(work: impl FnOnce() -> T) -> T {
    let _turn = AT_WORK.lock().unwrap_or_else(PoisonError::into_inner);
    work()
}
