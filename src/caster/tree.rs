//! A tree of boxes over all primitives: a bounding volume hierarchy with eight branches per node and eight primitives per
//! leaf.
//!
//! A node is made by halving the largest of its branches until there are eight (Wald, Benthin and Boulos, "Getting Rid of
//! Packets", IEEE Symposium on Interactive Ray Tracing 2008). Where the primitives of a branch are too small for the
//! coordinates of the frame, the branch gets a frame of its own.

use crate::base::memory;
use crate::caster::block::{Frame, LANES, NONE};
use crate::caster::bounds::{Region, widened};
use crate::caster::box8::Box8;
use crate::caster::division::{Item, ItemRun};
use crate::caster::lattice::GridTooLarge;
use crate::math::aabb::Aabb;
use crate::world::World;
use arrayvec::ArrayVec;
use rayon::prelude::*;

/// A branch of a tree is a node with this index, or has one of the following bits.
pub type Branch = u32;

/// The branch is a leaf, and the other bits are the index of its block.
pub const LEAF: Branch = 1 << 31;

/// The branch has a frame of its own, and the other bits are its index among such branches.
pub const SMALL: Branch = 1 << 30;

/// The number of levels that are divided by the heuristic. Below them the primitives are divided by their number, which
/// bounds the depth of trees of primitives that the heuristic does not divide evenly.
const HEURISTIC_LEVELS: usize = 40;

/// Upper bound on the number of levels: [`HEURISTIC_LEVELS`], and 29 that halve the at most 2^29 leaves.
pub const MAX_LEVELS: usize = HEURISTIC_LEVELS + 29;

/// The number of levels that a branch with a frame of its own counts as, so that at most eight are nested.
const LEVELS_OF_SMALL: usize = HEURISTIC_LEVELS / 8;

/// From this number of items on, the branches of a node are built at the same time.
const PARALLEL_ITEMS: usize = 1 << 13;

/// The tree.
#[derive(Debug, Default)]
pub struct Tree {
    /// Everything, which is not a leaf.
    pub root: Branch,
    pub nodes: Vec<Box8>,
    /// The branches with frames of their own.
    pub small: Vec<Small>,
}

/// The leaves of a tree.
#[derive(Debug, Default)]
pub struct Leaves {
    /// The ids of the primitives in each leaf, in ascending order and followed by [`NONE`].
    pub ids: Vec<[u32; LANES]>,
    /// From which leaf on which frame holds.
    pub frames: Vec<(usize, Frame)>,
}

/// A branch with a frame of its own.
#[derive(Debug)]
pub struct Small {
    /// The branch in these coordinates.
    pub branch: Branch,
    pub region: Region,
}

impl Tree {
    /// Builds the tree of all primitives that rays may hit, in the coordinates of a frame whose box contains them, and its
    /// leaves.
    pub fn new(world: &World, frame: &Frame) -> Result<(Self, Leaves), GridTooLarge> {
        let ids =
            (0..world.finite_count() as u32).filter(|&id| !world.is_triangle(id) || world.may_be_hit(id));
        let ids: Vec<u32> = ids.collect();
        memory::ask(least_bytes(ids.len())).map_err(|_| GridTooLarge)?;
        let mut growing = Growing::new(world);
        growing.leaves.frames.push((0, *frame));
        let mut items = items(world, &ids, frame);
        let all = ItemRun::new(&mut items);
        growing.tree.root = match all.items.len() {
            // The root is not a leaf.
            0..=LANES => growing.add_node(all, frame, 0),
            _ => growing.add_branch(all, frame, 0),
        };
        let Growing { tree, leaves, .. } = growing;
        let fits = tree.nodes.len() <= SMALL as usize && leaves.ids.len() <= SMALL as usize;
        if fits { Ok((tree, leaves)) } else { Err(GridTooLarge) }
    }

    /// Whether a condition holds for the block of any leaf of a branch. The leaves after it are not visited.
    pub fn any_leaf(&self, branch: Branch, holds: &mut impl FnMut(u32) -> bool) -> bool {
        if branch >= LEAF {
            holds(branch - LEAF)
        } else if branch >= SMALL {
            self.any_leaf(self.small[(branch - SMALL) as usize].branch, holds)
        } else {
            self.nodes[branch as usize].branches().any(|child| self.any_leaf(child, holds))
        }
    }
}

/// Returns the memory that a tree of this many primitives takes at least while it is built: if all leaves are full.
fn least_bytes(count: usize) -> u64 {
    (count * size_of::<Item>() + count / LANES * size_of::<[u32; LANES]>()) as u64
}

/// Some primitives in the coordinates of a frame.
fn items(world: &World, ids: &[u32], frame: &Frame) -> Vec<Item> {
    ids.par_iter().map(|&id| Item::new(frame, &world.box_of(id), id)).collect()
}

/// A tree that is being built.
struct Growing<'w> {
    tree: Tree,
    leaves: Leaves,
    world: &'w World,
}

impl<'w> Growing<'w> {
    fn new(world: &'w World) -> Self {
        Self { tree: Tree::default(), leaves: Leaves::default(), world }
    }

    /// Adds items below so many levels.
    fn add_branch(&mut self, run: ItemRun, frame: &Frame, level: usize) -> Branch {
        if run.items.len() <= LANES {
            self.add_leaf(run.items)
        } else if is_small(&run, level) {
            self.add_small(run.items, frame, level)
        } else {
            self.add_node(run, frame, level)
        }
    }

    fn add_leaf(&mut self, items: &[Item]) -> Branch {
        let mut ids = [NONE; LANES];
        ids.iter_mut().zip(items).for_each(|(id, item)| *id = item.id);
        ids.sort_unstable();
        self.leaves.ids.push(ids);
        LEAF | (self.leaves.ids.len() as u32 - 1)
    }

    fn add_small(&mut self, own: &[Item], outer: &Frame, level: usize) -> Branch {
        let boxes = own.iter().map(|item| self.world.box_of(item.id));
        let region = Region::new(&widened(boxes.fold(Aabb::EMPTY, Aabb::union)), f64::INFINITY);
        self.leaves.frames.push((self.leaves.ids.len(), region.frame));
        let ids: Vec<u32> = own.iter().map(|item| item.id).collect();
        let mut items = items(self.world, &ids, &region.frame);
        let branch = self.add_node(ItemRun::new(&mut items), &region.frame, level + LEVELS_OF_SMALL);
        self.leaves.frames.push((self.leaves.ids.len(), *outer));
        self.tree.small.push(Small { branch, region });
        SMALL | (self.tree.small.len() as u32 - 1)
    }

    fn add_node(&mut self, run: ItemRun, frame: &Frame, level: usize) -> Branch {
        let index = self.tree.nodes.len();
        self.tree.nodes.push(Box8::EMPTY);
        let is_large = run.items.len() >= PARALLEL_ITEMS;
        let runs = branches(run, level);
        let bounds: ArrayVec<_, LANES> = runs.iter().map(|(run, _)| run.bounds).collect();
        let children: Vec<Branch> = if is_large {
            let world = self.world;
            let build = |(run, level)| {
                let mut own = Self::new(world);
                (own.add_branch(run, frame, level), own)
            };
            let built: Vec<_> = runs.into_iter().collect::<Vec<_>>().into_par_iter().map(build).collect();
            built.into_iter().map(|(branch, own)| self.append(branch, own)).collect()
        } else {
            runs.into_iter().map(|(run, level)| self.add_branch(run, frame, level)).collect()
        };
        for (lane, (bounds, child)) in bounds.into_iter().zip(children).enumerate() {
            self.tree.nodes[index].set(lane, [bounds.min, bounds.max], child);
        }
        index as Branch
    }

    /// Appends what has been built apart, and returns what its root is here.
    fn append(&mut self, root: Branch, other: Self) -> Branch {
        let [nodes, small] = [self.tree.nodes.len(), self.tree.small.len()].map(|count| count as u32);
        let leaves = self.leaves.ids.len();
        let moved = |branch: Branch| match branch {
            LEAF.. => branch + leaves as u32,
            SMALL.. => branch + small,
            _ => branch + nodes,
        };
        self.tree.nodes.extend(other.tree.nodes.into_iter().map(|mut node| {
            node.children.iter_mut().for_each(|child| *child = moved(*child));
            node
        }));
        let own_small = other.tree.small.into_iter();
        self.tree.small.extend(own_small.map(|small| Small { branch: moved(small.branch), ..small }));
        self.leaves.ids.extend(other.leaves.ids);
        self.leaves.frames.extend(other.leaves.frames.iter().map(|&(leaf, frame)| (leaf + leaves, frame)));
        moved(root)
    }
}

/// Whether items below so many levels get a frame of their own.
fn is_small(run: &ItemRun, level: usize) -> bool {
    level < HEURISTIC_LEVELS && run.is_small
}

/// Divides the items of a node into its branches, each with the number of levels above it.
fn branches(run: ItemRun, level: usize) -> ArrayVec<(ItemRun, usize), LANES> {
    let is_divisible = run.items.len() > LANES;
    let mut branches = ArrayVec::<_, LANES>::new();
    branches.push((run, level));
    // The node itself is divided also where a branch would be small.
    let mut next = Some(0).filter(|_| is_divisible);
    while let Some(index) = next {
        let (run, level) = branches.swap_remove(index);
        branches.extend(run.halves(level >= HEURISTIC_LEVELS).map(|half| (half, level + 1)));
        let area = |i: &usize| branches[*i].0.bounds.half_area();
        let is_divisible = |i: &usize| {
            let (run, level) = &branches[*i];
            run.items.len() > LANES && !is_small(run, *level)
        };
        let divisible = (0..branches.len()).filter(|i| branches.len() < LANES && is_divisible(i));
        next = divisible.max_by(|i, j| area(i).total_cmp(&area(j)));
    }
    branches
}

#[cfg(test)]
mod tests;
