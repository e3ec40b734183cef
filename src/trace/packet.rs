//! Packets of camera rays. The rays of neighbouring samples pass through the stages together: rays, first hits,
//! surfaces, colours. The stages of one sample depend on each other. The processor overlaps the stages of different
//! samples, which hides the latency of divisions and of memory. The surfaces of triangles are computed four at a time.

use super::{FirstHit, Hints, Observer, RayStack, Tracer};
use crate::camera::Camera;
use crate::caster::RayOrigin;
use crate::math::ray::{Ray, Visible};
use crate::math::simd::LANES;
use crate::sampling::sample_packet::{Sample, SamplePacket, Stage};
use crate::scene::MaterialId;
use crate::world::triangle4::{Hits4, Triangles4};
use crate::world::{SurfacePoint, World};
use arrayvec::ArrayVec;
use fearless_simd::Simd;
use fearless_simd_macros::simd;

impl<H: Hints> Tracer<'_, H> {
    /// Traces the samples of a packet in row `j` up to a stage. Does not count the camera rays.
    #[simd]
    #[inline(never)]
    #[allow(clippy::too_many_arguments, reason = "an inner loop")]
    pub(crate) fn trace<S: Simd, O: Observer>(
        &self,
        simd: S,
        camera: &Camera,
        j: usize,
        stage: Stage,
        packet: &mut SamplePacket,
        stack: &mut RayStack,
        observer: &mut O,
    ) {
        aim::<S>(simd, packet, camera, j);
        if stage >= Stage::Hits {
            for sample in packet.samples_mut() {
                let Sample { ray, column, .. } = &sample;
                sample.visible = match self.hints.first_hit(self.caster.world, ray, [*column, j]) {
                    FirstHit::Nothing => None,
                    FirstHit::Primitive(visible) => Some(visible),
                    FirstHit::Unknown => self.nearest(ray, RayOrigin::FREE, observer),
                };
            }
        }
        if stage >= Stage::Surfaces {
            let world = self.world();
            find_surfaces::<S>(simd, world, packet);
            if world.has_smooth_normals() {
                for surface in packet.samples_mut().iter_mut().filter_map(|sample| sample.surface.as_mut()) {
                    *surface = self.smooth(*surface);
                }
            }
        }
        if stage == Stage::Colors {
            for (Sample { ray, surface, .. }, color) in packet.colors_mut() {
                if stack.asks_within_packets() && stack.spend(1) {
                    break;
                }
                self.set_color(simd, color, ray, surface.as_ref(), stack, observer);
            }
        }
    }
}

/// Computes the rays of the samples in row `j`.
#[inline(always)]
fn aim<S: Simd>(simd: S, packet: &mut SamplePacket, camera: &Camera, j: usize) {
    let count = packet.samples().len();
    // Places without a sample may get any ray.
    let (groups, _) = packet.places_mut().as_chunks_mut::<LANES>();
    for [a, b, c, d] in &mut groups[..count.div_ceil(LANES)] {
        let columns = [a.column, b.column, c.column, d.column];
        let offsets = [a.offset, b.offset, c.offset, d.offset];
        [a.ray, b.ray, c.ray, d.ray] = camera.rays::<S>(simd, columns, j, offsets);
    }
}

/// Four triangles that rays hit.
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
        // Most triangles of a packet share a run of one material.
        let (run, material) = world.material_run(a);
        let materials = ids.map(|id| if run.contains(&id) { material } else { world.material_of(id) });
        Self { ids, materials, triangles: Triangles4::new(simd, corners) }
    }
}

/// Computes the surface that each ray of a packet hits first, with the same result as [`World::visible_surface`].
#[inline(always)]
fn find_surfaces<S: Simd>(simd: S, world: &World, packet: &mut SamplePacket) {
    let samples = packet.samples_mut();
    // The indices of the samples whose rays hit triangles, and the ids of these.
    let mut on_triangles = ArrayVec::<(usize, u32), { SamplePacket::SIZE }>::new();
    for (i, Sample { ray, visible, surface, .. }) in samples.iter_mut().enumerate() {
        let Some(visible) = *visible else { continue };
        let id = visible.primitive;
        if world.is_triangle(id) {
            on_triangles.push((i, id));
        } else {
            *surface = Some(world.visible_surface(ray, visible));
        }
    }
    // Neighbours often lie on the same triangles.
    let mut last: Option<Group<S>> = None;
    for some in on_triangles.chunks(LANES) {
        // The last one fills the missing lanes.
        let [(i, a), (j, b), (k, c), (l, d)] = [0, 1, 2, 3].map(|i: usize| some[i.min(some.len() - 1)]);
        let ids = [a, b, c, d];
        let group = match &last {
            Some(group) if group.ids == ids => group,
            _ => last.insert(Group::new(simd, world, ids)),
        };
        let rays = [&samples[i].ray, &samples[j].ray, &samples[k].ray, &samples[l].ray];
        let Hits4 { points, certain } = group.triangles.hits(simd, rays);
        for (lane, &(i, id)) in some.iter().enumerate() {
            let Sample { ray, visible, surface, .. } = &mut samples[i];
            if certain >> lane & 1 != 0 {
                *surface = Some(SurfacePoint {
                    position: points[lane],
                    normal: group.triangles.normals[lane],
                    extent: group.triangles.extents[lane],
                    material: group.materials[lane],
                    primitive: Some(id),
                    triangle: Some(id),
                });
            } else if let Some(visible) = *visible {
                *surface = Some(surface_alone(world, ray, visible));
            }
        }
    }
}

/// Computes a surface that needs exact arithmetic.
#[cold]
fn surface_alone(world: &World, ray: &Ray, visible: Visible) -> SurfacePoint {
    world.visible_surface(ray, visible)
}
