//! What has been traced of a row of pixels.

use crate::picture::Color;
use crate::sampling::spread::Spread;
use crate::stats::Counts;

/// The result of tracing a row of pixels.
pub struct Row {
    /// The index of the row, counted from the bottom.
    pub j: usize,
    /// What was counted.
    pub counts: Counts,
    pub colors: Colors,
    /// The colours of each layer of the request: one for each pixel, or for a layer of samples the rows of
    /// the enlarged picture from the bottom. The list of a colour layer is empty, because `colors` has its
    /// colours.
    pub layers: Vec<Vec<Color>>,
}

impl Row {
    /// Row `j` in the memory of this one, whose counts have been taken; none if it has sums, which are not used again.
    pub(super) fn emptied(mut self, j: usize) -> Option<Self> {
        match &mut self.colors {
            Colors::Unwanted => {}
            Colors::Finished(colors) => colors.clear(),
            Colors::Spread(_) => return None,
        }
        self.layers.iter_mut().for_each(Vec::clear);
        Some(Self { j, ..self })
    }
}

/// What the samples of a row contribute to the layer of colours.
pub enum Colors {
    /// Nothing, because the request has no such layer.
    Unwanted,
    /// The colours of the row itself, if every sample contributes to its own pixel only.
    Finished(Vec<Color>),
    /// Sums for this row and those around it.
    Spread(Spread),
}

impl Colors {
    /// The colours of the row itself, if they are known.
    pub fn finished(&self) -> &[Color] {
        match self {
            Self::Finished(colors) => colors,
            Self::Unwanted | Self::Spread(_) => &[],
        }
    }
}
