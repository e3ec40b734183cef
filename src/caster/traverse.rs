//! The search along a ray: through the whole list, the cells of the grid in order, or the boxes of the tree, until no
//! nearer hit can follow.

use crate::caster::build::{AccelerationStructure, Order};
use crate::caster::cell_contents::{CellContents, NO_BLOCKS};
use crate::caster::grid::cell_table::{CellCursor, EMPTY};
use crate::caster::query::{FilterState, RayQuery};
use crate::caster::ray_entry::{Entry, ray_entry};
use crate::math::ray::Ray;
use crate::stats::Probe;
use fearless_simd::Simd;

impl AccelerationStructure {
    /// How the ray, up to t = `last`, enters the structure.
    #[inline(always)]
    pub fn ray_entry<S: Simd>(&self, simd: S, ray: &Ray, last: f64) -> Entry<S> {
        ray_entry(simd, &self.simd_bounds, &self.cells.frame, self.max_origin_distance, ray, last)
    }

    /// Looks for a nearer hit in the structure, which the ray enters in this way.
    #[inline(always)]
    pub fn run<S: Simd, P: Probe, const ANY: bool>(
        &self,
        simd: S,
        ray_entry: &Entry<S>,
        query: &mut RayQuery,
        probe: &mut P,
    ) {
        let interval = match ray_entry {
            Entry::TooFar => return self.run_all::<P, ANY>(query, probe),
            Entry::Passes(interval) if interval.entry <= query.end::<ANY>() => *interval,
            _ => {
                // The course's program tests every primitive. A ray that misses their bounds misses them all.
                let is_list = matches!(self.order, Order::List);
                let untested = if P::COUNTS && is_list { query.world.finite_count() } else { 0 };
                return probe.intersections(untested);
            }
        };
        let mut filter_state = FilterState::on_interval(&interval, &self.cells.frame, query.end::<ANY>());
        match &self.order {
            Order::List => {
                query.test_cell::<S, P, ANY>(simd, &self.cells, &self.blocks, &mut filter_state, probe);
            }
            Order::Grid(table) => {
                let cursor = table.cursor(&interval);
                self.traverse_cells::<S, P, ANY>(simd, cursor, filter_state, query, probe);
            }
            Order::Tree(tree) => {
                self.descend::<S, P, ANY>(simd, tree, tree.root, &mut filter_state, query, probe);
            }
        }
    }

    /// Tests the cells along the ray until no nearer hit can follow.
    #[inline(always)]
    pub fn traverse_cells<S: Simd, P: Probe, const ANY: bool>(
        &self,
        simd: S,
        mut cursor: CellCursor,
        mut filter_state: FilterState,
        query: &mut RayQuery,
        probe: &mut P,
    ) {
        let filter_state = &mut filter_state;
        let blocks = self.blocks.as_slice();
        let mut last_t = cursor.fixed_t(query.best.t_bound);
        loop {
            if !P::COUNTS {
                cursor.skip();
            }
            let entry = cursor.entry();
            if entry != EMPTY {
                unlikely();
                // Comparing with the border itself takes a tenth longer in a grid of small cells.
                if entry >= NO_BLOCKS {
                    return;
                }
                let own = CellContents::blocks_of(blocks, entry);
                if query.test_cell::<S, P, ANY>(simd, &self.cells, own, filter_state, probe) {
                    if ANY {
                        return;
                    }
                    last_t = cursor.fixed_t(query.best.t_bound);
                }
            }
            if last_t <= cursor.exit() {
                // Another primitive in the same place may be in the next cell. Seldom enough, another query looks for it.
                if !ANY && cursor.fixed_t(query.end::<ANY>()) > cursor.exit() {
                    query.leave_undecided();
                }
                return;
            }
            let unstepped = cursor.step();
            if P::COUNTS {
                (unstepped.count_ones()..3).for_each(|_| probe.cell());
            }
        }
    }

    /// Tests every primitive exactly, without the filter and the DDA, unless the ray certainly misses their
    /// bounds.
    #[cold]
    fn run_all<P: Probe, const ANY: bool>(&self, query: &mut RayQuery, probe: &mut P) {
        let count = query.world.finite_count();
        if self.simd_bounds.is_surely_missed(query.ray) {
            return probe.intersections(count);
        }
        for i in 0..count {
            probe.intersections(1);
            if query.test(i as u32) && ANY {
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
