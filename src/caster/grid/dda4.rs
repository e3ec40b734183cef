//! The set-up of the [`Dda`] for a packet of four rays at once, with the same results as for each ray alone.

use crate::caster::grid::dda::{Dda, DdaSetup, MIN_INTERVAL, T_ONE};
use crate::caster::grid::lattice::Lattice;
use crate::caster::ray_aabb::RayIntervals;
use crate::math::f64x4::F64x4;
use crate::math::ray_lanes::RayPacket4;

/// The initial states of the DDAs of four rays. That of a ray that misses the lattice is meaningless.
#[derive(Clone, Copy, Debug)]
pub struct Dda4 {
    axes: [DdaSetup; 3],
    /// The set of axes along which the direction of each ray is negative (bit 0 for x).
    negative_axes: [i32; 4],
    entry: [f64; 4],
    fixed_per_t: [f64; 4],
}

impl Dda4 {
    /// Of rays with these intervals in the lattice's bounds.
    #[inline(always)]
    pub fn new<F: F64x4>(lattice: &Lattice, packet: &RayPacket4<F>, intervals: &RayIntervals<F>) -> Self {
        let RayIntervals { entry, exit, .. } = *intervals;
        let fixed_per_t = exit.broadcast(T_ONE) / (exit - entry).max(exit.broadcast(MIN_INTERVAL));
        let [x, y, z] = &packet.axes;
        let (tables, proof) = (&lattice.tables, entry.proof());
        let negative_axes = x.inv_direction.where_negative(1.0)
            + y.inv_direction.where_negative(2.0)
            + z.inv_direction.where_negative(4.0);
        Self {
            axes: [
                DdaSetup::new(&tables.lattice_lanes_of_axis(proof, 0), x, entry, fixed_per_t),
                DdaSetup::new(&tables.lattice_lanes_of_axis(proof, 1), y, entry, fixed_per_t),
                DdaSetup::new(&tables.lattice_lanes_of_axis(proof, 2), z, entry, fixed_per_t),
            ],
            negative_axes: negative_axes.to_i32(),
            entry: entry.to_array(),
            fixed_per_t: fixed_per_t.to_array(),
        }
    }

    /// The DDA of one of the rays.
    #[inline(always)]
    pub fn dda<'l>(&self, lattice: &'l Lattice, ray: usize) -> Dda<'l> {
        let [x, y, z] = &self.axes;
        let setup = DdaSetup {
            cell: [x.cell[ray], y.cell[ray], z.cell[ray], 0],
            t_next: [x.t_next[ray], y.t_next[ray], z.t_next[ray], 0],
            t_delta: [x.t_delta[ray], y.t_delta[ray], z.t_delta[ray], 0],
        };
        let negative_axes = self.negative_axes[ray] as usize & 7;
        Dda::with_setup(lattice, &setup, negative_axes, self.entry[ray], self.fixed_per_t[ray])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caster::ray_aabb::{intersect_aabb, intersect_aabb4};
    use crate::math::aabb::Aabb;
    use crate::math::f64x4::Scalar;
    use crate::math::instructions::Portable;
    use crate::math::ray::Ray;
    use crate::math::ray_lanes::RayLanes;
    use glam::DVec3;

    /// The indices of the cells that a DDA visits in a lattice of `cells`, with the fixed-point t at which it
    /// leaves each, including a few steps beyond the lattice.
    fn visited(mut dda: Dda, cells: [usize; 3]) -> Vec<(usize, i32)> {
        let mut visited = vec![];
        for _ in 0..cells.iter().sum() {
            visited.push((dda.index(), dda.exit()));
            dda.step();
        }
        visited
    }

    #[test]
    fn four_rays_visit_the_same_cells_as_each_alone() {
        let cells = [9, 1, 20];
        let lattice = Lattice::new(Aabb { min: DVec3::new(-1.0, 2.0, 0.0), max: DVec3::splat(3.0) }, cells);
        let coordinate = |k: u32| (f64::from(k) * 0.618_034).fract() * 6.0 - 1.5;
        let ray = |k: u32| {
            let [origin, target] = [k, k + 50].map(|k| DVec3::from([1, 3, 7].map(|n| coordinate(n * k))));
            let direction =
                if k.is_multiple_of(5) { DVec3::AXES[k as usize / 5 % 3] } else { target - origin };
            let t_max = if k.is_multiple_of(3) { 0.5 } else { f64::INFINITY };
            Ray { t_max, ..Ray::new(origin, direction * if k.is_multiple_of(2) { 1.0 } else { -1.0 }) }
        };
        let mut entered = 0;
        for first in (0..4000).step_by(4) {
            let rays = [0, 1, 2, 3].map(|i| ray(first + i));
            let packet = RayPacket4::<Scalar>::new(Portable, rays.each_ref());
            let intervals = intersect_aabb4(lattice.simd_bounds(), &packet);
            let dda4 = Dda4::new(&lattice, &packet, &intervals);
            for (i, ray) in rays.iter().enumerate() {
                let interval = intersect_aabb(
                    lattice.simd_bounds(),
                    RayLanes::<Scalar>::all_axes(Portable, ray),
                    ray.t_min,
                    ray.t_max,
                );
                assert_eq!(intervals.set >> i & 1 != 0, interval.is_some(), "{ray:?}");
                if let Some(interval) = interval {
                    let (single, of_packet) = (Dda::new(&lattice, &interval), dda4.dda(&lattice, i));
                    assert_eq!(visited(of_packet, cells), visited(single, cells), "{ray:?}");
                    entered += 1;
                }
            }
        }
        assert!(entered > 500, "{entered}");
    }
}
