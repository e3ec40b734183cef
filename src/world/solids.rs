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
//! crosses. If it starts behind a face, it crosses at least this one, so the winding number is positive behind all faces.

use super::World;
use crate::math::aabb::Aabb;
use crate::memory::{self, NoMemory};
use crate::primitive::triangle;
use crate::scene::material::Material;
use crate::scene::{Color, Light};
use glam::DVec3;
use std::ops::Range;

/// What is known about the solids of a world.
#[derive(Clone, Debug, Default)]
pub(crate) struct Solids {
    /// The ids of the primitives whose inside is dark, in order.
    dark: Vec<Range<u32>>,
    /// The ids of the spheres and ellipsoids that stand alone, in order.
    lone: Vec<u32>,
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
    pub fn of(world: &World, transparent: &[bool], meshes: &[Range<u32>]) -> Result<Self, NoMemory> {
        let mut solids = Self::default();
        for mesh in meshes {
            if is_dark_mesh(world, &world.triangles[mesh.start as usize..mesh.end as usize])? {
                solids.add_dark(mesh.clone())?;
            }
        }
        let first = world.triangles.len() as u32;
        let mut comparisons = MAX_COMPARISONS;
        for (run, material) in world.material_runs() {
            let spheres = clipped(&run, first..first + world.spheres.len() as u32);
            let round = clipped(&run, first..world.first_plane());
            if !round.is_empty() && transparent.get(material) == Some(&true) {
                solids.add_dark_spheres(world, spheres)?;
                solids.add_lone(world, round, &mut comparisons)?;
            }
        }
        Ok(solids)
    }

    /// Whether no light reaches the inner side of a primitive where every object casts a shadow.
    #[inline]
    pub fn are_dark_within(&self, primitive: u32) -> bool {
        let next = self.dark.partition_point(|ids| ids.start <= primitive);
        next > 0 && primitive < self.dark[next - 1].end
    }

    /// Whether nothing is inside of a sphere or an ellipsoid or touches it, except for planes.
    #[inline]
    pub fn stands_alone(&self, primitive: u32) -> bool {
        self.lone.binary_search(&primitive).is_ok()
    }

    fn add_dark_spheres(&mut self, world: &World, mut ids: Range<u32>) -> Result<(), NoMemory> {
        ids.try_for_each(|id| if is_dark_sphere(world, id) { self.add_dark(id..id + 1) } else { Ok(()) })
    }

    /// Adds those of these spheres and ellipsoids that stand alone, as long as boxes may be compared.
    fn add_lone(&mut self, world: &World, ids: Range<u32>, comparisons: &mut usize) -> Result<(), NoMemory> {
        for id in ids {
            let Some(left) = comparisons.checked_sub(world.finite_count()) else { break };
            *comparisons = left;
            if is_lone(world, id) {
                memory::push(&mut self.lone, id)?;
            }
        }
        Ok(())
    }

    fn add_dark(&mut self, ids: Range<u32>) -> Result<(), NoMemory> {
        match self.dark.last_mut() {
            Some(last) if last.end == ids.start => {
                last.end = ids.end;
                Ok(())
            }
            _ => memory::push(&mut self.dark, ids),
        }
    }
}

/// The part of one range that is in another.
fn clipped(ids: &Range<u32>, to: Range<u32>) -> Range<u32> {
    ids.start.max(to.start)..ids.end.min(to.end)
}

/// For each material, whether rays are refracted anywhere on a surface of it. Textures follow the materials that they mix.
pub(super) fn transparent(materials: &[Material]) -> Result<Vec<bool>, NoMemory> {
    let mut transparent = memory::with_room(materials.len())?;
    for material in materials {
        transparent.push(match material {
            Material::Phong(phong) => phong.transparent != Color::ZERO,
            Material::Texture(texture) => {
                texture.children.iter().any(|&child| transparent.get(child) == Some(&true))
            }
        });
    }
    Ok(transparent)
}

/// Whether triangles bound a solid with all lights outside of it.
fn is_dark_mesh(world: &World, triangles: &[[u32; 3]]) -> Result<bool, NoMemory> {
    if triangles.len() > MAX_TRIANGLES {
        return Ok(false);
    }
    let corners = |face: &[u32; 3]| face.map(|i| world.vertices[i as usize]);
    let bounds = Aabb::around(triangles.iter().flat_map(corners));
    // It is inside of every convex mesh.
    let center = triangles.iter().flat_map(corners).sum::<DVec3>() / (3 * triangles.len()) as f64;
    let depth = MARGIN * world.max_abs_coord;
    let is_behind = |face: &[u32; 3]| {
        let [a, b, c] = corners(face);
        triangle::normal([a, b, c]).dot(a - center) > depth
    };
    Ok(triangles.iter().all(is_behind)
        && world.lights.iter().all(|light| is_outside(light, &bounds, world))
        && is_closed(triangles)?)
}

/// Whether each edge is used as often in one direction as in the other.
fn is_closed(triangles: &[[u32; 3]]) -> Result<bool, NoMemory> {
    let mut edges = memory::with_room(3 * triangles.len())?;
    for &[a, b, c] in triangles {
        edges.extend([[a, b], [b, c], [c, a]].map(|[p, q]| (p.min(q), p.max(q), p < q)));
    }
    edges.sort_unstable();
    let sides = edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1));
    Ok(sides.into_iter().all(|uses| 2 * uses.iter().filter(|edge| edge.2).count() == uses.len()))
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

/// Whether all lights are outside of a sphere.
fn is_dark_sphere(world: &World, id: u32) -> bool {
    let sphere = &world.spheres[id as usize - world.triangles.len()];
    let bounds = sphere.bounds();
    sphere.radius > MARGIN * world.max_abs_coord
        && world.lights.iter().all(|light| is_outside(light, &bounds, world))
}

/// Whether the box of a primitive is apart from those of all others.
fn is_lone(world: &World, id: u32) -> bool {
    let bounds = world.box_of(id);
    (0..world.first_plane()).all(|other| other == id || is_clear(&bounds, &world.box_of(other), world))
}

#[cfg(test)]
mod tests;
