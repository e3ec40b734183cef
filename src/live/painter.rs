//! Paints pictures. Scenes stay prepared, so that the next picture of them starts at once.

use super::http::Answer;
use super::limits::*;
use super::scenes::OpenScene;
use crate::base::memory;
use crate::caster::choose::{Rays, Resolution, Structure};
use crate::caster::insertion::{bounds_of, most_references};
use crate::caster::lattice::Lattice;
use crate::cli::Options;
use crate::picture::{CHANNELS, Color, Picture, RED_FIRST, truncate_to_bytes};
use crate::render::renderer::{Prepared, Renderer};
use crate::render::{Cost, Layer, Progress, Request, Tracing};
use crate::scene::Camera;
use crate::tools::explain::{CostMap, CostReport, Stop};
use self_cell::self_cell;
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// About the rays of a scene that turns for a while, by which its structure is chosen.
const MANY_RAYS: usize = 1 << 21;
/// How many of the fullest cells are named.
const FULLEST: usize = 5;

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

impl Subject {
    /// The request for one layer of the picture.
    pub fn request(&self, layer: Layer) -> Request {
        let (whole, layers) = (self.options.request(), vec![layer]);
        match self.sketch {
            None => Request { camera: self.camera, layers, ..whole },
            Some(size) => {
                Request { camera: self.camera, layers, effects: whole.effects, ..Request::new(size) }
            }
        }
    }

    /// Returns the memory in bytes of this number of pictures and copies of the scene.
    pub fn bytes(&self, pictures: u64, copies: u64) -> u64 {
        let [width, height] = self.sketch.unwrap_or(self.options.request().size).map(|side| side as u64);
        let primitives = self.scene.primitives() as u64;
        pictures * width * height * BYTES_PER_PIXEL + copies * primitives * BYTES_PER_PRIMITIVE
    }
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

self_cell! {
    /// A prepared scene.
    pub struct Ready {
        owner: Arc<OpenScene>,
        #[covariant]
        dependent: Prepared,
    }
}

/// What a preparation depends on: the scene's revision, its structure, whether cells are drawn and whether work is
/// counted, and the camera's rays where their number matters.
type Preparation = (u64, Structure, bool, bool, Option<usize>);

pub struct Painter {
    /// The structure that the command line asks for, whatever it takes.
    own: Structure,
    /// The last scenes that were prepared, the newest first.
    ready: Mutex<Vec<(Preparation, Arc<Ready>)>>,
}

impl Painter {
    pub fn new(own: Structure) -> Self {
        Self { own, ready: Mutex::default() }
    }

    /// Forgets typed scenes that were closed.
    pub fn forget(&self, is_open: impl Fn(u64) -> bool) {
        let mut ready = self.ready.lock().unwrap_or_else(PoisonError::into_inner);
        ready.retain(|((revision, ..), _)| is_open(*revision));
    }

    /// Paints a picture of the scene, unless it is stopped.
    pub fn paint(&self, subject: &Subject, stop: &Stop) -> Result<Painted, Answer> {
        let start = Instant::now();
        let ready = self.ready(subject, subject.cost.is_some(), subject.options.visualize_grid)?;
        let request = subject.request(subject.cost.map_or(Layer::Color, Layer::Cost));
        let [width, height] = request.layer_size(&Layer::Color);
        let (mut bytes, mut counts, mut nans) = (vec![], vec![], 0);
        let mut take_row = |_: usize, row: &[Color]| {
            if subject.cost.is_some() {
                counts.extend(row.iter().map(|cost| cost.x as u64));
            } else {
                let before = bytes.len();
                bytes.resize(before + row.len() * CHANNELS, 0);
                nans += truncate_to_bytes::<RED_FIRST>(row, &mut bytes[before..]);
            }
            ControlFlow::Continue(())
        };
        let watch = |progress: Progress| stop.watch(progress);
        let prepared = ready.borrow_dependent();
        prepared.render_rows(&request, &watch, &mut take_row)?;
        let costs = subject.cost.map(|cost| CostReport {
            map: CostMap { cost, size: request.size, counts },
            cells: prepared.fullness(FULLEST),
        });
        let picture = match &costs {
            Some(report) => report.map.draw()?,
            None => Picture::from_rgb(width as u32, height as u32, bytes),
        };
        Ok(Painted { picture, costs, nans, time: start.elapsed() })
    }

    /// Prepares the scene of a picture, unless it is prepared already: to count the work, or to show the grid's cells.
    pub fn ready(&self, subject: &Subject, counts: bool, shows_cells: bool) -> Result<Arc<Ready>, Answer> {
        let Subject { scene, options, .. } = subject;
        let structure = options.structure;
        let whole = Request { layers: vec![Layer::Color], ..options.request() };
        let rays = (counts || shows_cells).then(|| whole.camera_rays());
        let preparation = (scene.revision, structure, shows_cells, counts, rays);
        let known = || self.ready.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, ready)) = known().iter().find(|(known, _)| *known == preparation) {
            return Ok(ready.clone());
        }
        // Others need not wait meanwhile. The same may be prepared twice.
        let may_be_large = scene.revision == 0 && structure == self.own;
        let ready = Arc::new(Ready::try_new(scene.clone(), |scene| {
            prepare(&scene.renderer, preparation, &whole, may_be_large)
        })?);
        let mut all = known();
        all.insert(0, (preparation, ready.clone()));
        let is_full = |all: &[(Preparation, Arc<Ready>)]| {
            let primitives: usize = all.iter().map(|(_, ready)| ready.borrow_owner().primitives()).sum();
            all.len() > MAX_PREPARED || all.len() > 1 && primitives > MAX_PRIMITIVES
        };
        while is_full(&all) {
            all.pop();
        }
        Ok(ready)
    }
}

fn prepare<'r>(
    renderer: &'r Renderer,
    (_, structure, shows_cells, counts, _): Preparation,
    whole: &Request,
    may_be_large: bool,
) -> Result<Prepared<'r>, Answer> {
    if let Structure::Grid(Resolution::Cells(cells)) = structure {
        let world = renderer.world();
        let references = most_references(world, &Lattice::new(bounds_of(world), cells));
        if references > MAX_REFERENCES && !may_be_large {
            let reason = "-grid: these cells hold more than this page allows: choose fewer";
            return Err(Answer::impossible(reason));
        }
        memory::ask(references.saturating_mul(BYTES_PER_REFERENCE))?;
    }
    let tracing = if counts { Tracing::Counted } else { Tracing::Fast };
    Ok(match structure {
        Structure::Grid(grid) if shows_cells => renderer.prepare_cells(grid, whole.camera_rays(), tracing)?,
        structure if counts => renderer.prepare_for(structure, whole, tracing)?,
        structure => renderer.prepare_as(structure, Rays::cast(MANY_RAYS), tracing)?,
    })
}
