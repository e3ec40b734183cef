//! The binary tree of primitives from which the nodes of a [`Tree`](crate::caster::tree::Tree) are made.
//!
//! A branch is divided into halves by the surface area heuristic, evaluated at the borders of a few bins (Wald, "On
//! fast Construction of SAH-based Bounding Volume Hierarchies", IEEE Symposium on Interactive Ray Tracing 2007), or
//! into large and small primitives.
//!
//! A node with its eight children stands for several levels of the binary tree. The levels are chosen to minimise the
//! sum of the nodes' surface areas, which is proportional to the number of nodes that a ray visits. This uses dynamic
//! programming from the leaves upwards (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through
//! Compressed Wide BVHs", High Performance Graphics 2017).

use crate::caster::block::{Frame, LANES};
use crate::caster::box8::PADDING;
use crate::math::aabb::Aabb;
use arrayvec::ArrayVec;
use glam::Vec3A;
use std::ops::Range;

/// The number of levels that are divided by the heuristic. Below them the primitives are divided by their number. This
/// bounds the depth of the tree if the heuristic does not divide the primitives evenly.
pub const HEURISTIC_LEVELS: usize = 40;

/// Upper bound on the number of levels: [`HEURISTIC_LEVELS`], and 29 that halve the at most 2^29 leaves.
pub const MAX_LEVELS: usize = HEURISTIC_LEVELS + 29;

/// A binary tree over a list of items, which it reorders.
pub struct BinaryTree {
    /// The branches. The two halves of a branch precede it.
    halves: Vec<Half>,
}

/// A branch of the binary tree.
pub struct Half {
    pub bounds: Bounds,
    /// The range of the branch's items.
    pub items: Range<usize>,
    pub content: BranchContent,
    /// The best plan for each number of children, up to [`LANES`], that may stand for the branch in a node.
    plans: [Plan; LANES + 1],
}

/// The content of a branch of the binary tree.
pub enum BranchContent {
    /// A leaf.
    Leaf,
    /// A branch with a frame of its own, below this number of levels.
    Small { level: usize },
    /// Two halves, given by their indices.
    Halves([usize; 2]),
}

/// How the children of a node stand for a branch.
#[derive(Clone, Copy)]
struct Plan {
    /// The sum of half the areas of the nodes that the branch needs.
    area: f32,
    /// The number of these children for the first half; zero if one child stands for both halves.
    first: u32,
}

/// From this number of items on, both halves are divided at the same time.
const PARALLEL_ITEMS: usize = 1 << 13;

impl BinaryTree {
    /// Builds the tree of more than [`LANES`] items, below this number of levels.
    pub fn new(items: &mut [Item], level: usize) -> Self {
        Self::divided(ItemRun::new(items), 0, level)
    }

    /// Returns the root, which holds all items.
    pub fn root(&self) -> &Half {
        &self.halves[self.halves.len() - 1]
    }

    /// Returns the children of the node that is made from a branch.
    pub fn children(&self, half: &Half) -> ArrayVec<&Half, LANES> {
        let mut children = ArrayVec::new();
        self.add_halves(half, LANES, &mut children);
        children
    }

    /// Adds the children that stand for a branch. There are at most `count`.
    fn add_children<'a>(&'a self, half: &'a Half, count: usize, children: &mut ArrayVec<&'a Half, LANES>) {
        match half.plans[count].first {
            0 => children.push(half),
            _ => self.add_halves(half, count, children),
        }
    }

    fn add_halves<'a>(&'a self, half: &Half, count: usize, children: &mut ArrayVec<&'a Half, LANES>) {
        if let BranchContent::Halves([a, b]) = half.content {
            let first = half.plans[count].first as usize;
            self.add_children(&self.halves[a], first, children);
            self.add_children(&self.halves[b], count - first, children);
        }
    }

    /// Builds the tree of a branch with these items. The first item has the index `start`.
    fn of(group: ItemRun, start: usize, level: usize) -> Self {
        let content = if group.items.len() <= LANES {
            BranchContent::Leaf
        } else if level < HEURISTIC_LEVELS && group.is_small {
            BranchContent::Small { level }
        } else {
            return Self::divided(group, start, level);
        };
        let items = start..start + group.items.len();
        let mut tree = Self { halves: vec![] };
        tree.halves.push(Half { bounds: group.bounds, items, content, plans: [Plan::NOTHING; LANES + 1] });
        tree
    }

    /// Builds the tree of a branch that is divided into two halves.
    fn divided(group: ItemRun, start: usize, level: usize) -> Self {
        let (bounds, items) = (group.bounds, start..start + group.items.len());
        let [a, b] = group.halves(level >= HEURISTIC_LEVELS);
        let middle = start + a.items.len();
        let divide = |group, start| Self::of(group, start, level + 1);
        let (mut tree, second) = match items.len() {
            PARALLEL_ITEMS.. => rayon::join(|| divide(a, start), || divide(b, middle)),
            _ => (divide(a, start), divide(b, middle)),
        };
        let halves = [tree.halves.len() - 1, tree.append(second)];
        let plans = plans(bounds.half_area(), halves.map(|half| &tree.halves[half].plans));
        tree.halves.push(Half { bounds, items, content: BranchContent::Halves(halves), plans });
        tree
    }

    /// Appends the halves of another tree, and returns the index of its root.
    fn append(&mut self, mut other: Self) -> usize {
        let shift = self.halves.len();
        for half in &mut other.halves {
            if let BranchContent::Halves(halves) = &mut half.content {
                halves.iter_mut().for_each(|half| *half += shift);
            }
        }
        self.halves.append(&mut other.halves);
        self.halves.len() - 1
    }
}

impl Plan {
    /// The plan of a branch that needs no nodes.
    const NOTHING: Self = Self { area: 0.0, first: 0 };
}

/// Returns the plans for a branch. `half_area` is half its surface area, and `a` and `b` are the plans of its halves.
/// The last plan is for the node that is made from the branch.
fn plans(half_area: f32, [a, b]: [&[Plan; LANES + 1]; 2]) -> [Plan; LANES + 1] {
    let among = |count: usize| {
        let plan = |first: usize| Plan { area: a[first].area + b[count - first].area, first: first as u32 };
        (2..count).fold(plan(1), |best, first| if plan(first).area < best.area { plan(first) } else { best })
    };
    let inside = among(LANES);
    let whole = Plan { area: half_area + inside.area, first: 0 };
    std::array::from_fn(|count| match count {
        0 | 1 => whole,
        LANES => inside,
        _ => Some(among(count)).filter(|plan| plan.area < whole.area).unwrap_or(whole),
    })
}

/// The largest extent of a small branch along each axis, in units of the frame.
const MAX_SMALL: f32 = 1.0 / 64.0;

/// A primitive below this size is small, in units of the frame: errors of single precision, which are up to 2^-20 of
/// the frame, begin to matter.
const SMALL_PRIMITIVE: f32 = 1.0 / 8192.0;

/// The number of bins for the heuristic.
const BINS: usize = 16;

/// A box in single precision.
#[derive(Clone, Copy)]
pub struct Bounds {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl Bounds {
    const EMPTY: Self = Self { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    fn extent(&self) -> Vec3A {
        self.max - self.min
    }

    /// Returns the largest extent.
    fn size(&self) -> f32 {
        self.extent().max_element()
    }

    /// Returns half the surface area.
    pub fn half_area(&self) -> f32 {
        let extent = self.extent().max(Vec3A::ZERO);
        extent.x * extent.y + extent.y * extent.z + extent.z * extent.x
    }
}

/// A primitive and its padded box.
#[derive(Clone, Copy)]
pub struct Item {
    pub bounds: Bounds,
    pub id: u32,
}

impl Item {
    /// Returns the item of a primitive with this box, in the coordinates of a frame.
    pub fn new(frame: &Frame, bounds: &Aabb, id: u32) -> Self {
        let [min, max] = [bounds.min, bounds.max].map(|corner| frame.point(corner));
        Self { bounds: Bounds { min: (min - PADDING).as_vec3a(), max: (max + PADDING).as_vec3a() }, id }
    }

    /// Returns twice the centre of the box.
    fn center(&self) -> Vec3A {
        self.bounds.min + self.bounds.max
    }
}

/// Consecutive items.
pub struct ItemRun<'i> {
    pub items: &'i mut [Item],
    pub bounds: Bounds,
    /// The bounds of twice the centres.
    centers: Bounds,
    /// True if the run is small, and more than an eighth of its items are small.
    pub is_small: bool,
    /// True if the run has items that are large compared with it.
    has_large: bool,
}

impl<'i> ItemRun<'i> {
    pub fn new(items: &'i mut [Item]) -> Self {
        let (mut bounds, mut centers, mut largest) = (Bounds::EMPTY, Bounds::EMPTY, Vec3A::ZERO);
        for item in items.iter() {
            bounds = bounds.union(item.bounds);
            centers = centers.union(Bounds { min: item.center(), max: item.center() });
            largest = largest.max(item.bounds.extent());
        }
        let size = bounds.size();
        let are_small = |item: &&Item| item.bounds.size() < SMALL_PRIMITIVE;
        let is_small = size <= MAX_SMALL && 8 * items.iter().filter(are_small).count() > items.len();
        Self { items, bounds, centers, is_small, has_large: is_large(largest.max_element(), size) }
    }

    /// Divides the items into two runs.
    pub fn halves(self, by_number: bool) -> [Self; 2] {
        let plane = if by_number { None } else { self.best_plane() };
        let size = self.bounds.size();
        let is_large = |item: &Item| is_large(item.bounds.size(), size);
        let middle = match plane {
            Some((cost, _)) if self.has_large && cost_apart(self.items, is_large) < cost => {
                partition(self.items, is_large)
            }
            Some((_, plane)) => partition(self.items, |item| plane.is_before(item)),
            None => median(self.items, self.bounds),
        };
        let (left, right) = self.items.split_at_mut(middle);
        [left, right].map(ItemRun::new)
    }
}

/// Returns true if an item of this size is large in a run of this size.
fn is_large(item: f32, group: f32) -> bool {
    item > 0.5 * group
}

/// The bins of centres along each axis.
#[derive(Clone, Copy)]
struct Bins {
    start: Vec3A,
    /// Not finite along an axis on which all centres are the same.
    per_unit: Vec3A,
}

impl Bins {
    /// Returns the bins of centres with these bounds.
    fn new(centers: &Bounds) -> Self {
        // Slightly fewer bins per unit, so that the last centre is in the last bin.
        Self { start: centers.min, per_unit: 0.999 * BINS as f32 / centers.extent() }
    }

    /// Returns the bins of an item, by axis.
    fn of(&self, item: &Item) -> [usize; 3] {
        let bins = (item.center() - self.start) * self.per_unit;
        // No number is negative, and a NaN becomes 0. A direct conversion to `usize` takes more instructions.
        bins.to_array().map(|bin| (bin as i32 as usize).min(BINS - 1))
    }
}

/// A plane in front of a bin along an axis.
#[derive(Clone, Copy)]
struct Plane {
    bins: Bins,
    axis: usize,
    bin: usize,
}

impl Plane {
    fn is_before(&self, item: &Item) -> bool {
        self.bins.of(item)[self.axis] < self.bin
    }
}

impl ItemRun<'_> {
    /// Returns the least cost and its plane; `None` if all centres are the same. The cost is the sum over both sides of
    /// the area times the number of blocks for the items.
    fn best_plane(&self) -> Option<(f32, Plane)> {
        let bins = Bins::new(&self.centers);
        let mut contents = [[(0, Bounds::EMPTY); BINS]; 3];
        for item in self.items.iter() {
            for (contents, bin) in contents.iter_mut().zip(bins.of(item)) {
                let (count, bounds) = &mut contents[bin];
                *count += 1;
                *bounds = bounds.union(item.bounds);
            }
        }
        let mut best: Option<(f32, Plane)> = None;
        for (axis, contents) in contents.iter().enumerate() {
            let mut costs_behind = [0.0; BINS];
            sweep(contents.iter().enumerate().rev(), |bin, cost| costs_behind[bin] = cost);
            sweep(contents.iter().enumerate(), |bin, cost| {
                let cost = cost + costs_behind.get(bin + 1).unwrap_or(&f32::INFINITY);
                if cost < best.map_or(f32::INFINITY, |(least, _)| least) {
                    best = Some((cost, Plane { bins, axis, bin: bin + 1 }));
                }
            });
        }
        best
    }
}

/// Returns the cost of separating the large items from the others. A plane through the centre of a large item cannot
/// separate it from small ones, which would share its box on every level.
fn cost_apart(items: &[Item], is_large: impl Fn(&Item) -> bool) -> f32 {
    let cost = |large: bool| {
        let side = items.iter().filter(|item| is_large(item) == large);
        let (count, bounds) =
            side.fold((0, Bounds::EMPTY), |(count, all), item| (count + 1, all.union(item.bounds)));
        cost_of(count, bounds)
    };
    cost(true) + cost(false)
}

/// Returns the cost of items with these bounds. It is infinite for no items, because then nothing is divided.
fn cost_of(count: usize, bounds: Bounds) -> f32 {
    if count == 0 { f32::INFINITY } else { bounds.half_area() * count.div_ceil(LANES) as f32 }
}

/// Reports the cost of all bins up to each one.
fn sweep<'b>(bins: impl Iterator<Item = (usize, &'b (usize, Bounds))>, mut report: impl FnMut(usize, f32)) {
    let (mut count, mut bounds) = (0, Bounds::EMPTY);
    for (bin, (more, box_of_more)) in bins {
        count += more;
        bounds = bounds.union(*box_of_more);
        report(bin, cost_of(count, bounds));
    }
}

/// Moves the items for which `comes_first` holds to the start, and returns their number.
fn partition(items: &mut [Item], comes_first: impl Fn(&Item) -> bool) -> usize {
    let mut count = 0;
    for i in 0..items.len() {
        if comes_first(&items[i]) {
            items.swap(i, count);
            count += 1;
        }
    }
    count
}

/// Divides the items into two halves along the axis of their largest extent, and returns the start of the second half.
/// The first half fills its leaves.
fn median(items: &mut [Item], bounds: Bounds) -> usize {
    let extent = bounds.extent().to_array();
    let axis = if extent[0] >= extent[1].max(extent[2]) { 0 } else { 1 + usize::from(extent[2] > extent[1]) };
    let middle = (items.len() / 2).next_multiple_of(LANES).min(items.len() - 1);
    items.select_nth_unstable_by(middle, |a, b| a.center()[axis].total_cmp(&b.center()[axis]));
    middle
}

#[cfg(test)]
mod tests;
