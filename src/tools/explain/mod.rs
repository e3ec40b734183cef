//! Explains the cost of a picture and the computation of a pixel.

mod close_call;
mod cost_map;
mod explainer;
mod pixel;
mod text;
mod tree;

pub use cost_map::{CostMap, cubehelix};
pub use explainer::Explainer;
pub use tree::{ObjectPart, PixelTree, RayNode};
