//! The query for one ray, and its goals: the nearest hit, any hit, or all hits.
//!
//! The filter tests eight triangles at a time. The triangles that it cannot decide are tested exactly, one by one.

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

/// The search along one ray.
pub struct Query<'a, P, G> {
    pub world: &'a World,
    pub ray: &'a Ray,
    pub probe: &'a mut P,
    pub goal: G,
    /// Computed when the first triangle needs it.
    shear: Option<Shear<'a>>,
    /// The primitive that is not tested, or [`NONE`].
    left_out: u32,
    /// The primitives that were tested exactly last, and the position at which the next one is recorded. Without this
    /// list, a primitive that spans many cells and that the filter does not reject would be tested in each of them.
    tested: [u32; MAX_TESTED],
    next: usize,
}

/// The number of primitives in [`Query::tested`].
const MAX_TESTED: usize = 4;

/// The goal of a query: the nearest hit, any hit, or all hits.
pub trait Goal {
    /// True if the first hit is enough.
    const ANY: bool = false;

    /// Returns the nearest primitive found so far, or [`NONE`].
    fn best(&self) -> u32 {
        NONE
    }

    /// Returns two values: an upper bound on the t of the nearest hit so far, or the ray's end if there is none; and
    /// the t up to which to look for primitives.
    fn ends(&self, _: &World, ray: &Ray) -> [f64; 2] {
        [ray.t_max; 2]
    }

    /// Takes a hit at `t`. Returns true if that changes the rest of the search.
    fn offer(&mut self, world: &World, ray: &Ray, t: f64, primitive: u32) -> bool;

    /// Takes a hit by a lower and an upper bound on its t, if these decide that it is the nearest so far. Returns true
    /// if they do.
    fn offer_between(&mut self, _: &World, _bounds: [f64; 2], _primitive: u32) -> bool {
        false
    }

    /// Records that some primitives that may lie in the same place as the best one were not tested.
    fn leave_undecided(&mut self) {}
}

impl<'a, P: Probe, G: Goal> Query<'a, P, G> {
    #[inline(always)]
    pub fn new(world: &'a World, ray: &'a Ray, probe: &'a mut P, goal: G) -> Self {
        Self { world, ray, probe, goal, shear: None, left_out: NONE, tested: [NONE; MAX_TESTED], next: 0 }
    }

    /// Returns an upper bound on the t of the nearest hit so far.
    #[inline(always)]
    pub fn nearest_t(&self) -> f64 {
        self.goal.ends(self.world, self.ray)[0]
    }

    /// Returns the t up to which to look for primitives.
    #[inline(always)]
    pub fn end(&self) -> f64 {
        self.goal.ends(self.world, self.ray)[1]
    }

    #[inline(always)]
    fn offer(&mut self, t: f64, primitive: u32) -> bool {
        self.goal.offer(self.world, self.ray, t, primitive)
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
        self.test(self.left_out)
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
                self.probe.intersections(block.index.triangles());
            }
            // Most triangles that the filter does not reject are either the origin of the ray or the best triangle so
            // far.
            let left_out = [self.left_out, self.goal.best()];
            let verdict = filter::test(simd, block, &filter_state.ray, left_out);
            if verdict.possible != 0 && self.decide(block, &verdict, filter_state) {
                if G::ANY {
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
        ids.iter().fold(false, |changed, &id| (self.is_new(id) && self.test_exactly(id)) | changed)
    }

    /// Decides which of the triangles that the filter does not reject are hit, and takes these hits. Returns true if
    /// that changes the rest of the search.
    #[inline(always)]
    fn decide(&mut self, block: &Block, verdict: &Verdict, filter_state: &FilterState) -> bool {
        // A counting query tests every triangle, because the number of steps depends on t.
        let certain = if P::COUNTS { 0 } else { verdict.certain };
        if G::ANY {
            // Which primitive is hit does not matter.
            return certain != 0 && self.offer(0.0, NONE) || self.test_any_lane(block, verdict.possible);
        }
        let mut changed = false;
        for lane in lanes(verdict.possible) {
            let id = block.index.ids[lane];
            // Double precision, which loads the vertices, is needed only if the bounds on t do not decide.
            if certain >> lane & 1 != 0 {
                let bounds = verdict.depths(lane, block).map(|depth| filter_state.t(depth));
                if self.goal.offer_between(self.world, bounds, id) {
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
        lanes(possible).any(|lane| self.test_triangle(block.index.ids[lane]))
    }

    /// Tests a triangle exactly, unless it was one of the last to be tested.
    #[inline(never)]
    fn test_triangle(&mut self, triangle: u32) -> bool {
        self.is_new(triangle) && self.test_triangle_exactly(triangle)
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

    /// Counts and tests a primitive. Returns true if that changes the rest of the search.
    pub fn test(&mut self, id: u32) -> bool {
        self.probe.intersections(1);
        self.test_exactly(id)
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

/// The goal of finding any hit.
#[derive(Default)]
pub struct AnyHit {
    pub is_found: bool,
}

impl Goal for AnyHit {
    const ANY: bool = true;

    #[inline(always)]
    fn offer(&mut self, _: &World, _: &Ray, _t: f64, _primitive: u32) -> bool {
        self.is_found = true;
        true
    }
}

/// The goal of collecting all hits up to the ray's end, each with its t. Some hits may occur more than once.
#[derive(Default)]
pub struct AllHits(pub Vec<(f64, u32)>);

impl Goal for AllHits {
    fn offer(&mut self, _: &World, _: &Ray, t: f64, primitive: u32) -> bool {
        self.0.push((t, primitive));
        false
    }
}

/// The goal of finding the nearest hit.
pub struct Nearest {
    /// [`NONE`], bounded by the ray's end, until a primitive is found.
    pub best: Visible,
    /// A lower bound on the t of `best`. It equals the upper bound if t is known.
    t_lower_bound: f64,
    /// True if another primitive was hit so close to the best primitive at that time that both may lie in the same
    /// place. Then it is still undecided which of them the ray sees.
    pub is_undecided: bool,
}

impl Nearest {
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let best = Visible { primitive: NONE, t_bound: ray.t_max };
        Self { best, t_lower_bound: ray.t_max, is_undecided: false }
    }

    /// Returns true if a primitive that may lie in the same place as the best one precedes it.
    #[cold]
    fn precedes_close(&mut self, world: &World, ray: &Ray, t: f64, primitive: u32) -> bool {
        self.is_undecided |= self.best.primitive != NONE;
        t < self.t_lower_bound || (t <= self.best.t_bound && self.precedes_best(world, ray, t, primitive))
    }

    /// Returns true if a primitive precedes the best one, for a t within the bounds on the t of the best one.
    fn precedes_best(&mut self, world: &World, ray: &Ray, t: f64, primitive: u32) -> bool {
        if self.t_lower_bound < self.best.t_bound {
            self.best.t_bound = world.hit(ray, self.best).t;
            self.t_lower_bound = self.best.t_bound;
        }
        world.precedes((t, primitive), (self.best.t_bound, self.best.primitive))
    }
}

impl Goal for Nearest {
    #[inline(always)]
    fn best(&self) -> u32 {
        self.best.primitive
    }

    /// Extends the search behind the best primitive, where others may lie in the same place.
    #[inline(always)]
    fn ends(&self, world: &World, _: &Ray) -> [f64; 2] {
        let t = self.best.t_bound;
        [t, t + world.coincidence_reach(t)]
    }

    #[inline(always)]
    fn offer(&mut self, world: &World, ray: &Ray, t: f64, primitive: u32) -> bool {
        if t > self.ends(world, ray)[1] {
            return false;
        }
        let better = t + world.coincidence_reach(t) < self.t_lower_bound
            || self.precedes_close(world, ray, t, primitive);
        if better {
            self.best = Visible { primitive, t_bound: t };
            self.t_lower_bound = t;
        }
        better
    }

    #[inline(always)]
    fn offer_between(&mut self, world: &World, bounds: [f64; 2], primitive: u32) -> bool {
        let [lower, upper] = bounds;
        let reach = world.coincidence_reach(lower.abs().max(upper.abs()));
        let better = upper + reach < self.t_lower_bound;
        if better {
            self.best = Visible { primitive, t_bound: upper };
            self.t_lower_bound = lower;
        }
        better
    }

    #[inline(always)]
    fn leave_undecided(&mut self) {
        self.is_undecided |= self.best.primitive != NONE;
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
        let goal = |primitive, [t_lower_bound, t_bound]: [f64; 2]| {
            let best = Visible { primitive, t_bound };
            Nearest { best, t_lower_bound, is_undecided: false }
        };
        for (t, is_kept) in [(3.4, true), (3.9, true), (4.0, false), (4.1, false), (4.6, false)] {
            let mut probe = Quiet;
            let mut query = Query::new(&world, &ray, &mut probe, goal(0, [3.5, 4.5]));
            assert_eq!(query.offer(t, 1), is_kept, "{t}");
            assert_eq!(query.goal.best.primitive, u32::from(is_kept), "{t}");
        }
        let mut probe = Quiet;
        let mut query = Query::new(&world, &ray, &mut probe, goal(1, [5.0; 2]));
        let [behind, same, again] = [(5.5, 0), (5.0, 0), (5.0, 1)].map(|(t, id)| query.offer(t, id));
        assert_eq!([behind, same, again], [false, true, false]);
    }
}
