//! Plans the samples of a tile of a picture, by rays through the corners of its pixels, probes and tests.

use super::{Band, Planner};
use crate::picture::Color;
use crate::render::row::Looked;
use crate::render::tracing::PictureTracer;
use crate::sampling::adaptive::{BRIGHTEST, Contents, Line, beyond, finite};
use crate::sampling::allotment::{Find, Known, Tested, gain, own_and_random_error};
use crate::sampling::drand48::{Drand48, Jump};
use crate::sampling::multi_jittered::MultiJittered;
use glam::{DVec2, Vec3A};
use rand::RngExt;
use std::ops::Range;

/// A tile whose corners have been traced.
pub struct Tile<'t, 'a> {
    planner: &'t Planner<'a>,
    tracer: &'t PictureTracer<'t>,
    columns: Range<usize>,
    band: &'t mut Band,
    corners: Vec<Corners>,
}

/// Points in a row: columns, and offsets from their pixels' centres.
type Places = Vec<(usize, DVec2)>;

/// The seed of the probes and tests. It does not depend on the seed of the samples.
const PROBES: Drand48 = Drand48::seeded(0x50B0_0B5E);

/// The number of random numbers that are reserved for a pixel's probes in each round: more than are drawn.
const DRAWS: u64 = 251;

/// A plan is uncertain if more than `DOUBT` of the squared error is doubt. Then more probes are cast, up to
/// `OF_SAMPLES` of the number of samples.
const DOUBT: f64 = 0.2;
const OF_SAMPLES: f64 = 0.125;

/// The lower bound on the ratio of measured to expected errors. Smaller errors save no more samples.
const LEAST_GAIN: f64 = 1.0 / 16.0;

/// Plans are tested if the tests may save this part of the samples.
const WORTH_TESTING: f64 = 0.25;

/// Casts rays through the points of each line, and returns the colours. Lines are rows of the band, and the line after
/// the last one, whose points belong to the last row. Returns `None` if the watch cancels the render.
fn cast(
    tracer: &PictureTracer,
    band: &mut Band,
    lines: Range<usize>,
    places: impl Fn(usize) -> Places + Sync,
) -> Option<Vec<(Places, Vec<Color>)>> {
    let last = band.rows.end - 1;
    let look = |line: usize| {
        if tracer.tally.asks(0) {
            return None;
        }
        let places = places(line);
        Some((tracer.look(line.min(last), places.iter().copied())?, places))
    };
    let looked = tracer.tally.in_parallel(lines.clone(), look);
    let count = |(line, looked): (usize, Option<(Looked, Places)>)| {
        let (looked, places) = looked?;
        band.add_counts(line.min(last), &looked, places.iter().map(|place| place.0));
        Some((places, looked.colors))
    };
    lines.zip(looked).map(count).collect()
}

impl<'t, 'a> Tile<'t, 'a> {
    /// Casts the rays through the corners of the pixels in these columns of a band. Returns `None` if the watch
    /// cancels the render.
    pub fn new(
        planner: &'t Planner<'a>,
        tracer: &'t PictureTracer<'t>,
        columns: &Range<usize>,
        band: &'t mut Band,
    ) -> Option<Self> {
        let (rows, last) = (band.rows.clone(), columns.end - 1);
        let corners = cast(tracer, band, rows.start..rows.end + 1, |line| {
            // The last corners belong to the last pixels.
            let up = (line - line.min(rows.end - 1)) as f64;
            let corner = |k: usize| (k.min(last), DVec2::new((k - k.min(last)) as f64, up) - 0.5);
            (columns.start..=columns.end).map(corner).collect()
        })?;
        let most = Vec3A::splat(if planner.request.has_floats { f32::MAX } else { BRIGHTEST });
        let row = |(_, colors): (Places, Vec<Color>)| {
            Corners::new(colors.into_iter().map(|color| finite(color).min(most)).collect())
        };
        let corners = corners.into_iter().map(row).collect();
        Some(Self { planner, tracer, columns: columns.clone(), band, corners })
    }

    /// Returns the number of samples of each pixel, row by row, or `None` if the watch cancels the render.
    pub fn allot(mut self) -> Option<Vec<u16>> {
        let (settings, contents) = (self.planner.settings, self.contents()?);
        let has_floats = self.planner.request.has_floats;
        let brightest = self.corners.iter().flat_map(|row| &row.colors).fold(1.0, most_of);
        let contrast = self.planner.reflected.max(if has_floats { brightest } else { 1.0 });
        let (width, mut probes) = (self.columns.len(), settings.probes(contents.len(), contrast));
        let gains = [LEAST_GAIN; 2];
        let mut known = Known { width, contents, finds: vec![], probes: 0.0, contrast, has_floats, gains };
        for round in 0.. {
            let found = self.probe(round, probes - known.probes)?;
            known.probes = probes;
            for find in found {
                known.contrast = if has_floats { known.contrast.max(find.square.sqrt()) } else { contrast };
                known.finds.push(find);
            }
            // More probes are worthwhile if there are bright things, or if a few probes have found much.
            let (allotment, pixels) = (known.allot(settings), known.contents.len());
            let total = allotment.total();
            let is_open = allotment.doubt > DOUBT && total < pixels as u64 * u64::from(settings.most);
            let affordable = OF_SAMPLES * total as f64 / pixels as f64;
            let doubled = if is_open { (2.0 * probes).min(affordable) } else { 0.0 };
            probes = settings.probes(pixels, known.contrast).max(doubled);
            if probes <= 1.25 * known.probes {
                return self.tested(known, total);
            }
        }
        None
    }

    /// Returns the number of samples that each pixel needs, after tests of the errors that remain. `least` is the
    /// total number with the least errors.
    fn tested(&mut self, mut known: Known, least: u64) -> Option<Vec<u16>> {
        let settings = self.planner.settings;
        let optimistic = std::mem::replace(&mut known.gains, [1.0; 2]);
        let allotment = known.allot(settings);
        if least as f64 > (1.0 - WORTH_TESTING) * allotment.total() as f64 {
            return Some(allotment.samples);
        }
        known.gains = optimistic;
        // The ratio of measured to expected errors falls with the number of samples. So the ratio for fewer samples is
        // an upper bound.
        let samples = known.allot(settings).samples;
        let gains = self.test(&known.to_test(&samples), &samples, 0)?;
        if (0..2).all(|k| gains[k] <= LEAST_GAIN) {
            return Some(samples);
        }
        known.gains = gains.map(|gain| (gain.min(1.0) * LEAST_GAIN).max(LEAST_GAIN * LEAST_GAIN).sqrt());
        let samples = known.allot(settings).samples;
        let gains = self.test(&known.to_test(&samples), &samples, 1)?;
        known.gains = [0, 1].map(|k| known.gains[k].max(gains[k]));
        Some(known.allot(settings).samples)
    }

    /// Casts rays through the points of each row, and returns their pixels and colours.
    fn cast(&mut self, places: impl Fn(usize) -> Places + Sync) -> Option<Vec<(usize, Color)>> {
        let (start, width) = (self.columns.start, self.columns.len());
        let rows = cast(self.tracer, self.band, self.band.rows.clone(), places)?;
        let seen = rows.into_iter().enumerate().flat_map(|(row, (places, colors))| {
            places.into_iter().zip(colors).map(move |(place, color)| (row * width + place.0 - start, color))
        });
        Some(seen.collect())
    }

    /// Returns the squared distance of a colour from the range of the colours at its pixel's corners.
    fn find(&self, (pixel, color): (usize, Color)) -> Find {
        let [x, y] = [pixel % self.columns.len(), pixel / self.columns.len()];
        let [below, above] = [y, y + 1].map(|y| &self.corners[y].colors[x..]);
        let corners = [below[0], below[1], above[0], above[1]];
        Find { pixel, square: beyond(finite(color), corners, self.planner.request.has_floats) }
    }

    /// Estimates the contents of the pixels, by the corners and by rays to small things.
    fn contents(&mut self) -> Option<Vec<Contents>> {
        let (rows, width) = (self.band.rows.clone(), self.columns.len());
        let by_corners =
            self.tracer.tally.in_parallel(0..rows.len(), |row| Some(contents(&self.corners, row)));
        let mut contents = by_corners.into_iter().collect::<Option<Vec<_>>>()?.concat();
        let columns = self.columns.clone();
        let specks = self.planner.small_things.specks(&columns, &rows, self.tracer.tally).ok()?;
        let seen = self.cast(|j| {
            let row = &specks[(j - rows.start) * width..][..width];
            let alone = columns.clone().zip(row).filter(|(_, speck)| speck.is_alone());
            alone.map(|(column, speck)| (column, speck.offset.as_dvec2())).collect()
        })?;
        let has_floats = self.planner.request.has_floats;
        let most = if has_floats { f32::MAX } else { BRIGHTEST * BRIGHTEST };
        // The point in a small thing may have missed it, but rarely do the points in all pixels around it.
        let mut squares = vec![0.0f32; specks.len()];
        for Find { pixel, square } in seen.into_iter().map(|seen| self.find(seen)) {
            let [x, y] = [pixel % width, pixel / width];
            for y in y.saturating_sub(1)..(y + 2).min(rows.len()) {
                for near in &mut squares[y * width..][x.saturating_sub(1)..(x + 2).min(width)] {
                    *near = near.max(square.min(most));
                }
            }
        }
        for ((contents, speck), square) in contents.iter_mut().zip(&specks).zip(squares) {
            let part = speck.part.min(0.5);
            *contents = contents.with_known(part * (1.0 - part) * square);
        }
        Some(contents)
    }

    /// Casts this number of probes in each pixel on average, and returns their finds.
    fn probe(&mut self, round: u64, count: f64) -> Option<Vec<Find>> {
        let (columns, height) = (self.columns.clone(), self.planner.request.size[1]);
        let jump = Jump::of(height as u64 * DRAWS);
        let seen = self.cast(|j| {
            let mut next = PROBES.jumped((round << 40) + (columns.start * height + j) as u64 * DRAWS);
            let of_column = |column: usize| {
                let mut rng = next;
                next = next.after(jump);
                let count = (count + rng.random::<f64>()) as usize;
                (0..count).map(move |_| (column, DVec2::new(rng.random(), rng.random()) - 0.5))
            };
            columns.clone().flat_map(of_column).collect()
        })?;
        Some(seen.into_iter().map(|seen| self.find(seen)).filter(|find| find.square > 0.0).collect())
    }

    /// Takes the samples of some pixels twice, and returns the ratios of their measured to their expected errors.
    fn test(&mut self, tested: &[Vec<Tested>; 2], samples: &[u16], round: u64) -> Option<[f64; 2]> {
        let mut pixels: Vec<usize> = tested.iter().flatten().map(|tested| tested.pixel).collect();
        pixels.sort_unstable();
        pixels.dedup();
        let request = self.planner.request;
        let (width, start, most) = (self.columns.len(), self.columns.start, self.planner.settings.most);
        let (first, height) = (self.band.rows.start, request.size[1]);
        let strata = |pixel: usize| MultiJittered::strata(samples[pixel].into(), most);
        let seen = self.cast(|j| {
            let row = (j - first) * width;
            let in_row = pixels.partition_point(|&pixel| pixel < row);
            let end = pixels.partition_point(|&pixel| pixel < row + width);
            let of_pixel = |&pixel: &usize| {
                let column = start + pixel - row;
                let index = 2 * (column * height + j) as u64;
                [index, index + 1].into_iter().flat_map(move |index| {
                    let rng = PROBES.jumped(((2 + round) << 45) + index * MultiJittered::draws(most));
                    MultiJittered::new(strata(pixel), rng).map(move |offset| (column, offset))
                })
            };
            pixels[in_row..end].iter().flat_map(of_pixel).collect()
        })?;
        let shown = |color: Color| if request.has_floats { color } else { color.min(Color::ONE) };
        let colors: Vec<Color> = seen.into_iter().map(|(_, color)| shown(color)).collect();
        let mut rest = &colors[..];
        let mut errors = vec![];
        for &pixel in &pixels {
            let [columns, rows] = strata(pixel);
            let (own, others) = rest.split_at(2 * (columns * rows) as usize);
            let (one, other) = own.split_at(own.len() / 2);
            errors.push(own_and_random_error([one, other]));
            rest = others;
        }
        let of_pixel = |pixel| errors[pixels.binary_search(&pixel).unwrap_or(0)];
        Some(tested.each_ref().map(|tested| gain(tested, of_pixel)))
    }
}

fn most_of(most: f32, color: &Vec3A) -> f32 {
    most.max(color.max_element())
}

/// The colours at a row of corners of pixels.
struct Corners {
    colors: Vec<Vec3A>,
    /// The line around the side between each corner and the next one.
    sides: Vec<Line>,
}

impl Corners {
    fn new(colors: Vec<Vec3A>) -> Self {
        let at = |k: Option<usize>| colors.get(k?).copied();
        let side =
            |(k, pair): (usize, &[Vec3A])| Line::new(at(k.checked_sub(1)), pair[0], pair[1], at(Some(k + 2)));
        let sides = colors.windows(2).enumerate().map(side).collect();
        Self { colors, sides }
    }
}

/// Estimates the contents of the pixels of a row by the corners.
fn contents(corners: &[Corners], row: usize) -> Vec<Contents> {
    let [before, below, above, after] =
        [row.checked_sub(1), Some(row), Some(row + 1), Some(row + 2)].map(|k| corners.get(k?));
    let (Some(below), Some(above)) = (below, above) else { return vec![] };
    let along = [before.unwrap_or(below), below, above, after.unwrap_or(above)];
    let upright = |k: usize| {
        Line::new(
            before.map(|row| row.colors[k]),
            below.colors[k],
            above.colors[k],
            after.map(|row| row.colors[k]),
        )
    };
    let upright: Vec<Line> = (0..below.colors.len()).map(upright).collect();
    let of_pixel = |k: usize| {
        let across = [k.saturating_sub(1), k, k + 1, (k + 2).min(upright.len() - 1)];
        Contents::new(along.map(|row| row.sides[k]), across.map(|k| upright[k]))
    };
    (0..below.sides.len()).map(of_pixel).collect()
}
