//! The best hit along one ray: eight triangles at a time, and exactly where the filter leaves a doubt.

use super::cells::Cells;
use super::filter::{FARTHEST, FilterRay, Kernel, Verdict};
use super::triangle8::{Block, Frame, NONE};
use crate::grid::ray_aabb::Passage;
use crate::math::four::Four;
use crate::math::packet::Along;
use crate::math::ray::{Hit, Ray};
use crate::primitive::triangle::Shear;
use crate::stats::Probe;
use crate::world::{Primitive, World};

/// The best hit so far along one ray.
pub struct Search<'a> {
    pub world: &'a World,
    pub ray: &'a Ray,
    /// Computed when the first triangle needs it.
    shear: Option<Shear<'a>>,
    /// At the ray's end and of nothing, until something is found. Its t is not less than the right one.
    pub best: Hit,
    /// Not more than the best hit's right t: the same where that is known.
    least: f64,
    /// The primitives decided last, and the place of the next one: at first the one that the ray leaves.
    /// Those that span many cells, and that no filter rejects, would be decided over and over.
    decided: [u32; DECIDED],
    next: usize,
}

const DECIDED: usize = 4;

/// A ray on its way through the structure, in the filter's coordinates.
pub struct Filtered {
    ray: FilterRay,
    /// t where the filter's ray begins, how much of the filter's t one unit of t is, and the inverse.
    entry: f64,
    per_t: f64,
    unit: f64,
}

/// Where rays are at `entry`, in the coordinates of a frame with this centre and scale.
#[inline(always)]
pub fn place<F: Four>(along: &Along<F>, center: F, entry: F, scale: F) -> F {
    (along.origin - center + entry * along.direction) * scale
}

impl Filtered {
    /// The ray on its passage, as far as `last`.
    #[inline(always)]
    pub fn on<F: Four>(passage: &Passage<F>, frame: &Frame, last: f64) -> Self {
        let Passage { entry, along, .. } = passage;
        let (entry, Along { direction, inverse, .. }) = (*entry, *along);
        let largest = direction.abs().greatest();
        // One over the largest, without another division.
        let inverse = inverse.abs().least();
        let scale = direction.all(frame.scale);
        let center = F::new(direction.proof(), frame.center);
        let place = place(along, center, direction.all(entry), scale);
        let ray = [place.single(), (direction * direction.all(inverse)).single()];
        Self::new(ray, entry, largest * frame.scale, inverse * frame.unit, last)
    }

    /// With the filter's origin and direction, and what [`Filtered`] says of its t; as far as `last`.
    #[inline(always)]
    pub fn new([origin, direction]: [[f32; 4]; 2], entry: f64, per_t: f64, unit: f64, last: f64) -> Self {
        let ray = FilterRay { origin, direction, farthest: 0.0 };
        let mut filtered = Self { ray, entry, per_t, unit };
        filtered.cut(last);
        filtered
    }

    /// The ray's own t of the filter's.
    #[inline(always)]
    fn t(&self, depth: f32) -> f64 {
        self.entry + f64::from(depth) * self.unit
    }

    /// Nothing beyond `last` counts.
    #[inline(always)]
    pub fn cut(&mut self, last: f64) {
        let farthest = (last - self.entry) * self.per_t;
        self.ray.farthest = if farthest < FARTHEST { farthest } else { FARTHEST } as f32;
    }
}

impl<'a> Search<'a> {
    /// `leaving` is a primitive that the ray is known to miss, or [`NONE`].
    #[inline(always)]
    pub fn new(world: &'a World, ray: &'a Ray, leaving: u32) -> Self {
        let best = Hit { t: ray.t_max, primitive: NONE };
        let decided = [leaving, NONE, NONE, NONE];
        Self { world, ray, shear: None, best, least: best.t, decided, next: 1 }
    }

    /// The best hit, if there is one.
    #[inline(always)]
    pub fn hit(&self) -> Option<Hit> {
        (self.best.primitive != NONE).then_some(self.best)
    }

    #[inline(always)]
    pub fn test_planes<P: Probe>(&mut self, ray: &Ray, probe: &mut P) {
        let first = self.world.first_plane();
        probe.intersections(self.world.planes.len());
        for (i, plane) in self.world.planes.iter().enumerate() {
            if let Some(t) = plane.intersect(ray) {
                self.offer(Hit { t, primitive: first + i as u32 });
            }
        }
    }

    /// Tests a cell's blocks, and its other primitives; says whether the best hit changed. For any hit,
    /// the first one ends the test.
    #[inline(always)]
    pub fn test_cell<K: Kernel, P: Probe, const ANY: bool>(
        &mut self,
        kernel: K,
        cells: &Cells,
        blocks: &[Block],
        filtered: &mut Filtered,
        probe: &mut P,
    ) -> bool {
        let mut changed = false;
        for block in blocks {
            if P::COUNTS {
                probe.intersections(block.numbers.iter().filter(|&&n| n != NONE).count());
            }
            let verdict = kernel.test(block, &filtered.ray);
            if verdict.possible != 0 {
                if ANY {
                    if verdict.certain != 0 {
                        // Which one it is nobody asks.
                        self.best = Hit { t: self.ray.t_min, primitive: 0 };
                        return true;
                    }
                    if self.decide_any(block, verdict.possible) {
                        return true;
                    }
                } else if self.decide_nearest::<P>(block, &verdict, filtered) {
                    changed = true;
                    filtered.cut(self.best.t);
                }
            }
        }
        if let Some(last) = blocks.last()
            && last.others != [0, 0]
            && self.test_others(cells, last, probe)
        {
            changed = true;
            filtered.cut(self.best.t);
        }
        changed
    }

    /// Tests what is no triangle in the cell whose last block this is.
    #[inline(never)]
    fn test_others<P: Probe>(&mut self, cells: &Cells, last: &Block, probe: &mut P) -> bool {
        let [start, end] = last.others.map(|place| place as usize);
        let others = &cells.others[start..end];
        probe.intersections(others.len());
        others.iter().fold(false, |changed, &number| (self.is_new(number) && self.test(number)) | changed)
    }

    /// Whether the primitive was not among the last to be decided; notes that it is now. What was decided
    /// once is the best, or will never be.
    #[inline(always)]
    fn is_new(&mut self, number: u32) -> bool {
        let is_new = !self.decided.contains(&number);
        if is_new {
            self.decided[self.next % DECIDED] = number;
            self.next += 1;
        }
        is_new
    }

    /// Whether the ray hits any of a block's lanes that the filter left open.
    #[inline(never)]
    fn decide_any(&mut self, block: &Block, possible: u32) -> bool {
        lanes(possible).any(|lane| self.decide(block.numbers[lane]))
    }

    /// Decides what the filter cannot, unless that was just done; says whether the best hit changed.
    #[inline(never)]
    fn decide(&mut self, triangle: u32) -> bool {
        self.is_new(triangle) && self.test_triangle(triangle)
    }

    /// Looks for a better hit among the lanes of a block that the filter did not reject; says whether
    /// there is one. Only what the filter cannot tell apart is decided in double precision, since that
    /// has to fetch the triangle; and everything where steps are counted, which depend on t.
    #[inline(always)]
    fn decide_nearest<P: Probe>(&mut self, block: &Block, verdict: &Verdict, filtered: &Filtered) -> bool {
        let certain = if P::COUNTS { 0 } else { verdict.certain };
        let mut changed = false;
        for lane in lanes(verdict.possible) {
            let number = block.numbers[lane];
            if number == self.best.primitive {
                continue;
            }
            if certain >> lane & 1 != 0 {
                let [least, most] = verdict.depths(lane, block).map(|depth| filtered.t(depth));
                if most < self.least {
                    self.best = Hit { t: most, primitive: number };
                    self.least = least;
                    changed = true;
                    continue;
                }
            }
            changed |= self.decide(number);
        }
        changed
    }

    #[inline(always)]
    fn test_triangle(&mut self, number: u32) -> bool {
        // A copy, so that a new one is not written before it is read.
        let shear = match self.shear {
            Some(shear) => shear,
            None => *self.shear.insert(Shear::new(self.ray)),
        };
        match shear.intersect(self.world.corners_in_place(number as usize)) {
            Some(t) if self.ray.covers(t) => self.offer(Hit { t, primitive: number }),
            _ => false,
        }
    }

    /// Tests any finite primitive; says whether the best hit changed.
    pub fn test(&mut self, number: u32) -> bool {
        let t = match self.world.primitive(number) {
            Primitive::Triangle(_) => return self.test_triangle(number),
            Primitive::Sphere(i) => self.world.spheres[i].intersect(self.ray),
            Primitive::Ellipsoid(i) => self.world.ellipsoids[i].intersect(self.ray),
            Primitive::Plane(i) => self.world.planes[i].intersect(self.ray),
        };
        t.is_some_and(|t| self.offer(Hit { t, primitive: number }))
    }

    /// Keeps the hit, whose t is exact, if it precedes the best one.
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> bool {
        let better = hit.t < self.least || (hit.t <= self.best.t && self.precedes_best(hit));
        if better {
            self.best = hit;
            self.least = hit.t;
        }
        better
    }

    /// Whether a hit that is close to the best one precedes it.
    #[cold]
    fn precedes_best(&mut self, hit: Hit) -> bool {
        if self.least < self.best.t {
            self.best = self.world.exact(self.ray, self.best);
            self.least = self.best.t;
        }
        self.world.precedes(hit, self.best)
    }
}

/// The members of a set of lanes, in order.
#[inline(always)]
pub fn lanes(mut set: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = set.trailing_zeros() as usize;
        (set != 0).then(|| {
            set &= set - 1;
            lane
        })
    })
}
