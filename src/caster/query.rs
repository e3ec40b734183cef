//! The query for one ray. The filter tests eight triangles at a time; those that it cannot decide are tested
//! exactly, one by one.

use crate::caster::blocks::filter::{self, FilterRay, MAX_DEPTH, Verdict};
use crate::caster::blocks::triangle8::{Block, Frame, NONE};
use crate::caster::cell_contents::CellContents;
use crate::caster::ray_aabb::RayInterval;
use crate::math::f64x4::FourLanes;
use crate::math::lanes::lanes;
use crate::math::number::Number;
use crate::math::ray::{Ray, Visible};
use crate::math::ray_lanes::RayLanes;
use crate::primitive::triangle::Shear;
use crate::stats::Probe;
use crate::world::{Primitive, World};
use fearless_simd::{Simd, SimdFrom, f64x4};
use std::cell::RefCell;

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
    /// The primitive that is not tested, or [`NONE`].
    leaves: u32,
    /// The primitives that were tested exactly last, and the position at which the next one is recorded.
    /// Without this a primitive that spans many cells, and that the filter does not reject, would be tested
    /// in each of them.
    tested: [u32; MAX_TESTED],
    next: usize,
    /// Whether a primitive other than the best one was hit so close to the best one of then that both may lie in the same
    /// place.
    is_close: bool,
    /// If not none, all primitives that the ray hits up to its end are collected here, and none becomes the best one.
    collected: Option<&'a HitList>,
}

/// The primitives that a ray hits, each with its t, perhaps more than once.
pub type HitList = RefCell<Vec<(f64, u32)>>;

/// The number of primitives in [`RayQuery::tested`].
const MAX_TESTED: usize = 4;

/// A ray in the filter's coordinates, up to the nearest hit so far.
pub struct FilterState {
    pub ray: FilterRay,
    /// The t at which the filter's ray starts, the filter's units of t per unit of t, and the inverse.
    entry: f64,
    per_t: f64,
    unit: f64,
}

impl FilterState {
    /// The ray on its interval in the bounds, up to t = `last`.
    #[inline(always)]
    pub fn on_interval<S: Simd>(interval: &RayInterval<S>, frame: &Frame, last: f64) -> Self {
        let RayInterval { entry, ray_lanes, .. } = interval;
        let (entry, RayLanes { origin, direction, inv_direction }) = (*entry, *ray_lanes);
        let largest = direction.abs().max3();
        // The inverse of the largest component, without another division.
        let inv_largest = inv_direction.abs().min3();
        let scale = direction.broadcast(frame.scale);
        let center = f64x4::simd_from(direction.proof(), frame.center);
        let origin = (origin - center + direction.broadcast(entry) * direction) * scale;
        let ray = [origin.to_f32(), (direction * direction.broadcast(inv_largest)).to_f32()];
        Self::new(ray, entry, largest * frame.scale, inv_largest * frame.unit, last)
    }

    /// A ray with this origin and direction in the filter's coordinates, up to t = `last`. The other
    /// parameters are as in [`FilterState`].
    #[inline(always)]
    pub fn new([origin, direction]: [[f32; 4]; 2], entry: f64, per_t: f64, unit: f64, last: f64) -> Self {
        let ray = FilterRay { origin, direction, max_depth: 0.0 };
        let mut filter_state = Self { ray, entry, per_t, unit };
        filter_state.shorten(last);
        filter_state
    }

    /// Converts the filter's t to the ray's.
    #[inline(always)]
    fn t(&self, depth: f32) -> f64 {
        self.entry + f64::from(depth) * self.unit
    }

    /// Ends the ray at t = `last`.
    #[inline(always)]
    pub fn shorten(&mut self, last: f64) {
        let max_depth = (last - self.entry) * self.per_t;
        self.ray.max_depth = if max_depth < MAX_DEPTH { max_depth } else { MAX_DEPTH } as f32;
    }
}

impl<'a> RayQuery<'a> {
    /// `leaves` is the triangle or the plane that the ray leaves, which it is known to miss, or a primitive for
    /// [`leave_round`](Self::leave_round), or [`NONE`].
    #[inline(always)]
    pub fn new(world: &'a World, ray: &'a Ray, leaves: u32) -> Self {
        let best = Visible { primitive: NONE, t_bound: ray.t_max };
        let (t_lower_bound, tested) = (best.t_bound, [NONE; MAX_TESTED]);
        let (next, is_close, collected) = (0, false, None);
        Self { world, ray, shear: None, best, t_lower_bound, leaves, tested, next, is_close, collected }
    }

    /// Collects all primitives that the ray hits in a list, if there is one.
    #[inline(always)]
    pub fn collect_in(&mut self, list: Option<&'a HitList>) {
        if list.is_some() {
            self.collected = list;
            // No bounds suffice to decide.
            self.t_lower_bound = f64::NEG_INFINITY;
        }
    }

    /// Notes that primitives that may lie in the same place as the best one were not tested.
    #[inline(always)]
    pub fn leave_undecided(&mut self) {
        self.is_close |= self.best.primitive != NONE;
    }

    /// Whether it is still to be decided which of several primitives in the same place the ray sees.
    #[inline(always)]
    pub fn is_undecided(&self) -> bool {
        self.is_close && self.collected.is_none()
    }

    /// The t up to which primitives are looked for: behind the best one there may be others in the same place. Any hit
    /// has to be before the ray's end.
    #[inline(always)]
    pub fn end<const ANY: bool>(&self) -> f64 {
        let t = self.best.t_bound;
        if ANY { t } else { t + self.world.coincidence_reach(t) }
    }

    /// The nearest primitive found, if there is one.
    #[inline(always)]
    pub fn visible(&self) -> Option<Visible> {
        (self.best.primitive != NONE).then_some(self.best)
    }

    /// Tests the sphere or ellipsoid that the ray leaves. The course's program does so where it comes to it.
    #[inline(never)]
    pub fn leave_round<P: Probe>(&mut self, probe: &mut P) {
        if P::COUNTS {
            self.leaves = NONE;
        } else {
            probe.intersections(1);
            self.test(self.leaves);
        }
    }

    #[inline(always)]
    pub fn test_planes<P: Probe>(&mut self, ray: &Ray, probe: &mut P) {
        let first = self.world.first_plane();
        probe.intersections(self.world.planes.len());
        for (id, plane) in (first..).zip(&self.world.planes) {
            // A ray that leaves a plane does not hit it again.
            if id != self.leaves
                && let Some(t) = plane.intersect(ray)
            {
                self.offer(t, id);
            }
        }
    }

    /// Tests a cell's blocks of triangles and its other primitives, and returns whether the best primitive
    /// changed. An any-hit query ends with the first primitive that it finds.
    #[inline(always)]
    pub fn test_cell<S: Simd, P: Probe, const ANY: bool>(
        &mut self,
        simd: S,
        cells: &CellContents,
        blocks: &[Block],
        filter_state: &mut FilterState,
        probe: &mut P,
    ) -> bool {
        let mut changed = false;
        for block in cells.with_triangles(blocks) {
            if P::COUNTS {
                probe.intersections(block.index.triangles());
            }
            // Most triangles that the filter does not reject are the one that the ray leaves and the best one.
            let verdict = filter::test(simd, block, &filter_state.ray, [self.leaves, self.best.primitive]);
            if verdict.possible != 0 {
                if ANY {
                    if verdict.certain != 0 {
                        let primitive = block.index.ids[verdict.certain.trailing_zeros() as usize];
                        self.best = Visible { primitive, t_bound: self.ray.t_max };
                        return true;
                    }
                    if self.decide_any(block, verdict.possible) {
                        return true;
                    }
                } else if self.decide_nearest::<P>(block, &verdict, filter_state) {
                    changed = true;
                    filter_state.shorten(self.end::<ANY>());
                }
            }
        }
        if cells.has_non_triangles() && self.test_non_triangles(cells, blocks, probe) {
            changed = true;
            filter_state.shorten(self.end::<ANY>());
        }
        changed
    }

    /// Tests the primitives other than triangles in a cell of these blocks, and returns whether the best primitive
    /// changed.
    #[inline(always)]
    fn test_non_triangles<P: Probe>(
        &mut self,
        cells: &CellContents,
        blocks: &[Block],
        probe: &mut P,
    ) -> bool {
        let ids = cells.non_triangles_in(blocks);
        probe.intersections(ids.len());
        match ids {
            [] => false,
            // Most rays that pass several cells of a sphere end here.
            [id] if self.is_known(*id) => false,
            _ => self.test_new(ids),
        }
    }

    /// Tests those primitives that were not tested last.
    #[inline(never)]
    fn test_new(&mut self, ids: &[u32]) -> bool {
        ids.iter().fold(false, |changed, &id| (self.is_new(id) && self.test(id)) | changed)
    }

    /// Whether the primitive is not tested at all, or among those that were tested last.
    #[inline(always)]
    fn is_known(&self, id: u32) -> bool {
        id == self.leaves || self.tested.contains(&id)
    }

    /// Returns whether the primitive is not known, and records it. A primitive that has been tested once is the best
    /// one already, or never becomes the best.
    #[inline(always)]
    fn is_new(&mut self, id: u32) -> bool {
        let is_new = !self.is_known(id);
        if is_new {
            self.tested[self.next % MAX_TESTED] = id;
            self.next += 1;
        }
        is_new
    }

    /// Whether the ray hits any of the lanes that the filter could not decide.
    #[inline(never)]
    fn decide_any(&mut self, block: &Block, possible: u32) -> bool {
        lanes(possible).any(|lane| self.decide(block.index.ids[lane]))
    }

    /// Tests a triangle exactly, unless it was one of the last to be tested, and returns whether the best
    /// primitive changed.
    #[inline(never)]
    fn decide(&mut self, triangle: u32) -> bool {
        self.is_new(triangle) && self.test_triangle(triangle)
    }

    /// Looks for a nearer hit among the lanes of a block that the filter did not reject, and returns whether
    /// there is one. A triangle is tested in double precision, for which its vertices have to be loaded, only
    /// if the filter's bounds on t do not decide. Where steps are counted all are, because the
    /// steps depend on t.
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
            let id = block.index.ids[lane];
            if certain >> lane & 1 != 0 {
                let [lower, upper] = verdict.depths(lane, block).map(|depth| filter_state.t(depth));
                let reach = self.world.coincidence_reach(lower.abs().max(upper.abs()));
                if upper + reach < self.t_lower_bound {
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
        // Copied, because a reference to a new shear would force it through memory.
        let shear = match self.shear {
            Some(shear) => shear,
            None => *self.shear.insert(Shear::new(self.ray)),
        };
        match shear.intersect(self.world.corners_in_place(id as usize)) {
            Some(t) if self.ray.covers(t) => self.offer(t, id),
            _ => false,
        }
    }

    /// Tests a primitive exactly, and returns whether the best primitive changed.
    #[inline]
    pub fn test(&mut self, id: u32) -> bool {
        match self.world.primitive(id) {
            Primitive::Triangle(_) => self.test_triangle(id),
            _ => self.world.crossing(self.ray, id).is_some_and(|t| self.offer(t, id)),
        }
    }

    /// Keeps a primitive that the ray hits at `t` if it precedes the best one, and returns whether it does.
    #[inline(always)]
    fn offer(&mut self, t: f64, primitive: u32) -> bool {
        if t > self.end::<false>() {
            return false;
        }
        let better =
            t + self.world.coincidence_reach(t) < self.t_lower_bound || self.offer_close(t, primitive);
        if better {
            self.best = Visible { primitive, t_bound: t };
            self.t_lower_bound = t;
        }
        better
    }

    /// Whether a primitive precedes the best one, where both may lie in the same place.
    #[cold]
    fn offer_close(&mut self, t: f64, primitive: u32) -> bool {
        if let Some(list) = self.collected {
            list.borrow_mut().push((t, primitive));
            return false;
        }
        self.is_close |= self.best.primitive != NONE;
        t < self.t_lower_bound || (t <= self.best.t_bound && self.precedes_best(t, primitive))
    }

    /// Whether a primitive precedes the best one, for a t within the bounds on the latter's t.
    fn precedes_best(&mut self, t: f64, primitive: u32) -> bool {
        if self.t_lower_bound < self.best.t_bound {
            self.best.t_bound = self.world.hit(self.ray, self.best).t;
            self.t_lower_bound = self.best.t_bound;
        }
        self.world.precedes((t, primitive), (self.best.t_bound, self.best.primitive))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parser::parse;
    use glam::DVec3;

    #[test]
    fn the_depth_of_a_filter_ray_ends_where_the_ray_does() {
        let mut state = FilterState::new([[0.0; 4]; 2], 2.0, 4.0, 0.25, 2.4375);
        assert_eq!(state.ray.max_depth, 1.75);
        state.shorten(2.5);
        assert_eq!((state.ray.max_depth, state.t(2.0)), (2.0, 2.5));
        state.shorten(0.5);
        assert_eq!(state.ray.max_depth, -6.0);
        for far in [f64::INFINITY, f64::NAN, 1e300, 2.0 + MAX_DEPTH / 4.0] {
            state.shorten(far);
            assert_eq!(f64::from(state.ray.max_depth), MAX_DEPTH, "{far}");
        }
    }

    /// Where only bounds are known on the t of the best triangle, its t decides.
    #[test]
    fn of_a_triangle_within_bounds_and_another_the_nearer_one_is_kept() {
        let text = "OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }
             Group { numObjects 2 Material { }
             Triangle { vertex0 -1 -1 4 vertex1 1 -1 4 vertex2 0 1 4 }
             Triangle { vertex0 -1 -1 5 vertex1 1 -1 5 vertex2 0 1 5 } }";
        let world = World::new(&parse(text).unwrap(), &[]).unwrap();
        let ray = Ray::new(DVec3::ZERO, DVec3::Z);
        for (t, is_kept) in [(3.4, true), (3.9, true), (4.0, false), (4.1, false), (4.6, false)] {
            let mut query = RayQuery::new(&world, &ray, NONE);
            query.best = Visible { primitive: 0, t_bound: 4.5 };
            query.t_lower_bound = 3.5;
            assert_eq!(query.offer(t, 1), is_kept, "{t}");
            assert_eq!(query.best.primitive, u32::from(is_kept), "{t}");
        }
        let mut query = RayQuery::new(&world, &ray, NONE);
        query.best = Visible { primitive: 1, t_bound: 5.0 };
        query.t_lower_bound = 5.0;
        assert!(!query.offer(5.5, 0) && query.offer(5.0, 0) && !query.offer(5.0, 1));
    }
}
