//! The best hit along one ray: eight triangles at a time, and exactly where the filter leaves a doubt.

use super::cell_contents::CellContents;
use super::filter::{FilterRay, Kernel, MAX_DEPTH, Verdict};
use super::triangle8::{Block, Frame, NONE};
use crate::grid::ray_aabb::RayInterval;
use crate::math::f64x4::F64x4;
use crate::math::ray::{Hit, Ray};
use crate::math::ray_lanes::RayLanes;
use crate::primitive::triangle::Shear;
use crate::stats::Probe;
use crate::world::{Primitive, World};

/// The best hit so far along one ray.
pub struct RayQuery<'a> {
    pub world: &'a World,
    pub ray: &'a Ray,
    /// Computed when the first triangle needs it.
    shear: Option<Shear<'a>>,
    /// At the ray's end and of nothing, until something is found. Its t is not less than the right one.
    pub best: Hit,
    /// Not more than the best hit's right t: the same where that is known.
    t_lower_bound: f64,
    /// The primitives decided last, and the place of the next one: at first the one that the ray leaves.
    /// Those that span many cells, and that no filter rejects, would be decided over and over.
    decided: [u32; DECIDED],
    next: usize,
}

const DECIDED: usize = 4;

/// A ray on its way through the structure, in the filter's coordinates.
pub struct FilterState {
    ray: FilterRay,
    /// t where the filter's ray begins, how much of the filter's t one unit of t is, and the inverse.
    entry: f64,
    per_t: f64,
    unit: f64,
}

/// Where rays are at `entry`, in the coordinates of a frame with this centre and scale.
#[inline(always)]
pub fn to_frame<F: F64x4>(ray_lanes: &RayLanes<F>, center: F, entry: F, scale: F) -> F {
    (ray_lanes.origin - center + entry * ray_lanes.direction) * scale
}

impl FilterState {
    /// The ray on its passage, as far as `last`.
    #[inline(always)]
    pub fn on<F: F64x4>(interval: &RayInterval<F>, frame: &Frame, last: f64) -> Self {
        let RayInterval { entry, ray_lanes, .. } = interval;
        let (entry, RayLanes { direction, inv_direction, .. }) = (*entry, *ray_lanes);
        let largest = direction.abs().max3();
        // One over the largest, without another division.
        let inv_largest = inv_direction.abs().min3();
        let scale = direction.broadcast(frame.scale);
        let center = F::new(direction.proof(), frame.center);
        let origin = to_frame(ray_lanes, center, direction.broadcast(entry), scale);
        let ray = [origin.to_f32(), (direction * direction.broadcast(inv_largest)).to_f32()];
        Self::new(ray, entry, largest * frame.scale, inv_largest * frame.unit, last)
    }

    /// With the filter's origin and direction, and what [`FilterState`] says of its t; as far as `last`.
    #[inline(always)]
    pub fn new([origin, direction]: [[f32; 4]; 2], entry: f64, per_t: f64, unit: f64, last: f64) -> Self {
        let ray = FilterRay { origin, direction, max_depth: 0.0 };
        let mut filter_state = Self { ray, entry, per_t, unit };
        filter_state.shorten(last);
        filter_state
    }

    /// The ray's own t of the filter's.
    #[inline(always)]
    fn t(&self, depth: f32) -> f64 {
        self.entry + f64::from(depth) * self.unit
    }

    /// Nothing beyond `last` counts.
    #[inline(always)]
    pub fn shorten(&mut self, last: f64) {
        let max_depth = (last - self.entry) * self.per_t;
        self.ray.max_depth = if max_depth < MAX_DEPTH { max_depth } else { MAX_DEPTH } as f32;
    }
}

impl<'a> RayQuery<'a> {
    /// `exclude` is a primitive that the ray is known to miss, or [`NONE`].
    #[inline(always)]
    pub fn new(world: &'a World, ray: &'a Ray, exclude: u32) -> Self {
        let best = Hit { t: ray.t_max, primitive: NONE };
        let decided = [exclude, NONE, NONE, NONE];
        Self { world, ray, shear: None, best, t_lower_bound: best.t, decided, next: 1 }
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
        cells: &CellContents,
        blocks: &[Block],
        filter_state: &mut FilterState,
        probe: &mut P,
    ) -> bool {
        let mut changed = false;
        for block in blocks {
            if P::COUNTS {
                probe.intersections(block.ids.iter().filter(|&&n| n != NONE).count());
            }
            let verdict = kernel.test(block, &filter_state.ray);
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
                } else if self.decide_nearest::<P>(block, &verdict, filter_state) {
                    changed = true;
                    filter_state.shorten(self.best.t);
                }
            }
        }
        if let Some(last) = blocks.last()
            && last.non_triangles != [0, 0]
            && self.test_non_triangles(cells, last, probe)
        {
            changed = true;
            filter_state.shorten(self.best.t);
        }
        changed
    }

    /// Tests what is no triangle in the cell whose last block this is.
    #[inline(never)]
    fn test_non_triangles<P: Probe>(&mut self, cells: &CellContents, last: &Block, probe: &mut P) -> bool {
        let [start, end] = last.non_triangles.map(|place| place as usize);
        let non_triangles = &cells.non_triangles[start..end];
        probe.intersections(non_triangles.len());
        non_triangles.iter().fold(false, |changed, &id| (self.is_new(id) && self.test(id)) | changed)
    }

    /// Whether the primitive was not among the last to be decided; notes that it is now. What was decided
    /// once is the best, or will never be.
    #[inline(always)]
    fn is_new(&mut self, id: u32) -> bool {
        let is_new = !self.decided.contains(&id);
        if is_new {
            self.decided[self.next % DECIDED] = id;
            self.next += 1;
        }
        is_new
    }

    /// Whether the ray hits any of a block's lanes that the filter left open.
    #[inline(never)]
    fn decide_any(&mut self, block: &Block, possible: u32) -> bool {
        lanes(possible).any(|lane| self.decide(block.ids[lane]))
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
    fn decide_nearest<P: Probe>(
        &mut self,
        block: &Block,
        verdict: &Verdict,
        filter_state: &FilterState,
    ) -> bool {
        let certain = if P::COUNTS { 0 } else { verdict.certain };
        let mut changed = false;
        for lane in lanes(verdict.possible) {
            let id = block.ids[lane];
            if id == self.best.primitive {
                continue;
            }
            if certain >> lane & 1 != 0 {
                let [lower, upper] = verdict.depths(lane, block).map(|depth| filter_state.t(depth));
                if upper < self.t_lower_bound {
                    self.best = Hit { t: upper, primitive: id };
                    self.t_lower_bound = lower;
                    changed = true;
                    continue;
                }
            }
            changed |= self.decide(id);
        }
        changed
    }

    #[inline(always)]
    fn test_triangle(&mut self, id: u32) -> bool {
        // A copy, so that a new one is not written before it is read.
        let shear = match self.shear {
            Some(shear) => shear,
            None => *self.shear.insert(Shear::new(self.ray)),
        };
        match shear.intersect(self.world.corners_in_place(id as usize)) {
            Some(t) if self.ray.covers(t) => self.offer(Hit { t, primitive: id }),
            _ => false,
        }
    }

    /// Tests any finite primitive; says whether the best hit changed.
    pub fn test(&mut self, id: u32) -> bool {
        let t = match self.world.primitive(id) {
            Primitive::Triangle(_) => return self.test_triangle(id),
            Primitive::Sphere(i) => self.world.spheres[i].intersect(self.ray),
            Primitive::Ellipsoid(i) => self.world.ellipsoids[i].intersect(self.ray),
            Primitive::Plane(i) => self.world.planes[i].intersect(self.ray),
        };
        t.is_some_and(|t| self.offer(Hit { t, primitive: id }))
    }

    /// Keeps the hit, whose t is exact, if it precedes the best one.
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> bool {
        let better = hit.t < self.t_lower_bound || (hit.t <= self.best.t && self.precedes_best(hit));
        if better {
            self.best = hit;
            self.t_lower_bound = hit.t;
        }
        better
    }

    /// Whether a hit that is close to the best one precedes it.
    #[cold]
    fn precedes_best(&mut self, hit: Hit) -> bool {
        if self.t_lower_bound < self.best.t {
            self.best = self.world.exact(self.ray, self.best);
            self.t_lower_bound = self.best.t;
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
