//! Small utilities that every module may use.

pub mod escape;
pub mod memory;
pub mod patience;
pub mod processor_time;
pub mod shell;
pub mod shortcut;
pub mod stdio;

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Locks a mutex, whose value stays in use if a thread panicked that held it.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
