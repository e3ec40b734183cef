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

/// All sections with their titles, in the order of the help.
pub(super) const SECTIONS: [(Section, &str); 10] = [
    (Section::Pictures, "Scene and pictures"),
    (Section::Shading, "Shading"),
    (Section::Sampling, "Sampling"),
    (Section::Grid, "Grid"),
    (Section::Comparison, "Comparison"),
    (Section::Grading, "Grading"),
    (Section::ErrorReport, "Speed against error"),
    (Section::Statistics, "Statistics"),
    (Section::Preview, "Live page"),
    (Section::Other, "Other"),
];
