//! What a scene means where the editions of the course differ: each edition is a value of [`Model`], and nothing
//! behind the reader of scenes knows an edition by its name.

use crate::picture::Color;
use glam::DVec3;
use serde::Serialize;

/// How a scene is seen, lit and shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    pub screen: Screen,
    pub highlight: Highlight,
    pub split: Split,
    /// Rays that leave a surface overlook what is nearer than this. None is a few roundings, as the point asks for.
    pub epsilon: Option<f64>,
    pub normals: MeshNormals,
    pub depths: Depths,
    pub normal_colors: NormalColors,
    pub shows: Shows,
}

/// How the view of a perspective camera is spread over the pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Screen {
    /// The angle spans the longer side, from the outer edge of one pixel to that of another.
    LongerSide,
    /// The angle spans either side, from the centre of the first pixel to that of the last.
    /// With `up_as_written` the camera's `up` is neither made a unit vector nor made perpendicular to the direction.
    BothSides { up_as_written: bool },
}

/// How lights are reflected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Highlight {
    /// By the vector half way between light and viewer, and only where the surface faces the light. The side that is
    /// seen is lit, if any is.
    Blinn,
    /// By the mirrored viewing direction, whether or not the surface faces the light. The outside is lit, whichever side
    /// is seen.
    Phong,
}

/// How the light is split that comes through a transparent surface and is mirrored there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// By the material's two colours.
    Colors,
    /// By Schlick's approximation, of which both parts are multiplied by the colours.
    Schlick,
}

/// The normals of meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshNormals {
    Flat,
    /// Interpolated between the vertices. Meshes of at most `flat_up_to` vertices are flat.
    Smooth {
        weights: FaceWeights,
        flat_up_to: usize,
    },
}

/// The weights of the faces around a vertex for its normal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceWeights {
    Area,
    Equal,
}

/// The greys of distances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depths {
    /// What is near is white, and nothing is black.
    NearWhite,
    /// What is near is black, and so is nothing.
    NearBlack,
}

/// The colours of normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NormalColors {
    /// The absolute coordinates.
    Absolute,
    /// From -1, which is black, to 1.
    Shifted,
}

/// What the picture of colours shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shows {
    Scene,
    /// The place of each pixel: from 0 to 1, red grows to the right and green downwards, and blue is 1.
    Places,
}

impl Depths {
    /// The grey of a surface at the distance `t` where those between `near` and `far` are shown.
    pub fn grey(self, t: f64, [near, far]: [f64; 2]) -> f64 {
        match self {
            Self::NearWhite => (far - t.clamp(near, far)) / (far - near),
            Self::NearBlack => (t - near) / (far - near),
        }
    }
}

impl NormalColors {
    /// The colour of a normal, which is zero where nothing is seen.
    pub fn color(self, normal: DVec3) -> Color {
        match self {
            Self::Absolute => normal.abs(),
            Self::Shifted => 0.5 * normal + 0.5,
        }
    }
}

impl Model {
    /// That of the editions of 2003 and 2004.
    pub const COURSE: Self = Self {
        screen: Screen::LongerSide,
        highlight: Highlight::Blinn,
        split: Split::Colors,
        epsilon: None,
        normals: MeshNormals::Flat,
        depths: Depths::NearWhite,
        normal_colors: NormalColors::Absolute,
        shows: Shows::Scene,
    };
}
