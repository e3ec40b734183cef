//! The sections of the help.

/// The section of the help that lists a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Section {
    Pictures,
    Shading,
    Sampling,
    Grid,
    Comparison,
    Grading,
    ErrorReport,
    Statistics,
    Preview,
    Other,
}

impl Section {
    /// All sections, in the order of the help.
    pub const ALL: [Self; 10] = [
        Self::Pictures,
        Self::Shading,
        Self::Sampling,
        Self::Grid,
        Self::Comparison,
        Self::Grading,
        Self::ErrorReport,
        Self::Statistics,
        Self::Preview,
        Self::Other,
    ];

    pub fn title(self) -> &'static str {
        match self {
            Self::Pictures => "Scene and pictures",
            Self::Shading => "Shading",
            Self::Sampling => "Sampling",
            Self::Grid => "Grid",
            Self::Comparison => "Comparison",
            Self::Grading => "Grading",
            Self::ErrorReport => "Speed against error",
            Self::Statistics => "Statistics",
            Self::Preview => "Live page",
            Self::Other => "Other",
        }
    }
}
