//! Plans adaptive samples: finds the number of samples of each pixel, by rays through the corners of pixels and by
//! probes.
//!
//! The picture is cut into tiles. Each tile is planned by itself. So a part of a picture needs only the plans of the
//! tiles that it touches.

use super::Stopped;
use super::request::Request;
use super::row::Looked;
use super::small_things::SmallThings;
use super::tracing::PictureTracer;
use crate::base::memory;
use crate::picture::Color;
use crate::sampling::adaptive::Adaptive;
use crate::sampling::multi_jittered::MultiJittered;
use crate::scene::Light;
use crate::scene::material::Material;
use crate::stats::Counts;
use crate::world::World;
use std::ops::Range;
use tile::Tile;

mod tile;

/// The number of samples of each pixel of a row.
#[derive(Clone, Copy)]
pub struct Plan<'a> {
    band: &'a Band,
    /// The index of the row in the band.
    row: usize,
}

/// The number of samples of each pixel of a row of tiles.
pub struct Band {
    most: u32,
    columns: Range<usize>,
    rows: Range<usize>,
    samples: Vec<u16>,
    costs: Vec<u64>,
    /// The cost of planning each row.
    counts: Vec<Counts>,
}

/// Plans tiles of a picture.
pub struct Planner<'a> {
    picture: &'a PictureTracer<'a>,
    request: &'a Request,
    settings: Adaptive,
    small_things: SmallThings<'a>,
    /// The brightest colour that may be seen in mirrors or glass, at least white.
    reflected: f32,
    /// The rows of tiles that are planned.
    bands: Vec<Band>,
}

/// The largest side of a tile, in pixels. In larger tiles each pixel needs fewer probes.
const SIDE: usize = 256;

/// The approximate memory of a pixel, in bytes: in a band, and while its tile is planned.
const BYTES: usize = size_of::<u16>();
const BYTES_OF_TILE: usize = 120;

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

    /// Adds the cost of rays in row `j` and these columns.
    fn add_counts(&mut self, j: usize, looked: &Looked, columns: impl Iterator<Item = usize>) {
        let row = j - self.rows.start;
        self.counts[row] = self.counts[row].merge(looked.counts);
        for (column, cost) in columns.zip(&looked.costs) {
            let index = self.index(column, row);
            self.costs[index] += cost;
        }
    }
}

impl Plan<'_> {
    /// Returns the largest number of samples of a pixel.
    pub fn most(self) -> u32 {
        self.band.most
    }

    /// Returns the part of its pixel that a sample in this column represents.
    pub fn part(self, column: usize) -> f64 {
        let [columns, rows] = self.strata(column);
        1.0 / f64::from(columns * rows)
    }

    /// Returns the columns and rows of a pixel's strata.
    pub fn strata(self, column: usize) -> [u32; 2] {
        let samples = self.band.samples[self.band.index(column, self.row)];
        MultiJittered::strata(u32::from(samples), self.band.most)
    }

    /// Returns the cost of planning a pixel, if costs are a layer.
    pub fn cost(self, column: usize) -> Option<u64> {
        self.band.costs.get(self.band.index(column, self.row)).copied()
    }

    /// Returns the counts of planning the row.
    pub fn counts(self) -> Counts {
        self.band.counts[self.row]
    }
}

impl<'a> Planner<'a> {
    /// Returns a planner, or `None` if samples are not adaptive or no colours are traced.
    pub fn new(picture: &'a PictureTracer<'a>) -> Option<Self> {
        let (request, world) = (picture.request, picture.caster.world);
        let settings = request.adaptive.filter(|_| request.traces_colors(request.tracing))?;
        let reflects =
            request.effects.bounces > 0 && world.materials.iter().any(Material::has_secondary_rays);
        let reflected = if reflects { brightest(world) } else { 1.0 };
        let small_things = SmallThings::new(&picture.shot.camera, world);
        Some(Self { picture, request, settings, small_things, reflected, bands: vec![] })
    }

    /// Plans these rows and forgets the others. Fails if the render is cancelled, or if there is too little memory.
    pub fn prepare(&mut self, rows: &Range<usize>) -> Result<(), Stopped> {
        let [_, height] = self.request.size;
        self.bands.retain(|band| band.rows.start < rows.end && rows.start < band.rows.end);
        for rows in tiles(rows, height) {
            if self.bands.iter().all(|band| band.rows != rows) {
                let width = self.request.traced_columns().len();
                memory::ask((width * SIDE * BYTES + SIDE * SIDE * BYTES_OF_TILE) as u64)?;
                self.bands.push(self.band(rows).ok_or_else(|| self.picture.tally.reason())?);
            }
        }
        Ok(())
    }

    /// Returns the plan of row `j`, if the row is planned.
    pub fn plan(&self, j: usize) -> Option<Plan<'_>> {
        let band = self.bands.iter().find(|band| band.rows.contains(&j))?;
        Some(Plan { band, row: j - band.rows.start })
    }

    fn band(&self, rows: Range<usize>) -> Option<Band> {
        let tracer = self.picture.rows(rows.clone()).ok()?;
        let tiles: Vec<_> = tiles(&self.request.traced_columns(), self.request.size[0]).collect();
        let columns = tiles.first().map_or(0, |tile| tile.start)..tiles.last().map_or(0, |tile| tile.end);
        let pixels = columns.len() * rows.len();
        let costs = if self.request.cost().is_some() { vec![0; pixels] } else { vec![] };
        let counts = vec![Counts::default(); rows.len()];
        let mut band =
            Band { most: self.settings.most, columns, rows, samples: vec![0; pixels], costs, counts };
        for columns in tiles {
            let samples = Tile::new(self, &tracer, &columns, &mut band)?.allot()?;
            for (row, samples) in samples.chunks(columns.len()).enumerate() {
                let first = band.index(columns.start, row);
                band.samples[first..][..columns.len()].copy_from_slice(samples);
            }
        }
        Some(band)
    }
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
