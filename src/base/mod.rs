//! Small utilities that every module may use.

pub mod escape;
pub mod memory;
pub mod patience;
pub mod processor_time;
pub mod shell;
pub mod shortcut;
