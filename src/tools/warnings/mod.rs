//! Warnings: valid input that is probably a mistake.
//!
//! Each function looks for one kind of mistake in the scene, its meshes and the flags. Positions are those of the
//! scene's text, whose file the caller adds. [`nothing_visible`] looks once more at a picture that shows nothing but its
//! background.

mod filter;
mod flags;
mod lights;
mod rays;
mod triangles;
mod view;

pub use filter::narrow_filter;
pub use flags::{colors_not_asked_for, sampling_without_effect};
pub use lights::{lights_without_effect, no_lights};
pub use rays::{black_inside, rays_not_followed, rays_without_effect};
pub use triangles::triangles_without_area;
pub use view::nothing_visible;

fn have(count: usize) -> &'static str {
    if count == 1 { "has" } else { "have" }
}
