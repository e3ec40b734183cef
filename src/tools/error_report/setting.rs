//! A setting of the renderer, and its command-line flags.

use crate::caster::choose::{Resolution, Structure};
use crate::render::{Layer, Request, Tracing};
use crate::sampling::adaptive::Adaptive;
use crate::sampling::drand48::Drand48;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::{Pattern, Sampler};
use crate::scene::edition::Edition;
use crate::trace::{Effects, Shadows};

/// The placement of samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Samples {
    /// A fixed number in every pixel.
    Fixed(Pattern, u32),
    /// Adaptive sampling.
    Adaptive(Adaptive),
}

/// The kinds of sampling. Each has its own curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplingKind {
    /// `-random_samples`.
    Random,
    /// `-uniform_samples`.
    Uniform,
    /// `-jittered_samples`.
    Jittered,
    /// `-adaptive_samples`.
    Adaptive,
}

impl SamplingKind {
    /// All kinds of sampling.
    pub const ALL: [Self; 4] = [Self::Random, Self::Uniform, Self::Jittered, Self::Adaptive];

    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Uniform => "uniform",
            Self::Jittered => "jittered",
            Self::Adaptive => "adaptive",
        }
    }
}

/// The parameter that a setting varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The samples.
    Samples,
    /// Fewer bounces, or a larger weight.
    Secondary,
    /// Fewer octaves of noise.
    Octaves,
    /// Another acceleration structure, which must not change the picture.
    Structure,
}

impl Axis {
    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Samples => "samples",
            Self::Secondary => "secondary rays",
            Self::Octaves => "octaves",
            Self::Structure => "grid",
        }
    }
}

/// A setting to measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// The parameter that the setting varies.
    pub axis: Axis,
    /// The placement of samples.
    pub samples: Samples,
    /// The reconstruction filter.
    pub filter: Filter,
    /// The effects modelled.
    pub effects: Effects,
    /// The largest number of octaves of noise. `None` for the scene's own.
    pub octaves: Option<u32>,
    /// The acceleration structure.
    pub structure: Structure,
    /// The edition of the course whose flags are used.
    pub edition: Edition,
}

impl Setting {
    /// Returns the setting of a request, with the flags of an edition.
    pub fn of(request: &Request, structure: Structure, edition: Edition) -> Self {
        let fixed = Samples::Fixed(request.sampler.pattern(), request.sampler.count());
        let (filter, effects) = (request.filter, request.effects);
        let samples = request.adaptive.map_or(fixed, Samples::Adaptive);
        Self { axis: Axis::Samples, samples, filter, effects, octaves: None, structure, edition }
    }

    /// Returns the request for the colours with this setting and these random numbers.
    pub fn request(&self, base: &Request, rng: Drand48) -> Request {
        let (sampler, adaptive) = match self.samples {
            Samples::Fixed(pattern, count) => (Sampler::new(pattern, count, rng), None),
            Samples::Adaptive(adaptive) => (Sampler::of_adaptive(rng), Some(adaptive)),
        };
        let Self { filter, effects, structure, .. } = *self;
        let (layers, tracing, draws_cells) = (vec![Layer::Color], Tracing::Fast, false);
        Request {
            sampler,
            adaptive,
            filter,
            effects,
            layers,
            structure,
            tracing,
            draws_cells,
            ..base.clone()
        }
    }

    /// Returns the kind of sampling.
    pub fn kind(&self) -> SamplingKind {
        match self.samples {
            Samples::Fixed(Pattern::Random | Pattern::Displaced, _) => SamplingKind::Random,
            Samples::Fixed(Pattern::Uniform, _) => SamplingKind::Uniform,
            Samples::Fixed(Pattern::Jittered, _) => SamplingKind::Jittered,
            Samples::Adaptive(_) => SamplingKind::Adaptive,
        }
    }

    /// Returns the number of samples per pixel. `None` if they are adaptive.
    pub fn count(&self) -> Option<u32> {
        match self.samples {
            Samples::Fixed(_, count) => Some(count),
            Samples::Adaptive(_) => None,
        }
    }

    /// Returns the part of the setting that differs from others of its axis.
    pub fn label(&self) -> String {
        let (samples, secondary) = (self.samples_flag(), self.secondary_flags());
        match self.axis {
            Axis::Samples => samples,
            // This is often the default without bounces, and differs from the request.
            Axis::Secondary if !secondary.starts_with(" -bounces") => {
                format!("{samples} -bounces {}{secondary}", self.effects.bounces)
            }
            Axis::Secondary => format!("{samples}{secondary}"),
            Axis::Octaves => {
                format!("{samples} with at most {} octaves in the scene", self.octaves.unwrap_or_default())
            }
            Axis::Structure => format!("{samples}{}", structure_flag(self.structure)),
        }
    }

    /// Returns the part of the setting that distinguishes it from all others, including the filter.
    pub fn label_with_filter(&self) -> String {
        let (label, samples) = (self.label(), self.samples_flag());
        let rest = label.strip_prefix(&samples).unwrap_or_default();
        format!("{samples} {}{rest}", filter_flag(self.filter))
    }

    /// Returns all its flags, separated by spaces. `None` if flags cannot express it.
    pub fn flags(&self) -> Option<String> {
        let Effects { shadows, shade_back, .. } = self.effects;
        let shadows = match shadows {
            Shadows::None => "",
            Shadows::Opaque => " -shadows",
            Shadows::Transparent => " -transparent_shadows",
        };
        let back = if shade_back { " -shade_back" } else { "" };
        let (samples, secondary) = (self.samples_flag(), self.secondary_flags());
        let (filter, structure) = (filter_flag(self.filter), structure_flag(self.structure));
        self.octaves.is_none().then(|| format!("{samples} {filter}{shadows}{back}{secondary}{structure}"))
    }

    fn samples_flag(&self) -> String {
        match self.samples {
            Samples::Fixed(pattern, count) => format!("-{} {count}", pattern.flag(self.edition)),
            Samples::Adaptive(Adaptive { most, error }) => format!("-adaptive_samples {most} {error}"),
        }
    }

    /// Returns the flags for bounces and weight, except defaults.
    fn secondary_flags(&self) -> String {
        let Effects { bounces, min_weight, .. } = self.effects;
        let mut flags = String::new();
        if bounces != self.edition.default_bounces() {
            flags += &format!(" -bounces {bounces}");
        }
        if min_weight != self.edition.default_weight() {
            flags += &format!(" -weight {min_weight}");
        }
        flags
    }
}

/// Splits a string of flags. Each part is a flag with its values.
pub fn separate(flags: &str) -> Vec<String> {
    let mut parts = flags.split(" -");
    let first = parts.next().map(str::to_owned);
    first.into_iter().chain(parts.map(|part| format!("-{part}"))).collect()
}

/// Returns the flag of a filter.
pub fn filter_flag(filter: Filter) -> String {
    match filter {
        Filter::Box { radius } => format!("-box_filter {radius}"),
        Filter::Tent { radius } => format!("-tent_filter {radius}"),
        Filter::Gaussian { sigma } => format!("-gaussian_filter {sigma}"),
        Filter::Mitchell { radius } => format!("-mitchell_filter {radius}"),
    }
}

fn structure_flag(structure: Structure) -> String {
    match structure {
        Structure::Any => String::new(),
        Structure::List => " -grid none".into(),
        Structure::Grid(Resolution::Auto) => " -grid auto".into(),
        Structure::Grid(Resolution::Cells([x, y, z])) => format!(" -grid {x} {y} {z}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_setting_is_the_flags_that_make_it() {
        let setting = Setting {
            axis: Axis::Secondary,
            samples: Samples::Fixed(Pattern::Jittered, 9),
            filter: Filter::Tent { radius: 1.5 },
            effects: Effects { shadows: Shadows::Opaque, shade_back: true, bounces: 3, min_weight: 0.25 },
            octaves: None,
            structure: Structure::Grid(Resolution::Cells([3, 4, 5])),
            edition: Edition::Y2004,
        };
        let flags =
            "-jittered_samples 9 -tent_filter 1.5 -shadows -shade_back -bounces 3 -weight 0.25 -grid 3 4 5";
        assert_eq!(setting.flags().as_deref(), Some(flags));
        assert_eq!(setting.label(), "-jittered_samples 9 -bounces 3 -weight 0.25");
        assert_eq!(
            setting.label_with_filter(),
            "-jittered_samples 9 -tent_filter 1.5 -bounces 3 -weight 0.25"
        );
        let samples = Samples::Adaptive(Adaptive { most: 64, error: 0.5 });
        let plain = Setting {
            samples,
            filter: Filter::PIXEL,
            effects: Effects::default(),
            structure: Structure::Any,
            ..setting
        };
        assert_eq!(plain.flags().as_deref(), Some("-adaptive_samples 64 0.5 -box_filter 0.5"));
        assert_eq!(Setting { octaves: Some(2), ..plain }.flags(), None);
    }

    #[test]
    fn flags_are_those_of_the_edition_and_what_is_its_default_is_none() {
        let setting = |pattern, bounces, min_weight, edition| Setting {
            axis: Axis::Secondary,
            samples: Samples::Fixed(pattern, 9),
            filter: Filter::PIXEL,
            effects: Effects { bounces, min_weight, ..Effects::default() },
            octaves: None,
            structure: Structure::Any,
            edition,
        };
        let flags = |setting: Setting| setting.flags().unwrap_or_default().replace(" -box_filter 0.5", "");
        use Pattern::{Random, Uniform};
        assert_eq!(flags(setting(Random, 0, 0.1, Edition::Aalto)), "-uniform_samples 9");
        assert_eq!(flags(setting(Uniform, 0, 0.0, Edition::Aalto)), "-regular_samples 9 -weight 0");
        let (fewer, usual) =
            (setting(Uniform, 0, 0.0, Edition::Y2012A5), setting(Uniform, 4, 0.0, Edition::Y2012A5));
        assert_eq!([flags(fewer), fewer.label()], ["-uniform_samples 9 -bounces 0"; 2]);
        assert_eq!(flags(usual), "-uniform_samples 9");
        assert_eq!(usual.label(), "-uniform_samples 9 -bounces 4");
    }
}
