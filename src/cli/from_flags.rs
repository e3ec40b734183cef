//! Makes the options of the flags, and checks them together.

use super::error::{fail, value};
use super::flags::{Flags, MAX_INT};
use super::options::{ComparisonOptions, Given, LivePage, Options, ShowProgress};
use super::outputs::outputs;
use super::values::{NOT_NEGATIVE, Sides, number, picture};
use crate::base::stdio::is_stdio;
use crate::caster::choose::{Resolution, Structure};
use crate::diagnostic::Diagnostic;
use crate::render::adaptive::Adaptive;
use crate::render::{Layer, Window};
use crate::sampling::drand48::Drand48;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::{Pattern, Sampler};
use crate::scene::edition::Edition;
use crate::tools::compare::Tolerance;
use crate::trace::{Effects, Shadows};
use clap::value_parser;
use std::ffi::OsString;

/// The number of cells stays below this, so that the index of a cell fits into 32 bits.
const CELL_LIMIT: u128 = 1 << 31;

impl Options {
    /// Checks the flags together. `words` are the flags that the live page begins with.
    pub(super) fn new(flags: Flags, words: Vec<String>) -> Result<Self, Diagnostic> {
        let triples = flags.edition != Some(Edition::Y2019);
        let size = size(&flags.size)?;
        let options = Self {
            outputs: outputs(&flags, size)?,
            size,
            region: flags.region.as_deref().map(region).transpose()?,
            edition: edition(&flags)?,
            uv: flags.uv,
            // The program of 2019 accepts both flags and does nothing.
            jitter: flags.jitter && triples,
            reduced: flags.filter && triples,
            effects: Effects {
                shadows: match (flags.transparent_shadows, flags.shadows) {
                    (true, _) => Shadows::Transparent,
                    (false, true) => Shadows::Opaque,
                    (false, false) => Shadows::None,
                },
                shade_back: flags.shade_back,
                bounces: flags.bounces.unwrap_or(0),
                min_weight: flags.weight.unwrap_or(0.0),
            },
            given: Given {
                bounces: flags.bounces,
                weight: flags.weight,
                uniform_samples: flags.uniform_samples.is_some(),
            },
            sampler: sampler(&flags, triples),
            adaptive: adaptive(&flags)?,
            filter: filter(&flags),
            structure: flags.grid.as_deref().map_or(Ok(Structure::Any), structure)?,
            visualize_grid: flags.visualize_grid,
            comparison: ComparisonOptions::new(&flags)?,
            stats: flags.stats,
            repeat: flags.repeat,
            strict: flags.strict,
            pixel: flags.pixel.as_deref().map(|place| [0, 1].map(|axis| place[axis].into())),
            preview: flags.gui || flags.tessellation.is_some() || flags.gouraud,
            page: flags.gui.then_some(LivePage { port: flags.port, browser: !flags.no_browser, words }),
            threads: flags.threads,
            progress: ShowProgress::new(&flags),
            json: flags.json,
            input: flags.input,
        };
        options.check_together()?;
        Ok(options)
    }

    fn check_together(&self) -> Result<(), Diagnostic> {
        let [width, height] = self.picture_size();
        if width == 0 || height == 0 {
            return fail("-filter needs at least 3 x 3 pixels: use a larger -size");
        }
        if self.region.is_some_and(|region| !region.fits([width, height])) {
            return fail(format!("-region reaches beyond the picture of {width} x {height} pixels"));
        }
        if self.pixel.is_some_and(|[x, y]| x >= width || y >= height) {
            let [last_column, last_row] = [width - 1, height - 1];
            return fail(format!(
                "-pixel: outside the picture, whose columns are 0 to {last_column} and rows 0 to {last_row}"
            ));
        }
        if self.visualize_grid && !matches!(self.structure, Structure::Grid(_)) {
            return fail("-visualize_grid needs a grid, as in '-grid 20 20 20'");
        }
        let needs_scene = self.comparison.as_ref().is_some_and(ComparisonOptions::needs_scene);
        match self.compared_layer() {
            None if needs_scene => {
                return fail(
                    "-compare and -reference compare one picture, and several are written: give -output too, which is \
                     compared then, or write only one of them",
                );
            }
            Some(Layer::Cost(_)) if needs_scene => {
                return fail(
                    "-compare and -reference do not compare a cost map, which shows work in false colours beside a \
                     scale: give -output too, which is compared then, or leave out -cost_map",
                );
            }
            _ => {}
        }
        if self.written().filter(|file| is_stdio(file)).count() > 1 {
            return fail("only one of the pictures and -json can go to standard output");
        }
        Ok(())
    }
}

impl ComparisonOptions {
    fn new(flags: &Flags) -> Result<Option<Self>, Diagnostic> {
        if flags.compare.is_none() && flags.reference.is_none() {
            return Ok(None);
        }
        // clap does not check this value, since it is a folder for `-grade`.
        let reference = flags.reference.as_ref();
        let reference = reference.map(|path| value("reference", path.as_os_str(), picture())).transpose()?;
        let (picture, difference) = (flags.compare.clone(), flags.difference.clone());
        let tolerance = tolerance(flags)?;
        let comparison = Self { picture, reference, difference, tolerance };
        match tolerance {
            Some(Tolerance { levels, .. }) if levels > 255.0 && !comparison.has_only_numbers() => {
                fail(format!("-tolerance: {levels} is above 255 levels"))
            }
            _ => Ok(Some(comparison)),
        }
    }
}

impl ShowProgress {
    pub(super) fn new(flags: &Flags) -> Self {
        match (flags.progress, flags.quiet) {
            (_, true) => Self::Never,
            (true, false) => Self::Always,
            (false, false) => Self::OnTerminal,
        }
    }
}

/// Returns the edition of `-edition`, or the one that another flag implies.
fn edition(flags: &Flags) -> Result<Option<Edition>, Diagnostic> {
    let flags_of_editions = [
        ("jitter", flags.jitter, Edition::Y2012A5),
        ("filter", flags.filter, Edition::Y2012A5),
        ("regular_samples", flags.regular_samples.is_some(), Edition::Aalto),
        ("uv", flags.uv, Edition::Aalto),
    ];
    let mut named = flags.edition;
    for (flag, is_given, edition) in flags_of_editions {
        // The program of 2019 accepts all of them and does nothing.
        if is_given && named != Some(Edition::Y2019) {
            let named = *named.get_or_insert(edition);
            if named != edition {
                return fail(format!("-{flag} is a flag of the edition {edition}, not of {named}"));
            }
        }
    }
    Ok(named)
}

fn size(values: &[Sides]) -> Result<[usize; 2], Diagnostic> {
    match values.concat()[..] {
        [width, height] => Ok([width, height]),
        ref sides => fail(format!("-size takes 2 values, as in '-size 200 200'; {} given", sides.len())),
    }
}

pub(super) fn region(values: &[u16]) -> Result<Window, Diagnostic> {
    match *values {
        [x, y, width, height] if width > 0 && height > 0 => {
            let [x, y, width, height] = [x, y, width, height].map(usize::from);
            Ok(Window { x, y, width, height })
        }
        _ => fail("-region: width and height must be at least 1"),
    }
}

fn sampler(flags: &Flags, triples: bool) -> Sampler {
    let rng = flags.seed.map_or(Drand48::UNSEEDED, Drand48::seeded);
    let given = [
        (Pattern::Random, flags.random_samples),
        (Pattern::Uniform, flags.uniform_samples.or(flags.regular_samples)),
        (Pattern::Jittered, flags.jittered_samples),
        (Pattern::Sobol, flags.sobol_samples),
    ];
    match given.into_iter().find_map(|(pattern, count)| Some((pattern, count?))) {
        Some((pattern, count)) => Sampler::new(pattern, count, rng),
        None if flags.jitter && triples => Sampler::DISPLACED,
        None if flags.adaptive_samples.is_some() => Sampler::of_adaptive(rng),
        None => Sampler::new(Pattern::Uniform, 1, rng),
    }
}

pub(super) fn tolerance(flags: &Flags) -> Result<Option<Tolerance>, Diagnostic> {
    let Some([levels, pixels]) = flags.tolerance.as_deref() else { return Ok(None) };
    Ok(Some(Tolerance {
        levels: value("tolerance", levels, number(NOT_NEGATIVE))?,
        pixels: value("tolerance", pixels, value_parser!(u32))?.into(),
    }))
}

fn adaptive(flags: &Flags) -> Result<Option<Adaptive>, Diagnostic> {
    let Some([most, error]) = flags.adaptive_samples.as_deref() else { return Ok(None) };
    let counts = i64::from(Adaptive::BASE)..=i64::from(Adaptive::LIMIT);
    Ok(Some(Adaptive {
        most: value("adaptive_samples", most, value_parser!(u32).range(counts))?,
        error: value("adaptive_samples", error, number(NOT_NEGATIVE))?,
    }))
}

fn filter(flags: &Flags) -> Filter {
    let tent = flags.tent_filter.map(|radius| Filter::Tent { radius });
    let gaussian = flags.gaussian_filter.map(|sigma| Filter::Gaussian { sigma });
    let mitchell = flags.mitchell_filter.map(|radius| Filter::Mitchell { radius });
    tent.or(gaussian).or(mitchell).unwrap_or(Filter::Box { radius: flags.box_filter })
}

fn structure(values: &[OsString]) -> Result<Structure, Diagnostic> {
    let [x, y, z] = match values {
        [word] if word == "auto" => return Ok(Structure::Grid(Resolution::Auto)),
        [word] if word == "none" => return Ok(Structure::List),
        [x, y, z] => [x, y, z].map(|word| value("grid", word, value_parser!(u32).range(1..=MAX_INT))),
        _ => return fail("-grid takes 3 values, as in '-grid 20 20 20', or 'auto' or 'none'"),
    };
    let [x, y, z] = [x?, y?, z?];
    if [x, y, z].map(u128::from).iter().product::<u128>() >= CELL_LIMIT {
        return fail(format!("-grid: {x} x {y} x {z} cells are more than 2147483647"));
    }
    Ok(Structure::Grid(Resolution::Cells([x, y, z].map(|n| n as usize))))
}
