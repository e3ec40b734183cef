//! The layers of a render: each is one picture that shows something else of the same scene.

use crate::stats::Counts;

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Layer {
    /// The colours that the camera sees.
    Color,
    /// The distance along the ray through each pixel's centre, in lengths of its direction: white up to `near`,
    /// black from `far` on and where nothing is seen.
    Depth {
        /// The distance that is shown white. It is below `far`, and both are finite.
        near: f64,
        /// The distance that is shown black.
        far: f64,
    },
    /// The absolute coordinates of the unit normal that the ray through each pixel's centre sees.
    Normals,
    /// The samples of each pixel with their colours, on a chequered ground.
    Samples {
        /// The side of the square that shows one pixel, at least 1.
        zoom: usize,
    },
    /// What each pixel costs, as its probe counts it: zeros where the probe counts nothing.
    Cost(Cost),
    /// The weights of the filter around the middle pixel, with lines between the pixels.
    Filter {
        /// The side of the square that shows one pixel, at least 1.
        zoom: usize,
    },
}

/// What a pixel costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cost {
    /// Rays of every kind.
    Rays,
    /// Tests of a ray against a primitive.
    Tests,
    /// Steps from one cell of the grid to the next.
    Cells,
}

impl Cost {
    /// How much of it has been counted.
    pub fn of(self, counts: &Counts) -> u64 {
        match self {
            Self::Rays => counts.non_shadow_rays + counts.shadow_rays,
            Self::Tests => counts.intersections,
            Self::Cells => counts.cells_traversed,
        }
    }
}

impl Layer {
    /// Width and height of the layer's picture, for a window of so many pixels.
    pub fn size(self, window: [usize; 2]) -> [usize; 2] {
        match self {
            Self::Color | Self::Depth { .. } | Self::Normals | Self::Cost(_) => window,
            Self::Samples { zoom } => window.map(|n| n * zoom),
            Self::Filter { zoom } => window.map(|n| n * zoom + 1),
        }
    }

    /// How many numbers of one row of pixels are kept until the row is written.
    pub(super) fn colors_per_row(self, width: usize) -> usize {
        match self {
            Self::Color | Self::Depth { .. } | Self::Normals | Self::Cost(_) => width,
            Self::Samples { zoom } => width * zoom * zoom,
            Self::Filter { .. } => 0,
        }
    }
}
