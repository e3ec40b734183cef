//! The traversal: the cells along a ray in order, with the nested grids in crowded cells, until no nearer hit
//! can follow.

use super::build::AccelerationStructure;
use super::cell_contents::{CellContents, NESTED};
use super::cell_table::{BORDER, CellCursor, EMPTY};
use super::filter::Kernel;
use super::query::{FilterState, RayQuery};
use super::ray_aabb::{RayInterval, intersect_aabb};
use super::triangle8::Block;
use crate::math::f64x4::F64x4;
#[cfg(target_arch = "x86_64")]
use crate::math::instructions::Avx2;
use crate::math::instructions::Portable;
use crate::math::prefetch::prefetch;
use crate::math::ray::Ray;
use crate::math::ray_lanes::RayLanes;
use crate::mode::Mode;
use crate::stats::Probe;

/// A kernel that traverses nested structures. Each of them is traversed by a call of a function that is not
/// inlined, so that in the common case, a grid without nested ones, the loop keeps its variables in
/// registers.
pub(crate) trait TraversalKernel: Kernel {
    fn traverse<M: Mode, P: Probe, const ANY: bool>(
        self,
        structure: &AccelerationStructure,
        blocks: &[Block],
        query: &mut RayQuery,
        probe: &mut P,
    );
}

impl TraversalKernel for Portable {
    #[inline(never)]
    fn traverse<M: Mode, P: Probe, const ANY: bool>(
        self,
        structure: &AccelerationStructure,
        blocks: &[Block],
        query: &mut RayQuery,
        probe: &mut P,
    ) {
        structure.traverse::<_, M, P, ANY>(self, blocks, query, probe);
    }
}

#[cfg(target_arch = "x86_64")]
impl TraversalKernel for Avx2 {
    #[inline(always)]
    fn traverse<M: Mode, P: Probe, const ANY: bool>(
        self,
        structure: &AccelerationStructure,
        blocks: &[Block],
        query: &mut RayQuery,
        probe: &mut P,
    ) {
        // SAFETY: `self` proves that the processor has all that the function is compiled for.
        unsafe { traverse_avx2::<M, P, ANY>(self, structure, blocks, query, probe) }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn traverse_avx2<M: Mode, P: Probe, const ANY: bool>(
    avx2: Avx2,
    structure: &AccelerationStructure,
    blocks: &[Block],
    query: &mut RayQuery,
    probe: &mut P,
) {
    structure.traverse::<_, M, P, ANY>(avx2, blocks, query, probe);
}

/// How a ray enters a structure.
#[derive(Clone, Copy, Debug)]
pub enum Entry<F> {
    /// The ray misses the bounds.
    Misses,
    /// The ray is inside the bounds in this interval.
    Passes(RayInterval<F>),
    /// The origin is so far away that the error bounds of the filter and the DDA do not hold.
    TooFar,
}

impl AccelerationStructure {
    /// Looks for a nearer hit in a structure, whose blocks are the first of these.
    #[inline(always)]
    fn traverse<K: TraversalKernel, M: Mode, P: Probe, const ANY: bool>(
        &self,
        kernel: K,
        blocks: &[Block],
        query: &mut RayQuery,
        probe: &mut P,
    ) {
        let ray_entry = self.ray_entry::<K::F64x4>(kernel, query.ray, query.best.t_bound);
        self.run::<K, M, P, ANY, true>(kernel, &ray_entry, blocks, query, probe);
    }

    /// How the ray, up to t = `last`, enters the structure.
    #[inline(always)]
    pub fn ray_entry<F: F64x4>(&self, proof: F::Proof, ray: &Ray, last: f64) -> Entry<F> {
        let ray_lanes = RayLanes::<F>::all_axes(proof, ray);
        if !self.is_in_proven_range(&ray_lanes) {
            return Entry::TooFar;
        }
        intersect_aabb(&self.simd_bounds, ray_lanes, ray.t_min, last).map_or(Entry::Misses, Entry::Passes)
    }

    /// The same as [`traverse`](Self::traverse), for a ray that enters the structure in this way.
    #[inline(always)]
    pub fn run<K: TraversalKernel, M: Mode, P: Probe, const ANY: bool, const IS_NESTED: bool>(
        &self,
        kernel: K,
        ray_entry: &Entry<K::F64x4>,
        blocks: &[Block],
        query: &mut RayQuery,
        probe: &mut P,
    ) {
        let interval = match ray_entry {
            Entry::TooFar => return self.run_all::<P, ANY>(query, probe),
            Entry::Passes(interval) if interval.entry <= query.best.t_bound => *interval,
            _ => {
                // The course's program tests every primitive. A ray that misses their bounds misses them all.
                let untested =
                    if M::AS_COURSE && self.table.is_none() { self.prims.count(query.world) } else { 0 };
                return probe.intersections(untested);
            }
        };
        let mut filter_state = FilterState::on_interval(&interval, &self.cells.frame, query.best.t_bound);
        match &self.table {
            Some(table) if IS_NESTED && !M::AS_COURSE => {
                self.look_ahead::<K, M, P, ANY>(
                    kernel,
                    table.cursor(&interval),
                    blocks,
                    &mut filter_state,
                    query,
                    probe,
                );
            }
            Some(table) => {
                self.traverse_cells::<K, M, P, ANY>(
                    kernel,
                    table.cursor(&interval),
                    blocks,
                    &mut filter_state,
                    query,
                    probe,
                );
            }
            None => {
                let own = &blocks[..self.cells.block_count()];
                query.test_cell::<K, M, P, ANY>(kernel, &self.cells, own, &mut filter_state, probe);
            }
        }
    }

    /// Whether the error bounds of the filter and the DDA hold for the ray. They do not for one with a NaN.
    #[inline(always)]
    fn is_in_proven_range<F: F64x4>(&self, ray_lanes: &RayLanes<F>) -> bool {
        let origin = ray_lanes.origin;
        let from_center = origin - F::new(origin.proof(), self.cells.frame.center);
        from_center.abs().max3() <= self.max_origin_distance
    }

    /// Tests the cells along the ray until no nearer hit can follow.
    #[inline(always)]
    pub fn traverse_cells<K: TraversalKernel, M: Mode, P: Probe, const ANY: bool>(
        &self,
        kernel: K,
        mut cursor: CellCursor,
        blocks: &[Block],
        filter_state: &mut FilterState,
        query: &mut RayQuery,
        probe: &mut P,
    ) {
        let mut last_t = cursor.fixed_t(query.best.t_bound);
        loop {
            if !M::AS_COURSE {
                cursor.skip();
            }
            let entry = cursor.entry();
            if entry != EMPTY {
                unlikely();
                // Not by `test_entry`: comparing every entry with the border first takes a tenth longer in a grid of
                // small cells.
                let changed = if entry < NESTED {
                    let own = CellContents::blocks_of(blocks, entry);
                    query.test_cell::<K, M, P, ANY>(kernel, &self.cells, own, filter_state, probe)
                } else if entry != BORDER {
                    self.test_nested::<K, M, P, ANY>(kernel, entry, blocks, filter_state, query, probe)
                } else {
                    return;
                };
                if changed {
                    if ANY {
                        return;
                    }
                    last_t = cursor.fixed_t(query.best.t_bound);
                }
            }
            loop {
                if last_t <= cursor.exit() {
                    return;
                }
                let unstepped = cursor.step();
                if P::COUNTS {
                    (unstepped.count_ones()..3).for_each(|_| probe.cell());
                }
                // Adjacent cells with the same primitives share their entry. The course's program tests them in each.
                if M::AS_COURSE || cursor.entry() != entry {
                    break;
                }
            }
        }
    }

    /// The same for a grid in a crowded cell. Before a cell is tested, the first block of the next one is prefetched,
    /// since such a grid is one of so many that its blocks are often not in the cache.
    #[inline(always)]
    fn look_ahead<K: TraversalKernel, M: Mode, P: Probe, const ANY: bool>(
        &self,
        kernel: K,
        mut cursor: CellCursor,
        blocks: &[Block],
        filter_state: &mut FilterState,
        query: &mut RayQuery,
        probe: &mut P,
    ) {
        let mut last_t = cursor.fixed_t(query.best.t_bound);
        cursor.skip();
        while cursor.entry() != BORDER {
            let (entry, exit) = (cursor.entry(), cursor.exit());
            let unstepped = cursor.step();
            cursor.skip();
            if let Some(block) = CellContents::first_block_of(blocks, cursor.entry()) {
                prefetch(block);
            }
            if self.test_entry::<K, M, P, ANY>(kernel, entry, blocks, filter_state, query, probe) {
                if ANY {
                    return;
                }
                last_t = cursor.fixed_t(query.best.t_bound);
            }
            if last_t <= exit {
                return;
            }
            if P::COUNTS {
                (unstepped.count_ones()..3).for_each(|_| probe.cell());
            }
        }
    }

    /// Tests the contents of a cell that is neither empty nor on the border, and returns whether the best primitive
    /// changed.
    #[inline(always)]
    fn test_entry<K: TraversalKernel, M: Mode, P: Probe, const ANY: bool>(
        &self,
        kernel: K,
        entry: u32,
        blocks: &[Block],
        filter_state: &mut FilterState,
        query: &mut RayQuery,
        probe: &mut P,
    ) -> bool {
        if entry < NESTED {
            let own = CellContents::blocks_of(blocks, entry);
            query.test_cell::<K, M, P, ANY>(kernel, &self.cells, own, filter_state, probe)
        } else {
            self.test_nested::<K, M, P, ANY>(kernel, entry, blocks, filter_state, query, probe)
        }
    }

    /// Traverses the nested structures of a cell, and returns whether the best primitive changed.
    #[inline(always)]
    fn test_nested<K: TraversalKernel, M: Mode, P: Probe, const ANY: bool>(
        &self,
        kernel: K,
        entry: u32,
        blocks: &[Block],
        filter_state: &mut FilterState,
        query: &mut RayQuery,
        probe: &mut P,
    ) -> bool {
        let before = query.best;
        let nested = &self.nested[(entry - NESTED) as usize];
        for structure in nested.spanning.iter().chain([&nested.grid]) {
            let own = &blocks[structure.cells.first_block..];
            kernel.traverse::<M, P, ANY>(structure, own, query, probe);
            if ANY && query.best != before {
                return true;
            }
        }
        filter_state.shorten(query.best.t_bound);
        query.best != before
    }

    /// Tests every primitive exactly, without the filter and the DDA, unless the ray certainly misses their
    /// bounds.
    #[cold]
    fn run_all<P: Probe, const ANY: bool>(&self, query: &mut RayQuery, probe: &mut P) {
        let count = self.prims.count(query.world);
        if self.simd_bounds.is_surely_missed(query.ray) {
            return probe.intersections(count);
        }
        for i in 0..count {
            probe.intersections(1);
            if query.test(self.prims.id(i)) && ANY {
                return;
            }
        }
    }
}

/// Tells the compiler that the branch that calls it is rarely taken.
#[inline(always)]
#[cold]
fn unlikely() {}

#[cfg(test)]
mod tests;
