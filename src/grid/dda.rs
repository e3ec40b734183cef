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
//! cells, so the schedule is off by at most (n + 2) n / 2^30 cells, which is [`drift`]; `proofs/march.g`
//! lets a machine check the parts of this sum. Cells are filled with what touches them widened by it.
//! Then whatever the ray meets at a time t stands in the cell that the schedule names for t, and a
//! search that goes through all cells up to the time of its best hit has missed nothing nearer.

use super::fixed_point::Ticks;
use super::lattice::{Ahead, Lattice};
use super::ray_aabb::{Passage, clip};
use crate::math::extremes::greater;
use crate::math::four::{Four, Plain, TO_WHOLE};
use crate::math::instructions::Portable;
use crate::math::packet::Along;
use crate::math::ray::Ray;

/// The ray's whole way through the lattice, in ticks.
pub const WAY: f64 = (1u64 << 29) as f64;

/// Later than any face that the march comes to, and small enough for one more distance on top.
const NEVER: f64 = (1u64 << 30) as f64;

/// An upper bound on how far the march's idea of the cells' faces is off, in cells.
pub fn drift(lattice: &Lattice) -> f64 {
    let of_axis = |&n: &usize| (n as f64 + SETUP_ROUNDINGS) * n as f64 / (2.0 * WAY);
    lattice.cells().iter().map(of_axis).fold(1e-6, f64::max)
}

/// Roundings of half a tick beside those of the steps: the first face's, and one for all that f64 rounds.
const SETUP_ROUNDINGS: f64 = 2.0;

/// A position on the march through a lattice.
#[derive(Clone, Copy, Debug)]
pub struct March<'l> {
    /// Index of the current cell.
    index: usize,
    /// The tick at which the ray crosses the next face along each axis.
    next: Ticks,
    /// The ticks between such crossings.
    between: Ticks,
    /// What to add to the index, by the set of axes that do not step (bit 0 for x).
    moves: &'l [isize; 16],
    /// t at tick 0.
    entry: f64,
    per_tick: f64,
}

/// What the march takes from the lattice: of all axes, for one ray, or of one axis, for four rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Faces<F> {
    pub low: F,
    pub cell_size: F,
    pub per_unit: F,
    /// The last cell.
    pub last: F,
}

/// When faces are crossed: by one ray along each axis, or by four rays along one axis.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Schedule {
    /// The cell where the march begins.
    pub cell: [i32; 4],
    /// In ticks, as in [`March`].
    pub next: [i32; 4],
    pub between: [i32; 4],
}

impl Schedule {
    /// Of rays that enter the lattice at `entry`. What does not depend on that is computed while the
    /// processor waits for it.
    #[inline(always)]
    pub fn new<F: Four>(faces: &Faces<F>, along: &Along<F>, entry: F, per_tick: F) -> Self {
        let Along { origin, direction, inverse } = *along;
        // In units of cells from here on.
        let from = (origin - faces.low) * faces.per_unit;
        let per_cell = inverse * faces.cell_size;
        // On a face either cell will do: the march corrects it with its first step.
        let at = (from - from.all(0.5)) + entry * (direction * faces.per_unit);
        let at = at.max(from.all(0.0)).min(faces.last);
        let crossing = ((at.round() + (inverse.is_positive() - from)) * per_cell - entry) * per_tick;
        Self {
            cell: at.whole(),
            // Alongside a face the crossing is infinite, or NaN within it.
            next: ticks(crossing.unless_infinite(inverse, NEVER)),
            between: ticks(per_cell.abs() * per_tick),
        }
    }
}

/// The nearest ticks, cut to what the march comes to.
#[inline(always)]
fn ticks<F: Four>(t: F) -> [i32; 4] {
    t.max(t.all(-WAY)).min(t.all(NEVER)).whole()
}

/// Ways through the lattice count as not shorter, so that no division overflows for a ray that but touches
/// a corner.
pub(crate) const SHORTEST_WAY: f64 = f64::MIN_POSITIVE * WAY;

impl<'l> March<'l> {
    /// The march of a ray by itself, and the t at which it enters and leaves the lattice's bounds; none of a
    /// ray that misses them.
    pub fn of_ray(lattice: &'l Lattice, ray: &Ray) -> Option<(Self, [f64; 2])> {
        let along = Along::<Plain>::all_axes(Portable, ray);
        let passage = clip(lattice.slab(), along, ray.t_min, ray.t_max)?;
        Some((Self::new(lattice, &passage), [passage.entry, passage.exit]))
    }

    /// Starts at the cell where a ray's `passage` through the lattice's bounds begins.
    #[inline(always)]
    pub(crate) fn new<F: Four>(lattice: &'l Lattice, passage: &Passage<F>) -> Self {
        let Passage { entry, exit, along } = passage;
        let per_tick = WAY / greater(exit - entry, SHORTEST_WAY);
        let faces = lattice.ahead.faces(along.origin.proof());
        let [start, scale] = [*entry, per_tick].map(|x| along.origin.all(x));
        let schedule = Schedule::new(&faces, along, start, scale);
        Self::scheduled(lattice, &schedule, along.inverse.signs(), *entry, per_tick)
    }

    /// Starts as one ray's schedule says; `backwards` are the axes along which the ray runs backwards.
    #[inline(always)]
    pub(crate) fn scheduled(
        lattice: &'l Lattice,
        schedule: &Schedule,
        backwards: usize,
        entry: f64,
        per_tick: f64,
    ) -> Self {
        let Ahead { strides, moves, .. } = &lattice.ahead;
        Self {
            index: index(schedule.cell, strides),
            next: Ticks::new(schedule.next),
            between: Ticks::new(schedule.between),
            moves: &moves[backwards],
            entry,
            per_tick,
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
        self.next.least()
    }

    /// The first tick not before `t`.
    #[inline(always)]
    pub fn tick(&self, t: f64) -> i32 {
        let after = (t - self.entry) * self.per_tick;
        // Half a tick more, so that the nearest whole number is never before t.
        (if after < NEVER { after + 0.5 } else { NEVER } + TO_WHOLE).to_bits() as i32
    }

    /// Goes on to the next cell, or over an edge or a corner to the one behind it; gives the set of
    /// axes not stepped along.
    #[inline(always)]
    pub fn step(&mut self) -> usize {
        // A ray that but touches a corner may come to "never"; it wraps, and the border ends it.
        let stays = self.next.step(self.between);
        self.index = self.index.wrapping_add_signed(self.moves[stays]);
        stays
    }

    /// What a step along one axis adds to the index.
    pub fn stride(&self, axis: usize) -> isize {
        self.moves[7 & !(1 << axis)]
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

    fn place(lattice: &Lattice, index: usize) -> [i64; 3] {
        lattice.cell_of(index).to_array().map(|i| i as i64)
    }

    fn is_inside(lattice: &Lattice, index: usize) -> bool {
        place(lattice, index).iter().zip(lattice.cells()).all(|(&i, n)| i >= 0 && (i as usize) < n)
    }

    fn cells(ray: &Ray, n: [usize; 3]) -> Vec<[i64; 3]> {
        let lattice = unit(n);
        let Some((mut march, _)) = March::of_ray(&lattice, ray) else { return vec![] };
        let mut list = vec![];
        while is_inside(&lattice, march.index) {
            list.push(place(&lattice, march.index));
            march.step();
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
            let bound = drift(&lattice);
            for k in 0..200u32 {
                let angle = |k: u32| (k as f64 * 0.618_034) % 1.0;
                let target = DVec3::new(angle(k), angle(3 * k + 1), angle(7 * k + 2));
                let origin = DVec3::new(-1.3 + angle(11 * k), 2.0 * angle(5 * k) - 0.5, -0.7);
                let ray = Ray::new(origin, target - origin);
                let Some((mut march, [entry, _])) = March::of_ray(&lattice, &ray) else { continue };
                while is_inside(&lattice, march.index) {
                    let t = entry + march.exit() as f64 / march.per_tick;
                    let at = lattice.to_cells(ray.at(t));
                    let cell = place(&lattice, march.index);
                    for axis in 0..3 {
                        let low = cell[axis] as f64 - bound;
                        assert!(
                            at[axis] >= low && at[axis] <= low + 1.0 + 2.0 * bound,
                            "{n:?} {at} {cell:?}"
                        );
                    }
                    march.step();
                }
            }
        }
    }
}
