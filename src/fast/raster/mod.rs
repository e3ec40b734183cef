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
#[cfg(test)]
mod tests;
#[cfg(test)]
mod worst_cases;

use crate::base::memory;
use crate::base::shortcut::Shortcut;
use crate::camera::{Camera, Eye, Projection, TURN_ROUNDINGS};
use crate::caster::Caster;
use crate::caster::bounds::widened;
use crate::math::aabb::Aabb;
use crate::math::ray::{Ray, Visible};
use crate::trace::FirstHit;
use crate::world::{Primitive, World};
use bins::Bins;
use edge_functions::{EDGE_ROUNDINGS, EdgeFunctions, ErrorBound, InvDepthPlane};
use flat_triangle::Projected;
use glam::{DVec2, DVec3};
use parallel_view::ParallelView;
use rayon::prelude::*;
use std::ops::Range;
use triangle_bounds::{ScreenVertex, TriangleBounds};

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

/// Upper bound on the average number of pixel tests for each ray that need not be cast.
const PIXELS_PER_RAY: usize = 16;

impl VisibilityBuffer {
    /// Returns the first hits of the rays of this footprint in these rows, as far as triangles and planes determine
    /// them. Returns `None` if casting the rays is cheaper, if the view is not suitable, or if there is too little
    /// memory.
    pub fn new(
        camera: &Camera,
        caster: &Caster,
        size: [usize; 2],
        rows: Range<usize>,
        footprint: Footprint,
    ) -> Option<Self> {
        let (world, width) = (caster.world, size[0]);
        let pixels = width * rows.len();
        // According to measurements, casting a ray costs as much as rasterizing 3/4 of a triangle if there is a grid,
        // and otherwise as much as rasterizing 1/64 of all triangles.
        let count = world.triangles.len();
        let max_triangles =
            if caster.is_selective() { pixels / 4 * 3 } else { pixels.saturating_mul((count / 64).max(1)) };
        if !Self::suits(camera, world, size) || count > max_triangles {
            return None;
        }
        let same_place = world.coincidence_reach_by_t();
        let visible_ids = match camera.projection() {
            Projection::Perspective(eye) => {
                let viewport = Viewport::new(eye, world.bounds, size, rows.clone(), footprint, same_place)?;
                drawn_from_eye(&viewport, world)?
            }
            Projection::Orthographic(eye) => {
                let view = ParallelView::new(eye, &world.bounds, width, footprint, same_place)?;
                drawn_in_parallel(&view, world, &rows)?
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

    /// Returns the number of unsure pixels in these columns of all rows, whose rays must be cast.
    pub fn unsure(&self, columns: Range<usize>) -> usize {
        let rows = self.visible_ids.chunks_exact(self.stride);
        rows.map(|row| row[columns.clone()].iter().filter(|&&id| id == UNSURE).count()).sum()
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

/// Returns the ids that the pixels show to rays from an eye, or `None` as in [`VisibilityBuffer::new`].
fn drawn_from_eye(viewport: &Viewport, world: &World) -> Option<Vec<u32>> {
    memory::ask(bytes_for::<ScreenVertex>(world, viewport.rows.len() * viewport.screen.stride())).ok()?;
    let vertices: Vec<_> = world.vertices.par_iter().map(|&v| ScreenVertex::of(v, viewport)).collect();
    let bounds_of =
        |id: u32| world.may_be_hit(id).then(|| TriangleBounds::new(viewport, world, &vertices, id)).flatten();
    let bins = Bins::new(&viewport.rows, world.triangles.len(), bounds_of);
    let planes = world.planes.iter().map(|plane| InvDepthPlane::of_plane(viewport, plane));
    let of_box = |bounds: &Aabb| TriangleBounds::of_box(viewport, bounds);
    let others = Others { planes: planes.collect(), boxes: boxes(world, of_box) };
    let edge_functions = |id: u32| EdgeFunctions::new(viewport, world.corners(id as usize));
    drawn(&bins, viewport.screen, &others, world, edge_functions)
}

/// Returns the ids that the pixels show to parallel rays, or `None` as in [`VisibilityBuffer::new`].
fn drawn_in_parallel(view: &ParallelView, world: &World, rows: &Range<usize>) -> Option<Vec<u32>> {
    memory::ask(bytes_for::<Projected>(world, rows.len() * view.screen.stride())).ok()?;
    let vertices: Vec<_> = world.vertices.par_iter().map(|&vertex| view.project(vertex)).collect();
    let corners = |id: u32| world.triangles[id as usize].map(|vertex| vertices[vertex as usize]);
    let bounds_of = |id: u32| {
        let on_screen = || corners(id).map(|corner| corner.on(&view.screen));
        world.may_be_hit(id).then(|| TriangleBounds::ahead(&view.screen, rows, on_screen(), id)).flatten()
    };
    let bins = Bins::new(rows, world.triangles.len(), bounds_of);
    let planes = world.planes.iter().map(|plane| view.plane(plane));
    let of_box = |bounds: &Aabb| {
        let corners = bounds.corners().map(|corner| view.project(corner).on(&view.screen));
        TriangleBounds::of_box_ahead(&view.screen, rows, corners)
    };
    let others = Others { planes: planes.collect(), boxes: boxes(world, of_box) };
    let edge_functions = |id: u32| flat_triangle::edge_functions(corners(id), view.screen_error);
    drawn(&bins, view.screen, &others, world, edge_functions)
}

/// The primitives other than triangles.
struct Others {
    planes: Vec<InvDepthPlane>,
    /// The boxes of the visible spheres and ellipsoids.
    boxes: Vec<TriangleBounds>,
}

/// Returns the bounds of spheres and ellipsoids on the screen.
fn boxes(world: &World, of_box: impl Fn(&Aabb) -> Option<TriangleBounds>) -> Vec<TriangleBounds> {
    world.boxes().filter_map(|bounds| of_box(&widened(bounds))).collect()
}

/// Returns the memory in bytes of the world's vertices on the screen, of the bounds of its triangles, and of this
/// number of pixels.
fn bytes_for<Vertex>(world: &World, pixels: usize) -> u64 {
    let bytes = world.vertices.len() * size_of::<Vertex>()
        + world.triangles.len() * size_of::<TriangleBounds>()
        + pixels * size_of::<u32>();
    bytes as u64
}

/// Returns the ids that the pixels show after all primitives are drawn, or `None` if that takes too many pixel tests.
fn drawn(
    bins: &Bins,
    screen: Screen,
    Others { planes, boxes }: &Others,
    world: &World,
    edge_functions: impl Fn(u32) -> Option<EdgeFunctions> + Sync,
) -> Option<Vec<u32>> {
    let marked = boxes.iter().map(TriangleBounds::pixels).sum::<usize>();
    if bins.pixels().saturating_add(marked) > PIXELS_PER_RAY * screen.width * bins.rows().len() {
        return None;
    }
    Some(bins.draw(screen, edge_functions, |tile| {
        planes.iter().zip(world.first_plane()..).for_each(|(plane, id)| tile.fill(plane, id));
        for TriangleBounds { columns, rows, max_inv_depth, .. } in boxes {
            tile.mark_unsure(columns.range(), rows.range(), *max_inv_depth);
        }
    }))
}

/// The factor of the `max_direction_length` of a turned eye. All error bounds are at least proportional to this
/// length. For an edge function, the factor adds exactly the further roundings of a direction. It adds more than these
/// for the depths of triangles, which have 47.5 roundings and to which the roundings of a direction apply 2.6 times,
/// and for the depths of planes, which have 19 roundings.
const TURNED: f64 = 1.0 + TURN_ROUNDINGS / EDGE_ROUNDINGS;

/// The projection onto the rows that are drawn.
///
/// The direction of a pixel's ray is d + x h + y v, where x and y are in pixels from the eye's `middle`.
struct Viewport {
    eye: Eye,
    /// A power of two that scales all finite primitives to within a distance of 1 from the eye.
    scale: f64,
    /// The vectors whose dot products with a point at depth 1 are the point's x and y.
    axes: [DVec3; 2],
    /// Upper bound on the distance of the outermost pixel centres from the eye's `middle` along each axis, in pixels.
    far: DVec2,
    /// Upper bound on |d| + |x h| + |y v|, times [`TURNED`] if the eye is turned.
    max_direction_length: f64,
    screen: Screen,
    rows: Range<usize>,
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

impl Viewport {
    /// Returns `None` if numbers are too large or too small for the error bounds, or if the view is so narrow or so
    /// skewed that the error of a projected vertex may exceed a small fraction of a pixel. The last parameter is
    /// [`World::coincidence_reach_by_t`].
    fn new(
        eye: Eye,
        bounds: Aabb,
        size: [usize; 2],
        rows: Range<usize>,
        footprint: Footprint,
        [margin, per_t]: [f64; 2],
    ) -> Option<Self> {
        let distance = |corner: DVec3| (corner - eye.center).length();
        let farthest = bounds.corners().map(distance).into_iter().fold(0.0, f64::max);
        let scale = libm::ldexp(1.0, -libm::frexp(farthest).1);
        let axes = [eye.right, eye.up].map(|axis| axis / axis.length_squared());
        let [width, height] = size;
        let last = DVec2::new(width as f64, height as f64) - 1.0;
        // The `middle` of a turned eye is not exact.
        let clearance = if eye.is_turned { 1.0 } else { 0.0 };
        let far = eye.middle.abs().max((last - eye.middle).abs()) + clearance;
        let (across, along) = ((far.x + 0.5) * eye.right.length(), (far.y + 0.5) * eye.up.length());
        let allowed = if eye.is_turned { TURNED } else { 1.0 };
        let max_direction_length = allowed * (eye.direction.length() + across + along);
        let screen_error = triangle_bounds::screen_error_bound(&eye, axes, max_direction_length);
        let is_usual = (1e-60..1e60).contains(&scale)
            && max_direction_length < 1e12
            && screen_error < triangle_bounds::MAX_SCREEN_ERROR;
        // With n = 1 / t, a difference of e in t is a difference of less than e n^2 in n. The directions of rays are
        // no shorter than 1.
        let same_place = ErrorBound([0.0, per_t, margin * scale]);
        let screen = Screen { middle: eye.middle, width, reach: footprint.reach(), nothing: 0.0, same_place };
        is_usual.then_some(Self { eye, scale, axes, far, max_direction_length, screen, rows })
    }

    /// Returns a point relative to the eye, scaled.
    fn eye_space(&self, point: DVec3) -> DVec3 {
        (point - self.eye.center) * self.scale
    }

    /// Returns the dot product of `normal` and a pixel's ray direction, as a function of the pixel.
    fn affine(&self, normal: DVec3) -> Affine {
        let Eye { direction, right, up, .. } = self.eye;
        Affine { constant: normal.dot(direction), per_x: normal.dot(right), per_y: normal.dot(up) }
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
