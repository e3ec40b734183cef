//! What every module may use.

pub mod distinct_files;
pub mod escape;
pub mod memory;
pub mod shell;
pub mod shortcut;
pub mod undisturbed;
