//! The division of primitives into the branches of a [`Tree`](crate::caster::tree::Tree).
//!
//! A run of primitives is divided into halves by the surface area heuristic, evaluated at the borders of a few bins
//! (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", IEEE Symposium on Interactive Ray Tracing
//! 2007). For a node with eight branches, the half with the largest surface area is divided again until there are eight
//! (Wald, Benthin and Boulos, "Getting Rid of Packets", IEEE Symposium on Interactive Ray Tracing 2008).

use crate::base::patience::{Ended, Patience};
use crate::caster::block::{Frame, LANES};
use crate::caster::bounds::{Region, widened};
use crate::caster::box8::PADDING;
use crate::math::aabb::Aabb;
use crate::world::World;
use arrayvec::ArrayVec;
use glam::Vec3A;
use rayon::prelude::*;

/// The number of levels that are divided by the heuristic. Below them the primitives are divided by their number. This
/// bounds the depth of the tree if the heuristic does not divide the primitives evenly.
const HEURISTIC_LEVELS: usize = 40;

/// Upper bound on the number of levels: [`HEURISTIC_LEVELS`], and 29 that at least halve the at most 2^29 leaves.
pub const MAX_LEVELS: usize = HEURISTIC_LEVELS + 29;

/// The number of levels that a branch with a frame of its own counts as, so that at most eight are nested.
const LEVELS_OF_SMALL: usize = HEURISTIC_LEVELS / 8;

/// From this number of items on, all branches of a node are divided at the same time.
const PARALLEL_ITEMS: usize = 1 << 13;

/// A branch of a tree, before the tree is laid out.
pub enum Division {
    /// The ids of the primitives of a leaf, in ascending order.
    Leaf(ArrayVec<u32, LANES>),
    /// A branch in the frame of this region.
    Small(Box<(Region, Division)>),
    /// The branches of a node, each with its box.
    Node(Vec<(Bounds, Division)>),
}

impl Division {
    /// Divides primitives in the coordinates of a frame, below this number of levels, as long as there is patience.
    pub fn new(
        (world, patience): (&World, &dyn Patience),
        ids: Vec<u32>,
        frame: &Frame,
        level: usize,
    ) -> Result<Self, Ended> {
        let item = |id: u32| Item::new(frame, &world.box_of(id), id);
        let mut items: Vec<Item> = ids.into_par_iter().map(item).collect();
        Self::of((world, patience), ItemRun::new(&mut items), level)
    }

    /// Returns the number of leaves.
    pub fn leaves(&self) -> usize {
        match self {
            Self::Leaf(_) => 1,
            Self::Small(small) => small.1.leaves(),
            Self::Node(branches) => branches.iter().map(|(_, branch)| branch.leaves()).sum(),
        }
    }

    fn of((world, patience): (&World, &dyn Patience), run: ItemRun, level: usize) -> Result<Self, Ended> {
        let ids = run.items.iter().map(|item| item.id);
        if run.items.len() <= LANES {
            let mut ids: ArrayVec<u32, LANES> = ids.collect();
            ids.sort_unstable();
            Ok(Self::Leaf(ids))
        } else if run.is_small && level < HEURISTIC_LEVELS {
            let boxes = ids.clone().map(|id| world.box_of(id));
            let bounds = widened(boxes.fold(Aabb::EMPTY, |all, bounds| all.union(bounds)));
            let region = Region::new(&bounds, f64::INFINITY);
            let ids = ids.collect();
            let inner = Self::new((world, patience), ids, &region.frame, level + LEVELS_OF_SMALL)?;
            Ok(Self::Small(Box::new((region, inner))))
        } else {
            Self::node((world, patience), run, level)
        }
    }

    /// Divides more than [`LANES`] items into the branches of a node.
    fn node((world, patience): (&World, &dyn Patience), run: ItemRun, level: usize) -> Result<Self, Ended> {
        let by_number = level >= HEURISTIC_LEVELS;
        let count = run.items.len();
        let mut runs = vec![run];
        while runs.len() < LANES {
            let may_be_divided = |run: &ItemRun| run.items.len() > LANES && (by_number || !run.is_small);
            let size =
                |run: &ItemRun| if by_number { run.items.len() as f32 } else { run.bounds.half_area() };
            let divisible = (0..runs.len()).filter(|&k| may_be_divided(&runs[k]));
            let Some(largest) = divisible.max_by(|&a, &b| size(&runs[a]).total_cmp(&size(&runs[b]))) else {
                break;
            };
            if runs[largest].items.len() >= PARALLEL_ITEMS {
                patience.check()?;
            }
            let halves = runs.swap_remove(largest).halves(by_number);
            runs.extend(halves);
        }
        let divide = |run: ItemRun| Ok((run.bounds, Self::of((world, patience), run, level + 1)?));
        let branches: Result<_, Ended> = match count {
            PARALLEL_ITEMS.. => runs.into_par_iter().map(divide).collect(),
            _ => runs.into_iter().map(divide).collect(),
        };
        Ok(Self::Node(branches?))
    }
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
    fn half_area(&self) -> f32 {
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
struct ItemRun<'i> {
    items: &'i mut [Item],
    bounds: Bounds,
    /// The bounds of twice the centres.
    centers: Bounds,
    /// True if the run is small, and more than an eighth of its items are small.
    is_small: bool,
}

impl<'i> ItemRun<'i> {
    fn new(items: &'i mut [Item]) -> Self {
        let (mut bounds, mut centers) = (Bounds::EMPTY, Bounds::EMPTY);
        for item in items.iter() {
            bounds = bounds.union(item.bounds);
            centers = centers.union(Bounds { min: item.center(), max: item.center() });
        }
        let are_small = |item: &&Item| item.bounds.size() < SMALL_PRIMITIVE;
        let is_small = bounds.size() <= MAX_SMALL && 8 * items.iter().filter(are_small).count() > items.len();
        Self { items, bounds, centers, is_small }
    }

    /// Divides the items into two runs.
    fn halves(self, by_number: bool) -> [Self; 2] {
        let plane = if by_number { None } else { self.best_plane() };
        let middle = match plane {
            Some(plane) => partition(self.items, |item| plane.is_before(item)),
            None => median(self.items, self.bounds),
        };
        let (left, right) = self.items.split_at_mut(middle);
        [left, right].map(ItemRun::new)
    }
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
    /// Returns the plane with the least cost; `None` if all centres are the same. The cost is the sum over both sides of
    /// the area times the number of blocks for the items.
    fn best_plane(&self) -> Option<Plane> {
        let bins = Bins::new(&self.centers);
        let mut contents = [[(0, Bounds::EMPTY); BINS]; 3];
        for item in self.items.iter() {
            for (contents, bin) in contents.iter_mut().zip(bins.of(item)) {
                let (count, bounds) = &mut contents[bin];
                *count += 1;
                *bounds = bounds.union(item.bounds);
            }
        }
        let mut best = (f32::INFINITY, None);
        for (axis, contents) in contents.iter().enumerate() {
            let mut costs_behind = [0.0; BINS];
            sweep(contents.iter().enumerate().rev(), |bin, cost| costs_behind[bin] = cost);
            sweep(contents.iter().enumerate(), |bin, cost| {
                let cost = cost + costs_behind.get(bin + 1).unwrap_or(&f32::INFINITY);
                if cost < best.0 {
                    best = (cost, Some(Plane { bins, axis, bin: bin + 1 }));
                }
            });
        }
        best.1
    }
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
