//! The set-up of four rays before they traverse a grid, one in each SIMD lane.

use crate::caster::build::AccelerationStructure;
use crate::caster::grid::dda4::Dda4;
use crate::caster::grid::lattice::Lattice;
use crate::caster::query::{FilterState, to_frame};
use crate::caster::ray_aabb::intersect_aabb4;
use crate::math::f64x4::{F64x4, LANES};
use crate::math::ray::Ray;
use crate::math::ray_lanes::RayPacket4;

/// The set-up of up to four rays before they traverse a grid.
#[derive(Clone, Copy, Debug)]
pub struct PacketSetup {
    /// The set of the rays that hit the grid's bounds; bit 0 is the first ray.
    pub passing: u32,
    /// The set of those that start too far away for the error bounds.
    pub too_far: u32,
    /// Their ways through the cells.
    pub dda4: Dda4,
    /// The rays in the filter's coordinates, axis by axis. The other fields are as in [`FilterState`].
    origins: [[f32; 4]; 3],
    directions: [[f32; 4]; 3],
    entry: [f64; 4],
    per_t: [f64; 4],
    unit: [f64; 4],
}

impl PacketSetup {
    /// The set-up of the first `count` of four rays.
    #[inline(always)]
    pub fn new<F: F64x4>(
        proof: F::Proof,
        structure: &AccelerationStructure,
        lattice: &Lattice,
        four: [&Ray; LANES],
        count: usize,
    ) -> Self {
        let splat = |x| F::splat(proof, x);
        let packet = &RayPacket4::<F>::new(proof, four);
        let intervals = intersect_aabb4(&structure.simd_bounds, packet);
        let frame = &structure.cells.frame;
        let [x, y, z] = &packet.axes;
        let (cx, cy, cz) = (splat(frame.center[0]), splat(frame.center[1]), splat(frame.center[2]));
        let max_origin_distance = splat(structure.max_origin_distance);
        let is_in_proven_range = (x.origin - cx).abs().le_mask(max_origin_distance)
            & (y.origin - cy).abs().le_mask(max_origin_distance)
            & (z.origin - cz).abs().le_mask(max_origin_distance);
        let scale = splat(frame.scale);
        let (entry, used) = (intervals.entry, (1 << count) - 1);
        let largest = x.direction.abs().max(y.direction.abs()).max(z.direction.abs());
        let inv_largest = x.inv_direction.abs().min(y.inv_direction.abs()).min(z.inv_direction.abs());
        Self {
            passing: intervals.set & is_in_proven_range & used,
            too_far: !is_in_proven_range & used,
            dda4: Dda4::new(lattice, packet, &intervals),
            origins: [
                to_frame(x, cx, entry, scale).to_f32(),
                to_frame(y, cy, entry, scale).to_f32(),
                to_frame(z, cz, entry, scale).to_f32(),
            ],
            directions: [
                (x.direction * inv_largest).to_f32(),
                (y.direction * inv_largest).to_f32(),
                (z.direction * inv_largest).to_f32(),
            ],
            entry: entry.to_array(),
            per_t: (largest * scale).to_array(),
            unit: (inv_largest * splat(frame.unit)).to_array(),
        }
    }

    /// One of the rays for the filter, up to t = `last`.
    #[inline(always)]
    pub fn filter_state(&self, i: usize, last: f64) -> FilterState {
        let [ox, oy, oz] = &self.origins;
        let [dx, dy, dz] = &self.directions;
        let ray = [[ox[i], oy[i], oz[i], 0.0], [dx[i], dy[i], dz[i], 0.0]];
        FilterState::new(ray, self.entry[i], self.per_t[i], self.unit[i], last)
    }
}
