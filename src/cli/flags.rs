//! Every flag, once: its values, what it excludes, and its line of help.
//!
//! A new flag is one constant here, one entry in [`FLAGS`], and its reading in `options.rs`; the
//! parser and the help text follow from the table.

/// The heading under which a flag stands in the help.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Section {
    Pictures,
    Shading,
    Sampling,
    Grid,
    Statistics,
    Preview,
    Other,
}

impl Section {
    /// In the order of the help.
    pub const ALL: [Self; 7] = [
        Self::Pictures,
        Self::Shading,
        Self::Sampling,
        Self::Grid,
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
            Self::Statistics => "Statistics",
            Self::Preview => "Preview (accepted, not built: the picture is rendered directly)",
            Self::Other => "Other",
        }
    }
}

/// One flag. Names are without the dash.
#[derive(Debug)]
pub(super) struct Flag {
    pub name: &'static str,
    /// Other spellings, not shown in the help's table.
    pub aliases: &'static [&'static str],
    /// A word for each value, as the help shows them.
    pub values: &'static [&'static str],
    /// Names of flags that contradict this one.
    pub conflicts: &'static [&'static str],
    pub section: Section,
    pub doc: &'static str,
}

impl Flag {
    const fn new(
        section: Section,
        name: &'static str,
        values: &'static [&'static str],
        doc: &'static str,
    ) -> Self {
        Self { name, aliases: &[], values, conflicts: &[], section, doc }
    }

    const fn aliases(mut self, aliases: &'static [&'static str]) -> Self {
        self.aliases = aliases;
        self
    }

    const fn conflicts(mut self, conflicts: &'static [&'static str]) -> Self {
        self.conflicts = conflicts;
        self
    }

    /// How many values the flag may be given: `-grid` may also have the one word `auto`.
    pub fn value_counts(&self) -> std::ops::RangeInclusive<usize> {
        let least = if self.name == GRID.name { 1 } else { self.values.len() };
        least..=self.values.len()
    }

    /// The flag as it is typed: `-size w h`.
    pub fn usage(&self) -> String {
        self.values.iter().fold(format!("-{}", self.name), |line, value| line + " " + value)
    }
}

/// The flag called `name`, by any of its spellings.
pub(super) fn find(name: &str) -> Option<&'static Flag> {
    FLAGS.iter().copied().find(|flag| flag.name == name || flag.aliases.contains(&name))
}

/// In the order of the help within each section.
pub(super) const FLAGS: &[&Flag] = &[
    &INPUT,
    &OUTPUT,
    &SIZE,
    &DEPTH,
    &NORMALS,
    &SHADE_BACK,
    &SHADOWS,
    &NO_SHADOWS,
    &TRANSPARENT_SHADOWS,
    &BOUNCES,
    &WEIGHT,
    &RANDOM_SAMPLES,
    &UNIFORM_SAMPLES,
    &JITTERED_SAMPLES,
    &SEED,
    &BOX_FILTER,
    &TENT_FILTER,
    &GAUSSIAN_FILTER,
    &MITCHELL_FILTER,
    &RENDER_SAMPLES,
    &RENDER_FILTER,
    &GRID,
    &VISUALIZE_GRID,
    &STATS,
    &THREADS,
    &GUI,
    &TESSELLATION,
    &GOURAUD,
    &HELP,
    &VERSION,
];

pub(super) const INPUT: Flag =
    Flag::new(Section::Pictures, "input", &["file"], "The scene; its name ends in .txt. Required.");
pub(super) const OUTPUT: Flag =
    Flag::new(Section::Pictures, "output", &["file"], "Writes the picture; .tga or .png.");
pub(super) const SIZE: Flag = Flag::new(
    Section::Pictures,
    "size",
    &["w", "h"],
    "Pixels of every picture, 1 to 65535 each way. Default: 100 100.",
);
pub(super) const DEPTH: Flag = Flag::new(
    Section::Pictures,
    "depth",
    &["t0", "t1", "file"],
    "Writes a picture of distances: white at t0 and nearer, black at t1 and beyond. t0 < t1.",
);
pub(super) const NORMALS: Flag = Flag::new(
    Section::Pictures,
    "normals",
    &["file"],
    "Writes a picture of surface normals: |x|, |y|, |z| as red, green, blue. Also -normal.",
)
.aliases(&["normal"]);

pub(super) const SHADE_BACK: Flag = Flag::new(
    Section::Shading,
    "shade_back",
    &[],
    "Lights surfaces seen from behind; without it they are black.",
);
pub(super) const SHADOWS: Flag = Flag::new(Section::Shading, "shadows", &[], "Casts shadows. Default: none.");
pub(super) const NO_SHADOWS: Flag = Flag::new(
    Section::Shading,
    "no_shadows",
    &[],
    "Casts no shadows: the default, accepted for the 2003 course's lines.",
)
.conflicts(&["shadows", "transparent_shadows"]);
pub(super) const TRANSPARENT_SHADOWS: Flag = Flag::new(
    Section::Shading,
    "transparent_shadows",
    &[],
    "Casts shadows that transparent objects tint. Implies -shadows.",
);
pub(super) const BOUNCES: Flag = Flag::new(
    Section::Shading,
    "bounces",
    &["n"],
    "Follows reflected and refracted rays to this depth. Default: 0.",
);
pub(super) const WEIGHT: Flag =
    Flag::new(Section::Shading, "weight", &["w"], "Follows no ray that contributes w or less. Default: 0.");

pub(super) const RANDOM_SAMPLES: Flag = Flag::new(
    Section::Sampling,
    "random_samples",
    &["n"],
    "Takes n samples a pixel at random, 1 to 65536. Default: one in the middle.",
)
.conflicts(&["uniform_samples", "jittered_samples"]);
pub(super) const UNIFORM_SAMPLES: Flag = Flag::new(
    Section::Sampling,
    "uniform_samples",
    &["n"],
    "In the middles of a grid of cells; where n is no square, the grid nearest to one: 8 is 4 by 2.",
)
.conflicts(&["jittered_samples"]);
pub(super) const JITTERED_SAMPLES: Flag =
    Flag::new(Section::Sampling, "jittered_samples", &["n"], "At random in each cell of that grid.");
pub(super) const SEED: Flag = Flag::new(
    Section::Sampling,
    "seed",
    &["n"],
    "Starts the random numbers as srand48(n) does. Default: the course's sequence.",
);
pub(super) const BOX_FILTER: Flag = Flag::new(
    Section::Sampling,
    "box_filter",
    &["r"],
    "Averages the samples within r pixels along both axes. Default: a radius of 0.5.",
)
.conflicts(&["tent_filter", "gaussian_filter", "mitchell_filter"]);
pub(super) const TENT_FILTER: Flag =
    Flag::new(Section::Sampling, "tent_filter", &["r"], "Weighs samples down towards the radius r.")
        .conflicts(&["gaussian_filter", "mitchell_filter"]);
pub(super) const GAUSSIAN_FILTER: Flag =
    Flag::new(Section::Sampling, "gaussian_filter", &["s"], "Weighs samples by a Gaussian of deviation s.")
        .conflicts(&["mitchell_filter"]);
pub(super) const MITCHELL_FILTER: Flag = Flag::new(
    Section::Sampling,
    "mitchell_filter",
    &["r"],
    "Weighs samples by Mitchell and Netravali's cubic, which ends at r; 2 is usual.",
);
pub(super) const RENDER_SAMPLES: Flag = Flag::new(
    Section::Sampling,
    "render_samples",
    &["file", "zoom"],
    "Writes a picture of where the samples fall, each pixel enlarged.",
);
pub(super) const RENDER_FILTER: Flag = Flag::new(
    Section::Sampling,
    "render_filter",
    &["file", "zoom"],
    "Writes a picture of the filter's weights, each pixel enlarged.",
);

pub(super) const GRID: Flag = Flag::new(
    Section::Grid,
    "grid",
    &["nx", "ny", "nz"],
    "Speeds the rendering up with a uniform grid of so many cells, or with -grid auto of a fitting number. The picture stays the same.",
);
pub(super) const VISUALIZE_GRID: Flag = Flag::new(
    Section::Grid,
    "visualize_grid",
    &[],
    "Draws the grid's occupied cells instead of the scene. Needs -grid.",
);

pub(super) const STATS: Flag =
    Flag::new(Section::Statistics, "stats", &[], "Prints counts and times after rendering.");

pub(super) const GUI: Flag = Flag::new(Section::Preview, "gui", &[], "The course's preview window.");
pub(super) const TESSELLATION: Flag =
    Flag::new(Section::Preview, "tessellation", &["a", "b"], "Its spheres' faces around and along.");
pub(super) const GOURAUD: Flag = Flag::new(Section::Preview, "gouraud", &[], "Its spheres smooth.");

pub(super) const THREADS: Flag = Flag::new(
    Section::Other,
    "threads",
    &["n"],
    "Renders with n threads, 1 to 4096. Default: all cores. The picture stays the same.",
);
pub(super) const HELP: Flag = Flag::new(Section::Other, "help", &[], "Prints this text.").aliases(&["h"]);
pub(super) const VERSION: Flag = Flag::new(Section::Other, "version", &[], "Prints the version.");
