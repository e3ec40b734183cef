//! The rules by which scenes are viewed, lit and shown, as plain data. [`Edition`](super::edition::Edition) says which
//! rules an edition has. After a scene is read, no code asks for its edition.

use crate::picture::Color;
use glam::DVec3;
use serde::Serialize;

/// The rules by which surfaces reflect and transmit light. The default is the rules of 2004.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lighting {
    pub highlight: Highlight,
    pub split: Split,
    /// Rays that leave a surface ignore hits nearer than this. `None` ignores only a few roundings, depending on the
    /// point.
    pub epsilon: Option<f64>,
}

/// How a perspective camera's viewing angle maps to pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Screen {
    /// The angle spans the longer side, from the outer edge of the first pixel to the outer edge of the last.
    #[default]
    LongerSide,
    /// The angle spans each side, from the centre of the first pixel to the centre of the last.
    ///
    /// If `up_as_written`, the camera's `up` is neither normalised nor made perpendicular to the direction.
    BothSides { up_as_written: bool },
}

/// The model of specular reflection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Highlight {
    /// Uses the half vector between light and viewer, and only where the surface faces the light. Lights the visible
    /// side, if there is one.
    #[default]
    Blinn,
    /// Uses the mirrored viewing direction, even where the surface faces away from the light. Always lights the
    /// outside.
    Phong,
}

/// How light is divided between refraction and reflection at a transparent surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Split {
    /// By the material's two colours.
    #[default]
    Colors,
    /// By Schlick's approximation, with both parts multiplied by the colours.
    Schlick,
}

/// The normals of meshes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MeshNormals {
    #[default]
    Flat,
    /// Interpolated between the vertices. Meshes with at most `flat_up_to` vertices are flat.
    Smooth { weights: FaceWeights, flat_up_to: usize },
}

/// How the normals of adjacent faces are weighted at a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceWeights {
    Area,
    Equal,
}

/// The colours of depths and normals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeasureColors {
    pub depths: Depths,
    pub normals: NormalColors,
}

/// The mapping from distances to greys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Depths {
    /// Near surfaces are white. The background is black.
    #[default]
    NearWhite,
    /// Near surfaces are black, and so is the background.
    NearBlack,
}

/// The mapping from normals to colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NormalColors {
    /// The absolute coordinates.
    #[default]
    Absolute,
    /// Coordinates from -1 (black) to 1.
    Shifted,
}

/// The content of the colour picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shows {
    #[default]
    Scene,
    /// The pixel coordinates: red grows from 0 to 1 to the right, green downwards, and blue is 1.
    Places,
}

impl Depths {
    /// Returns the grey of a surface at the distance `t`, for the range from `near` to `far`.
    pub fn grey(self, t: f64, [near, far]: [f64; 2]) -> f64 {
        match self {
            Self::NearWhite => (far - t.clamp(near, far)) / (far - near),
            Self::NearBlack => (t - near) / (far - near),
        }
    }
}

impl NormalColors {
    /// Returns the colour of a normal. The normal is zero where nothing is hit.
    pub fn color(self, normal: DVec3) -> Color {
        match self {
            Self::Absolute => normal.abs(),
            Self::Shifted => 0.5 * normal + 0.5,
        }
    }
}
