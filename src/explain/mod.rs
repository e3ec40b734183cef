//! Where the work of a picture goes.

pub mod color_scale;
mod cost_map;
mod cost_report;
mod digits;

pub use cost_map::CostMap;
pub use cost_report::CostReport;
