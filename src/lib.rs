//! A ray tracer that mirrors the one of MIT's 6.837 graphics course.
//!
//! Data flows one way, and a module imports only from those before it in this list.

pub mod escape;
pub mod math;
pub mod scene;
pub mod mode;
pub mod stats;
pub mod primitive;
pub mod world;
pub mod grid;
pub mod shading;
pub mod camera;
pub mod raster;
pub mod trace;
pub mod sampling;
pub mod picture;
pub mod render;
pub mod image_io;
pub mod compare;
pub mod scene_io;
pub mod renderer;
pub mod cli;
