//! The results of tracing a row of pixels.

use crate::picture::Color;
use crate::sampling::spread::Spread;
use crate::stats::Counts;

/// The result of tracing a row of pixels.
pub struct Row {
    /// The index of the row, counted from the bottom.
    pub j: usize,
    /// The counts of the row's rays.
    pub counts: Counts,
    pub colors: Colors,
    /// The colours of each layer of the request: one for each pixel, or for a layer of samples the rows of the
    /// enlarged picture from the bottom. The list of a colour layer is empty, because its colours are in `colors`.
    pub layers: Vec<Vec<Color>>,
}

impl Row {
    /// Returns an empty row `j` in the memory of this row, whose counts have been taken. Returns `None` if this row
    /// has sums, whose memory is not reused.
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

/// The contribution of a row's samples to the layer of colours.
pub enum Colors {
    /// Nothing, because the request has no such layer.
    Unwanted,
    /// The colours of the row itself, if every sample contributes to its own pixel only.
    Finished(Vec<Color>),
    /// Sums for this row and the rows around it.
    Spread(Spread),
}

impl Colors {
    /// Returns the colours of the row itself, or an empty list if they are not known.
    pub fn finished(&self) -> &[Color] {
        match self {
            Self::Finished(colors) => colors,
            Self::Unwanted | Self::Spread(_) => &[],
        }
    }
}
