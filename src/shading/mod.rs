//! The colour of a surface point: light, material, solid texture.

pub mod light;
pub mod perlin;
pub mod phong;
pub mod texture;
