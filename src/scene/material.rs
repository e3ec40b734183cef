//! Materials as written: Phong materials and the textures that blend two earlier materials.

use super::{Color, MaterialId};
use glam::DAffine3;

#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    Phong(Phong),
    Texture(Texture),
}

/// A Blinn-Phong material with its secondary rays' colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    pub diffuse: Color,
    pub specular: Color,
    pub exponent: f64,
    pub reflective: Color,
    pub transparent: Color,
    pub index_of_refraction: f64,
}

impl Default for Phong {
    fn default() -> Self {
        Self {
            diffuse: Color::ONE,
            specular: Color::ZERO,
            exponent: 1.0,
            reflective: Color::ZERO,
            transparent: Color::ZERO,
            index_of_refraction: 1.0,
        }
    }
}

/// A solid texture: at every point a mix of two earlier materials.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    pub pattern: Pattern,
    /// Maps a world point to a texture point.
    pub world_to_texture: DAffine3,
    /// The two materials mixed; each index is below the texture's own.
    pub children: [MaterialId; 2],
}

/// How a texture mixes its two materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    Checkerboard,
    Noise { octaves: u32 },
    Marble { octaves: u32, frequency: f64, amplitude: f64 },
    Wood { octaves: u32, frequency: f64, amplitude: f64 },
}
