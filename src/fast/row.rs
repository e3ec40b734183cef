//! The stages that the samples of a row pass through together: their rays, the hits, the surfaces there, and the colours.
//! The stages of one sample depend on each other, while those of different samples overlap, which hides the latency of
//! divisions and of memory. All of them are compiled for each instruction set.

use super::FastRow;
use super::raster::{Seen, VisibilityBuffer};
use super::shading::Shading;
use super::surfaces::find_surfaces;
use crate::camera::Camera;
use crate::caster::Caster;
use crate::math::simd::LANES;
use crate::sampling::sample_packet::{PacketColors, Sample, SamplePacket, Wanted};
use crate::scene::model::MeshNormals;
use crate::stats::Quiet;
use crate::trace::{Rules, Tracer};
use fearless_simd::{Simd, dispatch};
use fearless_simd_macros::simd;

/// Traces the samples of a packet, which lie in row `j`, by the rules of the row's scene, and enters their colours, if
/// they are wanted.
pub fn trace<R: Rules>(
    row: &mut FastRow,
    rules: &R,
    j: usize,
    wanted: Wanted,
    packet: &mut SamplePacket,
    colors: &mut PacketColors,
) {
    dispatch!(row.rows.caster.level, simd => trace_at(simd, row, rules, j, wanted, packet, colors));
}

/// Traces the samples with these instructions.
#[simd]
#[inline(never)]
#[allow(clippy::too_many_arguments)]
fn trace_at<S: Simd, R: Rules>(
    simd: S,
    row: &mut FastRow,
    rules: &R,
    j: usize,
    wanted: Wanted,
    packet: &mut SamplePacket,
    colors: &mut PacketColors,
) {
    let FastRow { rows, memory } = row;
    aim::<S>(simd, packet, rows.picture.camera, j);
    if wanted.hits {
        cast(packet, rows.caster, rows.visibility.as_ref(), j);
    }
    if wanted.surfaces {
        find_surfaces::<S>(simd, rows.caster.world, packet);
        if rules.model().normals != MeshNormals::Flat {
            for sample in packet.samples_mut() {
                sample.surface = sample.surface.map(|surface| rules.smoothed(surface));
            }
        }
    }
    if wanted.colors {
        let tracer = Tracer { rules, effects: rows.picture.demand.effects };
        let shading = Shading { tracer, caster: rows.caster, shadow_maps: rows.picture.shadow_maps.as_ref() };
        for (color, Sample { ray, surface, .. }) in colors.iter_mut().zip(packet.samples()) {
            *color = shading.color(ray, surface.as_ref(), memory);
        }
    }
}

/// Computes the rays of the samples, which lie in row `j`.
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

/// Finds the first hit of each ray. `visibility` has those of rays through row `j`, as far as they are known.
#[inline(always)]
fn cast(packet: &mut SamplePacket, caster: &Caster, visibility: Option<&VisibilityBuffer>, j: usize) {
    for sample in packet.samples_mut() {
        let Sample { ray, source, .. } = &sample;
        let seen = match visibility {
            Some(buffer) => buffer.seen(caster.world, ray, source.column, j),
            None => Seen::Unsure,
        };
        sample.visible = match seen {
            Seen::Nothing => None,
            Seen::Primitive(visible) => Some(visible),
            Seen::Unsure => caster.nearest(ray, None, &mut Quiet),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::instructions;
    use crate::math::ray::Visible;
    use crate::scene::parser::parse;
    use crate::world::shape::Form;
    use crate::world::{SurfacePoint, World};
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

    /// Whether something is seen in a column, so that some samples of a packet see nothing.
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
