//! Divides the primitives of a branch into halves: by the surface area heuristic, evaluated at the borders of a few
//! bins (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", IEEE Symposium on Interactive Ray
//! Tracing 2007), or into large and small primitives.

use crate::caster::block::{Frame, LANES};
use crate::caster::box8::PADDING;
use crate::math::aabb::Aabb;
use glam::Vec3A;

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
