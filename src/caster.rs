//! Ray casting: finds the nearest hit or any hit of a ray. A caster tests the planes first, and then the finite
//! primitives in a list, a uniform grid or a tree of boxes.
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
pub mod cell_counts;
pub mod choose;
mod contents;
mod box8;
mod division;
mod tree;
mod search;
mod structure;
mod lazy;
#[doc(hidden)]
pub use crate::math::instructions::Level;
pub use cell_counts::{CourseSteps, Fullness};
pub use lattice::NotBuilt;
pub use lazy::LazyCaster;
pub use search::RayOrigin;
pub use structure::StructureSize;

use crate::base::patience::{Endless, Patience, Steps};
use crate::caster::block::NONE;
use crate::caster::cell_counts::CellCounts;
use crate::caster::choose::Layout;
use crate::caster::search::{All, Any, Goal, Nearest, Search};
use crate::caster::structure::AccelerationStructure;
use crate::math::instructions;
use crate::math::ray::{Hit, Ray, Visible};
use crate::world::World;
use fearless_simd::{Simd, dispatch};
use std::sync::Arc;

/// Casts rays into a world. A copy is cheap, since it shares the acceleration structure.
#[derive(Clone, Debug)]
pub struct Caster<'w> {
    /// The world into which rays are cast.
    pub world: &'w World,
    /// The instructions that the inner loops use.
    pub level: Level,
    /// Contains every finite primitive that a ray may see; `None` if there are none, or if no ray meets them.
    structure: Option<Arc<AccelerationStructure>>,
    /// The cells in which steps are counted; `None` without a grid, or if steps are not counted.
    counts: Option<Arc<CellCounts>>,
    /// Ends the search along a ray that takes long. The result is not used then.
    patience: &'w dyn Patience,
}

impl<'w> Caster<'w> {
    /// Returns a caster with a grid of this number of cells along each axis, or without a grid.
    pub fn new(world: &'w World, cells: Option<[usize; 3]>) -> Result<Self, NotBuilt> {
        Self::with(world, cells.map_or(Layout::List, Layout::Grid), instructions::available()[0])
    }

    /// Returns a caster with this acceleration structure, which uses these instructions.
    pub fn with(world: &'w World, layout: Layout, level: Level) -> Result<Self, NotBuilt> {
        let structure = AccelerationStructure::of_world(world, layout, &Endless)?;
        Ok(Self { level, structure, ..Self::of_planes(world) })
    }

    /// Returns a caster that tests the planes alone, for rays of which it is known that they hit nothing else.
    pub fn of_planes(world: &'w World) -> Self {
        let level = instructions::available()[0];
        Self { world, level, structure: None, counts: None, patience: &Endless }
    }

    /// Returns this caster, which counts steps in a grid of this number of cells along each axis.
    pub fn counting(self, cells: [usize; 3], patience: &dyn Patience) -> Result<Self, NotBuilt> {
        let count = || CellCounts::of_world(self.world, cells, patience).map(Arc::new);
        let counts = (self.world.finite_count() > 0).then(count).transpose()?;
        Ok(Self { counts, ..self })
    }

    /// Returns true if a ray is tested only against some of the primitives: those in the cells or leaves that it meets.
    pub fn is_selective(&self) -> bool {
        self.structure.as_ref().is_some_and(|structure| structure.is_selective())
    }

    /// Returns the size of the acceleration structure, for tests.
    pub fn size(&self) -> StructureSize {
        self.structure.as_ref().map_or(StructureSize::default(), |structure| structure.size())
    }

    /// Returns the nearest hit, or `None`.
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.nearest(ray, RayOrigin::FREE).map(|visible| self.world.hit(ray, visible))
    }

    /// Returns the primitive that the ray hits first, or `None`. The decision is exact.
    #[inline(always)]
    pub fn nearest(&self, ray: &Ray, origin: RayOrigin) -> Option<Visible> {
        let best = dispatch!(self.level, simd => self.nearest_at(simd, ray, origin));
        (best.primitive != NONE).then_some(best)
    }

    /// Returns true if the ray hits anything.
    #[inline(always)]
    pub fn any(&self, ray: &Ray, origin: RayOrigin) -> bool {
        dispatch!(self.level, simd => self.search(simd, ray, origin, Any::new(ray)).is_hit)
    }

    /// Returns true if the ray hits this triangle and does not start on it.
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

    /// Returns the steps that the course's program takes to find this nearest hit of the ray. Without a grid it tests
    /// every primitive. The planes are not in the grid.
    pub fn course_steps(&self, ray: &Ray, nearest: Option<Visible>) -> CourseSteps {
        let mut steps = match &self.counts {
            Some(counts) => {
                let t = nearest.map_or(ray.t_max, |visible| self.world.hit(ray, visible).t);
                let last = t + self.world.coincidence_reach(t);
                dispatch!(self.level, simd => counts.steps(simd, self.world, ray, t, last))
            }
            None => CourseSteps { tests: self.world.finite_count() as u64, cells: 0 },
        };
        steps.tests += self.world.planes.len() as u64;
        steps
    }

    #[inline(always)]
    fn nearest_at<S: Simd>(&self, simd: S, ray: &Ray, origin: RayOrigin) -> Visible {
        let nearest = Nearest::new(self.world, ray);
        let Nearest { best, is_undecided, .. } = self.search(simd, ray, origin, nearest);
        if is_undecided { self.foremost(simd, ray, origin, best) } else { best }
    }

    #[inline(always)]
    fn search<S: Simd, G: Goal>(&self, simd: S, ray: &Ray, origin: RayOrigin, goal: G) -> G {
        let mut search = Search::new(self.world, ray, goal, self.patience);
        if search.start(origin) && G::IS_ANY {
            return search.goal;
        }
        if let Some(structure) = self.structure.as_deref() {
            structure.traverse(simd, &mut search);
        }
        search.goal
    }

    /// Decides which primitive a ray sees if it hits several so close together that their t do not decide. Another
    /// search collects them, since the first one may have hit some of them before it found the nearest one.
    #[cold]
    #[inline(never)]
    fn foremost<S: Simd>(&self, simd: S, ray: &Ray, origin: RayOrigin, nearest: Visible) -> Visible {
        let t = self.world.hit(ray, nearest).t;
        // No hit lies at the end of a ray, so the next number is its end.
        let end = (t + self.world.coincidence_reach(t)).next_up();
        let ray_to_there = Ray { t_max: ray.t_max.min(end), ..*ray };
        let All { hits, .. } = self.search(simd, &ray_to_there, origin, All::new(&ray_to_there));
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
