//! The best hit along one ray: eight triangles at a time, and exactly where the filter leaves a doubt.

use super::cell_contents::CellContents;
use super::filter::{FilterRay, Kernel, MAX_DEPTH, Verdict};
use super::ray_aabb::RayInterval;
use super::triangle8::{Block, Frame, NONE};
use crate::math::f64x4::F64x4;
use crate::math::ray::{Ray, Visible};
use crate::math::ray_lanes::RayLanes;
use crate::mode::Mode;
use crate::primitive::triangle::Shear;
use crate::stats::Probe;
use crate::world::{Primitive, World};

/// The search along one ray, with the nearest primitive that it has found so far.
pub struct RayQuery<'a> {
    pub world: &'a World,
    pub ray: &'a Ray,
    /// Computed when the first triangle needs it.
    shear: Option<Shear<'a>>,
    /// [`NONE`], bounded by the ray's end, until a primitive is found.
    pub best: Visible,
    /// A lower bound on the t of `best`. It equals the upper bound where t is known.
    t_lower_bound: f64,
    /// The primitives that were decided last, and where the next one is noted. The first is the one that the ray
    /// leaves. A primitive that spans many cells, and that no filter rejects, would be decided in each of them.
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
        let best = Visible { primitive: NONE, t_bound: ray.t_max };
        let decided = [exclude, NONE, NONE, NONE];
        Self { world, ray, shear: None, best, t_lower_bound: best.t_bound, decided, next: 1 }
    }

    /// The nearest primitive found, if there is one.
    #[inline(always)]
    pub fn visible(&self) -> Option<Visible> {
        (self.best.primitive != NONE).then_some(self.best)
    }

    #[inline(always)]
    pub fn test_planes<P: Probe>(&mut self, ray: &Ray, probe: &mut P) {
        let first = self.world.first_plane();
        probe.intersections(self.world.planes.len());
        for (i, plane) in self.world.planes.iter().enumerate() {
            if let Some(t) = plane.intersect(ray) {
                self.offer(t, first + i as u32);
            }
        }
    }

    /// Tests a cell's blocks of triangles and its other primitives; returns whether the best primitive changed. An
    /// any-hit query ends with the first primitive that it finds.
    #[inline(always)]
    pub fn test_cell<K: Kernel, M: Mode, P: Probe, const ANY: bool>(
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
                        let primitive = block.ids[verdict.certain.trailing_zeros() as usize];
                        self.best = Visible { primitive, t_bound: self.ray.t_max };
                        return true;
                    }
                    if self.decide_any(block, verdict.possible) {
                        return true;
                    }
                } else if self.decide_nearest::<M>(block, &verdict, filter_state) {
                    changed = true;
                    filter_state.shorten(self.best.t_bound);
                }
            }
        }
        if let Some(last) = blocks.last()
            && last.non_triangles != [0, 0]
            && self.test_non_triangles(cells, last, probe)
        {
            changed = true;
            filter_state.shorten(self.best.t_bound);
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
    fn decide_nearest<M: Mode>(
        &mut self,
        block: &Block,
        verdict: &Verdict,
        filter_state: &FilterState,
    ) -> bool {
        let certain = if M::AS_COURSE { 0 } else { verdict.certain };
        let mut changed = false;
        for lane in lanes(verdict.possible) {
            let id = block.ids[lane];
            if id == self.best.primitive {
                continue;
            }
            if certain >> lane & 1 != 0 {
                let [lower, upper] = verdict.depths(lane, block).map(|depth| filter_state.t(depth));
                if upper < self.t_lower_bound {
                    self.best = Visible { primitive: id, t_bound: upper };
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
            Some(t) if self.ray.covers(t) => self.offer(t, id),
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
        t.is_some_and(|t| self.offer(t, id))
    }

    /// Keeps a primitive that the ray meets at `t` if it precedes the best one.
    #[inline(always)]
    fn offer(&mut self, t: f64, primitive: u32) -> bool {
        let better = t < self.t_lower_bound || (t <= self.best.t_bound && self.precedes_best(t, primitive));
        if better {
            self.best = Visible { primitive, t_bound: t };
            self.t_lower_bound = t;
        }
        better
    }

    /// Decides whether a primitive precedes the best one where the bounds on the latter's t do not tell.
    #[cold]
    fn precedes_best(&mut self, t: f64, primitive: u32) -> bool {
        if self.t_lower_bound < self.best.t_bound {
            self.best.t_bound = self.world.hit(self.ray, self.best).t;
            self.t_lower_bound = self.best.t_bound;
        }
        self.world.precedes((t, primitive), (self.best.t_bound, self.best.primitive))
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
