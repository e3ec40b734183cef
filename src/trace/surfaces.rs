//! Computes the surfaces that several rays hit first, for triangles four at a time.

use crate::math::instructions::prefetch;
use crate::math::ray::{Ray, Visible};
use crate::math::simd::LANES;
use crate::sampling::sample_packet::{Sample, SamplePacket};
use crate::scene::MaterialId;
use crate::world::triangle4::{Hits4, Triangles4};
use crate::world::{SurfacePoint, World};
use fearless_simd::Simd;

/// The index of a ray that hits a triangle, and the triangle's id.
#[derive(Clone, Copy, Debug, Default)]
struct OnTriangle {
    ray: usize,
    id: u32,
}

/// The triangles that four rays hit.
#[derive(Clone, Copy, Debug)]
struct Group<S: Simd> {
    ids: [u32; LANES],
    materials: [MaterialId; LANES],
    triangles: Triangles4<S>,
}

impl<S: Simd> Group<S> {
    #[inline(always)]
    fn new(simd: S, world: &World, ids: [u32; LANES]) -> Self {
        let [a, b, c, d] = ids;
        let corners = [
            world.corners_in_place(a as usize),
            world.corners_in_place(b as usize),
            world.corners_in_place(c as usize),
            world.corners_in_place(d as usize),
        ];
        Self { ids, materials: materials_of(world, ids), triangles: Triangles4::new(simd, corners) }
    }
}

/// Computes the surface that each ray of a packet hits first, with the same result as [`World::visible_surface`].
#[inline(always)]
pub fn find_surfaces<S: Simd>(simd: S, world: &World, packet: &mut SamplePacket) {
    let rays = packet.samples_mut();
    let (mut on_triangles, mut count) = ([OnTriangle::default(); SamplePacket::SIZE], 0);
    for (i, ray) in rays.iter_mut().enumerate() {
        let Some(visible) = ray.visible else { continue };
        let id = visible.primitive;
        if world.is_triangle(id) {
            if count == 0 || on_triangles[count - 1].id != id {
                prefetch_corners(world, id);
            }
            on_triangles[count] = OnTriangle { ray: i, id };
            count += 1;
        } else {
            ray.surface = Some(world.visible_surface(&ray.ray, visible));
        }
    }
    // Neighbours often lie on the same triangles.
    let mut last: Option<Group<S>> = None;
    for some in on_triangles[..count].chunks(LANES) {
        let four = match some {
            // Constant indices are faster than computed ones.
            [a, b, c, d] => [*a, *b, *c, *d],
            _ => [0, 1, 2, 3].map(|i: usize| some[i.min(some.len() - 1)]),
        };
        let [a, b, c, d] = four;
        let ids = [a.id, b.id, c.id, d.id];
        if !matches!(&last, Some(group) if group.ids == ids) {
            last = Some(Group::new(simd, world, ids));
        }
        if let Some(group) = &last {
            find_points(simd, world, rays, group, four, some.len());
        }
    }
}

/// Computes the surfaces of the first `count` of four rays that hit triangles.
#[inline(always)]
fn find_points<S: Simd>(
    simd: S,
    world: &World,
    rays: &mut [Sample],
    group: &Group<S>,
    four: [OnTriangle; LANES],
    count: usize,
) {
    let [a, b, c, d] = four;
    let of = [&rays[a.ray].ray, &rays[b.ray].ray, &rays[c.ray].ray, &rays[d.ray].ray];
    let Hits4 { points, certain } = group.triangles.hits(simd, of);
    for (lane, OnTriangle { ray, id }) in four[..count].iter().enumerate() {
        let ray = &mut rays[*ray];
        if certain & (1 << lane) != 0 {
            ray.surface = Some(SurfacePoint {
                position: points[lane],
                normal: group.triangles.normals[lane],
                extent: group.triangles.extents[lane],
                material: group.materials[lane],
                primitive: Some(*id),
                triangle: Some(*id),
            });
        } else if let Some(visible) = ray.visible {
            ray.surface = Some(surface_alone(world, &ray.ray, visible));
        }
    }
}

/// Computes a surface that needs exact arithmetic.
#[cold]
fn surface_alone(world: &World, ray: &Ray, visible: Visible) -> SurfacePoint {
    world.visible_surface(ray, visible)
}

/// Returns the materials of four triangles. Most of the triangles are neighbours.
#[inline(always)]
fn materials_of(world: &World, triangles: [u32; LANES]) -> [MaterialId; LANES] {
    let (run, material) = world.material_run(triangles[0]);
    triangles.map(|id| if run.contains(&id) { material } else { world.material_of(id) })
}

/// Loads the vertices of a triangle whose surface will be computed soon.
#[inline(always)]
fn prefetch_corners(world: &World, triangle: u32) {
    world.corners_in_place(triangle as usize).into_iter().for_each(prefetch);
}
