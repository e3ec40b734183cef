//! The surfaces that several rays hit first: those of triangles four at a time.

use super::{SurfacePoint, World};
use crate::math::f64x4::{F64x4, LANES};
use crate::math::ray::{Ray, Visible};
use crate::primitive::triangle4::{Hits4, Triangles4};
use crate::scene::MaterialId;

/// A ray with what it hits. The ray is in one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Traced<T> {
    pub ray: Ray,
    /// The surface that the ray hits first, once it has been computed.
    pub surface: Option<SurfacePoint>,
    /// What the ray hits first, once it has been cast.
    pub visible: Option<Visible>,
    /// Where the ray comes from.
    pub source: T,
}

impl<T> Traced<T> {
    /// A ray that has not been cast.
    pub const fn new(source: T, ray: Ray) -> Self {
        Self { ray, surface: None, visible: None, source }
    }
}

/// The largest number of rays whose surfaces are computed together.
const MOST_RAYS: usize = 32;

/// The index of a ray that hits a triangle, and the triangle's id.
#[derive(Clone, Copy, Debug, Default)]
struct OnTriangle {
    ray: usize,
    id: u32,
}

/// The triangles that four rays hit.
#[derive(Clone, Copy, Debug)]
struct Group<F> {
    ids: [u32; LANES],
    materials: [MaterialId; LANES],
    triangles: Triangles4<F>,
}

impl<F: F64x4> Group<F> {
    #[inline(always)]
    fn new(proof: F::Proof, world: &World, ids: [u32; LANES]) -> Self {
        let [a, b, c, d] = ids;
        let corners = [
            world.corners_in_place(a as usize),
            world.corners_in_place(b as usize),
            world.corners_in_place(c as usize),
            world.corners_in_place(d as usize),
        ];
        Self { ids, materials: world.materials_of(ids), triangles: Triangles4::new(proof, corners) }
    }
}

impl World {
    /// Computes the surface that each ray hits first, as [`visible_surface`](Self::visible_surface) does.
    #[inline(always)]
    pub fn find_surfaces<F: F64x4, T>(&self, proof: F::Proof, rays: &mut [Traced<T>]) {
        for rays in rays.chunks_mut(MOST_RAYS) {
            self.find_some::<F, T>(proof, rays);
        }
    }

    /// The same for at most [`MOST_RAYS`].
    #[inline(always)]
    fn find_some<F: F64x4, T>(&self, proof: F::Proof, rays: &mut [Traced<T>]) {
        let (mut on_triangles, mut count) = ([OnTriangle::default(); MOST_RAYS], 0);
        for (i, ray) in rays.iter_mut().enumerate() {
            let Some(visible) = ray.visible else { continue };
            let id = visible.primitive;
            if self.is_triangle(id) {
                if count == 0 || on_triangles[count - 1].id != id {
                    self.prefetch(id);
                }
                on_triangles[count] = OnTriangle { ray: i, id };
                count += 1;
            } else {
                ray.surface = Some(self.visible_surface(&ray.ray, visible));
            }
        }
        // Neighbours often lie on the same triangles.
        let mut last: Option<Group<F>> = None;
        for some in on_triangles[..count].chunks(LANES) {
            let four = match some {
                // Constant indices are faster than computed ones.
                [a, b, c, d] => [*a, *b, *c, *d],
                _ => [0, 1, 2, 3].map(|i: usize| some[i.min(some.len() - 1)]),
            };
            let [a, b, c, d] = four;
            let ids = [a.id, b.id, c.id, d.id];
            if !matches!(&last, Some(group) if group.ids == ids) {
                last = Some(Group::new(proof, self, ids));
            }
            if let Some(group) = &last {
                self.find_points(proof, rays, group, four, some.len());
            }
        }
    }

    /// Computes the surfaces of the first `count` of four rays that hit triangles.
    #[inline(always)]
    fn find_points<F: F64x4, T>(
        &self,
        proof: F::Proof,
        rays: &mut [Traced<T>],
        group: &Group<F>,
        four: [OnTriangle; LANES],
        count: usize,
    ) {
        let [a, b, c, d] = four;
        let of = [&rays[a.ray].ray, &rays[b.ray].ray, &rays[c.ray].ray, &rays[d.ray].ray];
        let Hits4 { points, certain } = group.triangles.hits(proof, of);
        for (lane, OnTriangle { ray, id }) in four[..count].iter().enumerate() {
            let ray = &mut rays[*ray];
            if certain & (1 << lane) != 0 {
                ray.surface = Some(SurfacePoint {
                    position: points[lane],
                    normal: group.triangles.normals[lane],
                    material: group.materials[lane],
                    primitive: Some(*id),
                    triangle: Some(*id),
                });
            } else if let Some(visible) = ray.visible {
                ray.surface = Some(self.surface_alone(&ray.ray, visible));
            }
        }
    }

    /// Computes a surface that needs exact arithmetic.
    #[cold]
    fn surface_alone(&self, ray: &Ray, visible: Visible) -> SurfacePoint {
        self.visible_surface(ray, visible)
    }
}
