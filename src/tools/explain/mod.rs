//! Explains the cost of a picture and the computation of a pixel.

mod close_call;
mod cost_map;
mod objects;
mod pixel;
mod stop;
mod text;
mod tree;

pub use close_call::{CloseCall, CloseCallKind};
pub use cost_map::{CostMap, cubehelix};
pub use objects::{MaterialPart, ObjectPart, Objects, TextureWeight};
pub use pixel::Explainer;
pub use stop::Stop;
pub use text::Line;
pub use tree::{
    Crossing, LeftOut, LightBlocker, Lighting, NotFollowed, PixelTree, RayNode, SampleTree, Shadow, Surface,
};
