//! The library's main interface. Open a scene once, prepare it once for each grid, and render it any number of times.

use crate::base::memory::with_room;
use crate::base::patience::{Endless, Patience};
use crate::camera::Camera;
use crate::caster::choose::{Layout, Rays, Structure};
use crate::caster::{Caster, Fullness, NotBuilt};
use crate::diagnostic::Diagnostic;
use crate::math::aabb::Aabb;
use crate::math::instructions;
use crate::picture::{BadSize, Color, FloatPicture};
use crate::render::grid_view::Occupancy;
use crate::render::{self, Rendered, Request, Stopped, TakeRow, Tracing, View, Watch};
use crate::sampling::sampler::Sampler;
use crate::scene::Scene;
use crate::scene::load::{self, LoadedScene, Source};
use crate::scene::mesh::Mesh;
use crate::scene::model::Shows;
use crate::stats::Counts;
use crate::world::World;
use glam::DVec2;
use std::ops::ControlFlow;
use std::path::Path;

/// A scene with its meshes, in world space.
#[derive(Debug)]
pub struct Renderer {
    /// The scene as parsed from its text.
    pub scene: Scene,
    /// The text of the scene, to show the position of an error in it.
    pub source: Source,
    world: World,
    /// The meshes, which are kept only for the view of the grid's cells, for the objects behind a pixel, and for other
    /// scenes with the same meshes.
    meshes: Vec<Mesh>,
}

/// Selects if a renderer keeps the meshes as they were read. The view of the grid's cells and the search for causes need
/// them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meshes {
    /// The meshes are moved into the world.
    Moved,
    /// The meshes are copied into the world, and kept.
    Kept,
}

impl Renderer {
    /// Reads the scene at `path` with its meshes, on rayon's current thread pool.
    pub fn open(path: &Path) -> Result<Self, Diagnostic> {
        Self::new(load::load(path)?, Meshes::Moved)
    }

    /// Returns a renderer of a scene that has been read. Fails if an object cannot be placed in world space.
    pub fn new(loaded: LoadedScene, kept: Meshes) -> Result<Self, Diagnostic> {
        Self::within(loaded, kept, &Endless)
    }

    /// Returns a renderer like [`Renderer::new`], as long as there is patience.
    pub(crate) fn within(
        loaded: LoadedScene,
        kept: Meshes,
        patience: &dyn Patience,
    ) -> Result<Self, Diagnostic> {
        let LoadedScene { scene, meshes, source, .. } = loaded;
        let world = match kept {
            Meshes::Moved => World::within(&scene, meshes, patience).map(|world| (world, vec![])),
            Meshes::Kept => World::copying(&scene, &meshes, patience).map(|world| (world, meshes)),
        };
        match world {
            Ok((world, meshes)) => Ok(Self { scene, source, world, meshes }),
            Err(error) => Err(source.locate(error)),
        }
    }

    /// Returns a renderer of another scene that names the same meshes in the same order. This renderer must have kept
    /// the meshes. The new one does not keep them. Fails also if the patience is over.
    pub(crate) fn with_scene(&self, scene: Scene, patience: &dyn Patience) -> Result<Self, Diagnostic> {
        let world = World::copying(&scene, &self.meshes, patience)?;
        Ok(Self { scene, source: self.source.clone(), world, meshes: vec![] })
    }

    /// Returns the meshes of the scene, or an empty list if they were not kept.
    pub fn meshes(&self) -> &[Mesh] {
        &self.meshes
    }

    /// Returns the scene in world space.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Returns the bounds of the finite primitives, or `None` if there are no such primitives.
    pub fn bounds(&self) -> Option<Aabb> {
        (!self.world.bounds.is_empty()).then_some(self.world.bounds)
    }

    /// Prepares the scene for a request: builds the structure that it asks for, or counts the primitives in each cell of
    /// the grid that is drawn in place of the scene. For the latter the renderer must have kept the scene's meshes. The
    /// result renders other requests, too.
    pub fn prepare(&self, request: &Request) -> Result<Prepared<'_>, NotBuilt> {
        self.prepare_within(request, self.rays(request), &Endless)
    }

    /// Prepares the scene like [`Renderer::prepare`], but for about this number of rays.
    pub fn prepare_for(&self, request: &Request, rays: Rays) -> Result<Prepared<'_>, NotBuilt> {
        self.prepare_within(request, rays, &Endless)
    }

    /// Returns the approximate number of rays of a request.
    pub(crate) fn rays(&self, request: &Request) -> Rays {
        let cast = request.cast_rays(&self.camera(request), &self.world);
        Rays { camera: request.camera_rays(), cast }
    }

    /// Prepares the scene for about this number of rays, as long as there is patience.
    pub(crate) fn prepare_within(
        &self,
        request: &Request,
        rays: Rays,
        patience: &dyn Patience,
    ) -> Result<Prepared<'_>, NotBuilt> {
        let Request { structure, tracing, .. } = *request;
        let draws_cells = request.draws_cells && matches!(structure, Structure::Grid(_));
        let layout = structure.layout(&self.world, rays, tracing == Tracing::Counted);
        let build = |layout| Caster::within(&self.world, layout, instructions::available()[0], patience);
        let caster = match build(if draws_cells { Layout::List } else { layout }) {
            Ok(caster) if structure == Structure::Any && tracing == Tracing::Fast => Ok(caster.replaceable()),
            // The user did not request the structure that does not fit into memory, so use a list instead.
            Err(_) if structure == Structure::Any => build(Layout::List),
            caster => caster,
        }?;
        let cells = layout.cells();
        let count = |cells| Occupancy::new(&self.scene, &self.meshes, self.world.bounds, cells, patience);
        let occupancy = cells.filter(|_| draws_cells).map(count).transpose()?;
        Ok(Prepared { renderer: self, caster, occupancy, cells })
    }

    /// Returns the camera of a request's pictures.
    pub(crate) fn camera(&self, request: &Request) -> Camera {
        let camera = request.camera.as_ref().unwrap_or(&self.scene.camera);
        Camera::with_screen(camera, request.size, self.scene.screen)
    }
}

/// A scene that is ready to be rendered.
#[derive(Debug)]
pub struct Prepared<'r> {
    renderer: &'r Renderer,
    caster: Caster<'r>,
    /// The cells that are drawn in place of the scene, if any.
    occupancy: Option<Occupancy>,
    cells: Option<[usize; 3]>,
}

impl Prepared<'_> {
    /// Returns the number of grid cells along each axis, or `None` without a grid.
    pub fn cells(&self) -> Option<[usize; 3]> {
        self.cells
    }

    /// Returns statistics of the primitives in the grid's cells, with up to `fullest` of the fullest cells. Returns
    /// `None` without a grid.
    pub fn fullness(&self, fullest: usize) -> Option<Fullness> {
        self.caster.fullness(fullest)
    }

    /// Renders the layers of a request into memory, in the order of the request. Fails if a picture has no pixels or
    /// does not fit into memory.
    pub fn render(&self, request: &Request) -> Result<Vec<FloatPicture>, BadSize> {
        let scene = (&self.camera(request), &self.caster);
        render::render_in_memory(scene, self.view(), request).map(|(pictures, _)| pictures)
    }

    /// Renders the only layer of a request into memory. Returns it, and the counts.
    pub(crate) fn render_layer(
        &self,
        request: &Request,
        watch: Watch,
    ) -> Result<(FloatPicture, Counts), Stopped> {
        let size = request.layers.first().map_or([0; 2], |layer| request.layer_size(layer));
        let mut colors = with_room(size.into_iter().product())?;
        let mut take_row = |_: usize, row: &[Color]| {
            colors.extend_from_slice(row);
            ControlFlow::Continue(())
        };
        let Rendered { counts, costs, .. } = self.render_rows(request, watch, &mut take_row)?;
        colors.extend(costs.iter().map(|&cost| Color::splat(cost as f64)));
        Ok((FloatPicture { size, colors }, counts))
    }

    /// Renders a request row by row, and returns the counts and the costs of the pixels. Rows are handed out from the top
    /// as soon as they are finished.
    pub fn render_rows(
        &self,
        request: &Request,
        watch: Watch,
        take_row: TakeRow,
    ) -> Result<Rendered, Stopped> {
        render::render((&self.camera(request), &self.caster), self.view(), request, watch, take_row)
    }

    /// Renders the colours of these rows of a request's window, counted from the top, with each of these samplers, which
    /// are not adaptive. Does not count.
    pub(crate) fn render_some_rows(
        &self,
        request: &Request,
        samplers: &[Sampler],
        rows: &[usize],
    ) -> Result<Vec<Vec<Color>>, Stopped> {
        let scene = (&self.camera(request), &self.caster);
        render::render_some_rows(scene, self.view(), request, samplers, rows)
    }

    /// Returns the number of grid cells along each axis if they are drawn in place of the scene.
    pub fn drawn_cells(&self) -> Option<[usize; 3]> {
        self.occupancy.as_ref().and(self.cells)
    }

    /// Returns the renderer that prepared it.
    pub fn renderer(&self) -> &Renderer {
        self.renderer
    }

    /// Returns the caster, which finds the hits of rays.
    pub(crate) fn caster(&self) -> &Caster<'_> {
        &self.caster
    }

    /// Returns the camera of a request's pictures.
    pub(crate) fn camera(&self, request: &Request) -> Camera {
        self.renderer.camera(request)
    }

    /// Returns the samples of the pixel in this column and row from the bottom left: their offsets from its centre,
    /// and the parts of the pixel that they represent, up to a factor. Returns an empty list if the watch cancels.
    pub(crate) fn samples(&self, request: &Request, pixel: [usize; 2], watch: Watch) -> Vec<(DVec2, f64)> {
        let scene = (&self.camera(request), &self.caster);
        let offsets = render::offsets(scene, self.view(), request, pixel, watch);
        // Adaptive samples of pixels that contribute to each other represent parts of their pixels.
        let is_alone = request.adaptive.is_none() || request.filter.support() == 0;
        let part = if is_alone { 1.0 } else { 1.0 / offsets.len() as f64 };
        offsets.into_iter().map(|offset| (offset, part)).collect()
    }

    fn view(&self) -> View<'_> {
        match (&self.occupancy, self.renderer.scene.shows) {
            (Some(occupancy), _) => View::Cells(occupancy),
            (None, Shows::Scene) => View::Scene,
            (None, Shows::Places) => View::Places,
        }
    }
}
