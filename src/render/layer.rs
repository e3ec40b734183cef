//! The layers of a render. Each layer is a picture of one property of the scene.

use crate::image_io::Content;
use crate::sampling::sample_packet::Stage;
use crate::stats::Counts;
use serde::{Deserialize, Serialize};

/// The property that a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Layer {
    /// The colours that the camera sees.
    Color,
    /// The t of the hit of the ray through each pixel's centre: white up to `near`, and black from `far` on
    /// and if the ray hits nothing.
    Depth {
        /// The t that is shown white. It is below `far`, and both are finite.
        near: f64,
        /// The t that is shown black.
        far: f64,
    },
    /// The t of the hit of the ray through each pixel's centre, in all three channels; infinity if the ray hits
    /// nothing.
    Distance,
    /// The absolute coordinates of the unit normal at the hit of the ray through each pixel's centre.
    Normals,
    /// The coordinates of the unit normal there; zeros if the ray hits nothing.
    SignedNormals,
    /// The samples of each pixel with their colours, on a chequered background.
    Samples {
        /// The side of the square that shows one pixel, at least 1.
        zoom: usize,
    },
    /// The cost of each pixel, as its probe counts it. All costs are zero if the probe counts nothing. It has no rows:
    /// [`Rendered`](super::Rendered) has the costs.
    Cost(Cost),
    /// The weights of the filter around the middle pixel, with lines between the pixels.
    Filter {
        /// The side of the square that shows one pixel, at least 1.
        zoom: usize,
    },
}

/// The kind of cost of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "cost", rename_all = "snake_case")]
pub enum Cost {
    /// Rays of every kind.
    Rays,
    /// Tests of a ray against a primitive.
    Tests,
    /// Steps from one cell of the grid to the next.
    Cells,
}

impl Cost {
    /// Returns the name, as after `-cost_map`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rays => "rays",
            Self::Tests => "tests",
            Self::Cells => "cells",
        }
    }

    /// Returns the count of this kind.
    pub fn of(self, counts: &Counts) -> u64 {
        match self {
            Self::Rays => counts.rays(),
            Self::Tests => counts.intersections,
            Self::Cells => counts.cells_traversed,
        }
    }
}

impl Layer {
    /// Returns the meaning of its colours.
    pub fn content(self) -> Content {
        if self == Self::Distance { Content::Distances } else { Content::Colors }
    }

    /// Returns the last stage of the rays through the pixels' centres that it needs, independent of the positions of the
    /// samples.
    pub(super) fn measured(self) -> Stage {
        match self {
            Self::Depth { .. } | Self::Distance => Stage::Hits,
            Self::Normals | Self::SignedNormals => Stage::Surfaces,
            Self::Color | Self::Samples { .. } | Self::Cost(_) | Self::Filter { .. } => Stage::Rays,
        }
    }

    /// Returns true for a picture of the scene as the camera sees it, in bytes.
    pub fn is_of_scene(self) -> bool {
        matches!(self, Self::Color | Self::Depth { .. } | Self::Normals)
    }

    /// Returns the width and height of the layer's picture, for a window of this width and height in pixels.
    pub fn size(self, window: [usize; 2]) -> [usize; 2] {
        match self {
            Self::Samples { zoom } => window.map(|n| n * zoom),
            Self::Filter { zoom } => window.map(|n| n * zoom + 1),
            _ => window,
        }
    }

    /// Returns the number of colours that a row of pixels has in this layer.
    pub(super) fn colors_per_row(self, width: usize) -> usize {
        match self {
            Self::Samples { zoom } => width * zoom * zoom,
            Self::Filter { .. } | Self::Cost(_) => 0,
            _ => width,
        }
    }
}
