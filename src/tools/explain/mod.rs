//! Explains the cost of a picture and the computation of a pixel.

mod close_call;
pub mod color_scale;
mod cost_map;
mod cost_report;
mod digits;
mod objects;
mod pixel;
mod pixel_text;
mod ray_tree;
mod short;
mod stop;

pub use close_call::{CloseCall, CloseCallKind};
pub use cost_map::CostMap;
pub use cost_report::CostReport;
pub use objects::{MaterialPart, ObjectPart, Objects, TextureWeight};
pub use pixel::{ExplainError, Explainer, PixelTree, SampleTree};
pub use ray_tree::{Crossing, LeftOut, LightBlocker, Lighting, NotFollowed, RayNode, Shadow, Surface};
pub use stop::Stop;
