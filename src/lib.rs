//! A ray tracer that mirrors the one of MIT's 6.837 graphics course.
//!
//! Data flows one way, and a module imports only from those before it:
//! scene text -> [`scene`] -> world -> grid -> rays -> picture and statistics.

pub mod math;
pub mod scene;
pub mod scene_io;
