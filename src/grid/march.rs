//! 3D-DDA: the cells along a ray (Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray
//! Tracing", Eurographics 1987), in fixed point and without branches on the axis.
//!
//! The ray's way through the lattice is cut into 2^29 ticks. Each axis holds the tick at which the
//! ray crosses its next face; the least decides, and a table of index strides, looked up by which
//! axes are least, moves on. A border cell ends the march.
//!
//! *Drift.* A face's tick is the rounded one of the first face plus a whole number of rounded
//! distances, so after k steps along an axis it is off by at most (k + 1) / 2 ticks, and by two more
//! for the setup's f64 rounding. A cell of that axis is at least 2^29 / n ticks long for n cells, so
//! the schedule is off by at most (n + 5) n / 2^30 cells. [`drift`] gives twice that; cells are
//! filled with what touches them widened by it. Then whatever the ray meets at a time t stands in
//! the cell that the schedule names for t, and a search that goes through all cells up to the time
//! of its best hit has missed nothing nearer.

use super::ticks::Ticks;
use super::{Ahead, Lattice};
use crate::math::aabb::Aabb;
use crate::math::four::Four;
use crate::math::ray::Ray;

/// The ray's whole way through the lattice, in ticks.
const WAY: f64 = (1u64 << 29) as f64;

/// Later than any face that the march comes to, and small enough for one more distance on top.
const NEVER: f64 = (1u64 << 30) as f64;

/// An upper bound on how far the march's idea of the cells' faces is off, in cells.
pub fn drift(lattice: &Lattice) -> f64 {
    lattice.cells.iter().map(|&n| (n as f64 + 5.0) * n as f64 / WAY).fold(1e-6, f64::max)
}

/// A position on the march through a lattice.
#[derive(Clone, Copy, Debug)]
pub struct March<'l> {
    /// Index of the current cell, in the lattice or on its border.
    pub index: usize,
    /// The tick at which the ray crosses the next face along each axis.
    next: Ticks,
    /// The ticks between such crossings.
    between: Ticks,
    /// What to add to the index, by the set of axes that step (bit 0 for x).
    moves: &'l [isize; 8],
    clock: Clock,
}

/// Turns t into ticks.
#[derive(Clone, Copy, Debug)]
struct Clock {
    /// t at tick 0.
    entry: f64,
    per_tick: f64,
}

/// Where a ray enters and leaves a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    pub entry: f64,
    pub exit: f64,
    origin: Four,
    direction: Four,
    /// One over the direction.
    inverse: Four,
}

impl<'l> March<'l> {
    /// Starts at the cell where a ray's `passage` through the lattice's bounds begins.
    #[inline(always)]
    pub fn new(lattice: &'l Lattice, passage: &Passage) -> Self {
        let Passage { entry, exit, origin, direction, inverse } = *passage;
        let Ahead { low, cell_size, per_unit, last, strides, moves } = &lattice.ahead;
        // Long enough that no division overflows, for a ray that but touches a corner.
        let length = (exit - entry).max(f64::MIN_POSITIVE * WAY);
        let clock = Clock { entry, per_tick: WAY / length };
        let (entry, per_tick) = (Four::splat(entry), Four::splat(clock.per_tick));
        // On a face either cell will do: the march corrects it with its first step.
        let start = (origin + entry * direction - *low) * *per_unit - Four::splat(0.5);
        let cell = start.max(Four::splat(0.0)).min(*last).map(|x| (x + TO_WHOLE) - TO_WHOLE);
        let ahead = inverse.map(|x| if x > 0.0 { 1.0 } else { 0.0 });
        let face = *low + *cell_size * (cell + ahead);
        let crossing = ((face - origin) * inverse - entry) * per_tick;
        // Alongside a face the crossing is infinite, or NaN within it.
        let crossing = crossing.zip(inverse, |t, x| if x.abs() == f64::INFINITY { NEVER } else { t });
        let between = *cell_size * inverse.map(f64::abs) * per_tick;
        let [x, y, z, _] = ((cell + Four::splat(1.0)) * *strides).0;
        let backwards = |axis: usize| usize::from(ahead.0[axis] == 0.0) << axis;
        Self {
            index: (x + y + z + TO_WHOLE).to_bits() as u32 as usize,
            next: ticks(crossing),
            between: ticks(between),
            moves: &moves[backwards(0) | backwards(1) | backwards(2)],
            clock,
        }
    }

    /// The tick at which the ray leaves the current cell.
    #[inline(always)]
    pub fn exit(&self) -> i32 {
        self.next.least()
    }

    /// The first tick not before `t`.
    #[inline(always)]
    pub fn tick(&self, t: f64) -> i32 {
        let after = (t - self.clock.entry) * self.clock.per_tick;
        // Half a tick more, so that the nearest whole number is never before t.
        (if after < NEVER { after + 0.5 } else { NEVER } + TO_WHOLE).to_bits() as i32
    }

    /// Goes on to the next cell, or over an edge or a corner to the one behind it; gives the set of
    /// axes stepped along.
    #[inline(always)]
    pub fn step(&mut self) -> usize {
        // A ray that but touches a corner may come to "never"; it wraps, and the border ends it.
        let set = self.next.step(self.between);
        self.index = self.index.wrapping_add_signed(self.moves[set]);
        set
    }

    /// What a step along one axis adds to the index.
    pub fn stride(&self, axis: usize) -> isize {
        self.moves[1 << axis]
    }
}

/// Added to a number below 2^31 it leaves no bits for a fraction, and the nearest whole number in
/// the lowest ones: 1.5 * 2^52. Faster than a conversion that must also say what becomes of others.
const TO_WHOLE: f64 = 6_755_399_441_055_744.0;

/// The nearest ticks, cut to what the march comes to.
#[inline(always)]
fn ticks(t: Four) -> Ticks {
    let cut = t.max(Four::splat(-WAY)).min(Four::splat(NEVER));
    let [x, y, z, _] = cut.0.map(|t| (t + TO_WHOLE).to_bits() as i32);
    Ticks::new([x, y, z])
}

/// Where the ray enters and leaves the box, if it does so before it ends.
#[inline(always)]
pub fn clip(bounds: &Aabb, ray: &Ray) -> Option<Passage> {
    let (origin, direction) = (Four::new(ray.origin, 0.0), Four::new(ray.direction, 1.0));
    let inverse = direction.map(|d| 1.0 / d);
    let low = (Four::new(bounds.min, 0.0) - origin) * inverse;
    let high = (Four::new(bounds.max, 0.0) - origin) * inverse;
    let (near, far) = (low.min(high).0, low.max(high).0);
    let greater = |a: f64, b: f64| if a > b { a } else { b };
    let lesser = |a: f64, b: f64| if a < b { a } else { b };
    let entry = greater(greater(near[0], near[1]), greater(near[2], ray.t_min));
    let exit = lesser(lesser(far[0], far[1]), far[2]);
    // A ray without direction never gets out again.
    let passes = entry <= exit && entry <= ray.t_max && exit < f64::INFINITY;
    passes.then_some(Passage { entry, exit, origin, direction, inverse })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn unit(n: [usize; 3]) -> Lattice {
        Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::ONE }, n)
    }

    fn place(lattice: &Lattice, index: usize) -> [i64; 3] {
        lattice.cell_of(index).to_array().map(|i| i as i64)
    }

    fn is_inside(lattice: &Lattice, index: usize) -> bool {
        place(lattice, index).iter().zip(lattice.cells).all(|(&i, n)| i >= 0 && (i as usize) < n)
    }

    fn cells(ray: &Ray, n: [usize; 3]) -> Vec<[i64; 3]> {
        let lattice = unit(n);
        let Some(passage) = clip(&lattice.bounds, ray) else { return vec![] };
        let mut march = March::new(&lattice, &passage);
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
                let Some(passage) = clip(&lattice.bounds, &ray) else { continue };
                let mut march = March::new(&lattice, &passage);
                while is_inside(&lattice, march.index) {
                    let t = passage.entry + march.exit() as f64 / march.clock.per_tick;
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
