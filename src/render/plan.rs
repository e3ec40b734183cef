//! Plans adaptive samples: how many each pixel gets, by rays through the corners of pixels and by probes.
//!
//! The picture is cut into tiles, of which each is planned by itself, so that a part of a picture needs the plans of the
//! tiles that it touches and no more.

use super::row::{Looked, RenderSetting};
use super::small_things::SmallThings;
use super::tally::{Tally, in_parallel};
use super::tracing::{PictureTracer, RowsTracer};
use crate::camera::Camera;
use crate::memory::{self, NoMemory};
use crate::sampling::adaptive::{
    Adaptive, BRIGHTEST, Contents, Find, Known, Line, MOST_PROBES, Planned, beyond, finite,
};
use crate::sampling::drand48::{Drand48, Jump};
use crate::sampling::multi_jittered::MultiJittered;
use crate::stats::Counts;
use glam::{DVec2, Vec3A};
use rand::RngExt;
use std::ops::Range;

/// How many samples the pixels of a row get.
#[derive(Clone, Copy)]
pub struct Plan<'a> {
    /// The largest number of samples of a pixel.
    pub most: u32,
    /// The column of the first pixel.
    start: usize,
    samples: &'a [u16],
    /// What planning a pixel has cost, if costs are a layer.
    costs: &'a [Counts],
    /// What planning the row has cost.
    pub counts: Counts,
}

/// How many samples the pixels of a row of tiles get.
pub struct Band {
    most: u32,
    columns: Range<usize>,
    rows: Range<usize>,
    samples: Vec<u16>,
    costs: Vec<Counts>,
    /// For each row.
    counts: Vec<Counts>,
}

/// Plans tiles of a picture.
pub struct Planner<'a> {
    setting: RenderSetting<'a>,
    settings: Adaptive,
    small_things: SmallThings<'a>,
}

/// Places in a row: columns, and offsets from their pixels' centres.
type Places = Vec<(usize, DVec2)>;

/// The side of a tile at most, in pixels. The larger tiles are, the fewer probes each pixel needs.
const SIDE: usize = 256;

/// The memory of a pixel in a band, and while its tile is planned, in bytes, about.
const BYTES: usize = size_of::<u16>();
const BYTES_OF_TILE: usize = 120;

/// The seed of the probes, which are the same for all seeds of the samples.
const PROBES: Drand48 = Drand48::seeded(0x50B0_0B5E);

/// The random numbers of a pixel's probes in each round, more than are drawn.
const DRAWS: u64 = 251;

/// Plans are uncertain where more than this part of the squared error is doubt. More probes are cast while they are fewer
/// than this part of the samples.
const DOUBT: f64 = 0.2;
const OF_SAMPLES: f64 = 0.125;

/// The rows or columns of tiles of so many pixels that have some of these.
fn tiles(pixels: &Range<usize>, count: usize) -> impl Iterator<Item = Range<usize>> + use<> {
    let (pixels, parts) = (pixels.clone(), count.div_ceil(SIDE));
    let tiles = (0..parts).map(move |k| k * count / parts..(k + 1) * count / parts);
    tiles.filter(move |tile| tile.start < pixels.end && pixels.start < tile.end)
}

/// The results for all rows; none if the watch cancels the render.
fn of_rows<T: Send>(
    rows: &Range<usize>,
    tally: &Tally,
    work: impl Fn(usize) -> Option<T> + Sync,
) -> Option<Vec<T>> {
    in_parallel(rows.clone(), tally, work).into_iter().map(Option::flatten).collect()
}

impl Band {
    /// The plan of row `j`, if it is in the band.
    pub fn plan(&self, j: usize) -> Option<Plan<'_>> {
        let row = j.checked_sub(self.rows.start).filter(|&row| row < self.rows.len())?;
        let width = self.columns.len();
        let costs = if self.costs.is_empty() { &[] } else { &self.costs[row * width..][..width] };
        let samples = &self.samples[row * width..][..width];
        Some(Plan { most: self.most, start: self.columns.start, samples, costs, counts: self.counts[row] })
    }

    /// Adds what rays of row `j` in these columns have cost.
    fn add_counts(&mut self, j: usize, looked: &Looked, columns: impl Iterator<Item = usize>) {
        let (row, width) = (j - self.rows.start, self.columns.len());
        self.counts[row] = self.counts[row].merge(looked.counts);
        for (column, counts) in columns.zip(&looked.costs) {
            let cost = &mut self.costs[row * width + column - self.columns.start];
            *cost = cost.merge(*counts);
        }
    }
}

impl Plan<'_> {
    /// The part of its pixel that a sample in this column stands for.
    pub fn part(&self, column: usize) -> f64 {
        let [columns, rows] = self.strata(column);
        1.0 / f64::from(columns * rows)
    }

    /// The columns and rows of a pixel's strata.
    pub fn strata(&self, column: usize) -> [u32; 2] {
        let samples = column.checked_sub(self.start).and_then(|k| self.samples.get(k)).copied().unwrap_or(1);
        MultiJittered::strata(u32::from(samples), self.most)
    }

    /// What planning a pixel has cost.
    pub fn cost(&self, column: usize) -> Counts {
        column.checked_sub(self.start).and_then(|k| self.costs.get(k)).copied().unwrap_or_default()
    }
}

impl<'a> Planner<'a> {
    /// None if samples are not adaptive, or no colours are traced.
    pub fn new(camera: &Camera, setting: RenderSetting<'a>) -> Option<Self> {
        let settings = setting.request.adaptive.filter(|_| setting.request.traces_colors(setting.tracing))?;
        Some(Self { setting, settings, small_things: SmallThings::new(camera, setting.caster.world) })
    }

    /// Plans the rows of tiles that have some of these rows, but for those that are planned already; none if the watch
    /// cancels the render. Too little memory is an error.
    pub fn bands(
        &self,
        picture: &PictureTracer,
        rows: &Range<usize>,
        mut planned: Vec<Band>,
        tally: &Tally,
    ) -> Result<Option<Vec<Band>>, NoMemory> {
        let [_, height] = self.setting.request.size;
        planned.retain(|band| band.rows.start < rows.end && rows.start < band.rows.end);
        for rows in tiles(rows, height) {
            if planned.iter().all(|band| band.rows != rows) {
                let width = self.setting.columns().len();
                memory::ask((width * SIDE * BYTES + SIDE * SIDE * BYTES_OF_TILE) as u64)?;
                let Some(band) = self.band(picture, rows, tally) else { return Ok(None) };
                planned.push(band);
            }
        }
        Ok(Some(planned))
    }

    fn band(&self, picture: &PictureTracer, rows: Range<usize>, tally: &Tally) -> Option<Band> {
        let tracer = picture.rows(rows.clone());
        let tiles: Vec<_> = tiles(&self.setting.columns(), self.setting.request.size[0]).collect();
        let columns = tiles.first().map_or(0, |tile| tile.start)..tiles.last().map_or(0, |tile| tile.end);
        let pixels = columns.len() * rows.len();
        let costs = if self.setting.request.has_costs() { vec![Counts::default(); pixels] } else { vec![] };
        let counts = vec![Counts::default(); rows.len()];
        let samples = Vec::with_capacity(pixels);
        let mut band = Band { most: self.settings.most, columns, rows, samples, costs, counts };
        let planned = tiles.into_iter().map(|columns| {
            let samples = self.tile(&tracer, &columns, &mut band, tally)?;
            Some((columns.len(), samples))
        });
        let planned = planned.collect::<Option<Vec<_>>>()?;
        for row in 0..band.rows.len() {
            planned.iter().for_each(|(width, samples)| {
                band.samples.extend_from_slice(&samples[row * width..][..*width]);
            });
        }
        Some(band)
    }

    /// Plans the tile of a band that has these columns: how many samples its pixels get, row by row.
    fn tile(
        &self,
        tracer: &RowsTracer,
        columns: &Range<usize>,
        band: &mut Band,
        tally: &Tally,
    ) -> Option<Vec<u16>> {
        let has_floats = self.setting.request.has_floats;
        let rows = band.rows.clone();
        let corners = self.corners(tracer, columns, band, tally)?;
        let width = columns.len();
        let contents = of_rows(&(0..rows.len()), tally, |row| Some(contents(&corners, row)))?;
        let mut contents = contents.concat();
        // Casts probes, and returns how far the colour that each sees is beyond those of the corners.
        let mut cast = |places: &(dyn Fn(usize) -> Places + Sync)| {
            let look = |j| {
                let places = places(j);
                Some((self.setting.look(tracer.row(), j, places.iter().copied())?, places))
            };
            let mut found = vec![];
            for (j, (looked, places)) in rows.clone().zip(of_rows(&rows, tally, look)?) {
                band.add_counts(j, &looked, places.iter().map(|place| place.0));
                let row = j - rows.start;
                found.extend(places.iter().zip(looked.colors).map(|(&(column, _), color)| {
                    let x = column - columns.start;
                    let [[a, b], [c, d]] = [0, 1].map(|k| [0, 1].map(|i| corners[row + k].colors[x + i]));
                    Find { pixel: row * width + x, square: beyond(finite(color), [a, b, c, d], has_floats) }
                }));
            }
            Some(found)
        };

        let specks = self.small_things.specks(columns, &rows);
        let in_row = |j: usize| &specks[(j - rows.start) * width..][..width];
        let of_specks = cast(&|j| {
            let alone = columns.clone().zip(in_row(j)).filter(|(_, speck)| speck.is_alone());
            alone.map(|(column, speck)| (column, speck.offset.as_dvec2())).collect()
        })?;
        let most = if has_floats { f32::MAX } else { BRIGHTEST * BRIGHTEST };
        // The place in a small thing may have missed it, but hardly all around.
        let mut squares = vec![0.0f32; specks.len()];
        for Find { pixel, square } in of_specks {
            let [x, y] = [pixel % width, pixel / width];
            for y in y.saturating_sub(1)..(y + 2).min(rows.len()) {
                for near in &mut squares[y * width..][x.saturating_sub(1)..(x + 2).min(width)] {
                    *near = near.max(square.min(most));
                }
            }
        }
        for ((contents, speck), square) in contents.iter_mut().zip(&specks).zip(squares) {
            let part = speck.part.min(0.5);
            contents.variance = contents.variance.max(part * (1.0 - part) * square);
        }

        let mut known = Known {
            width,
            contents: &contents,
            finds: vec![],
            probes: 0.0,
            brightest: corners.iter().flat_map(|row| &row.colors).fold(1.0, |a, b| a.max(b.max_element())),
            has_floats,
        };
        let mut probes = self.settings.probes(contents.len(), known.contrast());
        let mut round = 0;
        loop {
            let more = probes - known.probes;
            let found = cast(&|j| random_places(columns, j, self.setting.request.size[1], round, more))?;
            known.finds.extend(found.into_iter().filter(|find| find.square > 0.0));
            known.probes = probes;
            let seen = known.finds.iter().fold(0.0, |most: f32, find| most.max(find.square));
            known.brightest = known.brightest.max(seen.sqrt());
            let Planned { samples, doubt } = self.settings.plan(&known);
            let total = samples.iter().map(|&count| f64::from(count)).sum::<f64>();
            // More probes are worth while if there are bright things, or if few have found much.
            let affordable = OF_SAMPLES * total / contents.len() as f64;
            let for_doubt = if doubt > DOUBT && 2.0 * probes < affordable { 2.0 * probes } else { 0.0 };
            probes = self.settings.probes(contents.len(), known.contrast()).max(for_doubt).min(MOST_PROBES);
            if probes <= known.probes {
                return Some(samples);
            }
            round += 1;
        }
    }

    /// Casts the rays through the corners of the pixels in these columns of a band.
    fn corners(
        &self,
        tracer: &RowsTracer,
        columns: &Range<usize>,
        band: &mut Band,
        tally: &Tally,
    ) -> Option<Vec<Corners>> {
        // The last corners are in the last pixels.
        let of_corner = |k: usize, pixels: &Range<usize>| k.min(pixels.end - 1);
        let rows = band.rows.clone();
        let all = rows.start..rows.end + 1;
        let looked = of_rows(&all, tally, |j| {
            let row = of_corner(j, &rows);
            let places = (columns.start..=columns.end).map(|corner| {
                let column = of_corner(corner, columns);
                (column, DVec2::new((corner - column) as f64, (j - row) as f64) - 0.5)
            });
            self.setting.look(tracer.row(), row, places)
        })?;
        let most = Vec3A::splat(if self.setting.request.has_floats { f32::MAX } else { BRIGHTEST });
        let row = |(j, looked): (usize, Looked)| {
            let columns = (columns.start..=columns.end).map(|corner| of_corner(corner, columns));
            band.add_counts(of_corner(j, &rows), &looked, columns);
            Corners::new(looked.colors.into_iter().map(|color| finite(color).min(most)).collect())
        };
        Some(all.zip(looked).map(row).collect())
    }
}

/// So many random places in each pixel of a row on average.
fn random_places(columns: &Range<usize>, j: usize, height: usize, round: u64, count: f64) -> Places {
    let mut next = PROBES.jumped(round << 40 | (columns.start * height + j) as u64 * DRAWS);
    let jump = Jump::of(height as u64 * DRAWS);
    let of_column = |column: usize| {
        let mut rng = next;
        next = next.after(jump);
        let count = (count + rng.random::<f64>()) as usize;
        (0..count).map(move |_| (column, DVec2::new(rng.random(), rng.random()) - 0.5))
    };
    columns.clone().flat_map(of_column).collect()
}

/// The colours at a row of corners of pixels.
struct Corners {
    colors: Vec<Vec3A>,
    /// For each corner that has a next one, the line around the side between them.
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

/// What corners tell of the pixels of a row.
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
