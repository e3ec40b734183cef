//! The acceleration structure of the finite primitives: a list, a uniform grid or a tree.
//!
//! A ray is tested against the whole list, the cells of the grid in order, or the boxes of the tree from the nearest on.
//! The traversal ends when no nearer hit can follow. A [`Search`] tests the primitives.

use crate::base::patience::Patience;
use crate::caster::block::LANES;
use crate::caster::bounds::{Entry, Region};
use crate::caster::box8::{BoxRay, Meeting, meet};
use crate::caster::choose::Layout;
use crate::caster::contents::Contents;
use crate::caster::dda::Dda;
use crate::caster::division::MAX_LEVELS;
use crate::caster::filter::FilterState;
use crate::caster::insertion::{bounds_of, references};
use crate::caster::lattice::{Lattice, NotBuilt};
use crate::caster::search::{Goal, Search};
use crate::caster::tree::{Branch, LEAF, SMALL, Small, Tree};
use crate::math::simd::lanes;
use crate::world::World;
use arrayvec::ArrayVec;
use fearless_simd::Simd;
use fearless_simd_macros::simd;
use std::sync::Arc;

/// The acceleration structure of the finite primitives that rays may see.
#[derive(Debug)]
pub struct AccelerationStructure {
    /// The box in which rays are tested.
    pub region: Region,
    order: Order,
    /// The primitives of the cells or leaves; a list counts as one cell.
    contents: Contents,
}

/// The order in which a ray meets the cells or leaves.
// There is only one instance, and boxing the lattice would add a pointer dereference for every ray.
#[allow(clippy::large_enum_variant)]
#[derive(Debug)]
enum Order {
    /// There is only one cell.
    List,
    /// Along the ray.
    Grid(Lattice),
    /// Through the boxes that the ray meets.
    Tree(Tree),
}

/// The size of an acceleration structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StructureSize {
    /// Cells, including the border, or leaves of the tree; a list counts as one cell.
    pub cells: usize,
    /// References to primitives in all cells; a primitive counts once for each cell that lists it.
    pub references: usize,
    /// Blocks of eight triangles.
    pub blocks: usize,
}

impl AccelerationStructure {
    /// Builds the structure of a world like [`new`](Self::new); `None` if the world has no finite primitives.
    pub fn of_world(
        world: &World,
        layout: Layout,
        patience: &dyn Patience,
    ) -> Result<Option<Arc<Self>>, NotBuilt> {
        let build = || Self::new(world, layout, patience).map(Arc::new);
        (world.finite_count() > 0).then(build).transpose()
    }

    /// Builds the structure of a world with finite primitives. Returns an error if it does not fit into memory, or if the
    /// patience is over.
    pub fn new(world: &World, layout: Layout, patience: &dyn Patience) -> Result<Self, NotBuilt> {
        let bounds = bounds_of(world);
        let visible = || (0..world.finite_count() as u32).filter(|&id| world.may_be_seen(id)).collect();
        match layout {
            Layout::List => {
                let ids: Vec<u32> = visible();
                let region = Region::new(&bounds, f64::INFINITY);
                let mut contents = Contents::with_capacity(1, ids.len().div_ceil(LANES), world)?;
                contents.push(world, &ids);
                contents.fill(world, &[(0, region.frame)], patience)?;
                Ok(Self { region, order: Order::List, contents })
            }
            Layout::Grid(cells) => {
                let lattice = Lattice::new(bounds, cells);
                let region = Region::new(&bounds, lattice.cell_size.min_element());
                let references = references(world, &lattice, patience)?;
                let mut contents = Contents::of_cells(world, &lattice, references, patience)?;
                contents.fill(world, &[(0, region.frame)], patience)?;
                Ok(Self { region, order: Order::Grid(lattice), contents })
            }
            Layout::Tree => {
                let region = Region::new(&bounds, f64::INFINITY);
                let (tree, contents) = Tree::new(world, visible(), region.frame, patience)?;
                Ok(Self { region, order: Order::Tree(tree), contents })
            }
        }
    }

    /// Returns true unless this is a list.
    pub fn is_selective(&self) -> bool {
        !matches!(self.order, Order::List)
    }

    /// Returns the size of the structure.
    pub fn size(&self) -> StructureSize {
        StructureSize {
            cells: self.contents.len(),
            references: self.contents.primitives_of(0..self.contents.len()).count(),
            blocks: self.contents.blocks.len(),
        }
    }
}

/// The largest number of children that wait: seven of the eight on each level.
const MAX_WAITING: usize = (LANES - 1) * MAX_LEVELS;

/// The children that wait, each with the depth at which the ray enters its box. The children of one node are sorted,
/// with the nearest last.
type Stack = ArrayVec<(f32, Branch), MAX_WAITING>;

impl AccelerationStructure {
    /// Hands the primitives near the ray to the search.
    #[inline(always)]
    pub fn traverse<S: Simd, G: Goal>(&self, simd: S, search: &mut Search<G>) {
        let interval = match self.region.certain_entry(simd, search.ray, search.goal.end()) {
            Entry::Misses => return,
            Entry::Passes(interval) => interval,
            Entry::TooFar => {
                search.test_each(self.contents.primitives_of(0..self.contents.len()));
                return;
            }
        };
        let mut filter_state = FilterState::new(&interval, &self.region.frame, search.goal.end());
        match &self.order {
            Order::List => {
                if let Some((blocks, others)) = self.contents.cell(0) {
                    search.test_cell(simd, blocks, others, &mut filter_state);
                }
            }
            Order::Grid(lattice) => {
                self.test_cells(simd, Dda::new(lattice, &interval), filter_state, search);
            }
            Order::Tree(tree) => {
                self.descend(simd, tree, tree.root, &mut filter_state, search);
            }
        }
    }

    /// Tests the cells along the ray until no nearer hit can follow.
    #[inline(always)]
    fn test_cells<S: Simd, G: Goal>(
        &self,
        simd: S,
        mut dda: Dda,
        mut filter_state: FilterState,
        search: &mut Search<G>,
    ) {
        let mut last = dda.fixed_t(search.goal.end());
        while let Some((blocks, others)) = self.contents.cell(dda.index()) {
            if search.test_cell(simd, blocks, others, &mut filter_state) {
                if G::IS_ANY {
                    return;
                }
                last = dda.fixed_t(search.goal.end());
            }
            if last <= dda.exit() {
                return;
            }
            dda.step();
        }
    }

    /// Searches a branch of a tree in the frame of the filter's ray. If any hit will do, returns true if one was found.
    #[inline(always)]
    fn descend<S: Simd, G: Goal>(
        &self,
        simd: S,
        tree: &Tree,
        branch: Branch,
        filter_state: &mut FilterState,
        search: &mut Search<G>,
    ) -> bool {
        let box_ray = BoxRay::new(simd, &filter_state.ray);
        let (mut stack, mut child) = (Stack::new(), branch);
        loop {
            let next = if child < SMALL {
                let node = &tree.nodes[child as usize];
                let meeting = meet(simd, node, &box_ray, filter_state.ray.max_depth);
                first_child::<G>(&node.children, &meeting, &mut stack)
            } else {
                let has_changed = if child >= LEAF {
                    let (block, others) = self.contents.leaf((child - LEAF) as usize);
                    search.test_cell(simd, block, others, filter_state)
                } else {
                    self.test_small(simd, tree, &tree.small[(child - SMALL) as usize], filter_state, search)
                };
                if G::IS_ANY && has_changed {
                    return true;
                }
                None
            };
            child = match next {
                Some(next) => next,
                None => loop {
                    let Some((entry, waiting)) = stack.pop() else { return false };
                    if G::IS_ANY || entry <= filter_state.ray.max_depth {
                        break waiting;
                    }
                },
            };
        }
    }

    /// Searches a branch with a frame of its own, and shortens the ray in the outer frame. If any hit will do, returns true
    /// if one was found.
    #[simd]
    #[inline(never)]
    fn test_small<S: Simd, G: Goal>(
        &self,
        simd: S,
        tree: &Tree,
        Small { branch, region, leaves }: &Small,
        outer: &mut FilterState,
        search: &mut Search<G>,
    ) -> bool {
        let last = search.goal.end();
        let has_changed = match region.certain_entry(simd, search.ray, last) {
            Entry::Misses => return false,
            Entry::Passes(interval) => {
                let mut filter_state = FilterState::new(&interval, &region.frame, last);
                self.descend(simd, tree, *branch, &mut filter_state, search)
            }
            Entry::TooFar => search.test_each(self.contents.primitives_of(leaves.clone())),
        };
        outer.shorten(search.goal.end());
        has_changed
    }
}

/// Returns the child to visit next, which is the nearest one unless any hit will do. Pushes the other children that the
/// ray meets onto the stack.
#[inline(always)]
fn first_child<G: Goal>(children: &[Branch; LANES], meeting: &Meeting, stack: &mut Stack) -> Option<Branch> {
    let mut met = lanes(meeting.set).map(|lane| (meeting.entries[lane], children[lane]));
    let mut first = met.next()?;
    let waiting = stack.len();
    for mut other in met {
        if !G::IS_ANY && other.0 < first.0 {
            std::mem::swap(&mut first, &mut other);
        }
        stack.push(other);
        if !G::IS_ANY {
            sink_last(&mut stack[waiting..]);
        }
    }
    Some(first.1)
}

/// Moves the last child to its position among the others, which are sorted with the nearest last.
#[inline(always)]
fn sink_last(waiting: &mut [(f32, Branch)]) {
    let mut place = waiting.len() - 1;
    while place > 0 && waiting[place - 1].0 < waiting[place].0 {
        waiting.swap(place - 1, place);
        place -= 1;
    }
}

#[cfg(test)]
mod tests;
