//! The search along one ray: for the nearest hit, any hit, or all hits.
//!
//! The filter tests eight triangles at a time. The triangles that it cannot decide are tested exactly, one by one.

use crate::base::patience::{Endless, Patience};
use crate::caster::block::{Block, NONE};
use crate::caster::contents::Contents;
use crate::caster::filter::{self, FilterState, Verdict};
use crate::math::ray::{Ray, Visible};
use crate::math::simd::lanes;
use crate::stats::Probe;
use crate::world::triangle::Shear;
use crate::world::{Primitive, World};
use fearless_simd::Simd;

/// The primitive on which a ray starts, if any. A triangle or a plane is not tested, because the ray cannot hit it
/// again. A sphere or an ellipsoid is tested before all others, because a ray into it seldom hits anything else.
#[derive(Clone, Copy, Debug)]
pub struct RayOrigin {
    /// The primitive's id, or [`NONE`].
    pub(super) primitive: u32,
    /// True if it is a sphere or an ellipsoid.
    pub(crate) is_round: bool,
}

impl RayOrigin {
    /// The origin of a ray that starts on no primitive.
    pub const FREE: Self = Self { primitive: NONE, is_round: false };

    /// Returns the origin of a ray that starts on this primitive.
    #[inline(always)]
    pub fn on(world: &World, primitive: Option<u32>) -> Self {
        let primitive = primitive.unwrap_or(NONE);
        Self { primitive, is_round: world.is_shape(primitive) }
    }
}

/// The search along one ray, for any hit or for the nearest one.
pub struct Query<'a, P, const ANY: bool> {
    pub world: &'a World,
    pub ray: &'a Ray,
    pub probe: &'a mut P,
    /// The nearest primitive so far, or any hit; [`NONE`], bounded by the ray's end, until one is found.
    pub best: Visible,
    /// A lower bound on the t of `best`. It equals the upper bound if t is known.
    t_lower_bound: f64,
    /// True if another primitive was hit so close to the best primitive at that time that both may lie in the same
    /// place. Then it is still undecided which of them the ray sees.
    pub is_undecided: bool,
    /// If given, collects all hits up to the ray's end, each with its t, and none of them becomes the best. Some hits
    /// may occur more than once.
    all_hits: Option<&'a mut Vec<(f64, u32)>>,
    /// Computed when the first triangle needs it.
    shear: Option<Shear<'a>>,
    /// The primitive that is not tested, or [`NONE`].
    left_out: u32,
    /// The primitives that were tested exactly last, and the position at which the next one is recorded. Without this
    /// list, a primitive that spans many cells and that the filter does not reject would be tested in each of them.
    tested: [u32; MAX_TESTED],
    next: usize,
    /// Ends the search. Its result is not used then.
    pub patience: &'a dyn Patience,
}

/// The number of primitives in [`Query::tested`].
const MAX_TESTED: usize = 4;

/// The number of exact tests between two questions whether the search should end. Tests that need exact arithmetic take
/// up to some microseconds.
const TESTS_AT_ONCE: usize = 128;

impl<'a, P: Probe, const ANY: bool> Query<'a, P, ANY> {
    #[inline(always)]
    pub fn new(world: &'a World, ray: &'a Ray, probe: &'a mut P) -> Self {
        Self {
            world,
            ray,
            probe,
            best: Visible { primitive: NONE, t_bound: ray.t_max },
            t_lower_bound: ray.t_max,
            is_undecided: false,
            all_hits: None,
            shear: None,
            left_out: NONE,
            tested: [NONE; MAX_TESTED],
            next: 0,
            patience: &Endless,
        }
    }

    /// Returns a query that collects all hits.
    pub fn for_all(world: &'a World, ray: &'a Ray, probe: &'a mut P, hits: &'a mut Vec<(f64, u32)>) -> Self {
        // With this bound, every hit is close to the best one.
        Self { all_hits: Some(hits), t_lower_bound: f64::NEG_INFINITY, ..Self::new(world, ray, probe) }
    }

    /// Returns the t up to which to look for primitives. Behind the best one, others may lie in the same place.
    #[inline(always)]
    pub fn end(&self) -> f64 {
        let t = self.best.t_bound;
        if ANY { t } else { t + self.world.coincidence_reach(t) }
    }

    /// Records that some primitives that may lie in the same place as the best one were not tested.
    #[inline(always)]
    pub fn leave_undecided(&mut self) {
        self.is_undecided |= self.best.primitive != NONE;
    }

    /// Takes a hit at `t`. Returns true if that changes the rest of the search.
    #[inline(always)]
    fn offer(&mut self, t: f64, primitive: u32) -> bool {
        if ANY {
            self.best.primitive = primitive;
            return true;
        }
        if t > self.end() {
            return false;
        }
        let better =
            t + self.world.coincidence_reach(t) < self.t_lower_bound || self.precedes_close(t, primitive);
        if better {
            self.best = Visible { primitive, t_bound: t };
            self.t_lower_bound = t;
        }
        better
    }

    /// Takes a hit by a lower and an upper bound on its t, if these decide that it is the nearest so far. Returns true
    /// if they do.
    #[inline(always)]
    fn offer_between(&mut self, [lower, upper]: [f64; 2], primitive: u32) -> bool {
        let reach = self.world.coincidence_reach(lower.abs().max(upper.abs()));
        let better = upper + reach < self.t_lower_bound;
        if better {
            self.best = Visible { primitive, t_bound: upper };
            self.t_lower_bound = lower;
        }
        better
    }

    /// Returns true if a primitive that may lie in the same place as the best one precedes it.
    #[cold]
    fn precedes_close(&mut self, t: f64, primitive: u32) -> bool {
        if let Some(hits) = &mut self.all_hits {
            hits.push((t, primitive));
            return false;
        }
        self.leave_undecided();
        t < self.t_lower_bound || (t <= self.best.t_bound && self.precedes_best(t, primitive))
    }

    /// Returns true if a primitive precedes the best one, for a t within the bounds on the t of the best one.
    fn precedes_best(&mut self, t: f64, primitive: u32) -> bool {
        if self.t_lower_bound < self.best.t_bound {
            self.best.t_bound = self.world.hit(self.ray, self.best).t;
            self.t_lower_bound = self.best.t_bound;
        }
        self.world.precedes((t, primitive), (self.best.t_bound, self.best.primitive))
    }

    /// Tests the primitives outside the structure: the planes, and the sphere or ellipsoid on which the ray starts.
    /// Returns true if any was hit. `ray` is a copy of the query's ray.
    #[inline(always)]
    pub fn start(&mut self, ray: &Ray, origin: RayOrigin) -> bool {
        let mut is_hit = false;
        self.left_out = origin.primitive;
        self.probe.intersections(self.world.planes.len());
        for (id, plane) in (self.world.first_plane()..).zip(&self.world.planes) {
            if id != self.left_out
                && let Some(t) = plane.intersect(ray)
            {
                is_hit |= self.offer(t, id);
            }
        }
        if origin.is_round {
            is_hit |= self.test_origin();
        }
        is_hit
    }

    /// Tests the sphere or ellipsoid on which the ray starts. The course's program tests it in its normal order, so the
    /// counting query does so too.
    #[inline(never)]
    fn test_origin(&mut self) -> bool {
        if P::COUNTS {
            self.left_out = NONE;
            return false;
        }
        self.test_exactly(self.left_out)
    }

    /// Tests a cell's blocks of triangles and its other primitives. Returns true if that changes the rest of the
    /// search.
    #[inline(always)]
    pub fn test_blocks<S: Simd>(
        &mut self,
        simd: S,
        contents: &Contents,
        blocks: &[Block],
        filter_state: &mut FilterState,
    ) -> bool {
        let mut changed = false;
        for block in contents.with_triangles(blocks) {
            if P::COUNTS {
                self.probe.intersections(block.triangles());
            }
            // Most triangles that the filter does not reject are either the origin of the ray or the best triangle so
            // far.
            let left_out = [self.left_out, self.best.primitive];
            let verdict = filter::test(simd, block, &filter_state.ray, left_out);
            if verdict.possible != 0 && self.decide(block, &verdict, filter_state) {
                if ANY {
                    return true;
                }
                changed = true;
                filter_state.shorten(self.end());
            }
        }
        if contents.has_non_triangles() && self.test_non_triangles(contents.non_triangles_in(blocks)) {
            changed = true;
            filter_state.shorten(self.end());
        }
        changed
    }

    #[inline(always)]
    fn test_non_triangles(&mut self, ids: &[u32]) -> bool {
        self.probe.intersections(ids.len());
        match ids {
            [] => false,
            // Most rays that pass several cells of a sphere end here.
            [id] if self.is_known(*id) => false,
            _ => self.test_new(ids),
        }
    }

    /// Tests the primitives that were not among the last to be tested.
    #[inline(never)]
    fn test_new(&mut self, ids: &[u32]) -> bool {
        let mut changed = false;
        for &id in ids {
            changed |= self.is_new(id) && (self.ends_early() || self.test_exactly(id));
        }
        changed
    }

    /// Decides which of the triangles that the filter does not reject are hit, and takes these hits. Returns true if
    /// that changes the rest of the search.
    #[inline(always)]
    fn decide(&mut self, block: &Block, verdict: &Verdict, filter_state: &FilterState) -> bool {
        // A counting query tests every triangle, because the number of steps depends on t.
        let certain = if P::COUNTS { 0 } else { verdict.certain };
        if ANY {
            if certain != 0 {
                return self.offer(0.0, block.ids[certain.trailing_zeros() as usize]);
            }
            return self.test_any_lane(block, verdict.possible);
        }
        let mut changed = false;
        for lane in lanes(verdict.possible) {
            let id = block.ids[lane];
            // Double precision, which loads the vertices, is needed only if the bounds on t do not decide.
            if certain >> lane & 1 != 0 {
                let bounds = verdict.depths(lane, block).map(|depth| filter_state.t(depth));
                if self.offer_between(bounds, id) {
                    changed = true;
                    continue;
                }
            }
            changed |= self.test_triangle(id);
        }
        changed
    }

    #[inline(never)]
    fn test_any_lane(&mut self, block: &Block, possible: u32) -> bool {
        lanes(possible).any(|lane| self.test_triangle(block.ids[lane]))
    }

    /// Tests a triangle exactly, unless it was one of the last to be tested.
    #[inline(never)]
    fn test_triangle(&mut self, triangle: u32) -> bool {
        self.is_new(triangle) && (self.ends_early() || self.test_triangle_exactly(triangle))
    }

    /// Returns true if the primitive is left out, or was among the last to be tested.
    #[inline(always)]
    fn is_known(&self, id: u32) -> bool {
        id == self.left_out || self.tested.contains(&id)
    }

    /// Returns true if the primitive is not known, and records it. A primitive that has been tested once is already the
    /// best one, or never becomes it.
    #[inline(always)]
    fn is_new(&mut self, id: u32) -> bool {
        let is_new = !self.is_known(id);
        if is_new {
            self.tested[self.next % MAX_TESTED] = id;
            self.next += 1;
        }
        is_new
    }

    /// Asks now and then if the search should end. If so, returns true, and nothing is near enough from then on.
    #[inline(always)]
    fn ends_early(&mut self) -> bool {
        self.next.is_multiple_of(TESTS_AT_ONCE) && self.ends_now()
    }

    #[cold]
    #[inline(never)]
    fn ends_now(&mut self) -> bool {
        let is_over = self.patience.is_over();
        if is_over {
            self.best = Visible { primitive: NONE, t_bound: f64::MIN };
            (self.t_lower_bound, self.is_undecided) = (f64::MIN, false);
        }
        is_over
    }

    /// Counts and tests primitives without the filter. Returns true if that changes the rest of the search.
    #[inline(never)]
    pub fn test_each(&mut self, ids: impl Iterator<Item = u32>) -> bool {
        let mut changed = false;
        for id in ids {
            self.probe.intersections(1);
            changed |= self.test_exactly(id);
            if ANY && changed {
                break;
            }
        }
        changed
    }

    #[inline]
    fn test_exactly(&mut self, id: u32) -> bool {
        match self.world.primitive(id) {
            Primitive::Triangle(_) => self.test_triangle_exactly(id),
            _ => self.world.crossing(self.ray, id).is_some_and(|t| self.offer(t, id)),
        }
    }

    #[inline(always)]
    fn test_triangle_exactly(&mut self, id: u32) -> bool {
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parser::parse;
    use crate::stats::Quiet;
    use glam::DVec3;

    /// If only bounds on the t of the best triangle are known, its exact t decides.
    #[test]
    fn of_a_triangle_within_bounds_and_another_the_nearer_one_is_kept() {
        let text = "OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }
             Group { numObjects 2 Material { }
             Triangle { vertex0 -1 -1 4 vertex1 1 -1 4 vertex2 0 1 4 }
             Triangle { vertex0 -1 -1 5 vertex1 1 -1 5 vertex2 0 1 5 } }";
        let world = World::new(&parse(text).unwrap(), &[]).unwrap();
        let ray = Ray::new(DVec3::ZERO, DVec3::Z);
        for (t, is_kept) in [(3.4, true), (3.9, true), (4.0, false), (4.1, false), (4.6, false)] {
            let mut probe = Quiet;
            let mut query = Query::<_, false>::new(&world, &ray, &mut probe);
            query.best = Visible { primitive: 0, t_bound: 4.5 };
            query.t_lower_bound = 3.5;
            assert_eq!(query.offer(t, 1), is_kept, "{t}");
            assert_eq!(query.best.primitive, u32::from(is_kept), "{t}");
        }
        let mut probe = Quiet;
        let mut query = Query::<_, false>::new(&world, &ray, &mut probe);
        query.best = Visible { primitive: 1, t_bound: 5.0 };
        query.t_lower_bound = 5.0;
        let [behind, same, again] = [(5.5, 0), (5.0, 0), (5.0, 1)].map(|(t, id)| query.offer(t, id));
        assert_eq!([behind, same, again], [false, true, false]);
    }
}
