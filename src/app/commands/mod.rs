//! The commands of the program, each with what it reads, does, writes and says.

pub mod render;
pub mod merge;
pub mod convert;
pub mod grade;
pub mod report_errors;
