//! Traverses a structure along a ray: the whole list, the cells of the grid in order, or the boxes of the tree from the
//! nearest on. It ends when no nearer hit can follow. A [`Query`] handles the
//! primitives.

use crate::caster::block::LANES;
use crate::caster::bounds::Entry;
use crate::caster::box8::{BoxRay, Meeting, meet};
use crate::caster::contents::NO_BLOCKS;
use crate::caster::dda::{CellTable, Dda, EMPTY};
use crate::caster::division::MAX_LEVELS;
use crate::caster::filter::FilterState;
use crate::caster::query::Query;
use crate::caster::structure::{AccelerationStructure, Order};
use crate::caster::tree::{Branch, LEAF, SMALL, Small, Tree};
use crate::math::instructions::prefetch;
use crate::math::simd::lanes;
use crate::stats::Probe;
use arrayvec::ArrayVec;
use fearless_simd::Simd;
use fearless_simd_macros::simd;

/// The largest number of children that wait: seven of the eight on each level.
const MAX_WAITING: usize = (LANES - 1) * MAX_LEVELS;

/// A child of a node that the ray meets, with the depth at which the ray enters the child's box.
#[derive(Clone, Copy)]
struct Waiting {
    entry: f32,
    child: Branch,
}

/// The children that wait. The children of one node are sorted, with the nearest last.
type Stack = ArrayVec<Waiting, MAX_WAITING>;

impl AccelerationStructure {
    /// Searches the structure. `ray_entry` is how the ray enters it.
    #[inline(always)]
    pub fn traverse<S: Simd, P: Probe, const ANY: bool>(
        &self,
        simd: S,
        ray_entry: &Entry<S>,
        query: &mut Query<P, ANY>,
    ) {
        let interval = match ray_entry {
            Entry::TooFar => return self.test_all(query),
            Entry::Passes(interval) if interval.entry <= query.end() => *interval,
            _ => {
                // The course's program tests every primitive, so they are counted. A ray that misses the bounds misses
                // them all.
                let is_list = matches!(self.order, Order::List);
                let untested = if P::COUNTS && is_list { query.world.finite_count() } else { 0 };
                return query.probe.intersections(untested);
            }
        };
        let mut filter_state = FilterState::on_interval(&interval, &self.region.frame, query.end());
        match &self.order {
            Order::List => {
                query.test_blocks(simd, &self.contents, &self.contents.blocks, &mut filter_state);
            }
            Order::Grid(table) => {
                let dda = Dda::new(table.lattice(), &interval);
                self.test_cells(simd, table, dda, filter_state, query);
            }
            Order::Tree(tree) => {
                self.descend(simd, tree, tree.root, &mut filter_state, query);
            }
        }
    }

    /// Tests the cells along the ray until no nearer hit can follow.
    #[inline(always)]
    fn test_cells<'t, S: Simd, P: Probe, const ANY: bool>(
        &self,
        simd: S,
        table: &'t CellTable,
        dda: Dda<'t>,
        mut filter_state: FilterState,
        query: &mut Query<P, ANY>,
    ) {
        let mut cursor = table.start(dda);
        let mut last_t = cursor.dda().fixed_t(query.best.t_bound);
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
                let own = self.contents.blocks_of(entry);
                if query.test_blocks(simd, &self.contents, own, &mut filter_state) {
                    if ANY {
                        return;
                    }
                    last_t = cursor.dda().fixed_t(query.best.t_bound);
                }
            }
            if last_t <= cursor.dda().exit() {
                // Another primitive in the same place may be in the next cell. This is rare, so another query looks for
                // it.
                if !ANY && cursor.dda().fixed_t(query.end()) > cursor.dda().exit() {
                    query.leave_undecided();
                }
                return;
            }
            let unstepped = cursor.step();
            if P::COUNTS {
                (unstepped.count_ones()..3).for_each(|_| query.probe.cell());
            }
        }
    }

    /// Searches a branch of a tree in the frame of the filter's ray. Returns true if that changed the query. Not
    /// inlined, so that the loop over the cells stays small.
    #[simd]
    #[inline(never)]
    fn descend<S: Simd, P: Probe, const ANY: bool>(
        &self,
        simd: S,
        tree: &Tree,
        branch: Branch,
        filter_state: &mut FilterState,
        query: &mut Query<P, ANY>,
    ) -> bool {
        if (SMALL..LEAF).contains(&branch) {
            return self.test_small(simd, tree, &tree.small[(branch - SMALL) as usize], filter_state, query);
        }
        let mut has_changed = false;
        let box_ray = BoxRay::new(&filter_state.ray);
        let mut stack = Stack::new();
        let mut child = branch;
        loop {
            let next = if child >= SMALL {
                let changed = if child >= LEAF {
                    let block = std::slice::from_ref(&self.contents.blocks[(child - LEAF) as usize]);
                    query.test_blocks(simd, &self.contents, block, filter_state)
                } else {
                    self.descend(simd, tree, child, filter_state, query)
                };
                if ANY && changed {
                    return true;
                }
                has_changed |= changed;
                None
            } else {
                query.probe.cell();
                let node = &tree.nodes[child as usize];
                let meeting = meet(simd, node, &box_ray, filter_state.ray.max_depth);
                self.first_child::<ANY>(tree, &node.children, &meeting, &mut stack)
            };
            child = match next {
                Some(next) => next,
                None => loop {
                    let Some(Waiting { entry, child }) = stack.pop() else { return has_changed };
                    if ANY || entry <= filter_state.ray.max_depth {
                        break child;
                    }
                },
            };
        }
    }

    /// Searches a branch with a frame of its own, and shortens the ray in the outer frame.
    #[inline(always)]
    fn test_small<S: Simd, P: Probe, const ANY: bool>(
        &self,
        simd: S,
        tree: &Tree,
        Small { branch, region }: &Small,
        outer: &mut FilterState,
        query: &mut Query<P, ANY>,
    ) -> bool {
        let last = query.end();
        let changed = match region.entry(simd, query.ray, last) {
            Entry::Misses => return false,
            Entry::Passes(interval) => {
                let mut filter_state = FilterState::on_interval(&interval, &region.frame, last);
                self.descend(simd, tree, *branch, &mut filter_state, query)
            }
            Entry::TooFar => {
                !region.simd_bounds.is_surely_missed(query.ray) && {
                    let mut changed = false;
                    tree.any_leaf(*branch, &mut |leaf| {
                        let mut ids = self.contents.primitives_of(&self.contents.blocks[leaf as usize]);
                        ids.any(|id| {
                            changed |= query.test(id);
                            ANY && changed
                        })
                    });
                    changed
                }
            }
        };
        outer.shorten(query.end());
        changed
    }

    /// Tests every primitive exactly, without the filter and the DDA, unless the ray certainly misses their
    /// bounds.
    #[cold]
    fn test_all<P: Probe, const ANY: bool>(&self, query: &mut Query<P, ANY>) {
        let count = query.world.finite_count();
        if self.region.simd_bounds.is_surely_missed(query.ray) {
            return query.probe.intersections(count);
        }
        for id in 0..count as u32 {
            if query.test(id) && ANY {
                return;
            }
        }
    }

    /// Returns the child to visit next, which is the nearest one unless any hit will do. Pushes the other children that
    /// the ray meets onto the stack.
    #[inline(always)]
    fn first_child<const ANY: bool>(
        &self,
        tree: &Tree,
        children: &[Branch; LANES],
        meeting: &Meeting,
        stack: &mut Stack,
    ) -> Option<Branch> {
        let at = |lane: usize| Waiting { entry: meeting.entries[lane], child: children[lane] };
        let mut met = lanes(meeting.set).map(at);
        let mut first = met.next()?;
        self.prefetch_child(tree, first.child);
        let waiting = stack.len();
        for mut other in met {
            self.prefetch_child(tree, other.child);
            if !ANY && other.entry < first.entry {
                std::mem::swap(&mut first, &mut other);
            }
            stack.push(other);
            if !ANY {
                sink_last(&mut stack[waiting..]);
            }
        }
        Some(first.child)
    }

    #[inline(always)]
    fn prefetch_child(&self, tree: &Tree, child: Branch) {
        if child >= SMALL {
            self.contents.blocks.get((child & !LEAF) as usize).into_iter().for_each(prefetch);
        } else if let Some(node) = tree.nodes.get(child as usize) {
            prefetch(node);
        }
    }
}

/// Moves the last child to its position among the others, which are sorted with the nearest last.
#[inline(always)]
fn sink_last(waiting: &mut [Waiting]) {
    let mut place = waiting.len() - 1;
    while place > 0 && waiting[place - 1].entry < waiting[place].entry {
        waiting.swap(place - 1, place);
        place -= 1;
    }
}

/// Tells the compiler that the branch that calls it is rarely taken.
#[inline(always)]
#[cold]
fn unlikely() {}

#[cfg(test)]
mod tests;
