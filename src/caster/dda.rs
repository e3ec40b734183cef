//! 3D-DDA: visits the cells along a ray (Amanatides and Woo, "A Fast Voxel Traversal Algorithm for Ray Tracing",
//! Eurographics 1987), in fixed point and without branches on the axis.
//!
//! The interval of t in which the ray is inside the lattice is divided into 2^29 fixed-point units. For each axis the
//! DDA keeps the fixed-point t at which the ray crosses the next cell face. The axes with the smallest such t step. A
//! table of index offsets, indexed by the set of the other axes, gives the next cell. The traversal ends at a border
//! cell.
//!
//! *Error bound.* The fixed-point t of a face is the rounded t of the first face plus an integer multiple of the
//! rounded distance between faces. After k steps along an axis its error is at most (k + 1) / 2 units, plus less than
//! half a unit for the roundings in f64. If the axis has n cells, a cell is at least 2^29 / n units long, so the error
//! is at most (n + 2) n / 2^30 cells, which is [`face_error_bound`]; `proofs/dda.g` proves the parts of this sum.
//! Insertion pads the cells by this bound. Hence a primitive that the ray hits at t is listed in the cell that the DDA
//! visits at t, and a query that visits all cells up to the t of its best hit cannot miss a nearer one.

use crate::caster::bounds::{RayInterval, intersect_aabb};
use crate::caster::lattice::Lattice;
use crate::math::extremes::max;
use crate::math::instructions::Level;
use crate::math::ray::Ray;
use crate::math::simd::{FourLanes, Number, ROUND_TO_INTEGER, RayLanes};
use fearless_simd::{Simd, SimdFrom, dispatch, f64x4};
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

/// The length of the ray's interval in the lattice, in fixed-point units.
pub const T_ONE: f64 = (1u64 << 29) as f64;

/// The fixed-point t of a face that is never crossed: later than every face in the lattice, and small enough
/// for the distance between two such faces to be added.
const T_NEVER: f64 = (1u64 << 30) as f64;

/// Returns the error bound of the face crossings of a DDA, in cells.
pub fn face_error_bound(lattice: &Lattice) -> f64 {
    let of_axis = |&n: &usize| (n as f64 + SETUP_ROUNDINGS) * n as f64 / (2.0 * T_ONE);
    lattice.cells().iter().map(of_axis).fold(0.0, f64::max)
}

/// The roundings of half a unit that come before the steps: one for the first face, and one for all roundings in f64.
const SETUP_ROUNDINGS: f64 = 2.0;

/// The fixed-point t of the next face crossing along each axis. On x86-64 the three share an SSE2 register, which every
/// such processor has.
#[derive(Clone, Copy, Debug)]
pub struct FixedT(#[cfg(target_arch = "x86_64")] __m128i, #[cfg(not(target_arch = "x86_64"))] [i32; 4]);

#[cfg(target_arch = "x86_64")]
impl FixedT {
    /// Stores the t along x, y and z; the fourth lane is ignored.
    #[inline(always)]
    pub fn new(lanes: [i32; 4]) -> Self {
        Self(bytemuck::cast(lanes))
    }

    /// Returns the minimum of the three.
    #[inline(always)]
    pub fn min3(self) -> i32 {
        let t = self.0;
        // SAFETY: every x86-64 processor has SSE2, and intrinsics without pointers have no further
        // requirements.
        unsafe {
            let y = _mm_shuffle_epi32::<0b01_01_01_01>(t);
            let z = _mm_shuffle_epi32::<0b10_10_10_10>(t);
            _mm_cvtsi128_si32(min(min(t, y), z))
        }
    }

    /// Adds `t_delta` to all lanes that equal the minimum, wrapping on overflow, and returns the set of the
    /// other axes (bit 0 for x).
    #[inline(always)]
    pub fn step(&mut self, t_delta: Self) -> usize {
        let t = self.0;
        // The unused lane is compared with itself, so it is never in the set. SAFETY: every x86-64 processor
        // has SSE2, and intrinsics without pointers have no further requirements.
        unsafe {
            let yzx = _mm_shuffle_epi32::<0b11_00_10_01>(t);
            let zxy = _mm_shuffle_epi32::<0b11_01_00_10>(t);
            let unstepped = _mm_or_si128(_mm_cmpgt_epi32(t, yzx), _mm_cmpgt_epi32(t, zxy));
            self.0 = _mm_add_epi32(t, _mm_andnot_si128(unstepped, t_delta.0));
            _mm_movemask_ps(_mm_castsi128_ps(unstepped)) as usize
        }
    }
}

/// Returns the lane-wise minimum.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn min(a: __m128i, b: __m128i) -> __m128i {
    // SAFETY: every x86-64 processor has SSE2, and intrinsics without pointers have no further requirements.
    unsafe {
        let less = _mm_cmplt_epi32(a, b);
        _mm_or_si128(_mm_and_si128(less, a), _mm_andnot_si128(less, b))
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl FixedT {
    /// Stores the t along x, y and z; the fourth lane is ignored.
    #[inline(always)]
    pub fn new(lanes: [i32; 4]) -> Self {
        Self(lanes)
    }

    /// Returns the minimum of the three.
    #[inline(always)]
    pub fn min3(self) -> i32 {
        let [x, y, z, _] = self.0;
        x.min(y).min(z)
    }

    /// Adds `t_delta` to all lanes that equal the minimum, wrapping on overflow, and returns the set of the
    /// other axes (bit 0 for x).
    #[inline(always)]
    pub fn step(&mut self, t_delta: Self) -> usize {
        let (min, mut unstepped) = (self.min3(), 0);
        for axis in 0..3 {
            let steps = self.0[axis] == min;
            self.0[axis] = self.0[axis].wrapping_add(if steps { t_delta.0[axis] } else { 0 });
            unstepped |= usize::from(!steps) << axis;
        }
        unstepped
    }
}

/// The state of a 3D-DDA: the current cell of a ray in a lattice, and the next face crossings.
#[derive(Clone, Copy, Debug)]
pub struct Dda<'l> {
    /// The index of the current cell.
    index: usize,
    /// The fixed-point t at which the ray crosses the next face along each axis.
    t_next: FixedT,
    /// The distance between face crossings along each axis.
    t_delta: FixedT,
    /// The offset that a step adds to the index, by the set of axes that do not step (bit 0 for x).
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
    /// Returns the DDA of a single ray, and the t at which the ray enters and leaves the lattice's bounds; `None` if it
    /// misses them.
    pub fn of_ray(lattice: &'l Lattice, ray: &Ray) -> Option<(Self, [f64; 2])> {
        dispatch!(Level::baseline(), simd => {
            let ray_lanes = RayLanes::all_axes(simd, ray);
            let interval = intersect_aabb(&lattice.simd_bounds, ray_lanes, ray.t_min, ray.t_max);
            interval.map(|interval| (Self::new(lattice, &interval), [interval.entry, interval.exit]))
        })
    }

    /// Starts at the cell in which a ray's interval in the lattice's bounds begins. The expressions are arranged so
    /// that the processor can compute most of them before it knows the start of the interval.
    #[inline(always)]
    pub(crate) fn new<S: Simd>(lattice: &'l Lattice, interval: &RayInterval<S>) -> Self {
        let RayInterval { entry, exit, ray_lanes: RayLanes { origin, direction, inv_direction } } = *interval;
        let fixed_per_t = T_ONE / max(exit - entry, MIN_INTERVAL);
        let (entry_lanes, scale) = (origin.broadcast(entry), origin.broadcast(fixed_per_t));
        let lanes = |table: [f64; 4]| f64x4::simd_from(origin.proof(), table);
        let (min, cell_size) = (lanes(lattice.simd_bounds.min), lanes(lattice.cell_size_lanes));
        let (cells_per_unit, last_cell) = (lanes(lattice.cells_per_unit), lanes(lattice.last_cell));
        // From here on, positions are in units of cells.
        let origin = (origin - min) * cells_per_unit;
        let t_per_cell = inv_direction * cell_size;
        // The difference of 0.5 turns rounding to nearest into rounding down. On a face between two cells the
        // result may be either one, since the first step of the DDA then corrects it.
        let cell = (origin - origin.broadcast(0.5)) + entry_lanes * (direction * cells_per_unit);
        let cell = cell.max(origin.broadcast(0.0)).min(last_cell);
        let (zero, one) = (origin.broadcast(0.0), origin.broadcast(1.0));
        let ahead = zero.select_lt(inv_direction, one, zero);
        let to_next_face = ((cell + ROUND_TO_INTEGER) - ROUND_TO_INTEGER) + (ahead - origin);
        let crossing = (to_next_face * t_per_cell - entry_lanes) * scale;
        // For a ray parallel to the faces the crossing is infinite, or NaN if it lies in a face.
        let finite = origin.broadcast(f64::MAX);
        let crossing = finite.select_lt(inv_direction.abs(), origin.broadcast(T_NEVER), crossing);
        Self {
            index: index(cell.to_i32(), &lattice.strides),
            t_next: FixedT::new(to_fixed(crossing)),
            t_delta: FixedT::new(to_fixed(t_per_cell.abs() * scale)),
            step_offsets: &lattice.step_offsets[inv_direction.sign_mask()],
            entry,
            fixed_per_t,
        }
    }

    /// Returns the index of the current cell, which is in the lattice or, after a step, on its border.
    #[inline(always)]
    pub fn index(&self) -> usize {
        self.index
    }

    /// Returns the fixed-point t at which the ray leaves the current cell.
    #[inline(always)]
    pub fn exit(&self) -> i32 {
        self.t_next.min3()
    }

    /// Returns the smallest fixed-point t that is not before `t`, clamped to a value later than all faces.
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

    /// Returns the offset that a step along one axis adds to the index, with the sign of the ray's direction.
    pub fn stride(&self, axis: usize) -> isize {
        self.step_offsets[7 & !(1 << axis)]
    }
}

/// Returns the index of the cell with these coordinates. It is less than 2^32, so wrapping loses nothing.
#[inline(always)]
fn index([x, y, z, _]: [i32; 4], [_, sy, sz]: &[u32; 3]) -> usize {
    let [x, y, z] = [x, y, z].map(|i| i as u32 + 1);
    x.wrapping_add(y.wrapping_mul(*sy)).wrapping_add(z.wrapping_mul(*sz)) as usize
}

#[cfg(test)]
mod tests;
