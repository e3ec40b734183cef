//! Packets of camera rays. The rays of neighbouring samples pass through the stages together: rays, first hits,
//! surfaces, colours. The stages of one sample depend on each other. The processor overlaps the stages of different
//! samples, which hides the latency of divisions and of memory.

use super::surfaces::find_surfaces;
use super::{FirstHit, Hints, Memory, Observer, Tracer};
use crate::camera::Camera;
use crate::math::simd::LANES;
use crate::sampling::sample_packet::{PacketColors, Sample, SamplePacket, Wanted};
use fearless_simd::Simd;
use fearless_simd_macros::simd;

impl<H: Hints> Tracer<'_, H> {
    /// Traces the samples of a packet in row `j`, and stores their colours if they are wanted. Does not count the
    /// camera rays.
    #[simd]
    #[inline(never)]
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn trace<S: Simd, O: Observer>(
        &self,
        simd: S,
        camera: &Camera,
        j: usize,
        wanted: Wanted,
        packet: &mut SamplePacket,
        colors: &mut PacketColors,
        memory: &mut Memory,
        observer: &mut O,
    ) {
        aim::<S>(simd, packet, camera, j);
        if wanted.hits {
            for sample in packet.samples_mut() {
                let Sample { ray, source, .. } = &sample;
                sample.visible = match self.hints.first_hit(self.caster.world, ray, [source.column, j]) {
                    FirstHit::Nothing => None,
                    FirstHit::Primitive(visible) => Some(visible),
                    FirstHit::Unknown => self.nearest(ray, None, observer),
                };
            }
        }
        if wanted.surfaces {
            let world = self.world();
            find_surfaces::<S>(simd, world, packet);
            if world.has_smooth_normals() {
                for surface in packet.samples_mut().iter_mut().filter_map(|sample| sample.surface.as_mut()) {
                    surface.normal = world.smooth_normal(surface).unwrap_or(surface.normal);
                }
            }
        }
        if wanted.colors {
            for (color, Sample { ray, surface, .. }) in colors.iter_mut().zip(packet.samples()) {
                self.set_color(simd, color, ray, surface.as_ref(), memory, observer);
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
        let columns = [a.source.column, b.source.column, c.source.column, d.source.column];
        let offsets = [a.source.offset, b.source.offset, c.source.offset, d.source.offset];
        [a.ray, b.ray, c.ray, d.ray] = camera.rays::<S>(simd, columns, j, offsets);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::instructions;
    use crate::math::ray::Visible;
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
                sample.visible = visible.filter(|_| column_is_open(sample.source.column));
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
