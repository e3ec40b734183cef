//! Paints pictures one after the other, and drops those that are overtaken.
//!
//! A thread keeps the scene that was painted last prepared, so that the next picture of it starts at once.

use super::limits::{BYTES_PER_REFERENCE, PICTURE_TIME};
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
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Pictures that wait for the painter.
const QUEUE: usize = 8;
/// Pages whose turns are remembered.
const PAGES: usize = 16;
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
    /// The page has asked for a later one.
    Overtaken,
    /// It takes too long.
    TooSlow,
    /// Too many pictures wait already.
    Busy,
    /// It is impossible, for this reason.
    Failed(String),
}

struct Job {
    subject: Subject,
    turn: Turn,
    reply: SyncSender<Result<Painted, Unpainted>>,
}

/// A request's place among those of its page.
#[derive(Clone)]
struct Turn {
    number: u64,
    newest: Arc<AtomicU64>,
}

impl Turn {
    fn is_overtaken(&self) -> bool {
        self.newest.load(Ordering::Relaxed) > self.number
    }
}

/// Paints pictures on a thread of its own.
pub struct Painter {
    jobs: SyncSender<Job>,
    /// The newest turn of each page, the page that asked first coming first.
    turns: Mutex<Vec<(u64, Arc<AtomicU64>)>>,
}

impl Painter {
    pub fn start() -> std::io::Result<Self> {
        let (jobs, waiting) = sync_channel(QUEUE);
        thread::Builder::new().name("painter".into()).spawn(move || paint_all(&waiting))?;
        Ok(Self { jobs, turns: Mutex::default() })
    }

    /// Paints a picture, unless the page asks for one with a higher turn meanwhile.
    pub fn paint(&self, subject: Subject, page: u64, turn: u64) -> Result<Painted, Unpainted> {
        let (reply, painted) = sync_channel(1);
        let job = Job { subject, turn: self.turn(page, turn), reply };
        self.jobs.try_send(job).map_err(|error| match error {
            TrySendError::Full(_) => Unpainted::Busy,
            TrySendError::Disconnected(_) => Unpainted::Failed("the painter has ended".into()),
        })?;
        painted.recv().unwrap_or_else(|_| Err(Unpainted::Failed("the painter has ended".into())))
    }

    fn turn(&self, page: u64, number: u64) -> Turn {
        let mut turns = self.turns.lock().unwrap_or_else(PoisonError::into_inner);
        let newest = match turns.iter().find(|(known, _)| *known == page) {
            Some((_, newest)) => newest.clone(),
            None => {
                let surplus = (turns.len() + 1).saturating_sub(PAGES);
                turns.drain(..surplus);
                turns.push((page, Arc::default()));
                turns[turns.len() - 1].1.clone()
            }
        };
        newest.fetch_max(number, Ordering::Relaxed);
        Turn { number, newest }
    }
}

/// Paints until nobody can ask any more.
fn paint_all(jobs: &Receiver<Job>) {
    let mut next = jobs.recv().ok();
    while let Some(job) = next.take() {
        let scene = job.subject.scene.clone();
        let mut easel = Easel { renderer: &scene.renderer, ready: vec![] };
        let mut same = Some(job);
        while let Some(Job { subject, turn, reply }) = same.take() {
            // Whoever has asked may be gone.
            let _ = reply.send(easel.paint(&subject, &turn));
            match jobs.recv().ok() {
                Some(job) if Arc::ptr_eq(&job.subject.scene, &scene) => same = Some(job),
                other => next = other,
            }
        }
    }
}

/// A scene with the structures that its last pictures were traced through.
struct Easel<'r> {
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
    fn paint(&mut self, subject: &Subject, turn: &Turn) -> Result<Painted, Unpainted> {
        if turn.is_overtaken() {
            return Err(Unpainted::Overtaken);
        }
        let start = Instant::now();
        let ready = self.ready(subject).map_err(|error| Unpainted::Failed(error.to_string()))?;
        let watch = |_: Progress| match turn.is_overtaken() || start.elapsed() > PICTURE_TIME {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let request = request(subject);
        let [width, height] = request.size;
        let mut colors = Colors::default();
        let mut take_row = |_: usize, row: &[Color]| {
            colors.take(row, subject.cost.is_some());
            ControlFlow::Continue(())
        };
        match ready.render_rows(&request, &watch, &mut take_row) {
            Ok(_) => {}
            Err(Stopped::Cancelled { .. }) if turn.is_overtaken() => return Err(Unpainted::Overtaken),
            Err(Stopped::Cancelled { .. } | Stopped::Output) => return Err(Unpainted::TooSlow),
            Err(Stopped::Memory(refused)) => return Err(Unpainted::Failed(refused.to_string())),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_overtakes_those_before_it_on_its_own_page() {
        let painter = Painter::start().unwrap();
        let (first, other) = (painter.turn(1, 1), painter.turn(2, 1));
        assert!(!first.is_overtaken());
        let second = painter.turn(1, 2);
        assert_eq!([&first, &second, &other].map(Turn::is_overtaken), [true, false, false]);
        assert!(painter.turn(1, 1).is_overtaken(), "what comes late is overtaken at once");
    }

    #[test]
    fn pages_are_forgotten_in_their_order() {
        let painter = Painter::start().unwrap();
        (0..3 * PAGES as u64).for_each(|page| drop(painter.turn(page, 7)));
        assert_eq!(painter.turns.lock().unwrap().len(), PAGES);
        assert!(!painter.turn(0, 1).is_overtaken() && painter.turn(3 * PAGES as u64 - 1, 1).is_overtaken());
    }
}
