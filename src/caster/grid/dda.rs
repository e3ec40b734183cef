//! 3D-DDA: the cells along a ray (Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray
//! Tracing", Eurographics 1987), in fixed point and without branches on the axis.
//!
//! The interval of t in which the ray is inside the lattice is divided into 2^29 fixed-point units. For each
//! axis the DDA keeps the fixed-point t at which the ray crosses the next cell face. The axes for which it is
//! smallest step, and a table of index offsets, indexed by the set of the other axes, gives the next cell.
//! The traversal ends at a border cell.
//!
//! *Error bound.* The fixed-point t of a face is the rounded t of the first face plus an integer multiple of
//! the rounded distance between faces. After k steps along an axis its error is at most (k + 1) / 2 units,
//! plus less than half a unit for the roundings in f64. If the axis has n cells, a cell is at least 2^29 / n
//! units long, so the error is at most (n + 2) n / 2^30 cells, which is [`face_error_bound`]; `proofs/dda.g`
//! proves the parts of this sum. For insertion the cells are padded by this bound. Hence whatever the ray
//! hits at t is listed in the cell that the DDA visits at t, and a query that visits all cells up to the t of
//! its best hit cannot miss a nearer one.

use crate::caster::grid::fixed_t::FixedT;
use crate::caster::grid::lattice::{DdaTables, Lattice, LatticeLanes};
use crate::caster::ray_aabb::{RayInterval, intersect_aabb};
use crate::math::extremes::max;
use crate::math::f64x4::{FourLanes, ROUND_TO_INTEGER};
use crate::math::instructions::Level;
use crate::math::number::Number;
use crate::math::ray::Ray;
use crate::math::ray_lanes::RayLanes;
use fearless_simd::{Simd, dispatch, f64x4};

/// The length of the ray's interval in the lattice, in fixed-point units.
pub const T_ONE: f64 = (1u64 << 29) as f64;

/// The fixed-point t of a face that is never crossed: later than every face in the lattice, and small enough
/// for the distance between two such faces to be added.
const T_NEVER: f64 = (1u64 << 30) as f64;

/// Error bound of the face crossings of a DDA, in cells.
pub fn face_error_bound(lattice: &Lattice) -> f64 {
    let of_axis = |&n: &usize| (n as f64 + SETUP_ROUNDINGS) * n as f64 / (2.0 * T_ONE);
    lattice.cells().iter().map(of_axis).fold(0.0, f64::max)
}

/// Roundings of half a unit in addition to those of the steps: one for the first face, and one for all
/// roundings in f64.
const SETUP_ROUNDINGS: f64 = 2.0;

/// The state of a 3D-DDA: the current cell of a ray in a lattice, and the next face crossings.
#[derive(Clone, Copy, Debug)]
pub struct Dda<'l> {
    /// The index of the current cell.
    index: usize,
    /// The fixed-point t at which the ray crosses the next face along each axis.
    t_next: FixedT,
    /// The distance between face crossings along each axis.
    t_delta: FixedT,
    /// What a step adds to the index, by the set of axes that do not step (bit 0 for x).
    step_offsets: &'l [isize; 16],
    /// The t at fixed-point t 0.
    entry: f64,
    /// Fixed-point units per unit of t.
    fixed_per_t: f64,
}

/// Rounds to the nearest fixed-point t, clamped to the range that the DDA uses.
#[inline(always)]
fn to_fixed<S: Simd>(t: f64x4<S>) -> [i32; 4] {
    t.max(t.broadcast(-T_ONE)).min(t.broadcast(T_NEVER)).to_i32()
}

/// Lower bound on the length of the ray's interval, so that the division by it does not overflow for a ray
/// that only touches a corner.
pub(crate) const MIN_INTERVAL: f64 = f64::MIN_POSITIVE * T_ONE;

impl<'l> Dda<'l> {
    /// The DDA of a single ray, and the t at which the ray enters and leaves the lattice's bounds; none if it
    /// misses them.
    pub fn of_ray(lattice: &'l Lattice, ray: &Ray) -> Option<(Self, [f64; 2])> {
        dispatch!(Level::baseline(), simd => {
            let ray_lanes = RayLanes::all_axes(simd, ray);
            let interval = intersect_aabb(lattice.simd_bounds(), ray_lanes, ray.t_min, ray.t_max);
            interval.map(|interval| (Self::new(lattice, &interval), [interval.entry, interval.exit]))
        })
    }

    /// Starts at the cell in which a ray's interval in the lattice's bounds begins. The expressions are arranged so that
    /// the processor can compute most of them before the start of the interval is known.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(lattice: &'l Lattice, interval: &RayInterval<S>) -> Self {
        let RayInterval { entry, exit, ray_lanes: RayLanes { origin, direction, inv_direction } } = *interval;
        let fixed_per_t = T_ONE / max(exit - entry, MIN_INTERVAL);
        let (entry_lanes, scale) = (origin.broadcast(entry), origin.broadcast(fixed_per_t));
        let DdaTables { strides, step_offsets, .. } = &lattice.tables;
        let LatticeLanes { min, cell_size, cells_per_unit, last_cell } =
            lattice.tables.lattice_lanes(origin.proof());
        // Positions are in units of cells from here on.
        let origin = (origin - min) * cells_per_unit;
        let t_per_cell = inv_direction * cell_size;
        // The difference of 0.5 turns rounding to nearest into rounding down. On a face between two cells the
        // result may be either one, since the first step of the DDA then corrects it.
        let cell = (origin - origin.broadcast(0.5)) + entry_lanes * (direction * cells_per_unit);
        let cell = cell.max(origin.broadcast(0.0)).min(last_cell);
        let to_next_face = cell.round() + (inv_direction.one_where_positive() - origin);
        let crossing = (to_next_face * t_per_cell - entry_lanes) * scale;
        Self {
            index: index(cell.to_i32(), strides),
            // For a ray parallel to the faces the crossing is infinite, or NaN if it lies in a face.
            t_next: FixedT::new(to_fixed(crossing.unless_infinite(inv_direction, T_NEVER))),
            t_delta: FixedT::new(to_fixed(t_per_cell.abs() * scale)),
            step_offsets: &step_offsets[inv_direction.sign_mask()],
            entry,
            fixed_per_t,
        }
    }

    /// The index of the current cell, which is in the lattice or, after a step, on its border.
    #[inline(always)]
    pub fn index(&self) -> usize {
        self.index
    }

    /// The fixed-point t at which the ray leaves the current cell.
    #[inline(always)]
    pub fn exit(&self) -> i32 {
        self.t_next.min3()
    }

    /// The smallest fixed-point t that is not before `t`, clamped to a value later than all faces.
    #[inline(always)]
    pub fn fixed_t(&self, t: f64) -> i32 {
        let exact = (t - self.entry) * self.fixed_per_t;
        // Half a unit is added so that rounding to nearest never rounds down.
        (if exact < T_NEVER { exact + 0.5 } else { T_NEVER } + ROUND_TO_INTEGER).to_bits() as i32
    }

    /// Steps to the next cell, along several axes at once when the ray passes through an edge or a corner.
    /// Returns the set of axes that did not step (bit 0 for x).
    #[inline(always)]
    pub fn step(&mut self) -> usize {
        // For a ray that only touches a corner, t may reach `T_NEVER` and wrap; the traversal still ends at
        // the border.
        let unstepped = self.t_next.step(self.t_delta);
        self.index = self.index.wrapping_add_signed(self.step_offsets[unstepped]);
        unstepped
    }

    /// What a step along one axis adds to the index, with the sign of the ray's direction.
    pub fn stride(&self, axis: usize) -> isize {
        self.step_offsets[7 & !(1 << axis)]
    }
}

/// The index of the cell with these coordinates. It is below 2^32, so wrapping loses nothing.
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
    fn an_axis_parallel_ray_visits_one_line_of_cells() {
        let ray = Ray::new(DVec3::new(-1.0, 0.6, 0.1), DVec3::X);
        assert_eq!(cells(&ray, [3, 2, 1]), [[0, 1, 0], [1, 1, 0], [2, 1, 0]]);
        let reversed = Ray::new(DVec3::new(2.0, 0.6, 0.1), DVec3::NEG_X);
        assert_eq!(cells(&reversed, [3, 2, 1]), [[2, 1, 0], [1, 1, 0], [0, 1, 0]]);
    }

    #[test]
    fn rays_start_inside_the_lattice_outside_it_or_not_at_all() {
        let inside = Ray::new(DVec3::new(0.6, 0.5, 0.5), DVec3::X);
        assert_eq!(cells(&inside, [4, 1, 1]), [[2, 0, 0], [3, 0, 0]]);
        let miss = Ray::new(DVec3::new(0.6, 1.5, 0.5), DVec3::X);
        assert!(cells(&miss, [4, 1, 1]).is_empty());
        let past = Ray::new(DVec3::new(1.6, 0.5, 0.5), DVec3::X);
        assert!(cells(&past, [4, 1, 1]).is_empty());
        let orthographic = Ray { t_min: f64::NEG_INFINITY, ..past };
        assert_eq!(cells(&orthographic, [4, 1, 1]).len(), 4);
        let directionless = Ray::new(DVec3::splat(0.5), DVec3::ZERO);
        assert!(cells(&directionless, [4, 1, 1]).is_empty());
    }

    /// Compares the positions on the ray at all crossings with the faces.
    #[test]
    fn face_crossings_are_within_their_error_bound() {
        for n in [[9, 8, 7], [64, 1, 500], [1000, 1000, 1000], [4096, 3, 2]] {
            let lattice = unit(n);
            let bound = face_error_bound(&lattice);
            for k in 0..200u32 {
                let fraction = |k: u32| (k as f64 * 0.618_034) % 1.0;
                let target = DVec3::new(fraction(k), fraction(3 * k + 1), fraction(7 * k + 2));
                let origin = DVec3::new(-1.3 + fraction(11 * k), 2.0 * fraction(5 * k) - 0.5, -0.7);
                let ray = Ray::new(origin, target - origin);
                let Some((mut dda, [entry, _])) = Dda::of_ray(&lattice, &ray) else { continue };
                while is_inside(&lattice, dda.index) {
                    let t = entry + dda.exit() as f64 / dda.fixed_per_t;
                    let position = lattice.to_cells(ray.at(t));
                    let cell = cell_coords(&lattice, dda.index);
                    for axis in 0..3 {
                        let min = cell[axis] as f64 - bound;
                        assert!(
                            position[axis] >= min && position[axis] <= min + 1.0 + 2.0 * bound,
                            "{n:?} {position} {cell:?}"
                        );
                    }
                    dda.step();
                }
            }
        }
    }

    #[test]
    fn the_face_error_bound_is_that_of_the_axis_with_the_most_cells() {
        let of = |cells: f64| (cells + SETUP_ROUNDINGS) * cells * 2f64.powi(-30);
        assert_eq!(face_error_bound(&unit([3, 4096, 500])), of(4096.0));
        assert_eq!(face_error_bound(&unit([3, 2, 1])), of(3.0));
    }

    #[test]
    fn a_fixed_t_is_the_least_that_is_not_before_its_t() {
        let ray = Ray::new(DVec3::new(-1.0, 0.5, 0.5), DVec3::X);
        let lattice = unit([4, 1, 1]);
        let (dda, [entry, _]) = Dda::of_ray(&lattice, &ray).unwrap();
        for k in [0, 1, 5, 1 << 20, (1 << 29) - 1] {
            let t = |part: f64| entry + (f64::from(k) + part) / dda.fixed_per_t;
            assert_eq!([0.25, 0.75].map(|part| dda.fixed_t(t(part))), [k + 1; 2]);
            assert!((k..=k + 1).contains(&dda.fixed_t(t(0.0))));
        }
        assert_eq!(dda.fixed_t(f64::INFINITY), T_NEVER as i32);
    }

    #[test]
    fn a_ray_that_only_touches_the_box_has_finite_steps() {
        let ray = Ray::new(DVec3::new(-1.0, 1.0, 0.5), DVec3::new(1.0, -1.0, 0.0));
        let lattice = unit([4, 4, 4]);
        let (dda, [entry, exit]) = Dda::of_ray(&lattice, &ray).unwrap();
        assert_eq!(entry, exit);
        assert!(dda.fixed_per_t.is_finite(), "{}", dda.fixed_per_t);
    }
}
