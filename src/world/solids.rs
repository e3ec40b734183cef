//! Solids: transparent spheres and closed meshes, and what is known about their inside before any ray is traced.
//!
//! A ray from inside of a closed surface to a point outside of it crosses the surface. So where every object casts a
//! shadow, the inside of a solid is dark if all lights are outside of it, and no shadow ray has to find that out. This
//! also decides what a ray cannot: at an edge the offset of its start may lead out of the solid.
//!
//! *Which meshes are solids.* Let every edge of a mesh be used as often in one direction as in the other, and let all
//! of its faces be seen from behind from one point, its centre. The number of faces by which a ray without an end
//! leaves the mesh, minus the number of those by which it enters, is the winding number of its start: it is the same
//! for all directions, and zero outside of the mesh's box. A ray away from the centre leaves by every face that it
//! crosses. If it starts behind a face, it crosses at least this one, so the winding number is positive behind all
//! faces.
//!
//! The same is known of a mesh that is *embedded*, which takes longer to find out ([`embedding`]): its triangles meet
//! only at the vertices and the edges that they share, so that close to a face no other face is. Where only two faces
//! have an edge, the front of one is connected there to the front of the other, and no face is between, so that the
//! winding number is the same before all faces of a component. Where it is zero before them, it is one behind.
//!
//! *What is seen within.* Where the winding number of the centre is one, it is one behind every face, since it only
//! falls on the way out. Let nothing else be in the mesh's box. A ray from the inner side of a face, to the inside,
//! goes from where the winding number is one to where it is zero: the first face that it meets it sees from behind.
//! If the mesh is of one plain material, the colour of this face is that of its ambient light, or black, and known
//! before the ray is cast. The same holds for an embedded mesh and for a sphere.

use super::{Primitive, World};
use crate::math::aabb::Aabb;
use crate::math::ray::Ray;
use crate::memory::NoMemory;
use crate::primitive::triangle::{self, Shear};
use crate::scene::material::Material;
use crate::scene::{Color, Light};
use embedding::embedded;
use glam::DVec3;
use std::ops::Range;

mod contact;
mod embedding;
mod neighbors;
mod orientation;

/// What is known about the solids of a world.
#[derive(Clone, Debug, Default)]
pub(crate) struct Solids {
    /// The ids of the primitives whose inside is dark, in order.
    dark: Vec<Range<u32>>,
    /// The ids of the spheres and ellipsoids that stand alone, in order.
    lone: Vec<u32>,
    /// The ids of the primitives that bound solids of one plain material with nothing in them, in order.
    empty: Vec<Range<u32>>,
    /// The meshes of which it is not known whether they are solids.
    undecided: Vec<Range<u32>>,
}

/// The maximum number of triangles of a solid, so that looking for its edges takes no time that a user notices.
const MAX_TRIANGLES: usize = 4096;

/// The maximum number of boxes that are compared to find what stands alone.
const MAX_COMPARISONS: usize = 1 << 16;

/// Distances are not relied on below this times the coordinates involved. It is many times the offset of a secondary
/// ray and all rounding errors.
const MARGIN: f64 = 1.0 / (1 << 20) as f64;

impl Solids {
    /// The solids of a world whose primitives have their ids, given which materials are transparent, and the ids of the
    /// triangles of each mesh that is.
    pub fn of(world: &World, transparent: &[bool], meshes: &[Range<u32>]) -> Self {
        let mut solids = Self::default();
        let mut comparisons = MAX_COMPARISONS;
        for mesh in meshes {
            match star_shaped(world, mesh) {
                Some(solid) => solids.add_mesh(world, &solid, &mut comparisons),
                None => solids.undecided.push(mesh.clone()),
            }
        }
        let first = world.triangles.len() as u32;
        let mut comparisons = MAX_COMPARISONS;
        for (run, material) in world.material_runs() {
            let round = clipped(&run, first..world.first_plane());
            if transparent.get(material) == Some(&true) {
                round.for_each(|id| solids.add_round(world, id, &mut comparisons));
            }
        }
        solids
    }

    /// The number of triangles of which [`with_embedded`](Self::with_embedded) would find out whether they bound
    /// solids.
    pub fn undecided_triangles(&self) -> usize {
        self.undecided.iter().map(Range::len).sum()
    }

    /// The same with all meshes that are embedded. Finding them takes about as long as a ray for each triangle.
    pub fn with_embedded(&self, world: &World) -> Result<Self, NoMemory> {
        let mut solids = Self { undecided: vec![], ..self.clone() };
        let mut comparisons = MAX_COMPARISONS.max(4 * world.finite_count());
        for mesh in &self.undecided {
            if let Some(solid) = embedded(world, mesh) {
                solids.add_mesh(world, &solid, &mut comparisons);
            }
        }
        solids.dark.sort_unstable_by_key(|ids| ids.start);
        solids.empty.sort_unstable_by_key(|ids| ids.start);
        Ok(solids)
    }

    /// Whether no light reaches the inner side of a primitive where every object casts a shadow.
    #[inline]
    pub fn are_dark_within(&self, primitive: u32) -> bool {
        contains(&self.dark, primitive)
    }

    /// Whether a ray that starts on the inner side of a primitive ends on the inner side of the same solid, which has
    /// the same material everywhere.
    #[inline]
    pub fn are_empty_within(&self, primitive: u32) -> bool {
        contains(&self.empty, primitive)
    }

    /// Whether nothing is inside of a sphere or an ellipsoid or touches it, except for planes.
    #[inline]
    pub fn stands_alone(&self, primitive: u32) -> bool {
        self.lone.binary_search(&primitive).is_ok()
    }

    /// Adds what is known about a closed surface.
    fn add(&mut self, world: &World, solid: &Solid, stands_alone: bool) {
        let Solid { ids, bounds, is_simple } = solid;
        if world.lights.iter().all(|light| is_outside(light, bounds, world)) {
            append(&mut self.dark, ids);
        }
        if *is_simple && stands_alone && is_plain(world, ids.start) && is_clear_of_planes(bounds, world) {
            append(&mut self.empty, ids);
        }
    }

    /// Adds what is known about a mesh.
    fn add_mesh(&mut self, world: &World, solid: &Solid, comparisons: &mut usize) {
        let stands_alone = solid.is_simple && solid.stands_alone(world, comparisons);
        self.add(world, solid, stands_alone);
    }

    /// Adds what is known about a sphere or an ellipsoid.
    fn add_round(&mut self, world: &World, id: u32, comparisons: &mut usize) {
        let solid = Solid { ids: id..id + 1, bounds: world.box_of(id), is_simple: true };
        let stands_alone = solid.stands_alone(world, comparisons);
        if stands_alone {
            self.lone.push(id);
        }
        if let Primitive::Sphere(i) = world.primitive(id)
            && world.spheres[i].radius > MARGIN * world.max_abs_coord
        {
            self.add(world, &solid, stands_alone);
        }
    }
}

/// A closed surface with a positive winding number behind all of its faces, and zero outside of its box.
struct Solid {
    /// The ids of its primitives.
    ids: Range<u32>,
    bounds: Aabb,
    /// Whether the winding number is one behind all of its faces.
    is_simple: bool,
}

impl Solid {
    /// Whether the box is apart from those of all other primitives. This is false if no more boxes may be compared.
    fn stands_alone(&self, world: &World, comparisons: &mut usize) -> bool {
        let Some(left) = comparisons.checked_sub(world.finite_count()) else { return false };
        *comparisons = left;
        let is_apart = |other| is_clear(&self.bounds, &world.box_of(other), world);
        (0..self.ids.start).chain(self.ids.end..world.first_plane()).all(is_apart)
    }
}

/// Whether a primitive is in one of these ranges, which are in order.
#[inline]
fn contains(ranges: &[Range<u32>], primitive: u32) -> bool {
    let next = ranges.partition_point(|ids| ids.start <= primitive);
    next > 0 && primitive < ranges[next - 1].end
}

/// Adds a range behind the others, and joins it to the last one if it can.
fn append(ranges: &mut Vec<Range<u32>>, ids: &Range<u32>) {
    match ranges.last_mut() {
        Some(last) if last.end == ids.start => last.end = ids.end,
        _ => ranges.push(ids.clone()),
    }
}

/// The part of one range that is in another.
fn clipped(ids: &Range<u32>, to: Range<u32>) -> Range<u32> {
    ids.start.max(to.start)..ids.end.min(to.end)
}

/// For each material, whether rays are refracted anywhere on a surface of it. Textures follow the materials that they
/// mix.
pub(super) fn transparent(materials: &[Material]) -> Vec<bool> {
    let mut transparent = Vec::with_capacity(materials.len());
    for material in materials {
        transparent.push(match material {
            Material::Phong(phong) => phong.transparent != Color::ZERO,
            Material::Texture(texture) => {
                texture.children.iter().any(|&child| transparent.get(child) == Some(&true))
            }
        });
    }
    transparent
}

/// The solid that the triangles of a mesh bound, if all of them are seen from behind from one point.
fn star_shaped(world: &World, mesh: &Range<u32>) -> Option<Solid> {
    let triangles = &world.triangles[mesh.start as usize..mesh.end as usize];
    if triangles.len() > MAX_TRIANGLES {
        return None;
    }
    let corners = |face: &[u32; 3]| face.map(|i| world.vertices[i as usize]);
    // It is inside of every convex mesh.
    let center = triangles.iter().flat_map(corners).sum::<DVec3>() / (3 * triangles.len()) as f64;
    let depth = MARGIN * world.max_abs_coord;
    let is_behind = |face: &[u32; 3]| {
        let [a, b, c] = corners(face);
        triangle::normal([a, b, c]).dot(a - center) > depth
    };
    if !triangles.iter().all(is_behind) || !has_balanced_edges(&sorted_edges(triangles)) {
        return None;
    }
    // The ray leaves by every face that it crosses.
    let ray = Ray::new(center, DVec3::X);
    let shear = Shear::new(&ray);
    let is_crossed =
        |id: &u32| shear.intersect(world.corners_in_place(*id as usize)).is_some_and(|t| t > 0.0);
    let winding_number = mesh.clone().filter(is_crossed).count();
    let bounds = Aabb::around(triangles.iter().flat_map(corners));
    Some(Solid { ids: mesh.clone(), bounds, is_simple: winding_number == 1 })
}

/// The edges of the triangles, each with its face: the vertices in order, and twice the face, plus one where the face
/// has them in this order. Equal edges follow each other.
fn sorted_edges(triangles: &[[u32; 3]]) -> Vec<(u64, u32)> {
    let mut edges = Vec::with_capacity(3 * triangles.len());
    for (&[a, b, c], face) in triangles.iter().zip(0..) {
        edges
            .extend([[a, b], [b, c], [c, a]].map(|[p, q]| {
                (u64::from(p.min(q)) << 32 | u64::from(p.max(q)), 2 * face + u32::from(p < q))
            }));
    }
    edges.sort_unstable();
    edges
}

/// Whether each of these edges is used as often in one direction as in the other.
fn has_balanced_edges(edges: &[(u64, u32)]) -> bool {
    let forward = |uses: &[(u64, u32)]| uses.iter().filter(|edge| edge.1 % 2 == 1).count();
    edges.chunk_by(|one, other| one.0 == other.0).all(|uses| 2 * forward(uses) == uses.len())
}

/// Whether a light is surely outside of a box.
fn is_outside(light: &Light, bounds: &Aabb, world: &World) -> bool {
    match *light {
        Light::Directional { .. } => true,
        Light::Point { position, .. } => is_clear(bounds, &Aabb { min: position, max: position }, world),
    }
}

/// Whether two boxes are surely apart.
fn is_clear(one: &Aabb, other: &Aabb, world: &World) -> bool {
    let gap = (one.min - other.max).max(other.min - one.max).max_element();
    let largest = other.min.abs().max(other.max.abs()).max_element().max(world.max_abs_coord);
    gap > MARGIN * largest
}

/// Whether a box is surely apart from all planes.
fn is_clear_of_planes(bounds: &Aabb, world: &World) -> bool {
    let [center, half] = [0.5 * (bounds.min + bounds.max), 0.5 * bounds.extent()];
    world.planes.iter().all(|plane| {
        let gap = plane.ahead_of(center).abs() - plane.normal.abs().dot(half);
        gap > MARGIN * world.max_abs_coord.max(plane.offset.abs())
    })
}

/// Whether a primitive's material is the same everywhere.
fn is_plain(world: &World, primitive: u32) -> bool {
    matches!(world.materials.get(world.material_of(primitive)), Some(Material::Phong(_)))
}

#[cfg(test)]
mod tests;
