//! Materials as written: Phong materials and the textures that blend two earlier materials.

use super::{Color, MaterialId};
use glam::DAffine3;

/// What a surface is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// The same everywhere.
    Phong(Phong),
    /// A mix of two others.
    Texture(Texture),
}

/// A Blinn-Phong material with its secondary rays' colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    /// Scattered in all directions.
    pub diffuse: Color,
    /// The colour of highlights.
    pub specular: Color,
    /// How narrow the highlights are.
    pub exponent: f64,
    /// The share of the mirrored light.
    pub reflective: Color,
    /// The share of the refracted light.
    pub transparent: Color,
    /// Of the inside against the outside.
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
    /// How the materials mix.
    pub pattern: Pattern,
    /// Maps a world point to a texture point.
    pub world_to_texture: DAffine3,
    /// The two materials mixed; each index is below the texture's own.
    pub children: [MaterialId; 2],
}

/// How a texture mixes its two materials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// Unit cubes of the one and of the other in turn.
    Checkerboard,
    /// Perlin noise, summed over octaves.
    Noise {
        /// How many octaves of noise are summed.
        octaves: u32,
    },
    /// Stripes along x, bent by noise.
    Marble {
        /// How many octaves of noise are summed.
        octaves: u32,
        /// By how many radians the pattern's phase advances over one unit.
        frequency: f64,
        /// By how many radians a noise of 1 shifts the phase.
        amplitude: f64,
    },
    /// Rings around y, bent by noise.
    Wood {
        /// How many octaves of noise are summed.
        octaves: u32,
        /// By how many radians the pattern's phase advances over one unit.
        frequency: f64,
        /// By how many radians a noise of 1 shifts the phase.
        amplitude: f64,
    },
}
