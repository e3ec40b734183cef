//! What stands around the ray tracer: it measures, compares, explains and shows. The tools use the renderer as any
//! program does.
//!
//! A module uses only those before it in this list.

mod embedded;
pub mod warnings;
pub mod compare;
pub mod explain;
pub mod causes;
pub mod grade;
pub mod error_report;
pub mod standard_error;
