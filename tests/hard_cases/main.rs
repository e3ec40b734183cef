//! Numerical hard cases, compared with exact references. Every case also runs the textbook's method on the
//! same input and asserts that it fails, so that a case which tests nothing is noticed.
//!
//! The ordinary test command tries a sample of each case. `HARD_CASES=ordinary cargo test --test hard_cases` tries all
//! inputs of the ordinary tier, and `HARD_CASES=long` the many more rays of the long one. If `ACCURACY_DIR` is set to a
//! folder, every case writes its measurements there for `docs/accuracy.md`, by default those of the ordinary tier.

mod coincident_surfaces;
mod critical_angle;
mod far_things;
mod filter;
mod flattened;
mod grid;
mod grid_dda;
mod grid_scenes;
mod hostile_input;
mod invariance;
mod lights_near_surfaces;
mod lights_on_surfaces;
mod lights_on_triangles;
mod near_coincident;
mod near_lights;
mod offsets;
mod planes;
#[cfg(feature = "fast")]
mod raster;
#[cfg(feature = "fast")]
mod raster_parallel;
mod secondary_rays;
mod shading;
mod shading_output;
mod shading_textures;
mod shadow_rays;
mod singular_transforms;
mod spheres;
mod starts_on_triangles;
mod support;
mod ties;
mod transforms;
mod triangles_accuracy;
mod triangles_degenerate;
mod triangles_extremes;
mod triangles_order;
mod triangles_watertight;
mod within_bounds;
