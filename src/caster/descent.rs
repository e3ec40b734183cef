//! The descent through the tree: the boxes that a ray meets, the nearest first.

use crate::caster::blocks::triangle8::LANES;
use crate::caster::build::AccelerationStructure;
use crate::caster::query::{FilterState, RayQuery};
use crate::caster::ray_entry::{Entry, ray_entry};
use crate::caster::tree::box8::{BoxRay, Meeting, meet};
use crate::caster::tree::{Branch, LEAF, MAX_LEVELS, SMALL, Small, Tree};
use crate::math::lanes::lanes;
use crate::math::prefetch::prefetch;
use crate::stats::Probe;
use arrayvec::ArrayVec;
use fearless_simd::Simd;
use fearless_simd_macros::simd;

/// The largest number of children that wait: seven of the eight on each level.
const MAX_WAITING: usize = (LANES - 1) * MAX_LEVELS;

/// A child of a node that the ray meets, with the depth at which it enters its box.
#[derive(Clone, Copy)]
struct Waiting {
    entry: f32,
    child: Branch,
}

/// The children that wait, and of those of one node the nearest last.
type Stack = ArrayVec<Waiting, MAX_WAITING>;

impl AccelerationStructure {
    /// Looks for a nearer hit in a branch of a tree in the frame of the filter's ray, and returns whether there is one. Not
    /// inlined, so that the loop over the cells stays small.
    #[simd]
    #[inline(never)]
    pub fn descend<S: Simd, P: Probe, const ANY: bool>(
        &self,
        simd: S,
        tree: &Tree,
        branch: Branch,
        filter_state: &mut FilterState,
        query: &mut RayQuery,
        probe: &mut P,
    ) -> bool {
        if (SMALL..LEAF).contains(&branch) {
            return self.test_small::<S, P, ANY>(simd, tree, branch - SMALL, filter_state, query, probe);
        }
        let mut has_changed = false;
        let box_ray = BoxRay::new(&filter_state.ray);
        let mut stack = Stack::new();
        let mut child = branch;
        loop {
            let next = if child >= SMALL {
                let changed = if child >= LEAF {
                    let block = std::slice::from_ref(&self.blocks[(child - LEAF) as usize]);
                    query.test_cell::<S, P, ANY>(simd, &self.cells, block, filter_state, probe)
                } else {
                    self.descend::<S, P, ANY>(simd, tree, child, filter_state, query, probe)
                };
                if ANY && changed {
                    return true;
                }
                has_changed |= changed;
                None
            } else {
                probe.cell();
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

    /// Looks for a nearer hit in a branch with a frame of its own. The ray in the frame around it ends there.
    #[inline(always)]
    fn test_small<S: Simd, P: Probe, const ANY: bool>(
        &self,
        simd: S,
        tree: &Tree,
        index: u32,
        outer: &mut FilterState,
        query: &mut RayQuery,
        probe: &mut P,
    ) -> bool {
        let small = &tree.small[index as usize];
        let before = query.best;
        let Small { branch, simd_bounds, frame, max_origin_distance, .. } = small;
        let (ray, last) = (query.ray, query.end::<ANY>());
        match ray_entry(simd, simd_bounds, frame, *max_origin_distance, ray, last) {
            Entry::Misses => return false,
            Entry::Passes(interval) => {
                let mut filter_state = FilterState::on_interval(&interval, frame, last);
                self.descend::<S, P, ANY>(simd, tree, *branch, &mut filter_state, query, probe);
            }
            Entry::TooFar => self.test_leaves::<P, ANY>(tree, small, query, probe),
        }
        outer.shorten(query.end::<ANY>());
        query.best != before
    }

    /// Tests the primitives of a branch exactly, without the filter, unless the ray certainly misses their bounds.
    #[cold]
    fn test_leaves<P: Probe, const ANY: bool>(
        &self,
        tree: &Tree,
        small: &Small,
        query: &mut RayQuery,
        probe: &mut P,
    ) {
        if small.simd_bounds.is_surely_missed(query.ray) {
            return;
        }
        tree.any_leaf(small.branch, &mut |leaf| {
            let mut ids = self.cells.primitives_of(&self.blocks[leaf as usize]);
            ids.any(|id| {
                probe.intersections(1);
                query.test(id) && ANY
            })
        });
    }

    /// The child to visit next of those that a ray meets, which is the nearest one unless any hit will do. The others
    /// wait.
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
        if child < SMALL {
            tree.prefetch_node(child);
        } else if let Some(block) = self.blocks.get((child & !LEAF) as usize) {
            prefetch(block);
        }
    }
}

/// Moves the last child to its place, where the others are sorted with the nearest last.
#[inline(always)]
fn sink_last(waiting: &mut [Waiting]) {
    let mut place = waiting.len() - 1;
    while place > 0 && waiting[place - 1].entry < waiting[place].entry {
        waiting.swap(place - 1, place);
        place -= 1;
    }
}
