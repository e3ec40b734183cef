//! Ray casting: finds the nearest hit or any hit of a ray. A caster tests the planes first, and then the finite
//! primitives in a list, a uniform grid or a tree of boxes. These structures are never nested.
//!
//! Each module imports only from the modules before it in this list.

#[doc(hidden)]
pub mod block;
#[doc(hidden)]
pub mod bounds;
#[doc(hidden)]
pub mod filter;
#[doc(hidden)]
pub mod lattice;
#[doc(hidden)]
pub mod dda;
#[doc(hidden)]
pub mod insertion;
pub mod choose;
mod contents;
mod box8;
mod division;
mod tree;
mod query;
mod structure;
#[doc(hidden)]
pub use crate::math::instructions::Level;
pub use lattice::NotBuilt;
pub use query::RayOrigin;
pub use structure::{Fullness, StructureSize};

use crate::base::patience::{Endless, Patience, Steps};
use crate::caster::block::NONE;
use crate::caster::bounds::Entry;
use crate::caster::choose::{Layout, Rays};
use crate::caster::query::Query;
use crate::caster::structure::{AccelerationStructure, Order};
use crate::math::instructions;
use crate::math::ray::{Hit, Ray, Visible};
use crate::stats::{Probe, Quiet};
use crate::world::World;
use fearless_simd::{Simd, dispatch};
use fearless_simd_macros::simd;
use glam::DVec2;
use std::sync::{Arc, OnceLock};

/// Casts rays into a world. A copy is cheap, since it shares the acceleration structure.
#[derive(Clone, Debug)]
pub struct Caster<'w> {
    /// The world into which rays are cast.
    pub world: &'w World,
    /// The instructions that the inner loops use.
    pub level: Level,
    /// Contains every finite primitive; `None` if the world has no finite primitives.
    structure: Option<Arc<AccelerationStructure>>,
    /// Ends the search along a ray that takes long. The result is not used then.
    patience: &'w dyn Patience,
    /// The structure for many rays, if [`Caster::for_rays`] may build it. Copies of the caster share it.
    for_many_rays: Option<Arc<OnceLock<Arc<AccelerationStructure>>>>,
}

impl<'w> Caster<'w> {
    /// Returns a caster with a grid of this number of cells along each axis, or without a grid.
    pub fn new(world: &'w World, cells: Option<[usize; 3]>) -> Result<Self, NotBuilt> {
        Self::with(world, cells.map_or(Layout::List, Layout::Grid), instructions::available()[0])
    }

    /// Returns a caster with this acceleration structure, which uses these instructions.
    pub fn with(world: &'w World, layout: Layout, level: Level) -> Result<Self, NotBuilt> {
        Self::within(world, layout, level, &Endless)
    }

    /// Returns a caster like [`Caster::with`], which is built as long as there is patience.
    pub fn within(
        world: &'w World,
        layout: Layout,
        level: Level,
        patience: &dyn Patience,
    ) -> Result<Self, NotBuilt> {
        let build = || AccelerationStructure::new(world, layout, patience).map(Arc::new);
        let structure = (world.finite_count() > 0).then(build).transpose()?;
        Ok(Self { world, level, structure, patience: &Endless, for_many_rays: None })
    }

    /// Returns this caster, which searches and builds as long as there is patience.
    pub fn patient<'a>(&self, patience: &'a dyn Patience) -> Caster<'a>
    where
        'w: 'a,
    {
        Caster { patience, ..self.clone() }
    }

    /// Lets [`Caster::for_rays`] replace a list by a grid or a tree.
    pub fn replaceable(self) -> Self {
        let for_many_rays = (!self.is_selective()).then(Arc::default);
        Self { for_many_rays, ..self }
    }

    /// Returns a caster that takes the least total time for about this number of rays: this one, or if it is
    /// replaceable and the rays pay for it, one with a grid or a tree. That structure is built once.
    pub fn for_rays(&self, rays: Rays) -> Self {
        let Some(shared) = &self.for_many_rays else { return self.clone() };
        let layout = if shared.get().is_none() { Layout::chosen(self.world, rays) } else { Layout::List };
        // Threads do not wait for each other, since the build itself runs on them. So two may build the structure.
        if layout != Layout::List
            && let Ok(structure) = AccelerationStructure::new(self.world, layout, self.patience)
        {
            let _ = shared.set(Arc::new(structure));
        }
        Self { structure: shared.get().or(self.structure.as_ref()).cloned(), ..self.clone() }
    }

    /// Returns true if a ray is tested only against some of the primitives: those in the grid cells or tree boxes that
    /// it meets.
    pub fn is_selective(&self) -> bool {
        self.structure.as_ref().is_some_and(|structure| !matches!(structure.order, Order::List))
    }

    /// Returns the number of grid cells along each axis, or `None` without a grid.
    pub fn cells(&self) -> Option<[usize; 3]> {
        self.structure.as_ref()?.cells()
    }

    /// Returns how full the grid cells are, with this number of the fullest cells; `None` without a grid.
    pub fn fullness(&self, fullest: usize) -> Option<Fullness> {
        self.structure.as_ref()?.fullness(fullest)
    }

    /// Returns the size of the acceleration structure, for tests.
    pub fn size(&self) -> StructureSize {
        self.structure.as_ref().map_or(StructureSize::default(), |structure| structure.size())
    }

    /// Returns the nearest hit on the ray.
    #[inline]
    pub fn closest<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Hit> {
        self.nearest(ray, RayOrigin::FREE, probe).map(|visible| self.world.hit(ray, visible))
    }

    /// Finds the primitive that the ray hits first; the decision is exact.
    #[inline(always)]
    pub fn nearest<P: Probe>(&self, ray: &Ray, origin: RayOrigin, probe: &mut P) -> Option<Visible> {
        let best = self.cast::<_, false>(ray, origin, probe);
        (best.primitive != NONE).then_some(best)
    }

    /// Returns true if the ray hits anything.
    #[inline(always)]
    pub fn any<P: Probe>(&self, ray: &Ray, origin: RayOrigin, probe: &mut P) -> bool {
        self.cast::<_, true>(ray, origin, probe).primitive != NONE
    }

    /// Returns true if the ray hits this triangle.
    #[inline(never)]
    pub fn hits_triangle(&self, ray: &Ray, triangle: u32, origin: RayOrigin) -> bool {
        origin.primitive != triangle && self.world.crossing(ray, triangle).is_some()
    }

    /// Returns true if the world has no plane other than this origin.
    #[inline(always)]
    pub fn has_no_plane_but(&self, origin: RayOrigin) -> bool {
        match self.world.planes.len() {
            0 => true,
            1 => origin.primitive == self.world.first_plane(),
            _ => false,
        }
    }

    /// Returns true if the ray hits any plane.
    #[inline(always)]
    pub fn hits_plane(&self, ray: &Ray, origin: RayOrigin) -> bool {
        let mut planes = (self.world.first_plane()..).zip(&self.world.planes);
        planes.any(|(id, plane)| id != origin.primitive && plane.intersect(ray).is_some())
    }

    /// Finds the primitive that the ray hits first, or any that it hits, or [`NONE`], with the caster's instructions.
    #[inline(always)]
    fn cast<P: Probe, const ANY: bool>(&self, ray: &Ray, origin: RayOrigin, probe: &mut P) -> Visible {
        let [a, b, c, d] = ray.pairs();
        #[cfg(target_arch = "x86_64")]
        if let Level::Avx2(simd) = self.level {
            return self.cast_at::<_, P, ANY>(simd, a, b, c, d, origin, probe);
        }
        self.cast_with_few::<P, ANY>(a, b, c, d, origin, probe)
    }

    /// Casts a ray without AVX2. This is a function of its own, so that the ray stays in registers with AVX2: `dispatch`
    /// passes it through memory, which takes a tenth of the time of a short ray.
    #[inline(never)]
    fn cast_with_few<P: Probe, const ANY: bool>(
        &self,
        a: DVec2,
        b: DVec2,
        c: DVec2,
        d: DVec2,
        origin: RayOrigin,
        probe: &mut P,
    ) -> Visible {
        dispatch!(self.level, simd => self.cast_at::<_, P, ANY>(simd, a, b, c, d, origin, probe))
    }

    /// Casts a ray as [`cast`](Self::cast) does. It returns [`NONE`] instead of an `Option`, and takes the ray as pairs
    /// of coordinates, because these fit into registers.
    #[simd]
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn cast_at<S: Simd, P: Probe, const ANY: bool>(
        &self,
        simd: S,
        a: DVec2,
        b: DVec2,
        c: DVec2,
        d: DVec2,
        origin: RayOrigin,
        probe: &mut P,
    ) -> Visible {
        let ray = Ray::of_pairs([a, b, c, d]);
        let entry = self.entry(simd, &ray);
        // Most rays that hit nothing end here.
        if !P::COUNTS && matches!(entry, Entry::Misses) && self.world.planes.is_empty() {
            return Visible { primitive: NONE, t_bound: ray.t_max };
        }
        // Functions that are not inlined read this copy, so that `ray` itself stays in registers.
        let stored = ray;
        let mut query = Query::<P, ANY>::new(self.world, &stored, probe);
        query.patience = self.patience;
        self.search(simd, &ray, origin, &entry, &mut query);
        let (best, is_undecided) = (query.best, query.is_undecided);
        if !ANY && is_undecided { self.foremost(simd, &stored, origin, best) } else { best }
    }

    /// Returns how the ray enters the structure.
    #[inline(always)]
    fn entry<S: Simd>(&self, simd: S, ray: &Ray) -> Entry<S> {
        // A closure would not be compiled for the instructions of the caller.
        match self.structure.as_deref() {
            Some(structure) => structure.region.entry(simd, ray, ray.t_max),
            None => Entry::Misses,
        }
    }

    #[inline(always)]
    fn search<S: Simd, P: Probe, const ANY: bool>(
        &self,
        simd: S,
        ray: &Ray,
        origin: RayOrigin,
        entry: &Entry<S>,
        query: &mut Query<P, ANY>,
    ) {
        if query.start(ray, origin) && ANY {
            return;
        }
        if let Some(structure) = self.structure.as_deref() {
            structure.traverse(simd, entry, query);
        }
    }

    /// Decides which primitive a ray sees if it hits several so close together that their t do not decide. Another
    /// query collects them, since the first query may have hit some of them before it found the nearest one.
    #[cold]
    #[inline(never)]
    fn foremost<S: Simd>(&self, simd: S, ray: &Ray, origin: RayOrigin, nearest: Visible) -> Visible {
        let t = self.world.hit(ray, nearest).t;
        let end = (t + self.world.coincidence_reach(t)).next_up();
        let ray_to_there = Ray { t_max: ray.t_max.min(end), ..*ray };
        let (mut probe, mut hits) = (Quiet, vec![]);
        let mut query = Query::<_, false>::for_all(self.world, &ray_to_there, &mut probe, &mut hits);
        query.patience = self.patience;
        self.search(simd, &ray_to_there, origin, &self.entry(simd, &ray_to_there), &mut query);
        let foremost = self.world.foremost(ray, hits, &mut Steps::new(self.patience));
        foremost.map_or(nearest, |(t_bound, primitive)| Visible { primitive, t_bound })
    }
}

/// The patience of its searches.
impl Patience for Caster<'_> {
    fn is_over(&self) -> bool {
        self.patience.is_over()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parser::parse;

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
}
