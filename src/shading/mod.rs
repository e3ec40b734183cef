//! Local shading: the incident light, the material and the solid textures at a point of a surface.

pub mod checkerboard;
pub mod light;
pub mod perlin;
pub mod phong;
pub mod texture;
