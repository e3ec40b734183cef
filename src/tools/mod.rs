//! The tools around the ray tracer: they measure, compare, explain and display. They use the renderer like any other
//! program.
//!
//! A module uses only those before it in this list.

mod embedded;
mod table;
#[doc(hidden)]
pub mod warnings;
pub mod compare;
#[doc(hidden)]
pub mod explain;
pub mod causes;
#[doc(hidden)]
pub mod grade;
#[doc(hidden)]
pub mod error_report;
pub mod standard_error;
