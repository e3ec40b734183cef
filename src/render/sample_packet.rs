//! Samples of neighbouring pixels that pass through the stages together: first their rays, then the hits, and
//! then the surfaces there. The stages of one sample depend on each other, while those of different samples
//! overlap, which hides the latency of divisions and of memory.

use crate::camera::Camera;
use crate::fast::{Seen, VisibilityBuffer};
use crate::grid::Caster;
use crate::grid::packet::PacketRay;
use crate::math::f64x4::{F64x4, LANES};
use crate::math::ray::{Ray, Visible};
use crate::mode::Mode;
use crate::stats::Probe;
use crate::trace::MOST_CAMERA_RAYS;
use crate::world::World;
use crate::world::surfaces::Traced;
use glam::{DVec2, DVec3};
use std::ops::Range;

/// The place of a sample in a row of pixels.
#[derive(Clone, Copy, Debug)]
pub struct SamplePlace {
    pub column: usize,
    /// The offset from the pixel's centre, in pixels.
    pub offset: DVec2,
    /// Whether it is the last sample of its pixel.
    pub is_last: bool,
}

/// A sample in a row of pixels, and what its ray hits.
pub type Sample = Traced<SamplePlace>;

/// A sample that has not been placed.
const UNPLACED: Sample = Traced::new(
    SamplePlace { column: 0, offset: DVec2::ZERO, is_last: false },
    Ray { origin: DVec3::ZERO, t_min: 0.0, direction: DVec3::ZERO, t_max: 0.0 },
);

impl PacketRay for Sample {
    #[inline(always)]
    fn ray(&self) -> &Ray {
        &self.ray
    }

    #[inline(always)]
    fn set_visible(&mut self, visible: Option<Visible>) {
        self.visible = visible;
    }
}

/// Up to [`SIZE`](Self::SIZE) samples of a row.
#[derive(Debug)]
pub struct SamplePacket {
    /// The places of samples, the first of which are taken. They stay where they are from one packet to the next,
    /// because it would take longer to make whole samples than to change what is different.
    places: [Sample; Self::SIZE],
    count: usize,
}

impl Default for SamplePacket {
    fn default() -> Self {
        Self { places: [UNPLACED; Self::SIZE], count: 0 }
    }
}

impl SamplePacket {
    /// The maximum number of samples.
    pub const SIZE: usize = MOST_CAMERA_RAYS;

    #[inline(always)]
    pub fn samples(&self) -> &[Sample] {
        &self.places[..self.count]
    }

    #[inline(always)]
    fn samples_mut(&mut self) -> &mut [Sample] {
        &mut self.places[..self.count]
    }

    #[inline(always)]
    pub fn clear(&mut self) {
        self.count = 0;
    }

    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.count == Self::SIZE
    }

    /// Adds the centres of the pixels in these columns.
    #[inline(always)]
    pub fn push_centers(&mut self, columns: Range<usize>) {
        for column in columns {
            self.push(column, DVec2::ZERO, true);
        }
    }

    /// Adds a sample of the pixel in this column, unless the packet is full.
    #[inline(always)]
    pub fn push(&mut self, column: usize, offset: DVec2, is_last: bool) {
        if let Some(place) = self.places.get_mut(self.count) {
            place.source = SamplePlace { column, offset, is_last };
            (place.visible, place.surface) = (None, None);
            self.count += 1;
        }
    }

    /// Computes the rays of the samples, which lie in row `j`.
    #[inline(always)]
    pub fn aim<F: F64x4>(&mut self, proof: F::Proof, camera: &Camera, j: usize) {
        // Places without a sample may get any ray.
        let (groups, _) = self.places.as_chunks_mut::<LANES>();
        for [a, b, c, d] in &mut groups[..self.count.div_ceil(LANES)] {
            let columns = [a.source.column, b.source.column, c.source.column, d.source.column];
            let offsets = [a.source.offset, b.source.offset, c.source.offset, d.source.offset];
            [a.ray, b.ray, c.ray, d.ray] = camera.rays::<F>(proof, columns, j, offsets);
        }
    }

    /// Finds the first hit of each ray. `visibility` has those of rays through row `j`, as far as they are known.
    #[inline(always)]
    pub fn cast<M: Mode, P: Probe>(
        &mut self,
        caster: &Caster<M>,
        visibility: Option<&VisibilityBuffer>,
        j: usize,
        probe: &mut P,
    ) {
        let Some(visibility) = visibility else {
            return caster.nearest_of_packet(self.samples_mut(), probe);
        };
        let mut unsure = vec![];
        for sample in self.samples_mut() {
            match visibility.seen(caster.world, &sample.ray, sample.source.column, j) {
                Seen::Nothing => sample.visible = None,
                Seen::Primitive(visible) => sample.visible = Some(visible),
                Seen::Unsure => unsure.push(sample),
            }
        }
        caster.nearest_of_packet(&mut unsure, probe);
    }

    /// Computes the surface that each ray hits first.
    #[inline(always)]
    pub fn find_surfaces<F: F64x4>(&mut self, proof: F::Proof, world: &World) {
        world.find_surfaces::<F, _>(proof, self.samples_mut());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::f64x4::Scalar;
    use crate::math::instructions::Portable;
    use crate::scene::parser::parse;
    use crate::world::SurfacePoint;

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

    fn finds_what_each_ray_hits<F: F64x4>(proof: F::Proof) {
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
            packet.aim::<F>(proof, &camera, j);
            for sample in packet.samples_mut() {
                let t = |id: u32| match world.primitive(id) {
                    crate::world::Primitive::Triangle(i) => {
                        crate::primitive::triangle::Shear::new(&sample.ray)
                            .intersect(world.corners_in_place(i))
                    }
                    crate::world::Primitive::Sphere(i) => world.spheres[i].intersect(&sample.ray),
                    _ => Some(100.0),
                };
                let visible = (0..4).find_map(|id| Some(Visible { primitive: id, t_bound: t(id)? }));
                sample.visible = visible.filter(|_| column_is_open(sample.source.column));
            }
            packet.find_surfaces::<F>(proof, &world);
            for Sample { ray, visible, surface, .. } in packet.samples() {
                let expected = visible.map(|visible| world.visible_surface(ray, visible));
                assert_eq!(bits(*surface), bits(expected), "{ray:?}");
                visible.iter().for_each(|visible| kinds[visible.primitive as usize] += 1);
            }
            packet.clear();
        }
        assert!(kinds.iter().all(|&count| count > 100), "{kinds:?}");
    }

    /// Whether something is seen in a column, so that some samples of a packet see nothing.
    fn column_is_open(column: usize) -> bool {
        !column.is_multiple_of(7)
    }

    #[test]
    fn a_packet_has_the_surface_that_each_ray_hits() {
        finds_what_each_ray_hits::<Scalar>(Portable);
        #[cfg(target_arch = "x86_64")]
        if let Some(proof) = crate::math::instructions::Avx2::detect() {
            finds_what_each_ray_hits::<crate::math::avx::Avx>(proof);
        }
    }
}
