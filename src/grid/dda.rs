//! 3D-DDA: the cells along a ray (Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray
//! Tracing", Eurographics 1987), in fixed point and without branches on the axis.
//!
//! The ray's way through the lattice is cut into 2^29 ticks. Each axis holds the tick at which the
//! ray crosses its next face; the least decides, and a table of index strides, looked up by which
//! axes are least, moves on. A border cell ends the march.
//!
//! *Drift.* A face's tick is the rounded one of the first face plus a whole number of rounded
//! distances, so after k steps along an axis it is off by at most (k + 1) / 2 ticks, and by less than
//! half a tick more for what f64 rounds. A cell of that axis is at least 2^29 / n ticks long for n
//! cells, so the schedule is off by at most (n + 2) n / 2^30 cells, which is [`face_error_bound`]; `proofs/dda.g`
//! lets a machine check the parts of this sum. Cells are filled with what touches them widened by it.
//! Then whatever the ray meets at a time t stands in the cell that the schedule names for t, and a
//! search that goes through all cells up to the time of its best hit has missed nothing nearer.

use super::fixed_t::FixedT;
use super::lattice::{DdaTables, Lattice};
use super::ray_aabb::{RayInterval, intersect_aabb};
use crate::math::extremes::max;
use crate::math::f64x4::{F64x4, ROUND_TO_INTEGER, Scalar};
use crate::math::instructions::Portable;
use crate::math::ray::Ray;
use crate::math::ray_lanes::RayLanes;

/// The ray's whole way through the lattice, in ticks.
pub const T_ONE: f64 = (1u64 << 29) as f64;

/// Later than any face that the march comes to, and small enough for one more distance on top.
const T_NEVER: f64 = (1u64 << 30) as f64;

/// An upper bound on how far the march's idea of the cells' faces is off, in cells.
pub fn face_error_bound(lattice: &Lattice) -> f64 {
    let of_axis = |&n: &usize| (n as f64 + SETUP_ROUNDINGS) * n as f64 / (2.0 * T_ONE);
    lattice.cells().iter().map(of_axis).fold(1e-6, f64::max)
}

/// Roundings of half a tick beside those of the steps: the first face's, and one for all that f64 rounds.
const SETUP_ROUNDINGS: f64 = 2.0;

/// A position on the march through a lattice.
#[derive(Clone, Copy, Debug)]
pub struct Dda<'l> {
    /// Index of the current cell.
    index: usize,
    /// The tick at which the ray crosses the next face along each axis.
    t_next: FixedT,
    /// The ticks between such crossings.
    t_delta: FixedT,
    /// What to add to the index, by the set of axes that do not step (bit 0 for x).
    step_offsets: &'l [isize; 16],
    /// t at tick 0.
    entry: f64,
    fixed_per_t: f64,
}

/// What the march takes from the lattice: of all axes, for one ray, or of one axis, for four rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LatticeLanes<F> {
    pub low: F,
    pub cell_size: F,
    pub cells_per_unit: F,
    /// The last cell.
    pub last: F,
}

/// When faces are crossed: by one ray along each axis, or by four rays along one axis.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct DdaSetup {
    /// The cell where the march begins.
    pub cell: [i32; 4],
    /// In ticks, as in [`Dda`].
    pub t_next: [i32; 4],
    pub t_delta: [i32; 4],
}

impl DdaSetup {
    /// Of rays that enter the lattice at `entry`. What does not depend on that is computed while the
    /// processor waits for it.
    #[inline(always)]
    pub fn new<F: F64x4>(
        lattice_lanes: &LatticeLanes<F>,
        ray_lanes: &RayLanes<F>,
        entry: F,
        fixed_per_t: F,
    ) -> Self {
        let RayLanes { origin, direction, inv_direction } = *ray_lanes;
        // In units of cells from here on.
        let from = (origin - lattice_lanes.low) * lattice_lanes.cells_per_unit;
        let per_cell = inv_direction * lattice_lanes.cell_size;
        // On a face either cell will do: the march corrects it with its first step.
        let at = (from - from.broadcast(0.5)) + entry * (direction * lattice_lanes.cells_per_unit);
        let at = at.max(from.broadcast(0.0)).min(lattice_lanes.last);
        let crossing =
            ((at.round() + (inv_direction.one_where_positive() - from)) * per_cell - entry) * fixed_per_t;
        Self {
            cell: at.to_i32(),
            // Alongside a face the crossing is infinite, or NaN within it.
            t_next: to_fixed(crossing.unless_infinite(inv_direction, T_NEVER)),
            t_delta: to_fixed(per_cell.abs() * fixed_per_t),
        }
    }
}

/// The nearest ticks, cut to what the march comes to.
#[inline(always)]
fn to_fixed<F: F64x4>(t: F) -> [i32; 4] {
    t.max(t.broadcast(-T_ONE)).min(t.broadcast(T_NEVER)).to_i32()
}

/// Ways through the lattice count as not shorter, so that no division overflows for a ray that but touches
/// a corner.
pub(crate) const SHORTEST_INTERVAL: f64 = f64::MIN_POSITIVE * T_ONE;

impl<'l> Dda<'l> {
    /// The march of a ray by itself, and the t at which it enters and leaves the lattice's bounds; none of a
    /// ray that misses them.
    pub fn of_ray(lattice: &'l Lattice, ray: &Ray) -> Option<(Self, [f64; 2])> {
        let ray_lanes = RayLanes::<Scalar>::all_axes(Portable, ray);
        let interval = intersect_aabb(lattice.simd_bounds(), ray_lanes, ray.t_min, ray.t_max)?;
        Some((Self::new(lattice, &interval), [interval.entry, interval.exit]))
    }

    /// Starts at the cell where a ray's `interval` through the lattice's bounds begins.
    #[inline(always)]
    pub(crate) fn new<F: F64x4>(lattice: &'l Lattice, interval: &RayInterval<F>) -> Self {
        let RayInterval { entry, exit, ray_lanes } = interval;
        let fixed_per_t = T_ONE / max(exit - entry, SHORTEST_INTERVAL);
        let lattice_lanes = lattice.tables.lattice_lanes(ray_lanes.origin.proof());
        let [start, scale] = [*entry, fixed_per_t].map(|x| ray_lanes.origin.broadcast(x));
        let setup = DdaSetup::new(&lattice_lanes, ray_lanes, start, scale);
        Self::with_setup(lattice, &setup, ray_lanes.inv_direction.sign_mask(), *entry, fixed_per_t)
    }

    /// Starts as one ray's schedule says; `backwards` are the axes along which the ray runs backwards.
    #[inline(always)]
    pub(crate) fn with_setup(
        lattice: &'l Lattice,
        setup: &DdaSetup,
        backwards: usize,
        entry: f64,
        fixed_per_t: f64,
    ) -> Self {
        let DdaTables { strides, step_offsets, .. } = &lattice.tables;
        Self {
            index: index(setup.cell, strides),
            t_next: FixedT::new(setup.t_next),
            t_delta: FixedT::new(setup.t_delta),
            step_offsets: &step_offsets[backwards],
            entry,
            fixed_per_t,
        }
    }

    /// Index of the current cell: one of the lattice or, after a step, of its border.
    #[inline(always)]
    pub fn index(&self) -> usize {
        self.index
    }

    /// The tick at which the ray leaves the current cell.
    #[inline(always)]
    pub fn exit(&self) -> i32 {
        self.t_next.min3()
    }

    /// The first tick not before `t`.
    #[inline(always)]
    pub fn fixed_t(&self, t: f64) -> i32 {
        let after = (t - self.entry) * self.fixed_per_t;
        // Half a tick more, so that the nearest whole number is never before t.
        (if after < T_NEVER { after + 0.5 } else { T_NEVER } + ROUND_TO_INTEGER).to_bits() as i32
    }

    /// Goes on to the next cell, or over an edge or a corner to the one behind it; gives the set of
    /// axes not stepped along.
    #[inline(always)]
    pub fn step(&mut self) -> usize {
        // A ray that but touches a corner may come to "never"; it wraps, and the border ends it.
        let stays = self.t_next.step(self.t_delta);
        self.index = self.index.wrapping_add_signed(self.step_offsets[stays]);
        stays
    }

    /// What a step along one axis adds to the index.
    pub fn stride(&self, axis: usize) -> isize {
        self.step_offsets[7 & !(1 << axis)]
    }
}

/// The index of a cell, by its numbers along the axes. Less than 2^32, so that nothing is lost.
#[inline(always)]
fn index([x, y, z, _]: [i32; 4], [_, sy, sz]: &[u32; 3]) -> usize {
    let [x, y, z] = [x, y, z].map(|i| i as u32 + 1);
    x.wrapping_add(y.wrapping_mul(*sy)).wrapping_add(z.wrapping_mul(*sz)) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::aabb::Aabb;
    use glam::DVec3;

    fn unit(n: [usize; 3]) -> Lattice {
        Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::ONE }, n)
    }

    fn cell_coords(lattice: &Lattice, index: usize) -> [i64; 3] {
        lattice.cell_of(index).to_array().map(|i| i as i64)
    }

    fn is_inside(lattice: &Lattice, index: usize) -> bool {
        cell_coords(lattice, index).iter().zip(lattice.cells()).all(|(&i, n)| i >= 0 && (i as usize) < n)
    }

    fn cells(ray: &Ray, n: [usize; 3]) -> Vec<[i64; 3]> {
        let lattice = unit(n);
        let Some((mut dda, _)) = Dda::of_ray(&lattice, ray) else { return vec![] };
        let mut list = vec![];
        while is_inside(&lattice, dda.index) {
            list.push(cell_coords(&lattice, dda.index));
            dda.step();
        }
        list
    }

    #[test]
    fn an_axis_parallel_ray_visits_one_row() {
        let ray = Ray::new(DVec3::new(-1.0, 0.6, 0.1), DVec3::X);
        assert_eq!(cells(&ray, [3, 2, 1]), [[0, 1, 0], [1, 1, 0], [2, 1, 0]]);
        let back = Ray::new(DVec3::new(2.0, 0.6, 0.1), DVec3::NEG_X);
        assert_eq!(cells(&back, [3, 2, 1]), [[2, 1, 0], [1, 1, 0], [0, 1, 0]]);
    }

    #[test]
    fn three_ways_to_start() {
        let inside = Ray::new(DVec3::new(0.6, 0.5, 0.5), DVec3::X);
        assert_eq!(cells(&inside, [4, 1, 1]), [[2, 0, 0], [3, 0, 0]]);
        let miss = Ray::new(DVec3::new(0.6, 1.5, 0.5), DVec3::X);
        assert!(cells(&miss, [4, 1, 1]).is_empty());
        let past = Ray::new(DVec3::new(1.6, 0.5, 0.5), DVec3::X);
        assert!(cells(&past, [4, 1, 1]).is_empty());
        let orthographic = Ray { t_min: f64::NEG_INFINITY, ..past };
        assert_eq!(cells(&orthographic, [4, 1, 1]).len(), 4);
        let still = Ray::new(DVec3::splat(0.5), DVec3::ZERO);
        assert!(cells(&still, [4, 1, 1]).is_empty());
    }

    /// Against exact positions: at every crossing the schedule is off by less than the drift.
    #[test]
    fn the_schedule_keeps_within_its_drift() {
        for n in [[9, 8, 7], [64, 1, 500], [1000, 1000, 1000], [4096, 3, 2]] {
            let lattice = unit(n);
            let bound = face_error_bound(&lattice);
            for k in 0..200u32 {
                let angle = |k: u32| (k as f64 * 0.618_034) % 1.0;
                let target = DVec3::new(angle(k), angle(3 * k + 1), angle(7 * k + 2));
                let origin = DVec3::new(-1.3 + angle(11 * k), 2.0 * angle(5 * k) - 0.5, -0.7);
                let ray = Ray::new(origin, target - origin);
                let Some((mut dda, [entry, _])) = Dda::of_ray(&lattice, &ray) else { continue };
                while is_inside(&lattice, dda.index) {
                    let t = entry + dda.exit() as f64 / dda.fixed_per_t;
                    let at = lattice.to_cells(ray.at(t));
                    let cell = cell_coords(&lattice, dda.index);
                    for axis in 0..3 {
                        let low = cell[axis] as f64 - bound;
                        assert!(
                            at[axis] >= low && at[axis] <= low + 1.0 + 2.0 * bound,
                            "{n:?} {at} {cell:?}"
                        );
                    }
                    dda.step();
                }
            }
        }
    }
}
