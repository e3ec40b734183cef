//! A setting of the renderer, and its command-line flags.

use crate::caster::choose::{Resolution, Structure};
use crate::render::{Layer, Request, Tracing};
use crate::sampling::sampler::Pattern;
use crate::scene::edition::Edition;

/// The kinds of sampling. Each has its own curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplingKind {
    Random,
    Uniform,
    Jittered,
    Sobol,
    Adaptive,
}

impl SamplingKind {
    pub const ALL: [Self; 5] = [Self::Random, Self::Uniform, Self::Jittered, Self::Sobol, Self::Adaptive];

    pub fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Uniform => "uniform",
            Self::Jittered => "jittered",
            Self::Sobol => "sobol",
            Self::Adaptive => "adaptive",
        }
    }
}

/// The parameter that a setting varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    Samples,
    /// Fewer bounces, or a larger weight.
    Secondary,
    /// Noise with at most this number of octaves, which no flag can ask for.
    Octaves(u32),
    /// Another acceleration structure, which must not change the picture.
    Structure,
}

impl Axis {
    pub fn name(self) -> &'static str {
        match self {
            Self::Samples => "samples",
            Self::Secondary => "secondary rays",
            Self::Octaves(_) => "octaves",
            Self::Structure => "grid",
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    pub axis: Axis,
    /// The picture, with its samples, its filter, its effects and its acceleration structure.
    pub request: Request,
    /// The edition of the course whose flags are used.
    pub edition: Edition,
}

impl Setting {
    /// Returns the setting for the colours of a request, with the flags of an edition.
    pub fn new(request: Request, edition: Edition) -> Self {
        let (layers, tracing) = (vec![Layer::Color], Tracing::Fast);
        let request = Request { layers, tracing, draws_cells: false, ..request };
        Self { axis: Axis::Samples, request, edition }
    }

    pub fn kind(&self) -> SamplingKind {
        match self.request.sampler.pattern() {
            _ if self.request.adaptive.is_some() => SamplingKind::Adaptive,
            Pattern::Random | Pattern::Displaced => SamplingKind::Random,
            Pattern::Uniform => SamplingKind::Uniform,
            Pattern::Jittered => SamplingKind::Jittered,
            Pattern::Sobol => SamplingKind::Sobol,
        }
    }

    /// Returns the number of samples per pixel. `None` if they are adaptive.
    pub fn count(&self) -> Option<u32> {
        self.request.adaptive.is_none().then(|| self.request.sampler.count())
    }

    /// Returns the part of the setting that differs from others of its axis: the samples first, then flags with their
    /// values, or words.
    pub fn label(&self) -> String {
        let mut parts = vec![self.samples_flag()];
        match self.axis {
            Axis::Samples => {}
            Axis::Secondary => {
                parts.push(format!("-bounces {}", self.request.effects.bounces));
                parts.extend(self.request.weight_flag(self.edition));
            }
            Axis::Octaves(most) => parts.push(format!("with at most {most} octaves in the scene")),
            Axis::Structure => parts.extend(structure_flag(self.request.structure)),
        }
        parts.join(" ")
    }

    /// Returns all its flags, each with its values. Empty if flags cannot express it.
    pub fn flags(&self) -> Vec<String> {
        if matches!(self.axis, Axis::Octaves(_)) {
            return vec![];
        }
        let Request { effects, filter, structure, .. } = &self.request;
        let mut flags = vec![self.samples_flag(), filter.flag()];
        flags.extend(effects.shadows.flag().map(str::to_owned));
        flags.extend(effects.shade_back.then(|| "-shade_back".into()));
        let has_default_bounces = effects.bounces == self.edition.default_bounces();
        flags.extend((!has_default_bounces).then(|| format!("-bounces {}", effects.bounces)));
        flags.extend(self.request.weight_flag(self.edition));
        flags.extend(structure_flag(*structure));
        flags
    }

    pub(super) fn samples_flag(&self) -> String {
        self.request.samples_flag(self.edition)
    }
}

fn structure_flag(structure: Structure) -> Option<String> {
    match structure {
        Structure::Any => None,
        Structure::List => Some("-grid none".into()),
        Structure::Grid(Resolution::Auto) => Some("-grid auto".into()),
        Structure::Grid(Resolution::Cells([x, y, z])) => Some(format!("-grid {x} {y} {z}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::adaptive::Adaptive;
    use crate::sampling::drand48::Drand48;
    use crate::sampling::filter::Filter;
    use crate::sampling::sampler::Sampler;
    use crate::trace::{Effects, Shadows};

    fn setting(pattern: Pattern, effects: Effects, edition: Edition) -> Setting {
        let sampler = Sampler::new(pattern, 9, Drand48::UNSEEDED);
        let request = Request { sampler, effects, ..Request::new([4, 4]) };
        Setting { axis: Axis::Secondary, ..Setting::new(request, edition) }
    }

    #[test]
    fn a_setting_is_the_flags_that_make_it() {
        let effects = Effects { shadows: Shadows::Opaque, shade_back: true, bounces: 3, min_weight: 0.25 };
        let mut found = setting(Pattern::Jittered, effects, Edition::Y2004);
        found.request.filter = Filter::Tent { radius: 1.5 };
        found.request.structure = Structure::Grid(Resolution::Cells([3, 4, 5]));
        let flags =
            "-jittered_samples 9 -tent_filter 1.5 -shadows -shade_back -bounces 3 -weight 0.25 -grid 3 4 5";
        assert_eq!(found.flags().join(" "), flags);
        assert_eq!(found.label(), "-jittered_samples 9 -bounces 3 -weight 0.25");
        let mut plain = setting(Pattern::Uniform, Effects::default(), Edition::Y2004);
        plain.request.adaptive = Some(Adaptive { most: 64, error: 0.5 });
        assert_eq!(plain.flags(), ["-adaptive_samples 64 0.5", "-box_filter 0.5"]);
        assert!(Setting { axis: Axis::Octaves(2), ..plain }.flags().is_empty());
    }

    #[test]
    fn flags_are_those_of_the_edition_and_what_is_its_default_is_none() {
        let setting = |pattern, bounces, min_weight, edition| {
            setting(pattern, Effects { bounces, min_weight, ..Effects::default() }, edition)
        };
        let flags = |setting: &Setting| setting.flags().join(" ").replace(" -box_filter 0.5", "");
        use Pattern::{Random, Uniform};
        assert_eq!(flags(&setting(Random, 0, 0.1, Edition::Aalto)), "-uniform_samples 9");
        assert_eq!(flags(&setting(Uniform, 0, 0.0, Edition::Aalto)), "-regular_samples 9 -weight 0");
        let (fewer, usual) =
            (setting(Uniform, 0, 0.0, Edition::Y2012A5), setting(Uniform, 4, 0.0, Edition::Y2012A5));
        assert_eq!([flags(&fewer), fewer.label()], ["-uniform_samples 9 -bounces 0"; 2]);
        assert_eq!(flags(&usual), "-uniform_samples 9");
        assert_eq!(usual.label(), "-uniform_samples 9 -bounces 4");
    }
}
