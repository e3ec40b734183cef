//! Shadow maps (Williams, "Casting Curved Shadows on Curved Surfaces", SIGGRAPH 1978): what stands between a light and
//! any point of the world, as far as rasterization tells.
//!
//! The triangles are drawn as the light sees them, as on whole pixels of a picture: a pixel is certain if nothing is in
//! it, or if one triangle covers it and is the nearest of all of them. A ray to the light from a point in the pixel then
//! hits nothing, or that triangle or nothing. All other rays have to be cast, among them those near spheres. So shadows
//! are as exact as without maps.
//!
//! *Error bounds.* A vertex is off by at most e = [`SCREEN_ERROR`] along each axis. For vertices a and b and a point q, the
//! edge function (a - q) x (b - q) is then off by at most 1.42 e (|a - q| + |b - q|) + 2 e^2. The interpolated nearness
//! of a point within the triangle is off by at most the change that moving a vertex makes: e for each axis times the
//! slope. The roundings of both are far smaller if the triangle's area exceeds the error of an edge function.

use super::Affine;
use super::bins::Bins;
use super::edge_functions::{EdgeFunctions, ErrorBound, InvDepthPlane};
use super::light_view::{LightView, Place, Projected, SCREEN_ERROR};
use super::tile::{self, Tile};
use super::triangle_bounds::{ScreenVertex, Span, TriangleBounds};
use super::{NOTHING, UNSURE};
use crate::math::aabb::Aabb;
use crate::memory::{self, NoMemory};
use crate::scene::Light;
use crate::world::World;
use glam::DVec3;
use rayon::prelude::*;

/// What a ray from a point to a light may hit, other than planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blocker {
    /// No finite primitive.
    Nothing,
    /// This triangle or nothing.
    Only(u32),
    /// Anything.
    Any,
}

/// The shadow map of one light.
#[derive(Debug)]
struct ShadowMap {
    view: LightView,
    /// For each pixel the id of the triangle that is the nearest to the light, or [`NOTHING`] or [`UNSURE`].
    nearest_ids: Vec<u32>,
}

/// The shadow maps of a world's lights.
#[derive(Debug, Default)]
pub struct ShadowMaps(Vec<Option<ShadowMap>>);

/// The number of pixels along a side: so few that a map stays in the cache.
const SIZE: usize = 256;

/// There are at least so many rays to a light for each triangle, and one for each pixel, or there are no maps. According
/// to measurements they take more time than they save otherwise.
const RAYS_PER_TRIANGLE: usize = 64;

impl ShadowMaps {
    /// Maps for so many rays to each light. There is none for a light that is too close to the primitives, or where there
    /// is no memory for it, or where casting the rays is less work.
    pub fn new(world: &World, rays: usize) -> Self {
        // The light side of spheres is unsure.
        let has_flat_surfaces = !world.triangles.is_empty() || !world.planes.is_empty();
        let pays = rays >= SIZE * SIZE && rays / RAYS_PER_TRIANGLE >= world.triangles.len();
        if world.finite_count() == 0 || !has_flat_surfaces || !pays {
            return Self::default();
        }
        Self(world.lights.par_iter().map(|light| ShadowMap::new(world, light)).collect())
    }

    /// What a ray from a point to the light with this index may hit.
    #[inline(always)]
    pub fn blocker(&self, light: usize, point: DVec3) -> Blocker {
        match self.0.get(light) {
            Some(Some(map)) => map.blocker(point),
            _ => Blocker::Any,
        }
    }
}

impl ShadowMap {
    fn new(world: &World, light: &Light) -> Option<Self> {
        let mut boxes = memory::with_room(world.finite_count() - world.triangles.len()).ok()?;
        boxes.extend(world.boxes());
        let bounds = Aabb::around(boxes.iter().flat_map(Aabb::corners).chain(world.vertices.iter().copied()));
        let view = LightView::new(light, &bounds, SIZE)?;
        Some(Self { view, nearest_ids: draw(&view, world, &boxes).ok()? })
    }

    #[inline(always)]
    fn blocker(&self, point: DVec3) -> Blocker {
        match self.view.pixel(point) {
            Place::Outside => Blocker::Nothing,
            Place::Unknown => Blocker::Any,
            Place::Pixel([i, j]) => match self.nearest_ids[j * (SIZE + tile::LANES) + i] {
                NOTHING => Blocker::Nothing,
                UNSURE => Blocker::Any,
                id => Blocker::Only(id),
            },
        }
    }
}

/// Draws the triangles, and marks the pixels that may show something in these boxes.
fn draw(view: &LightView, world: &World, boxes: &[Aabb]) -> Result<Vec<u32>, NoMemory> {
    let (screen, rows) = (view.screen(), 0..SIZE);
    let mut vertices: Vec<Projected> = memory::with_room(world.vertices.len())?;
    world.vertices.par_iter().map(|&vertex| view.project(vertex)).collect_into_vec(&mut vertices);
    let on_screen = |point: Projected| ScreenVertex::at(point.at + screen.middle, point.nearness);
    let corners = |id: u32| world.triangles[id as usize].map(|vertex| vertices[vertex as usize]);
    let bins = Bins::new(&rows, world.triangles.len(), |id| {
        TriangleBounds::ahead(&screen, &rows, corners(id).map(on_screen), id)
    })?;
    let spans = boxes.iter().map(|bounds| {
        let corners = bounds.corners().map(|corner| on_screen(view.project(corner)));
        [0, 1].map(|axis| Span::around(corners, axis, &rows, screen.reach))
    });
    let spans = memory::collected(spans)?;
    let mark = |tile: &mut Tile| {
        spans.iter().for_each(|[columns, rows]| tile.mark_unsure(columns.range(), rows.range()));
    };
    bins.draw(screen, |id| edge_functions(corners(id)), mark)
}

/// The edge functions of a triangle and its nearness in place of the inverse depth; none where it may be seen edge on.
fn edge_functions(corners: [Projected; 3]) -> Option<EdgeFunctions> {
    let [a, b, c] = corners.map(|corner| corner.at);
    let area = (b - a).perp_dot(c - a);
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    let edge_error_bound = 8.0 * SCREEN_ERROR * (longest + 2.0);
    if area.abs() <= 2.0 * edge_error_bound {
        return None;
    }
    let edges = [(b, c), (c, a), (a, b)].map(|(p, q)| {
        let along = area.signum() * (q - p);
        Affine { constant: along.y * p.x - along.x * p.y, per_x: -along.y, per_y: along.x }
    });
    let [x, y, z] = [0, 1, 2].map(|k| edges[k].scaled(corners[k].nearness / area.abs()));
    let nearness = x.plus(y).plus(z);
    // The nearness is at most 3, so that a millionth is far more than its roundings.
    let error = 3e-6 + 4.0 * nearness.variation(SCREEN_ERROR);
    let inv_depth_plane = InvDepthPlane { inv_depth: nearness, error_bound: ErrorBound([error, 0.0, 0.0]) };
    Some(EdgeFunctions { edges, edge_error_bound, inv_depth_plane })
}

#[cfg(test)]
mod tests;
