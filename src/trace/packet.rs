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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::instructions;
    use crate::scene::parser::parse;
    use crate::world::{SurfacePoint, World};
    use fearless_simd::dispatch;
    use glam::{DVec2, DVec3};

    /// Two triangles, a sphere and a plane behind them.
    const TEXT: &str = "PerspectiveCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 angle 60 }
         Materials { numMaterials 4 Material { } Material { } Material { } Material { } }
         Group { numObjects 4
         MaterialIndex 3 Triangle { vertex0 -2 -1 0 vertex1 0 -1 0.5 vertex2 -1 2 1 }
         MaterialIndex 1 Triangle { vertex0 0 -1 0.5 vertex1 2 -1 0 vertex2 1 2 -1 }
         MaterialIndex 2 Sphere { center 0 1.5 0 radius 0.7 }
         MaterialIndex 0 Plane { normal 0 0 1 offset -3 } }";

    /// The bits of a surface's position and normal, and its ids.
    type Bits = ([[u64; 3]; 2], [Option<u32>; 3]);

    fn bits(surface: Option<SurfacePoint>) -> Option<Bits> {
        let bits = |v: DVec3| v.to_array().map(f64::to_bits);
        let ids = |s: SurfacePoint| [s.primitive, s.triangle, Some(s.material as u32)];
        surface.map(|s| ([bits(s.position), bits(s.normal)], ids(s)))
    }

    fn finds_what_each_ray_hits<S: Simd>(simd: S) {
        let scene = parse(TEXT).unwrap();
        let world = World::new(&scene, &[]).unwrap();
        let size = [32, 24];
        let camera = Camera::new(&scene.camera, size);
        let mut packet = SamplePacket::default();
        let mut kinds = [0; 4];
        for (j, start) in (0..size[1]).flat_map(|j| (0..size[0]).map(move |start| (j, start))) {
            let count = 1 + (start + 5 * j) % SamplePacket::SIZE;
            for k in 0..count {
                // Some neighbours lie close to each other, others far apart.
                let column = if j % 2 == 0 { start } else { (start + 3 * k) % size[0] };
                packet.push(column, DVec2::new(k as f64 / 16.0 - 0.5, 0.25), false);
            }
            aim::<S>(simd, &mut packet, &camera, j);
            for sample in packet.samples_mut() {
                let t = |id: u32| match world.primitive(id) {
                    crate::world::Primitive::Triangle(i) => {
                        crate::world::triangle::Shear::new(&sample.ray).intersect(world.corners_in_place(i))
                    }
                    crate::world::Primitive::Shape(i) => world.shapes[i].intersect(&sample.ray),
                    _ => Some(100.0),
                };
                let visible = (0..4).find_map(|id| Some(Visible { primitive: id, t_bound: t(id)? }));
                sample.visible = visible.filter(|_| column_is_open(sample.column));
            }
            find_surfaces::<S>(simd, &world, &mut packet);
            for Sample { ray, visible, surface, .. } in packet.samples() {
                let expected = visible.map(|visible| world.visible_surface(ray, visible));
                assert_eq!(bits(*surface), bits(expected), "{ray:?}");
                visible.iter().for_each(|visible| kinds[visible.primitive as usize] += 1);
            }
            packet.clear();
        }
        assert!(kinds.iter().all(|&count| count > 100), "{kinds:?}");
    }

    /// Returns true if samples in this column may hit something. Thus some samples of a packet hit nothing.
    fn column_is_open(column: usize) -> bool {
        !column.is_multiple_of(7)
    }

    #[test]
    fn a_packet_has_the_surface_that_each_ray_hits() {
        for level in instructions::available() {
            dispatch!(level, simd => finds_what_each_ray_hits(simd));
        }
    }
}
