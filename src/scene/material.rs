//! Materials as written in the scene: Phong materials, and solid textures that mix two earlier materials.

use super::transform::Factor;
use crate::math::rounded::RoundedAffine;
use crate::picture::Color;
use serde::Serialize;

/// The index of a material in [`Scene::materials`](super::Scene::materials).
pub type MaterialId = usize;

/// The material of a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// A material that is uniform over the surface.
    Phong(Phong),
    /// A mixture of two other materials.
    Texture(Texture),
    /// A material whose diffuse colour depends on the point.
    Painted(Phong, Paint),
}

impl Material {
    /// Returns true if rays are reflected or refracted at the material. False for a texture, where the mixed materials
    /// decide.
    pub fn has_secondary_rays(&self) -> bool {
        match self {
            Self::Phong(phong) | Self::Painted(phong, _) => {
                phong.reflective != Color::ZERO || phong.transparent != Color::ZERO
            }
            Self::Texture(_) => false,
        }
    }

    /// Returns the number of octaves of its noise, to be changed.
    pub fn octaves_mut(&mut self) -> Option<&mut u32> {
        match self {
            Self::Texture(Texture { pattern, .. }) | Self::Painted(_, Paint::Pattern(pattern, _)) => {
                pattern.octaves_mut()
            }
            Self::Phong(_) | Self::Painted(_, Paint::Image { .. }) => None,
        }
    }
}

/// A Blinn-Phong material, with the factors for reflected and refracted rays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Phong {
    pub diffuse: Color,
    pub specular: Color,
    pub exponent: f64,
    /// The factor for the light along the reflected ray.
    pub reflective: Color,
    /// The factor for the light along the refracted ray.
    pub transparent: Color,
    /// The index of refraction of the inside relative to the outside.
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

/// A solid texture: at every point a mixture of two earlier materials.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    pub pattern: Pattern,
    /// The map from world space to the texture's space: the product of `factors`.
    pub world_to_texture: RoundedAffine,
    pub factors: Box<[Factor]>,
    /// The two materials; each index is below the texture's own.
    pub children: [MaterialId; 2],
}

/// The pattern in which a texture mixes its two materials.
///
/// `octaves` is the number of octaves of noise. Over one unit of length the phase of stripes and rings changes by
/// `frequency`. A noise of 1 shifts it by `amplitude`. Both are in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// Unit cubes that alternate between the two materials.
    Checkerboard,
    /// Perlin noise, summed over octaves.
    Noise { octaves: u32 },
    /// Stripes along x, distorted by noise.
    Marble { octaves: u32, frequency: f64, amplitude: f64 },
    /// Rings around the y axis, distorted by noise.
    Wood { octaves: u32, frequency: f64, amplitude: f64 },
}

impl Pattern {
    /// Returns the keyword of the texture in a scene's text.
    pub fn name(self) -> &'static str {
        match self {
            Self::Checkerboard => "Checkerboard",
            Self::Noise { .. } => "Noise",
            Self::Marble { .. } => "Marble",
            Self::Wood { .. } => "Wood",
        }
    }

    /// Returns the number of octaves of noise.
    pub fn octaves(mut self) -> u32 {
        self.octaves_mut().map_or(0, |octaves| *octaves)
    }

    /// Returns the number of octaves of noise, to be changed.
    fn octaves_mut(&mut self) -> Option<&mut u32> {
        match self {
            Self::Checkerboard => None,
            Self::Noise { octaves } | Self::Marble { octaves, .. } | Self::Wood { octaves, .. } => {
                Some(octaves)
            }
        }
    }
}

/// The source of a painted material's diffuse colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Paint {
    /// A picture, given by its index in [`Scene::images`](super::Scene::images). It applies where the mesh has texture
    /// coordinates. Ambient light is multiplied by the picture's colour if `tints_ambient`, otherwise by the material's
    /// own diffuse colour.
    Image { image: usize, tints_ambient: bool },
    /// Two colours in a pattern of world space. Ambient light is multiplied by the material's own diffuse colour.
    Pattern(Pattern, [Color; 2]),
}
