//! The acceleration structure of the finite primitives: a list, a uniform grid or a tree.
//!
//! A ray is tested against the whole list, the cells of the grid in order, or the boxes of the tree from the nearest on.
//! The search ends when no nearer hit can follow. A [`Query`] tests the primitives.

use crate::base::patience::Patience;
use crate::caster::block::LANES;
use crate::caster::bounds::{Entry, Region};
use crate::caster::box8::{BoxRay, Meeting, meet};
use crate::caster::choose::Layout;
use crate::caster::contents::{Contents, EMPTY, NO_BLOCKS};
use crate::caster::dda::Dda;
use crate::caster::division::MAX_LEVELS;
use crate::caster::filter::FilterState;
use crate::caster::insertion::{bounds_of, references};
use crate::caster::lattice::{Lattice, NotBuilt};
use crate::caster::query::Query;
use crate::caster::tree::{Branch, LEAF, SMALL, Small, Tree};
use crate::math::instructions::prefetch;
use crate::math::simd::lanes;
use crate::stats::Probe;
use crate::world::World;
use arrayvec::ArrayVec;
use fearless_simd::Simd;
use fearless_simd_macros::simd;
use std::cmp::Reverse;

/// The acceleration structure of the finite primitives.
#[derive(Debug)]
pub struct AccelerationStructure {
    /// The box in which rays are tested.
    pub region: Region,
    /// How to find the blocks that a ray meets.
    pub order: Order,
    /// The primitives of the cells or leaves; a list counts as one cell.
    pub contents: Contents,
}

/// How to find the blocks that a ray meets.
// There is only one instance, and boxing the lattice would add a pointer dereference for every ray.
#[allow(clippy::large_enum_variant)]
#[derive(Debug)]
pub enum Order {
    /// A ray meets all blocks.
    List,
    /// Through the entries of the cells along the ray, which are given by index of the lattice.
    Grid(Lattice, Vec<u32>),
    /// Through the boxes that the ray meets.
    Tree(Tree),
}

/// The size of an acceleration structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StructureSize {
    /// Cells, including the border, or nodes of the tree; a list counts as one cell.
    pub cells: usize,
    /// References to primitives in all cells; a primitive counts once for each cell that lists it.
    pub references: usize,
    /// Blocks of eight triangles.
    pub blocks: usize,
}

/// How full the cells of a grid are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fullness {
    /// The fullest cells by their indices along the axes, each with its number of primitives. Equally full cells are in
    /// ascending order of their indices, along z before y before x.
    pub fullest: Vec<([usize; 3], usize)>,
    /// Cells without a primitive.
    pub empty: usize,
    /// All cells.
    pub cells: usize,
}

impl AccelerationStructure {
    /// Builds the structure of all finite primitives of a world. Returns an error if it does not fit into memory, or if
    /// the patience is over.
    pub fn new(world: &World, layout: Layout, patience: &dyn Patience) -> Result<Self, NotBuilt> {
        let bounds = bounds_of(world);
        let grid = |cells: [usize; 3], as_course| {
            let lattice = Lattice::new(bounds, cells);
            let references = references(world, &lattice, as_course, patience)?;
            let (contents, entries) = Contents::of_cells(world, &lattice, references, patience)?;
            let smallest = lattice.cell_size.min_element();
            Ok::<_, NotBuilt>((Order::Grid(lattice, entries), contents, smallest))
        };
        let all = 0..world.finite_count() as u32;
        let visible = || all.clone().filter(|&id| world.may_be_seen(id)).collect();
        let list = |ids: Vec<u32>| {
            let triangles = ids.partition_point(|&id| world.is_triangle(id));
            let mut contents = Contents::with_capacity(triangles.div_ceil(LANES).max(1))?;
            contents.push(world, &ids);
            Ok::<_, NotBuilt>((Order::List, contents, f64::INFINITY))
        };
        let (order, mut contents, min_cell_size) = match layout {
            Layout::Tree => {
                let region = Region::new(&bounds, f64::INFINITY);
                let (tree, contents) = Tree::new(world, visible(), region.frame, patience)?;
                return Ok(Self { region, order: Order::Tree(tree), contents });
            }
            Layout::List => list(visible())?,
            Layout::Grid(cells) => grid(cells, false)?,
            Layout::Course(None) => list(all.collect())?,
            Layout::Course(Some(cells)) => grid(cells, true)?,
        };
        let region = Region::new(&bounds, min_cell_size);
        contents.fill(world, &[(0, region.frame)], patience)?;
        Ok(Self { region, order, contents })
    }

    /// Returns the number of grid cells along each axis, if this is a grid.
    pub fn cells(&self) -> Option<[usize; 3]> {
        match &self.order {
            Order::Grid(lattice, _) => Some(lattice.cells()),
            Order::List | Order::Tree(_) => None,
        }
    }

    /// Returns the size of the structure.
    pub fn size(&self) -> StructureSize {
        StructureSize {
            cells: match &self.order {
                Order::List => 1,
                Order::Grid(lattice, _) => lattice.index_count(),
                Order::Tree(tree) => tree.nodes.len(),
            },
            references: self.contents.primitives_of(&self.contents.blocks).count(),
            blocks: self.contents.blocks.len(),
        }
    }

    /// Returns the fullness of the grid's cells, with this number of the fullest; `None` for a list or a tree.
    pub fn fullness(&self, fullest: usize) -> Option<Fullness> {
        let Order::Grid(lattice, entries) = &self.order else { return None };
        let [nx, ny, nz] = lattice.cells();
        let all = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        let full = all.filter_map(|cell| {
            let entry = Some(entries[lattice.index(cell)]).filter(|&entry| entry != EMPTY)?;
            Some((cell, self.contents.primitives_of(self.contents.blocks_of(entry)).count()))
        });
        let (mut full, cells) = (full.collect::<Vec<_>>(), nx * ny * nz);
        let empty = cells - full.len();
        full.sort_by_key(|&(_, count)| Reverse(count));
        full.truncate(fullest);
        Some(Fullness { fullest: full, empty, cells })
    }
}

/// The largest number of children that wait: seven of the eight on each level.
const MAX_WAITING: usize = (LANES - 1) * MAX_LEVELS;

/// The depths at which the ray enters the boxes of the children that wait, and the children. The children of one node
/// are sorted, with the nearest last.
type Stack = ArrayVec<(f32, Branch), MAX_WAITING>;

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
            Entry::TooFar if !self.region.simd_bounds.is_surely_missed(query.ray) => {
                query.test_each(0..query.world.finite_count() as u32);
                return;
            }
            Entry::Passes(interval) if interval.entry <= query.end() => *interval,
            _ => {
                // The course's program tests every primitive, so they are counted. A ray that misses the bounds misses
                // them all.
                let is_tested = matches!(self.order, Order::List) || matches!(ray_entry, Entry::TooFar);
                let untested = if P::COUNTS && is_tested { query.world.finite_count() } else { 0 };
                return query.probe.intersections(untested);
            }
        };
        let mut filter_state = FilterState::new(&interval, &self.region.frame, query.end());
        match &self.order {
            Order::List => {
                query.test_blocks(simd, &self.contents, &self.contents.blocks, &mut filter_state);
            }
            Order::Grid(lattice, entries) => {
                let dda = Dda::new(lattice, &interval);
                self.test_cells(simd, entries, dda, filter_state, query);
            }
            Order::Tree(tree) => {
                self.descend(simd, tree, tree.root, &mut filter_state, query);
            }
        }
    }

    /// Tests the cells along the ray until no nearer hit can follow.
    #[inline(always)]
    fn test_cells<S: Simd, P: Probe, const ANY: bool>(
        &self,
        simd: S,
        entries: &[u32],
        mut dda: Dda,
        mut filter_state: FilterState,
        query: &mut Query<P, ANY>,
    ) {
        let mut last_t = dda.fixed_t(query.best.t_bound);
        loop {
            let mut entry = entry_at(entries, dda.index());
            while !P::COUNTS && entry == EMPTY {
                dda.step();
                entry = entry_at(entries, dda.index());
            }
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
                    last_t = dda.fixed_t(query.best.t_bound);
                }
            }
            if last_t <= dda.exit() {
                // Another primitive in the same place may be in the next cell. This is rare, so another query looks for
                // it.
                if !ANY && dda.fixed_t(query.end()) > dda.exit() {
                    query.leave_undecided();
                }
                return;
            }
            let unstepped = dda.step();
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
        let box_ray = BoxRay::new(&filter_state.ray);
        let (mut stack, mut child, mut has_changed) = (Stack::new(), branch, false);
        loop {
            let mut next = None;
            if child < SMALL {
                query.probe.cell();
                let node = &tree.nodes[child as usize];
                let meeting = meet(simd, node, &box_ray, filter_state.ray.max_depth);
                next = self.first_child::<ANY>(tree, &node.children, &meeting, &mut stack);
            } else {
                let changed = if child >= LEAF {
                    let block = std::slice::from_ref(&self.contents.blocks[(child - LEAF) as usize]);
                    query.test_blocks(simd, &self.contents, block, filter_state)
                } else {
                    self.test_small(simd, tree, &tree.small[(child - SMALL) as usize], filter_state, query)
                };
                if ANY && changed {
                    return true;
                }
                has_changed |= changed;
            }
            while next.is_none() {
                let Some((entry, waiting)) = stack.pop() else { return has_changed };
                next = (ANY || entry <= filter_state.ray.max_depth).then_some(waiting);
            }
            child = next.unwrap_or(child);
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
        let mut met = lanes(meeting.set).map(|lane| (meeting.entries[lane], children[lane]));
        let mut first = met.next()?;
        self.prefetch_child(tree, first.1);
        let waiting = stack.len();
        for mut other in met {
            self.prefetch_child(tree, other.1);
            if !ANY && other.0 < first.0 {
                std::mem::swap(&mut first, &mut other);
            }
            stack.push(other);
            if !ANY {
                sink_last(&mut stack[waiting..]);
            }
        }
        Some(first.1)
    }

    /// Searches a branch with a frame of its own, and shortens the ray in the outer frame.
    #[inline(always)]
    fn test_small<S: Simd, P: Probe, const ANY: bool>(
        &self,
        simd: S,
        tree: &Tree,
        Small { branch, region, blocks }: &Small,
        outer: &mut FilterState,
        query: &mut Query<P, ANY>,
    ) -> bool {
        let last = query.end();
        let changed = match region.entry(simd, query.ray, last) {
            Entry::Misses => return false,
            Entry::Passes(interval) => {
                let mut filter_state = FilterState::new(&interval, &region.frame, last);
                self.descend(simd, tree, *branch, &mut filter_state, query)
            }
            Entry::TooFar if region.simd_bounds.is_surely_missed(query.ray) => return false,
            Entry::TooFar => {
                query.test_each(self.contents.primitives_of(&self.contents.blocks[blocks.clone()]))
            }
        };
        outer.shorten(query.end());
        changed
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

/// Returns the entry at an index of the lattice. The border keeps rays from any other index.
#[inline(always)]
fn entry_at(entries: &[u32], index: usize) -> u32 {
    match entries.get(index) {
        Some(&entry) => entry,
        None => NO_BLOCKS,
    }
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

/// Tells the compiler that the branch that calls it is rarely taken.
#[inline(always)]
#[cold]
fn unlikely() {}

#[cfg(test)]
mod tests;
