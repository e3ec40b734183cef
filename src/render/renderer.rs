//! The library's main interface. Open a scene once, prepare it once for each structure, and render it any number of
//! times.

use crate::base::patience::{Endless, Patience};
use crate::camera::Camera;
use crate::caster::choose::Structure;
use crate::caster::{Caster, Fullness, LazyCaster, NotBuilt};
use crate::diagnostic::Diagnostic;
use crate::math::aabb::Aabb;
use crate::picture::{Color, FloatPicture};
use crate::render::grid_view::Occupancy;
use crate::render::{self, Rendered, Request, Shot, Stopped, TakeRow, Tracing, View, Watch};
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

/// Says whether a renderer keeps the meshes as they were read. The view of the grid's cells and the search for causes need
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

    /// Prepares the scene for a request, with the structure that it asks for, or with the counts of primitives in the
    /// cells that are drawn in place of the scene. For the latter the renderer must have kept the scene's meshes. The
    /// result renders other requests, too. Steps are counted in a grid only if this request counts.
    pub fn prepare(&self, request: &Request) -> Result<Prepared<'_>, NotBuilt> {
        self.prepare_within(request, &Endless)
    }

    /// Prepares the scene like [`Renderer::prepare`], as long as there is patience.
    pub(crate) fn prepare_within(
        &self,
        request: &Request,
        patience: &dyn Patience,
    ) -> Result<Prepared<'_>, NotBuilt> {
        let Request { structure, tracing, .. } = *request;
        let layout = structure.layout(&self.world, request.camera_rays());
        let cells = layout.cells();
        let draws_cells = request.draws_cells && cells.is_some();
        let count = |cells| Occupancy::new(&self.scene, &self.meshes, self.world.bounds, cells, patience);
        let occupancy = cells.filter(|_| draws_cells).map(count).transpose()?;
        let mut planes = Caster::of_planes(&self.world);
        if let (Some(cells), Tracing::Counted) = (cells, tracing) {
            planes = planes.counting(cells, patience)?;
        }
        // If cells are drawn, rays only measure other layers, in whatever structure is fastest.
        let layout = if draws_cells { Structure::Any.layout(&self.world, 0) } else { layout };
        let caster = LazyCaster::new(planes, layout);
        // Built now, so that it counts as building, and an error comes before outputs are opened. A structure of our own
        // choice may never be needed.
        if !draws_cells && (structure != Structure::Any || tracing == Tracing::Counted) {
            caster.built(patience)?;
        }
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
    caster: LazyCaster<'r>,
    /// The cells that are drawn in place of the scene, if any.
    occupancy: Option<Occupancy>,
    cells: Option<[usize; 3]>,
}

impl Prepared<'_> {
    /// Returns the number of grid cells along each axis, or `None` without a grid.
    pub fn cells(&self) -> Option<[usize; 3]> {
        self.cells
    }

    /// Returns how full the cells of the grid are, with up to this number of the fullest; `None` without a grid, or if
    /// steps are not counted.
    pub fn fullness(&self, fullest: usize) -> Option<Fullness> {
        self.caster.fullness(fullest)
    }

    /// Returns the caster, which searches as long as there is patience. Its structure is built when it is needed first.
    pub(crate) fn caster<'a>(&'a self, patience: &'a dyn Patience) -> Result<Caster<'a>, NotBuilt> {
        self.caster.built(patience)
    }

    /// Returns the scene in world space.
    pub fn world(&self) -> &World {
        &self.renderer.world
    }

    /// Renders the layers of a request into memory, in the order of the request.
    pub fn render(&self, request: &Request) -> Result<Vec<FloatPicture>, Stopped> {
        Ok(self.render_watched(request, &|_| ControlFlow::Continue(()))?.0)
    }

    /// Renders like [`Prepared::render`], as long as the watch continues. Returns the counts, too.
    pub(crate) fn render_watched(
        &self,
        request: &Request,
        watch: Watch,
    ) -> Result<(Vec<FloatPicture>, Counts), Stopped> {
        render::render_in_memory(&self.shot(request), request, watch)
    }

    /// Renders a request row by row, and returns the counts and the costs of the pixels. Rows are handed out from the top
    /// as soon as they are finished.
    pub fn render_rows(
        &self,
        request: &Request,
        watch: Watch,
        take_row: TakeRow,
    ) -> Result<Rendered, Stopped> {
        render::render(&self.shot(request), request, watch, take_row)
    }

    /// Renders the colours of these rows of a request's window, counted from the top, with each of these samplers, which
    /// are not adaptive. Does not count.
    pub(crate) fn render_some_rows(
        &self,
        request: &Request,
        samplers: &[Sampler],
        rows: &[usize],
    ) -> Result<Vec<Vec<Color>>, Stopped> {
        render::render_some_rows(&self.shot(request), request, samplers, rows)
    }

    /// Returns the number of grid cells along each axis if they are drawn in place of the scene.
    pub fn drawn_cells(&self) -> Option<[usize; 3]> {
        self.occupancy.as_ref().and(self.cells)
    }

    /// Returns the renderer that prepared it.
    pub fn renderer(&self) -> &Renderer {
        self.renderer
    }

    /// Returns the camera of a request's pictures.
    pub(crate) fn camera(&self, request: &Request) -> Camera {
        self.renderer.camera(request)
    }

    /// Returns the samples of the pixel in this column and row from the bottom left: their offsets from its centre,
    /// and the parts of the pixel that they represent, up to a factor. Returns an empty list if the watch cancels.
    pub(crate) fn samples(&self, request: &Request, pixel: [usize; 2], watch: Watch) -> Vec<(DVec2, f64)> {
        let offsets = render::offsets(&self.shot(request), request, pixel, watch);
        // Adaptive samples of pixels that contribute to each other represent parts of their pixels.
        let is_alone = request.adaptive.is_none() || request.filter.support() == 0;
        let part = if is_alone { 1.0 } else { 1.0 / offsets.len() as f64 };
        offsets.into_iter().map(|offset| (offset, part)).collect()
    }

    /// Returns the scene as a request shows it.
    fn shot(&self, request: &Request) -> Shot<'_> {
        let view = match (&self.occupancy, self.renderer.scene.shows) {
            (Some(occupancy), _) => View::Cells(occupancy),
            (None, Shows::Scene) => View::Scene,
            (None, Shows::Places) => View::Places,
        };
        Shot { camera: self.camera(request), caster: &self.caster, view }
    }
}
