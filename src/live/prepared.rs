//! Scenes stay prepared, so that their next picture starts at once.

use super::http::Response;
use super::limits::*;
use super::lock;
use super::scenes::{OpenScene, is_too_large};
use super::view::View;
use crate::base::memory;
use crate::caster::choose::{Resolution, Structure};
use crate::caster::insertion::{bounds_of, most_references};
use crate::caster::lattice::Lattice;
use crate::render::renderer::Prepared;
use crate::render::{Layer, Request, Stop, Tracing};
use self_cell::self_cell;
use std::sync::{Arc, Mutex};

self_cell! {
    /// A prepared scene.
    pub struct Ready {
        owner: Arc<OpenScene>,
        #[covariant]
        dependent: Prepared,
    }
}

/// The values that a preparation depends on.
#[derive(PartialEq)]
struct Preparation {
    /// The scene's revision.
    scene: u64,
    structure: Structure,
    tracing: Tracing,
    draws_cells: bool,
    /// The number of camera rays, which an automatic grid depends on.
    rays: Option<usize>,
}

/// The last scenes that were prepared.
pub struct PreparedScenes {
    /// The command line's structure, which has no limit.
    own: Structure,
    /// The newest is the last.
    all: Mutex<Vec<(Preparation, Arc<Ready>)>>,
}

impl PreparedScenes {
    /// No scene is prepared yet. `own` is the command line's structure.
    pub fn new(own: Structure) -> Self {
        Self { own, all: Mutex::default() }
    }

    /// Prepares the scene of a view, unless it is prepared already: to count the work, or to show the grid's cells.
    pub fn get(
        &self,
        view: &View,
        tracing: Tracing,
        draws_cells: bool,
        stop: &Stop,
    ) -> Result<Arc<Ready>, Response> {
        let (scene, structure) = (&view.scene, view.options.structure);
        let whole = Request { layers: vec![Layer::Color], tracing, draws_cells, ..view.options.request() };
        let rays = (structure == Structure::Grid(Resolution::Auto)).then(|| whole.camera_rays());
        let preparation = Preparation { scene: scene.revision, structure, tracing, draws_cells, rays };
        if let Some((_, ready)) = lock(&self.all).iter().find(|(known, _)| *known == preparation) {
            return Ok(ready.clone());
        }
        if let Structure::Grid(Resolution::Cells(cells)) = structure {
            let world = scene.renderer.world();
            let references = most_references(world, &Lattice::new(bounds_of(world), cells));
            let is_own = scene.revision == 0 && structure == self.own;
            if references > MAX_REFERENCES && !is_own {
                let reason = "-grid: these cells hold more than this page allows: choose fewer";
                return Err(Response::text(422, reason));
            }
            memory::ask(references.saturating_mul(GRID_BYTES_PER_REFERENCE))?;
        }
        // Without the lock, so that others need not wait. Two requests may prepare the same.
        let ready =
            Arc::new(Ready::try_new(scene.clone(), |scene| scene.renderer.prepare_within(&whole, stop))?);
        let mut all = lock(&self.all);
        all.push((preparation, ready.clone()));
        while all.len() > MAX_PREPARED || is_too_large(all.iter().map(|(_, ready)| ready.borrow_owner())) {
            all.remove(0);
        }
        Ok(ready)
    }
}
