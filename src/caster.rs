//! Ray casting: the nearest or any hit of a ray among planes and in a list, a uniform grid or a tree of boxes, none of
//! which is inside another.
//!
//! The planes are tested first, and then every primitive of the list, the cells of the grid or the boxes of the tree. A
//! module imports only from the modules before it in this list.

mod error;
pub(crate) mod ray_aabb;
mod reach;
#[doc(hidden)]
pub mod blocks;
pub mod grid;
pub mod choose;
mod tree;
mod cell_contents;
mod build;
mod fullness;
mod query;
mod ray_entry;
mod descent;
mod traverse;
#[doc(hidden)]
pub use crate::math::instructions::Level;
pub use build::StructureSize;
pub use error::GridTooLarge;
pub use fullness::Fullness;

use crate::caster::blocks::triangle8;
use crate::caster::build::{AccelerationStructure, Order};
use crate::caster::choose::{Layout, Rays};
use crate::caster::query::{HitList, RayQuery};
use crate::caster::ray_entry::Entry;
use crate::math::instructions;
use crate::math::ray::{Hit, Ray, Visible};
use crate::stats::{Probe, Quiet};
use crate::world::World;
use fearless_simd::{Simd, dispatch};
use fearless_simd_macros::simd;
use glam::DVec2;
use std::sync::{Arc, OnceLock};

/// The primitive that a ray leaves.
#[derive(Clone, Copy)]
struct Left {
    /// Its id, or [`triangle8::NONE`].
    primitive: u32,
    /// Whether it is a sphere or an ellipsoid that the ray may hit again.
    may_return: bool,
}

impl Left {
    #[inline(always)]
    fn of(caster: &Caster, primitive: Option<u32>) -> Self {
        let primitive = primitive.unwrap_or(triangle8::NONE);
        Self { primitive, may_return: caster.is_round(primitive) }
    }
}

/// A structure once it has been built; none if it does not fit into memory.
type OnDemand = OnceLock<Option<Arc<AccelerationStructure>>>;

/// Casts rays into a world. A copy is cheap, since it shares the acceleration structure.
#[derive(Clone, Debug)]
pub struct Caster<'w> {
    /// The world into which rays are cast.
    pub world: &'w World,
    /// The instructions that the inner loops use.
    pub level: Level,
    /// Contains every finite primitive; none if the world has no finite primitives.
    pub(super) structure: Option<Arc<AccelerationStructure>>,
    /// A grid or a tree in place of the list, if it may be built where more rays are cast than were expected, and the camera
    /// rays it is built for.
    on_demand: Option<(usize, Arc<OnDemand>)>,
}

impl<'w> Caster<'w> {
    /// A caster with a grid of this number of cells along each axis, or without a grid.
    pub fn new(world: &'w World, cells: Option<[usize; 3]>) -> Result<Self, GridTooLarge> {
        Self::with(world, cells.map_or(Layout::List, Layout::Grid), instructions::available()[0])
    }

    /// A caster with this acceleration structure that uses these instructions.
    pub fn with(world: &'w World, layout: Layout, level: Level) -> Result<Self, GridTooLarge> {
        let finite = world.finite_count() > 0;
        let structure =
            finite.then(|| AccelerationStructure::new(world, layout).map(Arc::new)).transpose()?;
        Ok(Self { world, level, structure, on_demand: None })
    }

    /// Lets [`for_rays`](Self::for_rays) build the grid for so many camera rays.
    pub(crate) fn allow_grid(&mut self, rays: usize) {
        self.on_demand = Some((rays, Arc::default()));
    }

    /// The same caster with a grid, if it may build one and the number of rays to be cast, which is asked for only then,
    /// pays for it. It is built once for all copies of the caster.
    #[cfg_attr(not(feature = "fast"), allow(dead_code, reason = "only the fast twin needs it"))]
    pub(crate) fn for_rays(&self, count: impl FnOnce() -> usize) -> Self {
        let grid = self.on_demand.as_ref().and_then(|(rays, grid)| {
            let layout = Layout::chosen(self.world, Rays { camera: *rays, cast: count() });
            let build = || AccelerationStructure::new(self.world, layout).ok().map(Arc::new);
            if layout == Layout::List {
                return None;
            }
            // Nobody has asked for the grid that does not fit into memory.
            grid.get_or_init(build).clone()
        });
        if grid.is_some() { Self { structure: grid, on_demand: None, ..self.clone() } } else { self.clone() }
    }

    /// Whether a ray enters the bounds of the finite primitives, or may do so.
    #[cfg_attr(not(feature = "fast"), allow(dead_code, reason = "only the fast twin needs it"))]
    pub(crate) fn enters(&self, ray: &Ray) -> bool {
        self.structure.as_deref().is_some_and(|structure| {
            dispatch!(self.level, simd => !matches!(structure.ray_entry(simd, ray, ray.t_max), Entry::Misses))
        })
    }

    /// Whether a ray is tested against only a few of the primitives: those in the cells of a grid, or in the boxes of a
    /// tree, that it meets.
    pub fn is_selective(&self) -> bool {
        self.structure.as_ref().is_some_and(|structure| !matches!(structure.order, Order::List))
    }

    /// The cells along each axis of the grid.
    pub fn cells(&self) -> Option<[usize; 3]> {
        Some(self.structure.as_ref()?.table()?.lattice().cells())
    }

    /// How full the cells of the grid are, with so many of the fullest; none without a grid.
    pub fn fullness(&self, fullest: usize) -> Option<Fullness> {
        self.structure.as_ref()?.fullness(fullest)
    }

    /// The size of the acceleration structure, for tests.
    pub fn size(&self) -> StructureSize {
        self.structure.as_ref().map_or(StructureSize::default(), |structure| structure.size())
    }

    /// The nearest hit on the ray.
    #[inline]
    pub fn closest<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Hit> {
        self.nearest(ray, None, probe).map(|visible| self.world.hit(ray, visible))
    }

    /// The primitive that the ray hits first, decided exactly.
    ///
    /// `leaves` is the primitive that the ray leaves. A triangle or a plane is not tested, because the ray cannot hit it
    /// again.
    /// A sphere or an ellipsoid is tested before all others, because a ray into it seldom hits anything else.
    #[inline(always)]
    pub fn nearest<P: Probe>(&self, ray: &Ray, leaves: Option<u32>, probe: &mut P) -> Option<Visible> {
        self.run::<P, false>(ray, Left::of(self, leaves), probe)
    }

    /// Whether the ray hits anything.
    #[inline]
    pub fn any<P: Probe>(&self, ray: &Ray, probe: &mut P) -> bool {
        self.any_from(ray, None, probe)
    }

    /// The same for a ray that leaves the primitive `leaves`, as in [`nearest`](Self::nearest).
    #[inline(always)]
    pub fn any_from<P: Probe>(&self, ray: &Ray, leaves: Option<u32>, probe: &mut P) -> bool {
        self.run::<P, true>(ray, Left::of(self, leaves), probe).is_some()
    }

    /// Whether the ray hits a triangle, which is not the one that it leaves.
    #[inline(never)]
    pub fn is_hit(&self, ray: &Ray, primitive: u32, leaves: Option<u32>) -> bool {
        if leaves == Some(primitive) && self.world.is_triangle(primitive) {
            return false;
        }
        self.world.crossing(ray, primitive).is_some()
    }

    /// Whether the world has no plane, or none but this primitive.
    #[inline(always)]
    pub fn has_no_plane_but(&self, primitive: Option<u32>) -> bool {
        match self.world.planes.len() {
            0 => true,
            1 => primitive == Some(self.world.first_plane()),
            _ => false,
        }
    }

    /// Whether the ray hits a plane, which is not the one that it leaves.
    #[inline(always)]
    pub fn meets_plane(&self, ray: &Ray, leaves: Option<u32>) -> bool {
        let mut planes = (self.world.first_plane()..).zip(&self.world.planes);
        planes.any(|(id, plane)| leaves != Some(id) && plane.intersect(ray).is_some())
    }

    /// Whether this is a sphere or an ellipsoid.
    #[inline(always)]
    pub fn is_round(&self, primitive: u32) -> bool {
        !self.world.is_triangle(primitive) && primitive < self.world.first_plane()
    }

    #[inline(always)]
    fn run<P: Probe, const ANY: bool>(&self, ray: &Ray, leaves: Left, probe: &mut P) -> Option<Visible> {
        let best = dispatch!(self.level, simd => {
            let [a, b, c, d] = ray.pairs();
            self.run_at::<_, P, ANY>(simd, a, b, c, d, leaves, None, probe)
        });
        (best.primitive != triangle8::NONE).then_some(best)
    }

    /// Looks for the nearest primitive or, if there is a list for them, collects all that the ray hits.
    ///
    /// The nearest primitive, or [`triangle8::NONE`], because this is returned in registers and an option is
    /// not. So is the ray passed, by its pairs.
    #[simd]
    #[inline(never)]
    #[allow(clippy::too_many_arguments)]
    fn run_at<S: Simd, P: Probe, const ANY: bool>(
        &self,
        simd: S,
        a: DVec2,
        b: DVec2,
        c: DVec2,
        d: DVec2,
        leaves: Left,
        collected: Option<&HitList>,
        probe: &mut P,
    ) -> Visible {
        let ray = Ray::of_pairs([a, b, c, d]);
        let structure = self.structure.as_deref();
        let ray_entry =
            structure.map_or(Entry::Misses, |structure| structure.ray_entry(simd, &ray, ray.t_max));
        // Most rays that hit nothing end here.
        if !P::COUNTS && matches!(ray_entry, Entry::Misses) && self.world.planes.is_empty() {
            return Visible { primitive: triangle8::NONE, t_bound: ray.t_max };
        }
        // Functions that are not inlined read this copy, so that `ray` itself stays in registers.
        let stored = ray;
        let mut query = RayQuery::new(self.world, &stored, leaves.primitive);
        query.collect_in(collected);
        query.test_planes(&ray, probe);
        if leaves.may_return {
            query.leave_round::<P>(probe);
        }
        if ANY && query.visible().is_some() {
            return query.best;
        }
        if let Some(structure) = structure {
            structure.run::<S, P, ANY>(simd, &ray_entry, &mut query, probe);
        }
        if !ANY && query.is_undecided() {
            return self.foremost(simd, &stored, leaves, query.best);
        }
        query.best
    }

    /// What a ray sees of the primitives that it hits so close to each other that their t do not decide. They are collected
    /// by another query, since it may have hit some of them before it found the nearest one.
    #[cold]
    #[inline(never)]
    fn foremost<S: Simd>(&self, simd: S, ray: &Ray, leaves: Left, nearest: Visible) -> Visible {
        let t = self.world.hit(ray, nearest).t;
        let end = (t + self.world.coincidence_reach(t)).next_up();
        let ray_to_there = Ray { t_max: ray.t_max.min(end), ..*ray };
        let [a, b, c, d] = ray_to_there.pairs();
        let found = HitList::default();
        self.run_at::<S, _, false>(simd, a, b, c, d, leaves, Some(&found), &mut Quiet);
        let foremost = self.world.foremost(ray, found.into_inner());
        foremost.map_or(nearest, |(t_bound, primitive)| Visible { primitive, t_bound })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parser::parse;
    use glam::DVec3;

    #[test]
    fn a_caster_tells_whether_it_has_a_grid_and_of_which_cells() {
        let world = |objects: &str| {
            let camera = "OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }";
            World::new(&parse(&format!("{camera} Group {{ {objects} }}")).unwrap(), &[]).unwrap()
        };
        let sphere = world("numObjects 1 Material { } Sphere { center 0 0 0 radius 1 }");
        let plane = world("numObjects 1 Material { } Plane { normal 0 0 1 offset 0 }");
        for (world, cells, expected) in [
            (&sphere, Some([2, 3, 4]), Some([2, 3, 4])),
            (&sphere, None, None),
            (&plane, Some([2, 3, 4]), None),
        ] {
            let caster = Caster::new(world, cells).unwrap();
            assert_eq!((caster.is_selective(), caster.cells()), (expected.is_some(), expected));
            assert_eq!(caster.size() == StructureSize::default(), world.finite_count() == 0);
        }
    }

    #[test]
    fn a_grid_is_built_once_where_it_is_allowed_and_rays_pay_for_it() {
        let triangle =
            |i: u32| format!("Triangle {{ vertex0 {i} 0 0 vertex1 {i}.5 0 0 vertex2 {i} 1 {} }}", i % 7);
        let text = format!(
            "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
             Group {{ numObjects 100 Material {{ }} {} }}",
            (0..100).map(triangle).collect::<String>()
        );
        let world = World::new(&parse(&text).unwrap(), &[]).unwrap();
        let mut caster = Caster::new(&world, None).unwrap();
        assert!(!caster.for_rays(|| panic!("nobody asks for the number of rays")).is_selective());
        caster.allow_grid(10_000);
        assert!(!caster.for_rays(|| 31).is_selective());
        let grids = [32, 1000].map(|rays| caster.for_rays(|| rays));
        let expected = Layout::automatic(&world, 10_000);
        let expected = Caster::with(&world, expected, instructions::available()[0]).unwrap();
        assert_eq!(grids[0].cells(), expected.cells());
        let [one, other] = grids.each_ref().map(|grid| grid.structure.as_ref().unwrap());
        assert!(Arc::ptr_eq(one, other));
        let [into, beside] = [0.0, 1e3].map(|y| Ray::new(DVec3::new(0.1, y, 9.0), DVec3::NEG_Z));
        assert_eq!([into, beside].map(|ray| caster.enters(&ray)), [true, false]);
    }
}
