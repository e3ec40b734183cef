//! The search along one ray for a [`Goal`]: the nearest hit ([`Nearest`]), any hit ([`Any`]), or all hits ([`All`]).
//!
//! An acceleration structure hands the primitives near the ray to the search. The filter tests eight triangles at a
//! time. The triangles that it cannot decide are tested exactly, one by one.

use crate::base::patience::Patience;
use crate::caster::block::{Block, NONE};
use crate::caster::filter::{self, FilterState};
use crate::math::ray::{Ray, Visible};
use crate::math::simd::lanes;
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

/// The aim of a search.
pub trait Goal {
    /// True if the first hit ends the search.
    const IS_ANY: bool = false;

    /// Returns the t up to which a hit matters.
    fn end(&self) -> f64;

    /// Returns a primitive that need not be tested again, or [`NONE`].
    #[inline(always)]
    fn found(&self) -> u32 {
        NONE
    }

    /// Takes a hit at `t`. Returns true if that changes the rest of the search.
    fn take(&mut self, ray: &Ray, t: f64, primitive: u32) -> bool;

    /// Takes a hit that is certain by a lower and an upper bound on its t. Returns true if it was taken, which changes the
    /// rest of the search, and false if only the exact t can decide.
    #[inline(always)]
    fn take_between(&mut self, _bounds: impl FnOnce() -> [f64; 2], _primitive: u32) -> bool {
        false
    }
}

/// The nearest hit.
pub struct Nearest<'a> {
    world: &'a World,
    /// The nearest primitive so far; [`NONE`], bounded by the ray's end, until one is found.
    pub best: Visible,
    /// A lower bound on the t of `best`. It equals the upper bound if t is known.
    t_lower_bound: f64,
    /// True if two primitives were hit so close together that both may lie in the same place. Then it is undecided which
    /// of them the ray sees, unless a nearer hit followed.
    pub is_undecided: bool,
}

impl<'a> Nearest<'a> {
    #[inline(always)]
    pub fn new(world: &'a World, ray: &Ray) -> Self {
        let best = Visible { primitive: NONE, t_bound: ray.t_max };
        Self { world, best, t_lower_bound: ray.t_max, is_undecided: false }
    }

    /// Compares a hit with the best one if both may lie in the same place, and notes that this is undecided. Computes the
    /// exact t of the best primitive if its bounds do not decide. Returns true if the new hit comes first.
    #[cold]
    fn compare_with_best(&mut self, ray: &Ray, t: f64, primitive: u32) -> bool {
        self.is_undecided |= self.best.primitive != NONE;
        if t >= self.t_lower_bound && t <= self.best.t_bound && self.t_lower_bound < self.best.t_bound {
            // The bounds do not decide.
            self.best.t_bound = self.world.hit(ray, self.best).t;
            self.t_lower_bound = self.best.t_bound;
        }
        let precedes = || self.world.precedes((t, primitive), (self.best.t_bound, self.best.primitive));
        t < self.t_lower_bound || (t <= self.best.t_bound && precedes())
    }
}

impl Goal for Nearest<'_> {
    /// Behind the best primitive, others may lie in the same place.
    #[inline(always)]
    fn end(&self) -> f64 {
        self.best.t_bound + self.world.coincidence_reach(self.best.t_bound)
    }

    #[inline(always)]
    fn found(&self) -> u32 {
        self.best.primitive
    }

    #[inline(always)]
    fn take(&mut self, ray: &Ray, t: f64, primitive: u32) -> bool {
        if t > self.end() {
            return false;
        }
        let is_nearer = t + self.world.coincidence_reach(t) < self.t_lower_bound;
        let is_best = is_nearer || self.compare_with_best(ray, t, primitive);
        if is_best {
            self.best = Visible { primitive, t_bound: t };
            self.t_lower_bound = t;
        }
        is_best
    }

    #[inline(always)]
    fn take_between(&mut self, bounds: impl FnOnce() -> [f64; 2], primitive: u32) -> bool {
        let [lower, upper] = bounds();
        let is_nearer =
            upper + self.world.coincidence_reach(lower.abs().max(upper.abs())) < self.t_lower_bound;
        if is_nearer {
            self.best = Visible { primitive, t_bound: upper };
            self.t_lower_bound = lower;
        }
        is_nearer
    }
}

/// Any hit up to the ray's end.
pub struct Any {
    end: f64,
    pub is_hit: bool,
}

impl Any {
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        Self { end: ray.t_max, is_hit: false }
    }
}

impl Goal for Any {
    const IS_ANY: bool = true;

    #[inline(always)]
    fn end(&self) -> f64 {
        self.end
    }

    #[inline(always)]
    fn take(&mut self, _ray: &Ray, _t: f64, _primitive: u32) -> bool {
        self.is_hit = true;
        true
    }

    #[inline(always)]
    fn take_between(&mut self, _bounds: impl FnOnce() -> [f64; 2], _primitive: u32) -> bool {
        self.is_hit = true;
        true
    }
}

/// All hits up to the ray's end, each with its t. Some may occur more than once.
pub struct All {
    end: f64,
    pub hits: Vec<(f64, u32)>,
}

impl All {
    pub fn new(ray: &Ray) -> Self {
        Self { end: ray.t_max, hits: vec![] }
    }
}

impl Goal for All {
    fn end(&self) -> f64 {
        self.end
    }

    fn take(&mut self, _ray: &Ray, t: f64, primitive: u32) -> bool {
        self.hits.push((t, primitive));
        false
    }
}

/// The search along one ray.
pub struct Search<'a, G> {
    world: &'a World,
    pub ray: &'a Ray,
    pub goal: G,
    /// The primitive on which the ray starts, which is not tested again, or [`NONE`].
    left_out: u32,
    /// Computed when the first triangle needs it.
    shear: Option<Shear<'a>>,
    /// The primitives that were tested exactly last, and the number of exact tests. Without this list, a primitive that
    /// spans many cells and that the filter does not reject would be tested in each of them.
    tested: [u32; MAX_TESTED],
    tests: usize,
    /// Ends the exact tests. The result is not used then.
    patience: &'a dyn Patience,
    is_over: bool,
}

/// The number of primitives in [`Search::tested`].
const MAX_TESTED: usize = 4;

/// The number of exact tests between two questions whether the search should end. Tests that need exact arithmetic take
/// up to some microseconds.
const TESTS_AT_ONCE: usize = 128;

impl<'a, G: Goal> Search<'a, G> {
    #[inline(always)]
    pub fn new(world: &'a World, ray: &'a Ray, goal: G, patience: &'a dyn Patience) -> Self {
        Self {
            world,
            ray,
            goal,
            left_out: NONE,
            shear: None,
            tested: [NONE; MAX_TESTED],
            tests: 0,
            patience,
            is_over: false,
        }
    }

    /// Tests the primitives outside the structure: the planes, and the sphere or ellipsoid on which the ray starts.
    /// Returns true if that changes the rest of the search.
    #[inline(always)]
    pub fn start(&mut self, origin: RayOrigin) -> bool {
        let mut has_changed = false;
        for (id, plane) in (self.world.first_plane()..).zip(&self.world.planes) {
            if id != origin.primitive
                && let Some(t) = plane.intersect(self.ray)
            {
                has_changed |= self.goal.take(self.ray, t, id);
            }
        }
        if origin.is_round {
            has_changed |= self.test(origin.primitive);
        }
        self.left_out = origin.primitive;
        has_changed
    }

    /// Tests the primitives of a cell or a leaf: the triangles in blocks, and the others. Returns true if that changes
    /// the rest of the search.
    #[inline(always)]
    pub fn test_cell<S: Simd>(
        &mut self,
        simd: S,
        blocks: &[Block],
        others: &[u32],
        filter_state: &mut FilterState,
    ) -> bool {
        let mut has_changed = false;
        for block in blocks {
            if self.test_block(simd, block, filter_state) {
                if G::IS_ANY {
                    return true;
                }
                has_changed = true;
                filter_state.shorten(self.goal.end());
            }
        }
        for &id in others {
            // Spares the call for a sphere that an earlier cell listed.
            if !self.is_known(id) && self.test(id) {
                has_changed = true;
                filter_state.shorten(self.goal.end());
            }
        }
        has_changed
    }

    #[inline(always)]
    fn test_block<S: Simd>(&mut self, simd: S, block: &Block, filter_state: &FilterState) -> bool {
        // Most triangles that the filter does not reject are either the origin of the ray or the best triangle so far.
        let left_out = [self.left_out, self.goal.found()];
        let verdict = filter::test(simd, block, &filter_state.ray, left_out);
        let mut has_changed = false;
        for lane in lanes(verdict.possible) {
            let bounds = || verdict.depths(lane, block).map(|depth| filter_state.t(depth));
            let is_certain = verdict.certain >> lane & 1 != 0;
            let id = block.ids[lane];
            // Double precision, which loads the vertices, is needed only if the bounds on t do not decide.
            has_changed |= (is_certain && self.goal.take_between(bounds, id)) || self.test(id);
            if G::IS_ANY && has_changed {
                break;
            }
        }
        has_changed
    }

    /// Tests primitives one by one, without the filter. Returns true if that changes the rest of the search.
    #[inline(never)]
    pub fn test_each(&mut self, ids: impl Iterator<Item = u32>) -> bool {
        let mut has_changed = false;
        for id in ids {
            has_changed |= self.test(id);
            if G::IS_ANY && has_changed {
                break;
            }
        }
        has_changed
    }

    /// Returns true if the primitive is left out, or was among the last to be tested. A primitive that has been tested
    /// once is already the best one, or never becomes it.
    #[inline(always)]
    fn is_known(&self, id: u32) -> bool {
        id == self.left_out || id == self.goal.found() || self.tested.contains(&id)
    }

    /// Tests a primitive exactly, unless it is known. Returns true if that changes the rest of the search.
    #[inline(never)]
    fn test(&mut self, id: u32) -> bool {
        if self.is_known(id) {
            return false;
        }
        self.tested[self.tests % MAX_TESTED] = id;
        self.tests += 1;
        if self.tests.is_multiple_of(TESTS_AT_ONCE) {
            self.is_over |= self.patience.is_over();
        }
        if self.is_over {
            return false;
        }
        let crossing = match self.world.primitive(id) {
            Primitive::Triangle(i) => {
                let shear = self.shear.get_or_insert_with(|| Shear::new(self.ray));
                shear.intersect(self.world.corners_in_place(i)).filter(|&t| self.ray.covers(t))
            }
            _ => self.world.crossing(self.ray, id),
        };
        crossing.is_some_and(|t| self.goal.take(self.ray, t, id))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::test_worlds::world_of_triangles;
    use glam::DVec3;

    /// If only bounds on the t of the best triangle are known, its exact t decides.
    #[test]
    fn of_a_triangle_within_bounds_and_another_the_nearer_one_is_kept() {
        let across = |z: f64| [DVec3::new(-1.0, -1.0, z), DVec3::new(1.0, -1.0, z), DVec3::new(0.0, 1.0, z)];
        let world = world_of_triangles([4.0, 5.0].map(across), &[]);
        let ray = Ray::new(DVec3::ZERO, DVec3::Z);
        for (t, is_kept) in [(3.4, true), (3.9, true), (4.0, false), (4.1, false), (4.6, false)] {
            let mut nearest = Nearest::new(&world, &ray);
            nearest.best = Visible { primitive: 0, t_bound: 4.5 };
            nearest.t_lower_bound = 3.5;
            assert_eq!(nearest.take(&ray, t, 1), is_kept, "{t}");
            assert_eq!(nearest.best.primitive, u32::from(is_kept), "{t}");
        }
        let mut nearest = Nearest::new(&world, &ray);
        nearest.best = Visible { primitive: 1, t_bound: 5.0 };
        nearest.t_lower_bound = 5.0;
        let [behind, same, again] = [(5.5, 0), (5.0, 0), (5.0, 1)].map(|(t, id)| nearest.take(&ray, t, id));
        assert_eq!([behind, same, again], [false, true, false]);
    }
}
