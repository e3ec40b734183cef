//! A ray tracer that mirrors the one of MIT's 6.837 graphics course: it reads the course's scenes, and renders and
//! counts as the course's program does, but exactly and in milliseconds.
//!
//! A [`Renderer`](render::renderer::Renderer) opens a scene once. Prepared once for each structure, it renders any number
//! of requests: other layers, other effects, a moved camera, or a window of the picture.
//!
//! ```
//! use raytracer::render::{Layer, Request, Window};
//! use raytracer::render::renderer::Renderer;
//! use raytracer::trace::{Effects, Shadows};
//! use std::path::Path;
//!
//! let renderer = Renderer::open(Path::new("scenes/scene6_04_bunny_mesh_200.txt"))?;
//! let size = [80, 60];
//! let effects = Effects { shadows: Shadows::Opaque, ..Effects::default() };
//! let layers = vec![Layer::Color, Layer::Normals];
//! let request = Request { effects, layers, ..Request::new(size) };
//! // The structure is built when the first ray needs it.
//! let prepared = renderer.prepare(&request)?;
//! let pictures = prepared.render(&request)?;
//! assert_eq!(pictures[0].size, size);
//!
//! // A window has the same colours as this part of the whole picture.
//! let window = Window { x: 30, y: 20, width: 8, height: 5 };
//! let part = prepared.render(&Request { window: Some(window), ..request })?;
//! assert_eq!(part[0].colors[..8], pictures[0].colors[20 * 80 + 30..][..8]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Prepared::render_rows`](render::renderer::Prepared::render_rows) hands out the rows as they are finished, so that
//! no picture has to fit into memory. It reports its progress and can be cancelled. [`image_io`] writes such rows to
//! TGA, PNG, BMP, PPM, PFM and OpenEXR files, and reads pictures. Of the [`tools`], [`compare`](tools::compare)
//! measures how two pictures differ, [`causes`](tools::causes) finds out why, and
//! [`error_report`](tools::error_report) measures the time and the error of settings. `command` is the program.
//!
//! Data flows one way: a module imports only from the modules before it in this list.

pub mod base;
pub mod diagnostic;
#[doc(hidden)]
pub mod math;
pub mod picture;
pub mod image_io;
#[doc(hidden)]
pub mod scene;
pub mod stats;
#[doc(hidden)]
pub mod world;
pub mod caster;
#[doc(hidden)]
pub mod shading;
#[doc(hidden)]
pub mod camera;
pub mod sampling;
pub mod trace;
#[cfg(feature = "fast")]
#[doc(hidden)]
pub mod fast;
pub mod render;
pub mod tools;
#[doc(hidden)]
pub mod cli;
#[cfg(feature = "gui")]
mod live;
#[cfg(not(target_family = "wasm"))]
#[doc(hidden)]
pub mod command;
