//! Plans adaptive samples: finds the number of samples of each pixel, by rays through the corners of pixels, through
//! small things, and at random.
//!
//! The picture is cut into tiles. Each tile is planned by itself. So a part of a picture needs only the plans of the
//! tiles that it touches.

use super::request::Request;
use super::small_things::SmallThings;
use super::tally::Tally;
use super::tracing::PictureTracer;
use crate::base::memory::{self, NoMemory};
use crate::picture::Color;
use crate::sampling::adaptive::{Adaptive, BRIGHTEST, Contents, beyond, edge_and_variation, finite};
use crate::sampling::allotment::{Find, Known, gain_of};
use crate::sampling::drand48::Drand48;
use crate::sampling::multi_jittered::MultiJittered;
use crate::scene::Light;
use crate::scene::material::Material;
use crate::stats::Counts;
use crate::world::World;
use glam::{DVec2, Vec3A};
use rand::RngExt;
use rayon::prelude::*;
use std::ops::Range;

/// The plan of a tile.
pub struct Plan {
    columns: Range<usize>,
    rows: Range<usize>,
    /// The number of samples of each pixel, row by row.
    samples: Vec<u16>,
    /// The cost of planning each row, or each pixel if costs are a layer.
    costs: Vec<Counts>,
}

/// Plans tiles of a picture.
pub struct Planner<'a> {
    request: &'a Request,
    settings: Adaptive,
    small_things: SmallThings<'a>,
    /// The brightest colour that may be seen in mirrors or glass, at least white.
    reflected: f32,
}

/// A tile that is being planned.
struct Tile<'t, 'a> {
    planner: &'t Planner<'a>,
    tracer: &'t PictureTracer<'t>,
    tally: &'t Tally<'t>,
    plan: Plan,
    /// The colours at the corners of the pixels, row by row.
    corners: Vec<Vec3A>,
}

/// Points in a row: columns, and offsets from their pixels' centres.
type Places = Vec<(usize, DVec2)>;

/// The largest side of a tile, in pixels. In larger tiles each pixel needs fewer probes.
const SIDE: usize = 256;

/// The approximate memory of a pixel, in bytes: in a plan, and while its tile is planned.
const BYTES: usize = size_of::<u16>();
const BYTES_OF_TILE: usize = 120;

/// The seed of the probes and tests. It does not depend on the seed of the samples.
const PROBES: Drand48 = Drand48::seeded(0x50B0_0B5E);

/// The number of random numbers that are reserved for the probes of a row of a tile: more than are drawn.
const DRAWS: u64 = 9973;

/// The plan that is tested assumes this ratio of the errors of stratified samples to those of random ones.
const LEAST_GAIN: f64 = 1.0 / 16.0;

/// The number of pixels that are tested.
const TESTS: usize = 64;

impl Plan {
    /// Returns true if it has the pixel in this column and row from the bottom left.
    pub fn contains(&self, [column, j]: [usize; 2]) -> bool {
        self.columns.contains(&column) && self.rows.contains(&j)
    }

    /// Returns the cost of planning row `j`.
    pub fn counts(&self, j: usize) -> Counts {
        if !self.rows.contains(&j) {
            return Counts::default();
        }
        self.costs[self.costs_of_row(j)].iter().fold(Counts::default(), |sum, &cost| sum.merge(cost))
    }

    /// Returns the cost of planning a pixel, if costs are a layer.
    pub fn cost(&self, [column, j]: [usize; 2]) -> Counts {
        self.costs[self.costs_of_row(j)][column - self.columns.start]
    }

    fn costs_of_row(&self, j: usize) -> Range<usize> {
        let width = self.costs.len() / self.rows.len();
        (j - self.rows.start) * width..(j - self.rows.start + 1) * width
    }
}

/// Returns the columns and rows of the strata of the pixel in this column and row from the bottom left.
pub fn strata(plans: &[Plan], place: [usize; 2], most: u32) -> [u32; 2] {
    let samples = plans.iter().find(|plan| plan.contains(place)).map_or(1, |plan| {
        plan.samples[(place[1] - plan.rows.start) * plan.columns.len() + place[0] - plan.columns.start]
    });
    MultiJittered::strata(u32::from(samples), most)
}

impl<'a> Planner<'a> {
    /// Returns a planner, or `None` if samples are not adaptive or no colours are traced.
    pub fn new(&PictureTracer { camera, caster, request, .. }: &PictureTracer<'a>) -> Option<Self> {
        let settings = request.adaptive.filter(|_| request.traces_colors(request.tracing))?;
        let world = caster.world;
        let reflects =
            request.effects.bounces > 0 && world.materials.iter().any(Material::has_secondary_rays);
        let reflected = if reflects { brightest(world) } else { 1.0 };
        Some(Self { request, settings, small_things: SmallThings::new(camera, world), reflected })
    }

    /// Plans the tiles that overlap these rows, except the ones in `planned`. Returns `None` if the watch cancels the
    /// render. Fails if there is too little memory.
    pub fn plans(
        &self,
        picture: &PictureTracer,
        rows: &Range<usize>,
        mut planned: Vec<Plan>,
        tally: &Tally,
    ) -> Result<Option<Vec<Plan>>, NoMemory> {
        let [width, height] = self.request.size;
        planned.retain(|plan| plan.rows.start < rows.end && rows.start < plan.rows.end);
        for rows in tiles(rows, height) {
            if planned.iter().any(|plan| plan.rows == rows) {
                continue;
            }
            memory::ask(
                (self.request.traced_columns().len() * SIDE * BYTES + SIDE * SIDE * BYTES_OF_TILE) as u64,
            )?;
            let tracer = &picture.rows(rows.clone());
            for columns in tiles(&self.request.traced_columns(), width) {
                let costs_per_row = if self.request.has_costs() { columns.len() } else { 1 };
                let costs = vec![Counts::default(); rows.len() * costs_per_row];
                let plan = Plan { columns, rows: rows.clone(), samples: vec![], costs };
                let Some(plan) = (Tile { planner: self, tracer, tally, plan, corners: vec![] }).planned()
                else {
                    return Ok(None);
                };
                planned.push(plan);
            }
        }
        Ok(Some(planned))
    }
}

impl Tile<'_, '_> {
    /// Returns the plan, or `None` if the watch cancels the render.
    fn planned(mut self) -> Option<Plan> {
        let (settings, has_floats) = (self.planner.settings, self.has_floats());
        self.cast_corners()?;
        let contents = self.contents()?;
        let seen = self.corners.iter().map(|color| color.max_element()).fold(1.0, f32::max);
        let contrast = self.planner.reflected.max(if has_floats { seen } else { 1.0 });
        let (width, probes) = (self.plan.columns.len(), settings.probes(contents.len(), contrast));
        let finds = self.probe(probes)?;
        // Stratified samples leave less error than random ones where details are larger than strata. The ratio falls
        // with the number of samples. So its value for fewer samples than necessary is an upper bound.
        let mut known = Known { width, contents, finds, probes, contrast, has_floats, gain: LEAST_GAIN };
        let samples = known.allot(settings);
        known.gain = self.test(&known, &samples)?.clamp(LEAST_GAIN, 1.0);
        self.plan.samples = known.allot(settings);
        Some(self.plan)
    }

    fn has_floats(&self) -> bool {
        self.planner.request.has_floats
    }

    /// Casts rays through the points of each row, and returns their pixels and colours.
    fn cast(&mut self, places: impl Fn(usize) -> Places + Sync) -> Option<Vec<(usize, Color)>> {
        let (tracer, tally, width) = (self.tracer, self.tally, self.plan.columns.len());
        let rows = self.plan.rows.clone();
        let cast = |j: usize| {
            let places = if tally.asks(0) { None } else { Some(places(j)) }?;
            let (colors, costs) = tracer.look(j, &places)?;
            Some((places, colors, costs))
        };
        let seen: Vec<_> = rows.clone().into_par_iter().map(cast).collect::<Option<_>>()?;
        let mut all = vec![];
        for (j, (places, colors, costs)) in rows.clone().zip(seen) {
            let sums = self.plan.costs_of_row(j);
            let sums = &mut self.plan.costs[sums];
            for (k, cost) in costs.into_iter().enumerate() {
                let index = if sums.len() == 1 { 0 } else { places[k].0 - self.plan.columns.start };
                sums[index] = sums[index].merge(cost);
            }
            let first = (j - rows.start) * width;
            let pixels = places.iter().map(|place| first + place.0 - self.plan.columns.start);
            all.extend(pixels.zip(colors));
        }
        Some(all)
    }

    fn cast_corners(&mut self) -> Option<()> {
        let (columns, rows) = (self.plan.columns.clone(), self.plan.rows.clone());
        let most = Vec3A::splat(if self.has_floats() { f32::MAX } else { BRIGHTEST });
        let seen = self.cast(|j| {
            // The last corners belong to the last pixels.
            let of_side = |y: f64| {
                let left = columns.clone().map(move |column| (column, DVec2::new(-0.5, y)));
                left.chain([(columns.end - 1, DVec2::new(0.5, y))])
            };
            let above = of_side(0.5).filter(|_| j + 1 == rows.end);
            of_side(-0.5).chain(above).collect()
        })?;
        self.corners = seen.into_iter().map(|(_, color)| finite(color).min(most)).collect();
        Some(())
    }

    /// Returns the squared distance of a colour from the range of the colours at its pixel's corners.
    fn find(&self, (pixel, color): (usize, Color)) -> Find {
        let width = self.plan.columns.len();
        let corner = pixel / width * (width + 1) + pixel % width;
        let corners = [0, 1, width + 1, width + 2].map(|k| self.corners[corner + k]);
        Find { pixel, square: beyond(finite(color), corners, self.has_floats()) }
    }

    /// Estimates the contents of the pixels, by the corners and by rays to small things.
    fn contents(&mut self) -> Option<Vec<Contents>> {
        let (width, rows, columns) =
            (self.plan.columns.len(), self.plan.rows.clone(), self.plan.columns.clone());
        let specks = self.planner.small_things.specks(&columns, &rows);
        let seen = self.cast(|j| {
            let row = &specks[(j - rows.start) * width..][..width];
            let alone = columns.clone().zip(row).filter(|(_, speck)| speck.is_alone());
            alone.map(|(column, speck)| (column, speck.offset.as_dvec2())).collect()
        })?;
        let most = if self.has_floats() { f32::MAX } else { BRIGHTEST * BRIGHTEST };
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
        let corner = |x: Option<usize>, y: Option<usize>| {
            let (x, y) = (x.filter(|&x| x <= width)?, y?);
            self.corners.get(y * (width + 1) + x).copied()
        };
        let around = |k: usize| [k.checked_sub(1), Some(k), Some(k + 1), Some(k + 2)];
        let of_pixel = |pixel: usize| {
            let [x, y] = [pixel % width, pixel / width];
            let across = |y: usize| edge_and_variation(around(x).map(|x| corner(x, Some(y))));
            let upright = |x: usize| edge_and_variation(around(y).map(|y| corner(Some(x), y)));
            let sides = [across(y), across(y + 1), upright(x), upright(x + 1)];
            let [edge, variation] = [0, 1].map(|k| sides.iter().map(|side| side[k]).sum::<f32>());
            let part = specks[pixel].part.min(0.5);
            // An edge that crosses the pixel crosses two of its sides. If colours are a random choice of two, the mean
            // square variation along each side is 8 variances.
            let variance = (variation / 32.0).max(part * (1.0 - part) * squares[pixel]);
            Contents { edge: 0.5 * edge, variance }
        };
        Some((0..specks.len()).into_par_iter().map(of_pixel).collect())
    }

    /// Casts this number of probes in each pixel on average, and returns their finds.
    fn probe(&mut self, count: f64) -> Option<Vec<Find>> {
        let (columns, height) = (self.plan.columns.clone(), self.planner.request.size[1]);
        let seen = self.cast(|j| {
            let mut rng = PROBES.jumped((columns.start * height + j) as u64 * DRAWS);
            let mut places = vec![];
            for column in columns.clone() {
                for _ in 0..(count + rng.random::<f64>()) as usize {
                    places.push((column, DVec2::new(rng.random(), rng.random()) - 0.5));
                }
            }
            places
        })?;
        Some(seen.into_iter().map(|seen| self.find(seen)).filter(|find| find.square > 0.0).collect())
    }

    /// Takes the samples of some pixels twice. Returns the mean ratio of their squared errors to those of random
    /// samples, plus its standard error.
    fn test(&mut self, known: &Known, samples: &[u16]) -> Option<f64> {
        let chosen = known.to_test(samples, TESTS);
        let (width, start, most) =
            (self.plan.columns.len(), self.plan.columns.start, self.planner.settings.most);
        let (first, height) = (self.plan.rows.start, self.planner.request.size[1]);
        let seen = self.cast(|j| {
            let row = (j - first) * width..(j - first + 1) * width;
            let of_pixel = |pixels: &[usize]| {
                let (pixel, column) = (pixels[0], start + pixels[0] - row.start);
                let strata = MultiJittered::strata(samples[pixel].into(), most);
                let index = 2 * (column * height + j) as u64;
                [index, index + 1].into_iter().flat_map(move |index| {
                    let rng = PROBES.jumped((1 << 45) + index * MultiJittered::draws(most));
                    MultiJittered::new(strata, rng).map(move |offset| (column, offset))
                })
            };
            chosen
                .chunk_by(|a, b| a == b)
                .filter(|pixels| row.contains(&pixels[0]))
                .flat_map(of_pixel)
                .collect()
        })?;
        let shown = |color: Color| if self.has_floats() { color } else { color.min(Color::ONE) };
        let (pixels, colors): (Vec<_>, Vec<_>) =
            seen.into_iter().map(|(pixel, color)| (pixel, shown(color))).unzip();
        let mut rest = &colors[..];
        let [mut sum, mut squares] = [0.0; 2];
        for (own, times) in pixels.chunk_by(|a, b| a == b).zip(chosen.chunk_by(|a, b| a == b)) {
            let (own, others) = rest.split_at(own.len());
            let (ratio, times) = (gain_of(own.split_at(own.len() / 2).into()), times.len() as f64);
            (sum, squares, rest) = (sum + times * ratio, squares + times * ratio * ratio, others);
        }
        let count = chosen.len().max(1) as f64;
        let mean = sum / count;
        Some(mean + ((squares / count - mean * mean).max(0.0) / count).sqrt())
    }
}

/// Returns the rows or columns of tiles of this number of pixels that overlap the range.
fn tiles(pixels: &Range<usize>, count: usize) -> impl Iterator<Item = Range<usize>> + use<> {
    let (pixels, parts) = (pixels.clone(), count.div_ceil(SIDE));
    let tiles = (0..parts).map(move |k| k * count / parts..(k + 1) * count / parts);
    tiles.filter(move |tile| tile.start < pixels.end && pixels.start < tile.end)
}

/// Returns the brightest colour of diffuse surfaces and the background, without highlights, but at least white.
fn brightest(world: &World) -> f32 {
    let color = |light: &Light| match *light {
        Light::Directional { color, .. } | Light::Point { color, .. } => color,
    };
    let light = world.ambient + world.lights.iter().map(color).sum::<Color>();
    let diffuse = world.materials.iter().filter_map(|material| match material {
        Material::Phong(phong) | Material::Painted(phong, _) => Some((phong.diffuse * light).max_element()),
        Material::Texture(_) => None,
    });
    diffuse.fold(world.background.max_element().max(1.0), f64::max) as f32
}
