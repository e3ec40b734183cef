//! The search along one ray: cells in order, eight triangles at a time, each decided exactly.

use super::Structure;
use super::block::{NONE, Numbers};
use super::cells::{BORDER, Cells, EMPTY};
use super::filter::{FARTHEST, FilterRay, Kernel};
use crate::grid::march::{March, Passage, clip};
use crate::math::ray::{Hit, Ray};
use crate::primitive::triangle::Shear;
use crate::stats::Probe;
use crate::world::{Primitive, World};

/// The best hit so far along one ray.
pub struct Search<'w> {
    world: &'w World,
    ray: Ray,
    /// Computed when the first triangle needs it.
    shear: Option<Shear>,
    /// At the ray's end and of nothing, until something is found.
    best: Hit,
}

/// A ray on its way through the structure, in the filter's coordinates.
struct Filtered {
    ray: FilterRay,
    /// t where the filter's ray begins, and how much of the filter's t one unit of t is.
    entry: f64,
    per_t: f64,
    /// How far along the filter's ray a hit still counts.
    farthest: f32,
}

impl Filtered {
    #[inline(always)]
    fn new(structure: &Structure, search: &Search, passage: &Passage) -> Self {
        let (frame, ray) = (&structure.cells.frame, &search.ray);
        let largest = ray.direction.abs().max_element();
        let origin = ((ray.origin - frame.center) + passage.entry * ray.direction) * frame.scale;
        let mut filtered = Self {
            ray: FilterRay::new(origin, ray.direction * (1.0 / largest)),
            entry: passage.entry,
            per_t: largest * frame.scale,
            farthest: 0.0,
        };
        filtered.cut(search);
        filtered
    }

    /// Nothing beyond the best hit counts.
    #[inline(always)]
    fn cut(&mut self, search: &Search) {
        self.farthest = ((search.best.t - self.entry) * self.per_t).min(FARTHEST) as f32;
    }
}

impl Structure {
    /// Looks for a better hit than the search has, in the structure's cells.
    #[inline(always)]
    pub fn run<K: Kernel, P: Probe, const ANY: bool>(&self, search: &mut Search, probe: &mut P) {
        let from_middle = (search.ray.origin - self.cells.frame.center).abs().max_element();
        if from_middle > self.farthest || from_middle.is_nan() {
            return self.run_all::<P, ANY>(search, probe);
        }
        let ray = Ray { t_max: search.best.t, ..search.ray };
        let Some(passage) = clip(&self.bounds, &ray) else {
            // The course's program tests everything; what is outside the box misses.
            let untested = if self.lattice.is_none() { search.world.finite_count() } else { 0 };
            return probe.intersections(untested);
        };
        let mut filtered = Filtered::new(self, search, &passage);
        match &self.lattice {
            Some(lattice) => {
                let march = March::new(lattice, &passage);
                self.march::<K, P, ANY>(march, filtered, search, probe);
            }
            None => {
                search.test_cell::<K, P, ANY>(&self.cells, 0, &mut filtered, probe);
            }
        }
    }

    /// Tests the cells along the ray until no nearer hit can follow.
    #[inline(always)]
    fn march<K: Kernel, P: Probe, const ANY: bool>(
        &self,
        mut march: March,
        mut filtered: Filtered,
        search: &mut Search,
        probe: &mut P,
    ) {
        let mut last_tick = march.tick(search.best.t);
        let mut word = self.cells.words[march.index];
        while word != BORDER {
            if word != EMPTY
                && search.test_cell::<K, P, ANY>(&self.cells, word as usize - 1, &mut filtered, probe)
            {
                if ANY {
                    return;
                }
                last_tick = march.tick(search.best.t);
            }
            if last_tick <= march.exit() {
                return;
            }
            word = self.next_cell(&mut march, probe);
        }
    }

    /// Goes on to the next cell that is not empty. With counters it goes on by one cell, so that
    /// the march stops as early as the course's program does.
    #[inline(always)]
    fn next_cell<P: Probe>(&self, march: &mut March, probe: &mut P) -> u32 {
        // A copy, so that this innermost loop works in registers.
        let mut ahead = *march;
        let word = loop {
            let set = ahead.step();
            let word = self.cells.words[ahead.index];
            if P::COUNTS {
                (0..set.count_ones()).for_each(|_| probe.cell());
                break word;
            }
            if word != EMPTY {
                break word;
            }
        };
        *march = ahead;
        word
    }

    /// Without filter and march: every primitive by itself.
    #[cold]
    fn run_all<P: Probe, const ANY: bool>(&self, search: &mut Search, probe: &mut P) {
        for number in 0..search.world.first_plane() {
            probe.intersections(1);
            if search.test(number) && ANY {
                return;
            }
        }
    }
}

impl<'w> Search<'w> {
    #[inline(always)]
    pub fn new(world: &'w World, ray: &Ray) -> Self {
        Self { world, ray: *ray, shear: None, best: Hit { t: ray.t_max, primitive: NONE } }
    }

    /// The best hit, if there is one.
    #[inline(always)]
    pub fn best(&self) -> Option<Hit> {
        (self.best.primitive != NONE).then_some(self.best)
    }

    #[inline(always)]
    pub fn test_planes<P: Probe>(&mut self, probe: &mut P) {
        let first = self.world.first_plane();
        probe.intersections(self.world.planes.len());
        for (i, plane) in self.world.planes.iter().enumerate() {
            if let Some(t) = plane.intersect(&self.ray) {
                self.offer(Hit { t, primitive: first + i as u32 });
            }
        }
    }

    /// Tests the blocks from `first` to the end of their cell, and the cell's other primitives; says
    /// whether the best hit changed. For any hit, the first one ends the test.
    #[inline(always)]
    fn test_cell<K: Kernel, P: Probe, const ANY: bool>(
        &mut self,
        cells: &Cells,
        first: usize,
        filtered: &mut Filtered,
        probe: &mut P,
    ) -> bool {
        let mut changed = false;
        let mut number = first;
        loop {
            let block = &cells.blocks[number];
            if P::COUNTS {
                probe.intersections(cells.numbers[number].iter().filter(|&&n| n != NONE).count());
            }
            let verdict = K::test(block, &filtered.ray, filtered.farthest);
            if verdict.possible != 0 {
                if ANY && verdict.certain != 0 {
                    // Which one it is nobody asks.
                    self.best = Hit { t: self.ray.t_min, primitive: 0 };
                    return true;
                }
                if self.decide::<ANY>(&cells.numbers[number], verdict.possible) {
                    changed = true;
                    if ANY {
                        return true;
                    }
                    filtered.cut(self);
                }
            }
            if block.is_last {
                break;
            }
            number += 1;
        }
        if cells.blocks[first].has_others && self.test_others(cells, first, probe) {
            changed = true;
            filtered.cut(self);
        }
        changed
    }

    /// Tests what is no triangle in the cell whose first block is `first`.
    #[inline(never)]
    fn test_others<P: Probe>(&mut self, cells: &Cells, first: usize, probe: &mut P) -> bool {
        let others = cells.others_of(first);
        probe.intersections(others.len());
        others.iter().fold(false, |changed, &number| self.test(number) | changed)
    }

    /// Decides the lanes of a block that the filter left open; says whether the best hit changed.
    #[inline(always)]
    fn decide<const ANY: bool>(&mut self, numbers: &Numbers, mut lanes: u32) -> bool {
        let mut changed = false;
        while lanes != 0 {
            let number = numbers[lanes.trailing_zeros() as usize];
            lanes &= lanes - 1;
            // What is already the best need not be found again in the next cell.
            if number != self.best.primitive {
                changed |= self.test_triangle(number);
                if ANY && changed {
                    return true;
                }
            }
        }
        changed
    }

    #[inline(always)]
    fn test_triangle(&mut self, number: u32) -> bool {
        let shear = self.shear.get_or_insert_with(|| Shear::new(&self.ray));
        match shear.intersect(self.world.corners(number as usize)) {
            Some(crossing) if self.ray.covers(crossing.t) => {
                self.offer(Hit { t: crossing.t, primitive: number })
            }
            _ => false,
        }
    }

    /// Tests any finite primitive; says whether the best hit changed.
    fn test(&mut self, number: u32) -> bool {
        let t = match self.world.primitive(number) {
            Primitive::Triangle(_) => return self.test_triangle(number),
            Primitive::Sphere(i) => self.world.spheres[i].intersect(&self.ray),
            Primitive::Ellipsoid(i) => self.world.ellipsoids[i].intersect(&self.ray),
            Primitive::Plane(i) => self.world.planes[i].intersect(&self.ray),
        };
        t.is_some_and(|t| self.offer(Hit { t, primitive: number }))
    }

    /// Keeps the hit if it precedes the best one.
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> bool {
        let better = self.world.precedes(hit, self.best);
        if better {
            self.best = hit;
        }
        better
    }
}
