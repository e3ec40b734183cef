//! Paints pictures one after the other. The scene stays prepared, so that the next picture of it starts at once.

use super::cancel::Cancel;
use super::limits::BYTES_PER_REFERENCE;
use super::stage::OpenScene;
use crate::caster::GridTooLarge;
use crate::caster::choose::{Rays, Resolution, Structure};
use crate::caster::grid::Lattice;
use crate::caster::grid::insertion::{bounds_of, most_references};
use crate::cli::Options;
use crate::memory;
use crate::picture::{CHANNELS, Picture, RED_FIRST, truncate_to_bytes};
use crate::render::{Cost, Layer, Progress, Request, Stopped, Tracing};
use crate::renderer::{Prepared, Renderer};
use crate::scene::{Camera, Color};
use crate::tools::explain::{CostMap, CostReport};
use crate::world::World;
use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Scenes stay prepared with so many structures.
const STRUCTURES: usize = 3;
/// About the rays of a scene that turns for a while, by which its structure is chosen.
const MANY_RAYS: usize = 1 << 21;

/// A picture to paint.
#[derive(Clone)]
pub struct Subject {
    pub scene: Arc<OpenScene>,
    /// The picture, with its structure. Nothing else of it is used.
    pub options: Options,
    pub camera: Option<Camera>,
    /// What is shown in place of the colours.
    pub cost: Option<Cost>,
    /// The size of a sketch with one ray through each centre, in place of the picture.
    pub sketch: Option<[usize; 2]>,
}

/// A picture that is finished.
pub struct Painted {
    pub picture: Picture,
    /// What it cost, if that is shown.
    pub costs: Option<CostReport>,
    /// How many of its colours are not numbers.
    pub nans: u64,
    pub time: Duration,
}

/// Why a picture is not finished.
#[derive(Debug)]
pub enum Unpainted {
    /// Nobody waits for it any more.
    Stopped,
    /// It is impossible, for this reason.
    Failed(String),
}

impl fmt::Display for Unpainted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Stopped => "nobody waits for it",
            Self::Failed(reason) => reason,
        })
    }
}

/// A scene with the structures that its last pictures were traced through.
pub struct Easel<'r> {
    renderer: &'r Renderer,
    ready: Vec<(Purpose, Prepared<'r>)>,
}

/// How many of the fullest cells are named.
const FULLEST: usize = 5;

/// What a scene is prepared for.
#[derive(Clone, Copy, PartialEq)]
struct Purpose {
    structure: Structure,
    shows_cells: bool,
    counts: bool,
    /// The camera's rays, where the picture depends on how many there are.
    rays: Option<usize>,
}

impl<'r> Easel<'r> {
    /// Nothing is prepared yet.
    pub fn new(renderer: &'r Renderer) -> Self {
        Self { renderer, ready: vec![] }
    }

    /// Paints a picture of the scene, unless it is stopped.
    pub fn paint(&mut self, subject: &Subject, stop: &Cancel) -> Result<Painted, Unpainted> {
        let start = Instant::now();
        let ready = self.ready(subject).map_err(|error| Unpainted::Failed(error.to_string()))?;
        let watch = |_: Progress| match stop.is_over() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let request = request(subject);
        let [width, height] = request.layer_size(&Layer::Color);
        let mut colors = Colors::default();
        let mut take_row = |_: usize, row: &[Color]| {
            colors.take(row, subject.cost.is_some());
            ControlFlow::Continue(())
        };
        match ready.render_rows(&request, &watch, &mut take_row) {
            Ok(_) => {}
            Err(Stopped::Cancelled { .. } | Stopped::Output) => return Err(Unpainted::Stopped),
            Err(reason @ (Stopped::Memory(_) | Stopped::Rays)) => {
                return Err(Unpainted::Failed(reason.to_string()));
            }
        }
        let costs = subject.cost.map(|cost| CostReport {
            map: CostMap { cost, size: request.size, counts: std::mem::take(&mut colors.counts) },
            cells: ready.fullness(FULLEST),
        });
        let picture = match &costs {
            Some(report) => report.map.draw().map_err(|error| Unpainted::Failed(error.to_string()))?,
            None => Picture::from_rgb(width as u32, height as u32, colors.bytes),
        };
        Ok(Painted { picture, costs, nans: colors.nans, time: start.elapsed() })
    }

    /// The scene, prepared for a picture.
    fn ready(&mut self, subject: &Subject) -> Result<&Prepared<'r>, GridTooLarge> {
        let Options { structure, visualize_grid, .. } = subject.options;
        let whole = subject.options.request();
        let counts = subject.cost.is_some();
        let rays = (counts || visualize_grid).then(|| whole.camera_rays());
        let purpose = Purpose { structure, shows_cells: visualize_grid, counts, rays };
        let found = self.ready.iter().position(|(known, _)| *known == purpose);
        let place = match found {
            Some(place) => place,
            None => {
                let ready = prepare(self.renderer, purpose, &whole)?;
                self.ready.truncate(STRUCTURES - 1);
                self.ready.insert(0, (purpose, ready));
                0
            }
        };
        Ok(&self.ready[place].1)
    }
}

fn prepare<'r>(
    renderer: &'r Renderer,
    purpose: Purpose,
    whole: &Request,
) -> Result<Prepared<'r>, GridTooLarge> {
    if let Structure::Grid(Resolution::Cells(cells)) = purpose.structure {
        ask_for_references(renderer.world(), cells)?;
    }
    let tracing = if purpose.counts { Tracing::Counted } else { Tracing::Fast };
    match purpose.structure {
        Structure::Grid(grid) if purpose.shows_cells => {
            renderer.prepare_cells(grid, whole.camera_rays(), tracing)
        }
        structure if purpose.counts => {
            let request = Request { layers: vec![Layer::Color], ..whole.clone() };
            renderer.prepare_for(structure, &request, tracing)
        }
        structure => renderer.prepare_as(structure, Rays::cast(MANY_RAYS), tracing),
    }
}

/// Asks for the memory of the primitives in these cells, if there are as many as there may be. Nothing else that a grid
/// takes is unknown before it is built.
fn ask_for_references(world: &World, cells: [usize; 3]) -> Result<(), GridTooLarge> {
    let most = most_references(world, &Lattice::new(bounds_of(world), cells));
    memory::ask(most.saturating_mul(BYTES_PER_REFERENCE)).map_err(|_| GridTooLarge)
}

/// The request for a picture or its sketch.
fn request(subject: &Subject) -> Request {
    let whole = subject.options.request();
    let layer = subject.cost.map_or(Layer::Color, Layer::Cost);
    let layers = vec![layer];
    match subject.sketch {
        None => Request { camera: subject.camera, layers, ..whole },
        Some(size) => {
            Request { camera: subject.camera, layers, effects: whole.effects, ..Request::new(size) }
        }
    }
}

/// The rows of a picture as they come.
#[derive(Default)]
struct Colors {
    bytes: Vec<u8>,
    counts: Vec<u64>,
    nans: u64,
}

impl Colors {
    fn take(&mut self, row: &[Color], are_costs: bool) {
        if are_costs {
            return self.counts.extend(row.iter().map(|cost| cost.x as u64));
        }
        let before = self.bytes.len();
        self.bytes.resize(before + row.len() * CHANNELS, 0);
        self.nans += truncate_to_bytes::<RED_FIRST>(row, &mut self.bytes[before..]);
    }
}
