//! Warnings: valid input that is probably a mistake.
//!
//! Each function looks for one kind of mistake in the scene, its meshes and the flags.

mod filter;
mod flags;
mod scene;

pub use flags::{about_colors, colors_not_asked_for};
pub use scene::{lights_without_effect, no_lights, nothing_visible, triangles_without_area};
