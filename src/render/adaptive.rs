//! Adaptive samples: each pixel gets as many samples as the picture needs to reach the error that was asked for.
//!
//! The picture is cut into tiles, and each tile of P pixels is sampled by itself. So a part of a picture has the same
//! pixels as the whole. With t the square of the error that was asked for, where white is 1, and s(p) the part of a pixel
//! that small things cover, if they cover some of it and not most:
//!
//! ```text
//! floor = c sqrt(2 / (t P))                         details of contrast c that no sample hits leave less than t then
//! n(p) = floor, rounded up to a power of two from 2 to the most, for each pixel p
//! take the first n(p) points of each pixel's Sobol' sequence; its pilot samples are the first of them, at most 8
//! ring(p) = range of the pilot samples of p's neighbours within half a pixel of p       neighbours with small things
//!                                                                                       count if there are no others
//! u(p) = mean square distance of p's own pilot samples from ring(p)
//! D(p) = |ring(p)|^2 + 8 * mean u of the pixels without small things                    for such pixels
//!        |ring(p)|^2 + 8 s(p) * (sum of u / sum of s of the pixels with small things)   for the others
//! w(p) = D(p)^0.4                                   n ~ w has the least sum of D n^-1.5 for a sum of n
//! repeat, at most 10 times, until no k grows:
//!     for each group g of pixels, with P the pixels that decide for it:
//!         e(p) = 0.7 |mean of the first half of p's samples - mean of the second half|^2 / 4
//!         n'(p) = the larger one of n(p), and k(g) w(p) rounded to a power of two
//!         E(k) = mean e' + 2 sqrt(sum of e'^2) / P, e' = e (n'/n)^-1.5          the second term is doubt: few decide
//!         if E(k(g)) > 0.64 t in the first pass, or > 0.9 t later:
//!             k(g) = the least with E(k) <= 0.64 t, but 1.3 to 2.5 times as many samples in all
//!     n(p) = n'(p) for the pixels of each group, and take the points that they lack
//! ```
//!
//! All numbers of samples are powers of two, because the first points of a Sobol' sequence are most even then. The error
//! of a pixel with n of them is about c^2 n^-1.5 if an edge of contrast c crosses it (Owen, "Scrambled net variance").
//!
//! The picture is unbiased if a pixel's own samples do not decide their number: a pixel that happens to look dark would
//! stay dark, and one that happens to look bright would be corrected (Kirk and Arvo, "Unbiased sampling techniques for
//! image synthesis", SIGGRAPH 1991). So ring(p) is found from the neighbours, and the pixels that decide for a group, in
//! the means of u and in E, are neither its own nor their neighbours. Squares of 8 by 8 pixels belong to 16 groups in
//! turn, which repeat every 4 squares along each axis. The square of a colour is the mean square of its channels.
//!
//! To be fast, the pixels of a tile are sorted into kinds with about equal rings and small things, and into classes of w,
//! 8 for each doubling. `decisions.rs` has groups, classes and E; this file takes the samples.

mod decisions;

use super::Stopped;
use super::layer::Layer;
use super::request::Request;
use super::small_things::SmallThings;
use super::tracing::PictureTracer;
use crate::base::memory;
use crate::picture::Color;
use crate::sampling::filter::Filter;
use crate::scene::Light;
use crate::scene::material::Material;
use crate::stats::Counts;
use crate::world::World;
use decisions::{
    CLASSES, Deciding, DecidingPixels, GROUPS, LEAST_SCALE, SURROUNDINGS, Sums, class, group, grown,
    is_left_out, middle, surroundings,
};
use glam::{DVec2, Vec3, Vec3A};
use rayon::prelude::*;
use serde::Serialize;
use std::ops::Range;

/// The settings of adaptive sampling.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Adaptive {
    /// The largest number of samples per pixel, from [`BASE`](Self::BASE) to [`LIMIT`](Self::LIMIT). Powers of two are
    /// used.
    pub most: u32,
    /// The target error of the picture, in levels.
    pub error: f64,
}

impl Adaptive {
    /// The smallest permitted value of `most`.
    pub const BASE: u32 = 4;

    /// The largest permitted value of `most`.
    pub const LIMIT: u32 = 1024;

    /// Returns the approximate average number of samples per pixel if edges cross some pixels.
    pub fn usual(self) -> u32 {
        // With an edge of 160 levels through a twelfth of the pixels, whose errors are as above.
        (libm::pow(160.0 / self.error, 4.0 / 3.0) / 12.0).ceil().min(f64::from(self.most)) as u32
    }

    /// Returns the target squared error, where white is 1.
    fn square(self) -> f64 {
        (self.error / LEVELS) * (self.error / LEVELS)
    }
}

/// The number of levels from black to white.
const LEVELS: f64 = 255.0;

/// The largest side of a tile, in pixels.
const SIDE: usize = 256;

/// The least number of samples of a pixel.
const LEAST: u32 = 2;
/// The largest number of pilot samples.
const MOST_PILOTS: usize = 8;

/// Pilot samples and halves in pictures of bytes are clamped to this brightness. A half that is brighter than white may
/// well get darker, so its brightness counts up to a limit.
const BRIGHTEST: f64 = 2.0;
/// Pilot samples and halves in pictures of floats are clamped to this brightness.
const BRIGHTEST_FLOAT: f64 = 1e6;

/// The largest contrast that is assumed for details that no sample hits.
const MOST_CONTRAST: f64 = 8.0;

/// The weight of u in D.
const UNSEEN: f32 = 8.0;
/// The factor of the difference of halves in e.
const HALVES: f64 = 0.7;
/// The part of t that is aimed at.
const AIM: f64 = 0.64;
/// The part of t that is enough after the first pass.
const ENOUGH: f64 = 0.9;

/// The largest number of passes after the first samples.
const PASSES: usize = 10;
/// The largest memory of the samples that a band keeps, in bytes. The rows of the band have equal parts of it. If a row
/// has more samples, they are traced again.
const KEPT: usize = 128 << 20;

/// The approximate memory of a pixel in a band, in bytes.
const BYTES: usize = size_of::<u8>() + size_of::<Color>() + size_of::<u64>();
/// The approximate memory of a pixel while its tile is sampled, in bytes.
const BYTES_OF_TILE: usize = 2 * size_of::<Pixel>() + 8 * size_of::<Pilot>() + 64;

/// The adaptive samples of a row of pixels.
#[derive(Clone, Copy)]
pub struct AdaptiveRow<'a> {
    band: &'a Band,
    /// The index of the row in the band.
    row: usize,
}

/// The samples of a row of tiles.
struct Band {
    columns: Range<usize>,
    rows: Range<usize>,
    /// The numbers of samples, as logarithms to base 2.
    doublings: Vec<u8>,
    /// The colours of the pixels, if only their own samples contribute to them, with equal weights.
    colors: Vec<Color>,
    /// Otherwise the colours of the samples of each row, from left to right, unless there are too many.
    samples: Vec<Option<Vec<Color>>>,
    /// The cost of each pixel, if costs are a layer.
    costs: Vec<u64>,
    /// The counts and the sum of the estimated squared errors of each row.
    counts: Vec<Counts>,
    errors: Vec<f64>,
}

/// Samples tiles of a picture.
pub struct AdaptiveSampler<'a> {
    picture: &'a PictureTracer<'a>,
    request: &'a Request,
    /// The target squared error, where white is 1.
    target: f64,
    /// The largest number of samples, a power of two.
    most: u32,
    small_things: SmallThings<'a>,
    /// The largest contrast of details that no sample hits.
    contrast: f64,
    /// The brightness to which pilot samples and halves are clamped.
    brightest: f64,
    /// The rows of tiles that are sampled.
    bands: Vec<Band>,
}

/// Returns the rows or columns of tiles of this number of pixels that overlap the range.
fn tiles(pixels: &Range<usize>, count: usize) -> impl Iterator<Item = Range<usize>> + use<> {
    let (pixels, parts) = (pixels.clone(), count.div_ceil(SIDE));
    let tiles = (0..parts).map(move |k| k * count / parts..(k + 1) * count / parts);
    tiles.filter(move |tile| tile.start < pixels.end && pixels.start < tile.end)
}

impl Band {
    /// Returns the index of a pixel in the lists, given by its column and the index of its row.
    fn index(&self, column: usize, row: usize) -> usize {
        row * self.columns.len() + column - self.columns.start
    }

    /// Returns the largest number of samples of a row that are kept.
    fn most_kept(&self) -> usize {
        KEPT / size_of::<Color>() / self.rows.len().max(1)
    }
}

impl<'a> AdaptiveRow<'a> {
    /// Returns the number of samples of a pixel.
    pub fn samples(self, column: usize) -> u32 {
        1 << self.band.doublings[self.band.index(column, self.row)]
    }

    /// Returns the colour of a pixel, or `None` if others contribute to it, too.
    pub fn color(self, column: usize) -> Option<Color> {
        self.band.colors.get(self.band.index(column, self.row)).copied()
    }

    /// Returns the colours of the samples of the pixels in these columns, or `None` if they must be traced again.
    pub fn kept_samples(self, columns: Range<usize>) -> Option<&'a [Color]> {
        let all = self.band.samples[self.row].as_deref()?;
        let count = |columns: Range<usize>| columns.map(|column| self.samples(column) as usize).sum();
        let before: usize = count(self.band.columns.start..columns.start);
        all.get(before..before + count(columns))
    }

    /// Returns the cost of sampling a pixel, if costs are a layer.
    pub fn cost(self, column: usize) -> Option<u64> {
        self.band.costs.get(self.band.index(column, self.row)).copied()
    }

    /// Returns the counts of sampling the row.
    pub fn counts(self) -> Counts {
        self.band.counts[self.row]
    }

    /// Returns the sum of the estimated squared errors of the row's pixels in the window, where white is 1.
    pub fn squared_error(self) -> f64 {
        self.band.errors[self.row]
    }
}

impl<'a> AdaptiveSampler<'a> {
    /// Returns a sampler, or `None` if samples are not adaptive or no colours are traced.
    pub fn new(picture: &'a PictureTracer<'a>) -> Option<Self> {
        let (request, world) = (picture.request, picture.caster.world);
        let settings = request.adaptive.filter(|_| request.traces_colors(request.tracing))?;
        let reflects =
            request.effects.bounces > 0 && world.materials.iter().any(Material::has_secondary_rays);
        Some(Self {
            picture,
            request,
            target: settings.square(),
            most: 1 << settings.most.ilog2(),
            small_things: SmallThings::new(&picture.shot.camera, world),
            contrast: if reflects { brightest(world).min(MOST_CONTRAST) } else { 1.0 },
            brightest: if request.has_floats { BRIGHTEST_FLOAT } else { BRIGHTEST },
            bands: vec![],
        })
    }

    /// Samples these rows and forgets the others. Fails if the render is cancelled, or if there is too little memory.
    pub fn sample(&mut self, rows: &Range<usize>) -> Result<(), Stopped> {
        let [_, height] = self.request.size;
        self.bands.retain(|band| band.rows.start < rows.end && rows.start < band.rows.end);
        for rows in tiles(rows, height) {
            if self.bands.iter().all(|band| band.rows != rows) {
                let pixels = (self.request.traced_columns().len() + 2 * SIDE) * rows.len();
                // The samples of a tile in progress are kept as well.
                let samples = (pixels * self.most as usize).saturating_mul(size_of::<Color>());
                let kept = if self.keeps_colors() { 0 } else { samples.min(2 * KEPT) };
                memory::ask((pixels * BYTES + SIDE * SIDE * BYTES_OF_TILE + kept) as u64)?;
                self.bands.push(self.band(rows)?);
            }
        }
        Ok(())
    }

    /// Returns true if only the samples of a pixel contribute to its colour, and are shown by nothing else.
    fn keeps_colors(&self) -> bool {
        let plots_samples = self.request.layers.iter().any(|layer| matches!(layer, Layer::Samples { .. }));
        self.request.filter == Filter::PIXEL && !plots_samples
    }

    /// Returns row `j`, if it is sampled.
    pub fn row(&self, j: usize) -> Option<AdaptiveRow<'_>> {
        let band = self.bands.iter().find(|band| band.rows.contains(&j))?;
        Some(AdaptiveRow { band, row: j - band.rows.start })
    }

    /// Samples a row of tiles.
    fn band(&self, rows: Range<usize>) -> Result<Band, Stopped> {
        let request = self.request;
        let tracer = self.picture.for_rows(rows.clone())?;
        let tiles: Vec<_> = tiles(&request.traced_columns(), request.size[0]).collect();
        let columns = tiles.first().map_or(0, |tile| tile.start)..tiles.last().map_or(0, |tile| tile.end);
        let pixels = columns.len() * rows.len();
        let keeps_colors = self.keeps_colors();
        let mut band = Band {
            columns,
            rows: rows.clone(),
            doublings: vec![0; pixels],
            colors: if keeps_colors { vec![Color::ZERO; pixels] } else { vec![] },
            samples: vec![if keeps_colors { None } else { Some(vec![]) }; rows.len()],
            costs: if request.cost().is_some() { vec![0; pixels] } else { vec![] },
            counts: vec![Counts::default(); rows.len()],
            errors: vec![0.0; rows.len()],
        };
        for columns in tiles {
            Tile::sample(self, &tracer, columns, &mut band).ok_or_else(|| tracer.tally.reason())?;
        }
        Ok(band)
    }
}

/// A pixel of a tile.
#[derive(Clone, Copy, Default)]
struct Pixel {
    /// The sums of the first half of its samples, and of all.
    half: Color,
    sum: Color,
    /// The number of samples: 0 at first, and then a power of two.
    samples: u32,
    /// The index of its kind.
    kind: u16,
    /// The index of its surroundings, which decides the groups that leave it out.
    surroundings: u8,
}

/// Pixels with about equal rings and covered parts. Both are rounded to classes, so that a tile has few kinds.
#[derive(Clone, Copy)]
struct Kind {
    /// The square of the range of the neighbours' pilot samples.
    ring: f32,
    /// The part that small things cover, if there are any.
    covered: Option<f32>,
}

impl Pixel {
    /// Adds samples of these colours. Their number is 0 or doubles the number of samples some times.
    fn add(&mut self, colors: &[Color]) {
        let count = self.samples + colors.len() as u32;
        let half = count / 2;
        if self.samples == half {
            self.half = self.sum;
        }
        for (index, color) in (self.samples..).zip(colors) {
            self.sum += *color;
            if index + 1 == half {
                self.half = self.sum;
            }
        }
        self.samples = count;
    }
}

/// A pilot sample.
#[derive(Clone, Copy)]
struct Pilot {
    color: Vec3,
    /// True if it is in the right half of its pixel, and in the upper half.
    is_right: bool,
    is_upper: bool,
}

/// The range of some colours.
#[derive(Clone, Copy)]
struct Ring {
    low: Vec3A,
    high: Vec3A,
}

impl Ring {
    /// The range of no colours.
    const EMPTY: Self = Self { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    fn is_empty(self) -> bool {
        self.low.x > self.high.x
    }

    fn add(&mut self, color: Vec3A) {
        (self.low, self.high) = (self.low.min(color), self.high.max(color));
    }

    /// Returns the mean square distance of a pixel's own pilot samples from this ring. A tile of one pixel has an empty
    /// one.
    fn unseen(self, own: &[Pilot]) -> f32 {
        if self.is_empty() {
            return 0.0;
        }
        let beyond = |pilot: &Pilot| {
            let color = Vec3A::from(pilot.color);
            mean_square((color - self.high).max(self.low - color).max(Vec3A::ZERO))
        };
        own.iter().map(beyond).sum::<f32>() / own.len() as f32
    }

    /// Returns the square of the range.
    fn square(self) -> f32 {
        if self.is_empty() { 0.0 } else { mean_square(self.high - self.low) }
    }
}

/// The new samples of a row of a tile.
struct TracedRow {
    pixels: Vec<Pixel>,
    pilots: Vec<Pilot>,
    /// The colours of the samples so far, if they are kept.
    kept: Option<Vec<Color>>,
    /// The cost of each pixel, or zeros if costs are no layer.
    costs: Vec<u64>,
    counts: Counts,
}

/// A tile in progress.
struct Tile<'t, 'a> {
    sampler: &'t AdaptiveSampler<'a>,
    tracer: &'t PictureTracer<'t>,
    columns: Range<usize>,
    rows: Range<usize>,
    /// The pixels, row by row.
    pixels: Vec<Pixel>,
    /// The pilot samples of each pixel.
    pilots: Vec<Pilot>,
    /// The colours of the samples of each row, if they are kept, and their largest number.
    kept: Vec<Option<Vec<Color>>>,
    most_kept: usize,
    kinds: Vec<Kind>,
    /// The first number of samples.
    floor: u32,
    groups: [Group; GROUPS],
}

/// The decisions for a group of pixels.
#[derive(Clone, Copy)]
struct Group {
    /// The mean u of pixels without small things, and the sum of u over the sum of covered parts of pixels with them.
    unseen: [f32; 2],
    /// The logarithm of k to base 2, in steps of the classes.
    scale: i32,
}

/// The pixels of a kind with the same number of samples.
struct Alike {
    kind: u16,
    /// The number of samples, as its logarithm to base 2.
    doublings: u8,
    by_surroundings: [Sums; SURROUNDINGS],
}

impl<'t, 'a> Tile<'t, 'a> {
    /// Samples the tile in these columns of a band. Returns `None` if the render is cancelled.
    fn sample(
        sampler: &'t AdaptiveSampler<'a>,
        tracer: &'t PictureTracer<'t>,
        columns: Range<usize>,
        band: &mut Band,
    ) -> Option<()> {
        let rows = band.rows.clone();
        let (count, target) = (columns.len() * rows.len(), sampler.target);
        let floor = (sampler.contrast * (2.0 / (target * count as f64)).sqrt()).ceil();
        let floor = (floor.clamp(1.0, f64::from(sampler.most)) as u32).next_power_of_two();
        let mut tile = Self {
            sampler,
            tracer,
            columns,
            rows,
            pixels: vec![Pixel::default(); count],
            pilots: vec![],
            kept: band.samples.iter().map(|row| row.is_some().then(Vec::new)).collect(),
            most_kept: band.most_kept(),
            kinds: vec![],
            floor: floor.clamp(LEAST, sampler.most),
            groups: [Group { unseen: [0.0; 2], scale: LEAST_SCALE }; GROUPS],
        };
        tile.trace(band)?;
        tile.look_around()?;
        for pass in 0..PASSES {
            let (aim, enough) = (AIM * target, if pass == 0 { AIM } else { ENOUGH } * target);
            let alike = tile.alike();
            let next_scale = |group: usize| {
                let (deciding, scale) = (tile.deciding_pixels(group, &alike), tile.groups[group].scale);
                let [estimate, _] = deciding.expected(scale);
                if estimate > enough { deciding.next_scale(scale, aim) } else { scale }
            };
            let scales: Vec<i32> = (0..GROUPS).into_par_iter().map(next_scale).collect();
            if tile.groups.iter().map(|group| group.scale).eq(scales.iter().copied()) {
                break;
            }
            tile.groups.iter_mut().zip(scales).for_each(|(group, scale)| group.scale = scale);
            tile.trace(band)?;
        }
        tile.finish(band);
        Some(())
    }

    /// Returns the column and the row of a pixel in the tile.
    fn place(&self, pixel: usize) -> [usize; 2] {
        [pixel % self.columns.len(), pixel / self.columns.len()]
    }

    /// Returns the class that pixels of a kind have or would have in a group.
    fn class(&self, group: usize, kind: u16) -> usize {
        let [plain, with_small_things] = self.groups[group].unseen;
        let Kind { ring, covered } = self.kinds[usize::from(kind)];
        class(ring + UNSEEN * covered.map_or(plain, |part| part * with_small_things))
    }

    /// Traces the samples that pixels lack. The first samples are also pilot samples.
    fn trace(&mut self, band: &mut Band) -> Option<()> {
        let is_first = self.pilots.is_empty();
        let rows = self.tracer.tally.in_parallel(self.rows.clone(), |j| self.trace_row(j, is_first));
        let mut all_pixels = Vec::with_capacity(self.pixels.len());
        for (row, traced) in rows.into_iter().enumerate() {
            let TracedRow { pixels, pilots, kept, costs, counts } = traced?;
            all_pixels.extend(pixels);
            self.pilots.extend(pilots);
            self.kept[row] = kept;
            band.counts[row] = band.counts[row].merge(counts);
            let first = band.index(self.columns.start, row);
            let of_band = band.costs.get_mut(first..).unwrap_or_default();
            of_band.iter_mut().zip(costs).for_each(|(sum, cost)| *sum += cost);
        }
        self.pixels = all_pixels;
        Some(())
    }

    /// Traces the samples that the pixels of row `j` lack.
    fn trace_row(&self, j: usize, is_first: bool) -> Option<TracedRow> {
        if self.tracer.tally.asks(0) {
            return None;
        }
        let Request { sampler, size: [_, height], .. } = self.sampler.request;
        let first = (j - self.rows.start) * self.columns.len();
        let mut pixels = self.pixels[first..][..self.columns.len()].to_vec();
        let counts: Vec<u32> = (first..).zip(&pixels).map(|(k, pixel)| self.wanted(k, pixel)).collect();
        let mut samples = vec![];
        for ((column, pixel), &count) in self.columns.clone().zip(&pixels).zip(&counts) {
            if count > pixel.samples {
                let sequence = sampler.sequence((column * height + j) as u64);
                samples.extend((pixel.samples..count).map(|index| (column, sequence.offset(index))));
            }
        }
        let traced = self.tracer.trace_rays(j, samples.iter().copied())?;
        let old = self.kept[j - self.rows.start].as_deref();
        let old = old.filter(|old| old.len() + samples.len() <= self.most_kept);
        let mut kept = old.map(|old| Vec::with_capacity(old.len() + samples.len()));
        let (mut old, mut new, mut ray_costs) =
            (old.unwrap_or_default(), &traced.colors[..], traced.costs.iter());
        let mut costs = Vec::with_capacity(pixels.len());
        for (pixel, count) in pixels.iter_mut().zip(counts) {
            let [had, lacks] = [pixel.samples, count - pixel.samples].map(|count| count as usize);
            let (added, others) = new.split_at(lacks);
            new = others;
            if let Some(kept) = &mut kept {
                let (own, others) = old.split_at(had);
                old = others;
                kept.extend(own.iter().chain(added));
            }
            pixel.add(added);
            costs.push(ray_costs.by_ref().take(lacks).sum());
        }
        let pilots = if is_first { self.pilots_of_row(&samples, &traced.colors) } else { vec![] };
        Some(TracedRow { pixels, pilots, kept, costs, counts: traced.counts })
    }

    /// Returns the number of samples that a pixel should have.
    fn wanted(&self, k: usize, pixel: &Pixel) -> u32 {
        if pixel.samples == 0 {
            return self.floor;
        }
        let (group, most) = (group(self.place(k)), self.sampler.most.ilog2() as u8);
        let class = self.class(group, pixel.kind);
        1 << grown(pixel.samples.ilog2() as u8, self.groups[group].scale, class, most)
    }

    /// Returns the pilot samples among the first samples of a row, of which each pixel has an equal number.
    fn pilots_of_row(&self, samples: &[(usize, DVec2)], colors: &[Color]) -> Vec<Pilot> {
        let brightest = Color::splat(self.sampler.brightest);
        let (first, pilots) = (self.floor as usize, MOST_PILOTS.min(self.floor as usize));
        let mut found = Vec::with_capacity(samples.len() / first * pilots);
        for (samples, colors) in samples.chunks(first).zip(colors.chunks(first)) {
            found.extend(samples[..pilots].iter().zip(colors).map(|((_, offset), color)| Pilot {
                color: color.clamp(Color::ZERO, brightest).as_vec3(),
                is_right: offset.x >= 0.0,
                is_upper: offset.y >= 0.0,
            }));
        }
        found
    }

    /// Sorts the pixels into kinds by their rings and their small things, and finds u and its means.
    fn look_around(&mut self) -> Option<()> {
        let pilots = self.pilots.len() / self.pixels.len();
        let small_things = &self.sampler.small_things;
        let covered = small_things.covered_parts(&self.columns, &self.rows, self.tracer.tally).ok()?;
        let rings = self.rings(&covered);
        let mut kind_of_classes = vec![None; CLASSES * (CLASSES + 1)];
        let mut sums = [[UnseenSums::default(); 2]; SURROUNDINGS];
        for (k, own) in self.pilots.chunks(pilots).enumerate() {
            // Parts are sorted in steps four times as large.
            let part_class = covered[k].map(|part| class(part) / 4 * 4 + 2);
            let ring_class = class(rings[k].square());
            let kind = &mut kind_of_classes[ring_class * (CLASSES + 1) + part_class.unwrap_or(CLASSES)];
            let kind = *kind.get_or_insert_with(|| {
                self.kinds.push(Kind { ring: middle(ring_class), covered: part_class.map(middle) });
                self.kinds.len() as u16 - 1
            });
            let surroundings = surroundings(self.place(k));
            (self.pixels[k].kind, self.pixels[k].surroundings) = (kind, surroundings);
            let sums = &mut sums[usize::from(surroundings)][usize::from(covered[k].is_some())];
            sums.unseen += f64::from(rings[k].unseen(own));
            sums.weight += covered[k].map_or(1.0, f64::from);
        }
        for (group, decisions) in self.groups.iter_mut().enumerate() {
            for (has_small_things, mean) in decisions.unseen.iter_mut().enumerate() {
                let mut all = UnseenSums::default();
                for index in (0..SURROUNDINGS).filter(|&index| !is_left_out(index, group)) {
                    all.unseen += sums[index][has_small_things].unseen;
                    all.weight += sums[index][has_small_things].weight;
                }
                *mean = if all.weight > 0.0 { (all.unseen / all.weight) as f32 } else { 0.0 };
            }
        }
        Some(())
    }

    /// Returns the rings of the pixels. `covered` has the part of each pixel that small things cover, if there are any.
    fn rings(&self, covered: &[Option<f32>]) -> Vec<Ring> {
        let (width, height) = (self.columns.len(), self.rows.len());
        let pilots = self.pilots.len() / self.pixels.len();
        // The rings of neighbours without small things and with them.
        let mut rings = [(); 2].map(|()| vec![Ring::EMPTY; self.pixels.len()]);
        let beside = |k: usize, is_after: bool| if is_after { Some(k + 1) } else { k.checked_sub(1) };
        for (k, own) in self.pilots.chunks(pilots).enumerate() {
            let [x, y] = self.place(k);
            let rings = &mut rings[usize::from(covered[k].is_some())];
            for pilot in own {
                // Each pilot sample is within half a pixel of three neighbours.
                let column = beside(x, pilot.is_right).filter(|&x| x < width);
                let row = beside(y, pilot.is_upper).filter(|&y| y < height);
                for (x, y) in [(column, Some(y)), (Some(x), row), (column, row)] {
                    if let (Some(x), Some(y)) = (x, y) {
                        rings[y * width + x].add(pilot.color.into());
                    }
                }
            }
        }
        let [plain, with_small_things] = rings;
        let either = |(plain, other): (Ring, Ring)| if plain.is_empty() { other } else { plain };
        plain.into_iter().zip(with_small_things).map(either).collect()
    }

    /// Returns the pixels by kinds and numbers of samples.
    fn alike(&self) -> Vec<Alike> {
        let numbers = self.sampler.most.ilog2() as usize + 1;
        let mut alike: Vec<Alike> = vec![];
        let mut indices = vec![None; self.kinds.len() * numbers];
        for pixel in &self.pixels {
            let (kind, doublings) = (pixel.kind, pixel.samples.ilog2() as u8);
            let index = &mut indices[usize::from(kind) * numbers + usize::from(doublings)];
            let index = *index.get_or_insert_with(|| {
                alike.push(Alike { kind, doublings, by_surroundings: [Sums::default(); SURROUNDINGS] });
                alike.len() - 1
            });
            let error = self.error(pixel, self.sampler.brightest);
            let sums = &mut alike[index].by_surroundings[usize::from(pixel.surroundings)];
            sums.pixels += 1.0;
            sums.error += error;
            sums.squares += error * error;
        }
        alike
    }

    /// Returns the pixels that decide for a group.
    fn deciding_pixels(&self, group: usize, alike: &[Alike]) -> DecidingPixels {
        let part = |Alike { kind, doublings, by_surroundings }: &Alike| {
            let mut all = Sums::default();
            for (_, sums) in by_surroundings.iter().enumerate().filter(|&(k, _)| !is_left_out(k, group)) {
                all.pixels += sums.pixels;
                all.error += sums.error;
                all.squares += sums.squares;
            }
            Deciding { doublings: *doublings, class: self.class(group, *kind), sums: all }
        };
        DecidingPixels { most: self.sampler.most.ilog2() as u8, parts: alike.iter().map(part).collect() }
    }

    /// Returns the estimated squared error of a pixel whose halves are clamped to this brightness. In pictures of bytes,
    /// halves that are both white are equal.
    fn error(&self, pixel: &Pixel, brightest: f64) -> f64 {
        let Pixel { half, sum, samples, .. } = *pixel;
        let part = 2.0 / f64::from(samples);
        let most = Color::splat(brightest);
        let [one, other] = [half, sum - half].map(|sum| (part * sum).clamp(Color::ZERO, most));
        let mut difference = one - other;
        if !self.sampler.request.has_floats {
            difference = Color::select(one.min(other).cmpge(Color::ONE), Color::ZERO, difference);
        }
        if difference.is_finite() { HALVES / 4.0 * difference.length_squared() / 3.0 } else { 0.0 }
    }

    /// Moves the results to the band.
    fn finish(&mut self, band: &mut Band) {
        for (all, own) in band.samples.iter_mut().zip(&mut self.kept) {
            *all = match (all.take(), own.take()) {
                (Some(mut all), Some(own)) if all.len() + own.len() <= self.most_kept => {
                    all.extend(own);
                    Some(all)
                }
                _ => None,
            };
        }
        let request = self.sampler.request;
        let brightest = if request.has_floats { BRIGHTEST_FLOAT } else { 1.0 };
        let shown = request.columns();
        for (k, pixel) in self.pixels.iter().enumerate() {
            let [x, row] = self.place(k);
            let column = self.columns.start + x;
            let index = band.index(column, row);
            band.doublings[index] = pixel.samples.ilog2() as u8;
            if let Some(color) = band.colors.get_mut(index) {
                *color = pixel.sum / f64::from(pixel.samples);
            }
            if shown.contains(&column) {
                band.errors[row] += self.error(pixel, brightest);
            }
        }
    }
}

/// Sums of pixels with or without small things.
#[derive(Clone, Copy, Default)]
struct UnseenSums {
    /// The sum of u.
    unseen: f64,
    /// The sum of covered parts, or the number of pixels without small things.
    weight: f64,
}

/// Returns the brightest colour of diffuse surfaces and the background, without highlights, but at least white.
fn brightest(world: &World) -> f64 {
    let color = |light: &Light| match *light {
        Light::Directional { color, .. } | Light::Point { color, .. } => color,
    };
    let light = world.ambient + world.lights.iter().map(color).sum::<Color>();
    let diffuse = world.materials.iter().filter_map(|material| match material {
        Material::Phong(phong) | Material::Painted(phong, _) => Some((phong.diffuse * light).max_element()),
        Material::Texture(_) => None,
    });
    diffuse.fold(world.background.max_element().max(1.0), f64::max)
}

fn mean_square(v: Vec3A) -> f32 {
    v.length_squared() / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;
    use crate::caster::choose::Structure;
    use crate::caster::{Caster, LazyCaster};
    use crate::render::tally::Tally;
    use crate::render::{Shot, View};
    use crate::scene::parser::parse;
    use std::ops::ControlFlow;

    #[test]
    fn kept_samples_have_the_colours_that_tracing_them_again_gives() {
        let text = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 3 }
             Lights { numLights 1 DirectionalLight { direction 0 -1 -1 color 1 1 1 } }
             Group { numObjects 2 Material { diffuseColor 1 1 1 } Sphere { center 0 0 0 radius 1 }
             Triangle { vertex0 -2 0 0 vertex1 2 0.1 0 vertex2 0 2 -1 } }";
        let scene = parse(text).unwrap();
        let world = World::new(&scene, &[]).unwrap();
        let (size, adaptive) = ([40, 30], Some(Adaptive { most: 256, error: 3.0 }));
        let filter = Filter::Gaussian { sigma: 0.6 };
        let request = Request { adaptive, filter, ..Request::new(size) };
        let caster = LazyCaster::new(Caster::of_planes(&world), Structure::Any.layout(&world, 0));
        let shot = Shot { camera: Camera::new(&scene.camera, size), caster: &caster, view: View::Scene };
        let tally = Tally::new(size[1], &|_| ControlFlow::Continue(()));
        let tracer = PictureTracer::new(&shot, &request, &tally);
        let mut sampler = AdaptiveSampler::new(&tracer).unwrap();
        sampler.sample(&(0..size[1])).unwrap();
        let tracer = tracer.for_rows(0..size[1]).unwrap();
        let mut numbers = 0u32;
        for j in 0..size[1] {
            let row = sampler.row(j).unwrap();
            for column in 0..size[0] {
                let sequence = request.sampler.sequence((column * size[1] + j) as u64);
                let places = (0..row.samples(column)).map(|index| (column, sequence.offset(index)));
                let again = tracer.trace_rays(j, places).unwrap();
                assert_eq!(row.kept_samples(column..column + 1), Some(&again.colors[..]), "{column} {j}");
                numbers |= row.samples(column);
            }
        }
        assert!(numbers.count_ones() > 2, "{numbers:b}");
    }
}
