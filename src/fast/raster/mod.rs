//! Primary visibility by rasterization. The triangles and planes are projected onto the pixels. Spheres and ellipsoids
//! are not drawn: the rays through the pixels of their boxes are cast, unless something is certainly nearer.
//!
//! If all camera rays start at one eye or are parallel, and one of them goes through each pixel's centre, it is much
//! cheaper to find the pixels of each triangle than the triangle of each pixel. The result for a pixel is the same as
//! if its ray were cast. If rounding errors make it uncertain, the ray must be cast. `proofs/raster_*.g` prove the
//! error bounds for the rays of an eye. `parallel_view` and `flat_triangle` derive the error bounds for parallel rays.
//!
//! If rays go through other points of the pixels, the variation of a function within the pixel is added to its error
//! bound. So a pixel is certain if all rays through it hit the same primitive first. Most pixels away from edges are
//! certain.

mod bins;
mod edge_functions;
mod flat_triangle;
mod light_view;
mod parallel_view;
mod shadow_map;
mod tile;
mod triangle_bounds;
mod viewport;
#[cfg(test)]
mod tests;

use crate::base::memory;
use crate::base::patience::Patience;
use crate::base::shortcut::Shortcut;
use crate::camera::{Camera, Projection};
use crate::caster::Caster;
use crate::caster::bounds::widened;
use crate::math::aabb::Aabb;
use crate::math::ray::{Ray, Visible};
use crate::trace::FirstHit;
use crate::world::plane::Plane;
use crate::world::{Primitive, World};
use bins::Bins;
use edge_functions::{EdgeFunctions, ErrorBound, InvDepthPlane};
use glam::{DVec2, DVec3};
use parallel_view::ParallelView;
use rayon::prelude::*;
use std::ops::Range;
use triangle_bounds::{ScreenVertex, TriangleBounds};
use viewport::Viewport;

pub use shadow_map::ShadowMaps;

/// The rays through a pixel for which a buffer holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Footprint {
    /// The ray through its centre.
    Center,
    /// The rays through any of its points.
    Pixel,
}

impl Footprint {
    /// Returns the largest distance between its rays and the pixel's centre along an axis, in pixels. Half a pixel
    /// gets a margin for the rounding of a sample's position.
    fn reach(self) -> f64 {
        match self {
            Self::Center => 0.0,
            Self::Pixel => 0.5 + 1.0 / 1024.0,
        }
    }
}

/// The first hits of the rays through some rows of pixels.
#[derive(Debug)]
pub struct VisibilityBuffer {
    /// The number of elements from one row to the next.
    stride: usize,
    first_row: usize,
    /// The id of the visible primitive in each pixel, or [`NOTHING`] or [`UNSURE`].
    visible_ids: Vec<u32>,
}

/// The id of a pixel in which nothing is visible.
const NOTHING: u32 = u32::MAX;
/// The id of a pixel whose ray must be cast.
const UNSURE: u32 = u32::MAX - 1;

/// The number of rows of pixels in a tile, which one thread draws. A tile fits into the thread's cache.
const TILE_ROWS: usize = 32;

/// The number of planes in a tile between two questions whether the work should end.
const PLANES_AT_ONCE: u32 = 16;

/// Upper bound on the average number of pixel tests for each ray that need not be cast.
const PIXELS_PER_RAY: usize = 16;

impl VisibilityBuffer {
    /// Returns the first hits of the rays of this footprint in these rows, as far as triangles and planes determine
    /// them. Returns `None` if casting the rays is cheaper, if the view is not suitable, if there is too little memory,
    /// or if the patience of the caster is over.
    pub fn new(
        camera: &Camera,
        caster: &Caster,
        size: [usize; 2],
        rows: Range<usize>,
        footprint: Footprint,
    ) -> Option<Self> {
        let (world, width) = (caster.world, size[0]);
        let pixels = width * rows.len();
        // According to measurements, casting a ray costs as much as rasterizing 3/4 of a triangle if the caster is
        // selective, and otherwise as much as rasterizing 1/64 of all triangles. A tree that is not built is a list here,
        // since building it costs as much as rasterizing some times.
        let count = world.triangles.len();
        let max_triangles =
            if caster.is_selective() { pixels / 4 * 3 } else { pixels.saturating_mul((count / 64).max(1)) };
        if !Self::suits(camera, world, size) || count > max_triangles {
            return None;
        }
        memory::ask(bytes_to_draw(world, rows.len() * (width + tile::LANES))).ok()?;
        let (same_place, most_tests) = (world.coincidence_reach_by_t(), PIXELS_PER_RAY * pixels);
        let visible_ids = match camera.projection() {
            Projection::Perspective(eye) => {
                let view = Viewport::new(eye, world.bounds, size, footprint, same_place)?;
                drawn(&view, &rows, world, most_tests, caster)?
            }
            Projection::Orthographic(eye) => {
                let view = ParallelView::new(eye, &world.bounds, width, footprint, same_place)?;
                drawn(&view, &rows, world, most_tests, caster)?
            }
        };
        Some(Self { stride: width + tile::LANES, first_row: rows.start, visible_ids })
    }

    /// Returns true if rasterization suits the camera and the world. The finite primitives must not be only spheres
    /// and ellipsoids.
    pub fn suits(camera: &Camera, world: &World, [width, height]: [usize; 2]) -> bool {
        let is_large = width.max(height) > triangle_bounds::MAX_PIXELS;
        let is_accurate = match camera.projection() {
            Projection::Perspective(_) => true,
            Projection::Orthographic(eye) => {
                let same_place = world.coincidence_reach_by_t();
                ParallelView::new(eye, &world.bounds, width, Footprint::Pixel, same_place).is_some()
            }
        };
        let is_drawn = !world.triangles.is_empty() || world.finite_count() == 0;
        Shortcut::FirstHits.is_taken() && is_drawn && !is_large && is_accurate
    }

    /// Returns true if the rays through some pixels must be cast.
    pub fn is_incomplete(&self) -> bool {
        self.visible_ids.contains(&UNSURE)
    }

    /// Returns the first hit of `ray`, which goes through the pixel in column `i` of row `j`.
    #[inline(always)]
    pub fn first_hit(&self, world: &World, ray: &Ray, [i, j]: [usize; 2]) -> FirstHit {
        let primitive = self.visible_ids[(j - self.first_row) * self.stride + i];
        match primitive {
            NOTHING => FirstHit::Nothing,
            UNSURE => FirstHit::Unknown,
            _ => match world.primitive(primitive) {
                Primitive::Plane(k) => match world.planes[k].intersect(ray) {
                    Some(t) => FirstHit::Primitive(Visible { primitive, t_bound: t }),
                    None => FirstHit::Unknown,
                },
                _ => FirstHit::Primitive(Visible { primitive, t_bound: f64::INFINITY }),
            },
        }
    }
}

/// A projection of the world to a screen.
trait ScreenProjection: Sync {
    /// Returns the pixels.
    fn screen(&self) -> Screen;

    /// Returns the inverse depth of a plane as a function of the pixel, or `None` if planes are not drawn.
    fn plane(&self, _plane: &Plane) -> Option<InvDepthPlane> {
        None
    }

    /// Projects a point.
    fn vertex(&self, point: DVec3) -> ScreenVertex;

    /// Returns true if points certainly lie beyond one side of the screen. This is only asked if they are not all
    /// ahead.
    fn are_outside<const N: usize>(&self, _points: [DVec3; N]) -> bool {
        false
    }

    /// Returns the edge functions of the triangle with these corners, or `None` if it may be seen edge on.
    fn edge_functions(&self, corners: [DVec3; 3]) -> Option<EdgeFunctions>;
}

/// Returns the memory in bytes of the world's vertices on the screen, of the bounds of its triangles, and of this
/// number of pixels.
fn bytes_to_draw(world: &World, pixels: usize) -> u64 {
    let bytes = world.vertices.len() * size_of::<ScreenVertex>()
        + world.triangles.len() * size_of::<TriangleBounds>()
        + pixels * size_of::<u32>();
    bytes as u64
}

/// Draws the primitives of a world into these rows of a screen. Returns the ids that the pixels show, or `None` if that
/// takes more than `most_tests` pixel tests, or if the patience is over. The pixels in the boxes of spheres and
/// ellipsoids are unsure, unless something is certainly nearer.
fn drawn(
    view: &impl ScreenProjection,
    rows: &Range<usize>,
    world: &World,
    most_tests: usize,
    patience: &dyn Patience,
) -> Option<Vec<u32>> {
    let screen = view.screen();
    let vertices: Vec<_> = world.vertices.par_iter().map(|&vertex| view.vertex(vertex)).collect();
    let bins = Bins::new(rows, world.triangles.len(), |id| {
        let on_screen = world.triangles[id as usize].map(|vertex| vertices[vertex as usize]);
        let corners = || world.corners(id as usize);
        let bounds = || TriangleBounds::new(view, &screen, rows, on_screen, corners, id);
        Some((world.may_be_seen(id).then(bounds)??, triangle_bounds::is_front(on_screen)))
    });
    let of_box = |bounds: Aabb| {
        let corners = widened(bounds).corners();
        let on_screen = corners.map(|corner| view.vertex(corner));
        TriangleBounds::new(view, &screen, rows, on_screen, || corners, UNSURE)
    };
    let boxes: Vec<_> = world.boxes().filter_map(of_box).collect();
    let marked = boxes.iter().map(TriangleBounds::pixels).sum::<usize>();
    if bins.pixels().saturating_add(marked) > most_tests {
        return None;
    }
    let planes: Vec<_> = world.planes.iter().map(|plane| view.plane(plane)).collect();
    let edge_functions = |id: u32| view.edge_functions(world.corners(id as usize));
    let ids = bins.draw(screen, edge_functions, |tile| {
        for (plane, id) in planes.iter().zip(world.first_plane()..) {
            if id.is_multiple_of(PLANES_AT_ONCE) && patience.is_over() {
                break;
            }
            if let Some(plane) = plane {
                tile.fill(plane, id);
            }
        }
        for TriangleBounds { columns, rows, max_inv_depth, .. } in &boxes {
            tile.mark_unsure(columns.range(), rows.range(), *max_inv_depth);
        }
    });
    (!patience.is_over()).then_some(ids)
}

/// The pixels on which primitives are drawn.
#[derive(Clone, Copy)]
struct Screen {
    /// The middle in pixels, relative to the centre of the lower left pixel.
    middle: DVec2,
    width: usize,
    /// The largest distance between rays and the centres of their pixels along an axis, in pixels.
    reach: f64,
    /// The inverse depth of a pixel that shows nothing. No visible primitive has a smaller one.
    nothing: f32,
    /// The largest difference between the inverse depths of two hits that count as one place. There the primitives,
    /// not the depths, decide which one is visible.
    same_place: ErrorBound,
}

impl Screen {
    /// Returns the number of elements from one row of a buffer to the next.
    fn stride(&self) -> usize {
        self.width + tile::LANES
    }
}

/// An affine function of a pixel's x and y.
#[derive(Clone, Copy)]
struct Affine {
    constant: f64,
    per_x: f64,
    per_y: f64,
}

impl Affine {
    fn at(self, x: f64, y: f64) -> f64 {
        self.constant + self.per_x * x + self.per_y * y
    }

    /// Returns the largest change of the value if both coordinates change by up to `reach`.
    fn variation(self, reach: f64) -> f64 {
        reach * (self.per_x.abs() + self.per_y.abs())
    }

    fn plus(self, other: Self) -> Self {
        Self {
            constant: self.constant + other.constant,
            per_x: self.per_x + other.per_x,
            per_y: self.per_y + other.per_y,
        }
    }

    fn scaled(self, factor: f64) -> Self {
        Self { constant: factor * self.constant, per_x: factor * self.per_x, per_y: factor * self.per_y }
    }
}
