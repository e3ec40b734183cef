//! Views of scenes, and their pictures. Scenes stay prepared, so that their next picture starts at once.

use super::http::Answer;
use super::limits::*;
use super::lock;
use super::scenes::{OpenScene, Scenes, is_too_large};
use crate::base::memory;
use crate::caster::choose::{Resolution, Structure};
use crate::caster::insertion::{bounds_of, most_references};
use crate::caster::lattice::Lattice;
use crate::cli::{Options, Output};
use crate::image_io::{CompleteFile, OutputFile};
use crate::picture::{Color, Picture, Pixels};
use crate::render::renderer::Prepared;
use crate::render::{Cost, Layer, Progress, Request, Stop, TakeRow, Tracing};
use crate::scene::Camera;
use crate::tools::explain::CostMap;
use self_cell::self_cell;
use std::sync::Arc;

/// A view of a scene, as the controls and the hand have set it.
#[derive(Clone)]
pub struct View {
    pub scene: Arc<OpenScene>,
    /// The flags that shape the picture, with their values.
    pub words: Vec<String>,
    /// The options that they ask for. Only the picture and its structure are used.
    pub options: Options,
    pub camera: Option<Camera>,
    /// The cost that is shown in place of the colours.
    pub cost: Option<Cost>,
    /// The size of a sketch with one ray through each centre, in place of the picture.
    pub sketch: Option<[usize; 2]>,
}

impl View {
    /// The request for one layer of the picture.
    pub fn request(&self, layer: Layer) -> Request {
        let whole = self.options.request();
        let drawn = match self.sketch {
            Some(size) => Request { effects: whole.effects, ..Request::new(size) },
            None => whole,
        };
        let tracing = if matches!(layer, Layer::Cost(_)) { Tracing::Counted } else { Tracing::Fast };
        Request { camera: self.camera, layers: vec![layer], tracing, ..drawn }
    }

    /// Returns the memory in bytes of the picture, or of comparing it with another.
    pub fn bytes(&self) -> u64 {
        let [width, height] = self.request(Layer::Color).size.map(|side| side as u64);
        width * height * VIEW_BYTES_PER_PIXEL
    }
}

/// A picture that is finished.
pub struct Painted {
    pub picture: Picture,
    /// The costs of its pixels, if they are shown.
    pub costs: Option<CostMap>,
    /// The number of colours that are not numbers.
    pub nans: u64,
}

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
pub struct Preparation {
    /// The scene's revision.
    scene: u64,
    structure: Structure,
    tracing: Tracing,
    draws_cells: bool,
    /// The number of camera rays, which an automatic grid depends on.
    rays: Option<usize>,
}

impl Scenes {
    /// Paints a view, unless it is stopped.
    pub fn paint(&self, view: &View, stop: &Stop) -> Result<Painted, Answer> {
        let layer = view.cost.map_or(Layer::Color, Layer::Cost);
        let request = view.request(layer);
        let mut picture = Pixels::zeros(request.layer_size(&layer), false)?;
        let (mut rows, mut nans) = (0, 0);
        let mut take_row = |_: usize, row: &[Color]| {
            nans += picture.set([0, rows], row);
            rows += 1;
            Ok(())
        };
        let (ready, counts) = self.render(view, layer, stop, &mut take_row)?;
        let costs = view.cost.map(|cost| CostMap::new(cost, counts, ready.borrow_dependent(), &request));
        let picture = match &costs {
            Some(map) => map.draw()?,
            None => picture.into_bytes(),
        };
        Ok(Painted { picture, costs, nans })
    }

    /// Returns a complete file with one of the pictures that the command line names, of this view.
    pub fn complete(&self, view: &View, output: &Output, stop: &Stop) -> Result<CompleteFile, Answer> {
        let (file, layer) = (OutputFile::prepare(&output.file)?, output.layer);
        if let Layer::Cost(cost) = layer {
            let painted = self.paint(&View { cost: Some(cost), ..view.clone() }, stop)?;
            return Ok(file.picture(output.format, &painted.picture)?);
        }
        let size = view.request(layer).layer_size(&layer);
        let mut writer = file.begin(output.format, size, layer.content(), None)?;
        self.render(view, layer, stop, &mut |_, row| writer.row(row))?;
        Ok(writer.complete()?)
    }

    /// Renders a layer. Returns the prepared scene and the costs of the pixels, if they are the layer.
    fn render(
        &self,
        view: &View,
        layer: Layer,
        stop: &Stop,
        take_row: TakeRow,
    ) -> Result<(Arc<Ready>, Vec<u64>), Answer> {
        let request = view.request(layer);
        let ready = self.ready(view, request.tracing, view.options.visualize_grid, stop)?;
        let watch = |progress: Progress| stop.watch(progress);
        let rendered = ready.borrow_dependent().render_rows(&request, &watch, take_row)?;
        Ok((ready, rendered.costs))
    }

    /// Prepares the scene of a view, unless it is prepared already: to count the work, or to show the grid's cells.
    pub fn ready(
        &self,
        view: &View,
        tracing: Tracing,
        draws_cells: bool,
        stop: &Stop,
    ) -> Result<Arc<Ready>, Answer> {
        let (scene, structure) = (&view.scene, view.options.structure);
        let whole = Request { layers: vec![Layer::Color], tracing, draws_cells, ..view.options.request() };
        let rays = (structure == Structure::Grid(Resolution::Auto)).then(|| whole.camera_rays());
        let preparation = Preparation { scene: scene.revision, structure, tracing, draws_cells, rays };
        if let Some((_, ready)) = lock(&self.ready).iter().find(|(known, _)| *known == preparation) {
            return Ok(ready.clone());
        }
        if let Structure::Grid(Resolution::Cells(cells)) = structure {
            let world = scene.renderer.world();
            let references = most_references(world, &Lattice::new(bounds_of(world), cells));
            let is_own = scene.revision == 0 && structure == self.structure;
            if references > MAX_REFERENCES && !is_own {
                let reason = "-grid: these cells hold more than this page allows: choose fewer";
                return Err(Answer::text(422, reason));
            }
            memory::ask(references.saturating_mul(GRID_BYTES_PER_REFERENCE))?;
        }
        // Without the lock, so that others need not wait. Two requests may prepare the same.
        let ready =
            Arc::new(Ready::try_new(scene.clone(), |scene| scene.renderer.prepare_within(&whole, stop))?);
        let mut all = lock(&self.ready);
        all.push((preparation, ready.clone()));
        while all.len() > MAX_PREPARED || is_too_large(all.iter().map(|(_, ready)| ready.borrow_owner())) {
            all.remove(0);
        }
        Ok(ready)
    }
}
