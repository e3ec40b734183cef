//! The search along one ray: cells in order, eight triangles at a time, each decided exactly.

use super::Structure;
use super::block::Block;
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
    pub best: Option<Hit>,
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
    fn new(structure: &Structure, ray: &Ray, passage: &Passage) -> Self {
        let frame = &structure.cells.frame;
        let largest = ray.direction.abs().max_element();
        let origin = ((ray.origin - frame.center) + passage.entry * ray.direction) * frame.scale;
        let mut filtered = Self {
            ray: FilterRay::new(origin, ray.direction / largest),
            entry: passage.entry,
            per_t: largest * frame.scale,
            farthest: FARTHEST as f32,
        };
        filtered.cut(ray.t_max);
        filtered
    }

    /// Nothing beyond `t` counts any more.
    #[inline(always)]
    fn cut(&mut self, t: f64) {
        self.farthest = ((t - self.entry) * self.per_t).min(FARTHEST) as f32;
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
        let ray = search.within_best();
        let passage = clip(&self.bounds, &ray);
        match (&self.lattice, passage) {
            (Some(lattice), Some(passage)) => {
                let march = March::new(lattice, &ray, &passage);
                let filtered = Filtered::new(self, &ray, &passage);
                self.march::<K, P, ANY>(march, filtered, search, probe);
            }
            (None, Some(passage)) => {
                let mut filtered = Filtered::new(self, &ray, &passage);
                search.test_cell::<K, P, ANY>(&self.cells, 0, &mut filtered, probe);
            }
            // The course's program tests everything; what is outside the box misses.
            (None, None) => probe.intersections(search.world.finite_count()),
            (Some(_), None) => {}
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
        let mut last_tick = march.tick(search.ray.t_max.min(search.best.map_or(f64::INFINITY, |hit| hit.t)));
        loop {
            let word = self.cells.words[march.index];
            if word != EMPTY {
                if word == BORDER {
                    return;
                }
                if search.test_cell::<K, P, ANY>(&self.cells, word as usize - 1, &mut filtered, probe) {
                    if ANY {
                        return;
                    }
                    if let Some(hit) = search.best {
                        last_tick = march.tick(hit.t);
                    }
                }
            }
            if (P::COUNTS || word != EMPTY) && last_tick <= march.exit() {
                return;
            }
            probe.cell();
            march.step();
        }
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
        Self { world, ray: *ray, shear: None, best: None }
    }

    /// The ray up to the best hit.
    #[inline(always)]
    fn within_best(&self) -> Ray {
        let t_max = self.best.map_or(self.ray.t_max, |hit| hit.t);
        Ray { t_max, ..self.ray }
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
        for block in &cells.blocks[first..] {
            if P::COUNTS {
                probe.intersections(block.count());
            }
            let verdict = K::test(block, &filtered.ray, filtered.farthest);
            if verdict.possible != 0 {
                if ANY && verdict.certain != 0 {
                    self.best = Some(Hit { t: self.ray.t_min, primitive: u32::MAX });
                    return true;
                }
                if self.decide(block, verdict.possible) {
                    changed = true;
                    if ANY {
                        return true;
                    }
                    filtered.cut(self.best.map_or(f64::INFINITY, |hit| hit.t));
                }
            }
            if block.is_last {
                break;
            }
        }
        let Block { others_start, others_count, .. } = cells.blocks[first];
        if others_count > 0 {
            let others = &cells.others[others_start as usize..][..others_count as usize];
            probe.intersections(others.len());
            for &number in others {
                changed |= self.test(number);
            }
            filtered.cut(self.best.map_or(self.ray.t_max, |hit| hit.t));
        }
        changed
    }

    /// Decides the lanes of a block that the filter left open; says whether the best hit changed.
    #[inline(always)]
    fn decide(&mut self, block: &Block, mut lanes: u32) -> bool {
        let mut changed = false;
        while lanes != 0 {
            let number = block.numbers[lanes.trailing_zeros() as usize];
            lanes &= lanes - 1;
            // What is already the best need not be found again in the next cell.
            if self.best.is_none_or(|best| best.primitive != number) {
                changed |= self.test_triangle(number);
            }
        }
        changed
    }

    #[inline(always)]
    fn test_triangle(&mut self, number: u32) -> bool {
        let shear = *self.shear.get_or_insert_with(|| Shear::new(&self.ray));
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
        let better = self.best.is_none_or(|best| hit.precedes(&best));
        if better {
            self.best = Some(hit);
        }
        better
    }
}
