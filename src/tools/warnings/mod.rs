//! Warnings: valid input that is probably a mistake.
//!
//! Each function looks for one kind of mistake in the scene, its meshes and the flags. Positions refer to the scene's
//! text; the caller adds the file. [`nothing_visible`] examines a picture that shows only its background a second time.

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
