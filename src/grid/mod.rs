//! What a ray hits: the planes, then the grid's cells or, without a grid, everything.

mod allowance;
pub mod budget;
mod build;
pub mod cell_lists;
mod cell_table;
mod cell_contents;
pub mod dda;
pub(crate) mod dda4;
pub mod filter;
mod fitting;
mod fixed_t;
mod lattice;
pub mod options;
mod prim_set;
mod query;
pub(crate) mod ray_aabb;
pub mod packet;
mod traverse;
pub mod triangle8;
pub mod voxelize;

#[cfg(target_arch = "x86_64")]
use crate::math::instructions::Avx2;
use crate::math::instructions::Portable;
use crate::math::ray::{Hit, Ray};
use crate::stats::Probe;
use crate::world::World;
use build::AccelerationStructure;
pub use build::StructureSize;
use cell_lists::GridTooLarge;
use glam::DVec2;
pub use lattice::Lattice;
use options::GridOptions;
use query::RayQuery;
use traverse::{Entry, TraversalKernel};

pub use crate::math::instructions::Instructions;

/// Casts rays into a world.
#[derive(Debug)]
pub struct Caster<'w> {
    /// What rays are cast into.
    pub world: &'w World,
    instructions: Instructions,
    /// What everything finite lies in; none where nothing is finite.
    structure: Option<AccelerationStructure>,
}

impl<'w> Caster<'w> {
    /// With a grid of so many cells along each axis, or none.
    pub fn new(world: &'w World, cells: Option<[usize; 3]>) -> Result<Self, GridTooLarge> {
        let options = cells.map_or(GridOptions::NONE, GridOptions::uniform);
        Self::with(world, options, Instructions::available()[0])
    }

    /// With the primitives arranged as told, and with these instructions.
    pub fn with(
        world: &'w World,
        options: GridOptions,
        instructions: Instructions,
    ) -> Result<Self, GridTooLarge> {
        let finite = world.finite_count() > 0;
        let structure = finite.then(|| AccelerationStructure::new(world, options)).transpose()?;
        Ok(Self { world, instructions, structure })
    }

    /// Whether a ray meets but a few of the primitives.
    pub fn has_grid(&self) -> bool {
        self.structure.as_ref().is_some_and(|structure| structure.table.is_some())
    }

    /// The cells along each axis of its grid, which may be fewer than those of an automatic one's options.
    pub fn cells(&self) -> Option<[usize; 3]> {
        Some(self.structure.as_ref()?.table.as_ref()?.lattice().cells())
    }

    /// How large what the rays are cast into is, for tests.
    pub fn size(&self) -> StructureSize {
        self.structure.as_ref().map_or(StructureSize::default(), AccelerationStructure::size)
    }

    /// The nearest hit on the ray.
    #[inline]
    pub fn closest<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Hit> {
        self.nearest(ray, None, probe).map(|hit| self.world.exact(ray, hit))
    }

    /// The nearest primitive on the ray, as exactly decided, but a triangle's t only as well as the search had
    /// to know it: not less than the right one, and more by some roundings of single precision at most.
    /// For who looks at the triangle anyway, such as [`World::surface`].
    ///
    /// `exclude` is the triangle that the ray starts at and does not meet again, so that need not be found out.
    #[inline]
    pub fn nearest<P: Probe>(&self, ray: &Ray, exclude: Option<u32>, probe: &mut P) -> Option<Hit> {
        self.run::<P, false>(ray, exclude, probe)
    }

    /// Whether anything stands on the ray.
    #[inline]
    pub fn any<P: Probe>(&self, ray: &Ray, probe: &mut P) -> bool {
        self.any_from(ray, None, probe)
    }

    /// The same for a ray that leaves a triangle, as for [`nearest`](Self::nearest).
    #[inline]
    pub fn any_from<P: Probe>(&self, ray: &Ray, exclude: Option<u32>, probe: &mut P) -> bool {
        if P::COUNTS {
            // The course's program looks for the nearest hit also where any would do.
            return self.nearest(ray, exclude, probe).is_some();
        }
        self.run::<P, true>(ray, exclude, probe).is_some()
    }

    #[inline(always)]
    fn run<P: Probe, const ANY: bool>(&self, ray: &Ray, exclude: Option<u32>, probe: &mut P) -> Option<Hit> {
        let exclude = exclude.unwrap_or(triangle8::NONE);
        let hit = match self.instructions {
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx2(avx2) => {
                let [a, b, c, d] = ray.pairs();
                // SAFETY: `avx2` proves that the processor has all that the function is compiled for.
                unsafe { run_avx2::<P, ANY>(avx2, self, a, b, c, d, exclude, probe) }
            }
            Instructions::Portable => self.run_with::<_, P, ANY>(Portable, *ray, exclude, probe),
        };
        (hit.primitive != triangle8::NONE).then_some(hit)
    }

    /// The best hit, of [`triangle8::NONE`] where there is none: unlike an option it is returned in registers.
    #[inline(always)]
    fn run_with<K: TraversalKernel, P: Probe, const ANY: bool>(
        &self,
        kernel: K,
        ray: Ray,
        exclude: u32,
        probe: &mut P,
    ) -> Hit {
        let ray_entry = match &self.structure {
            Some(structure) => structure.ray_entry::<K::F64x4>(kernel, &ray, ray.t_max),
            None => Entry::Misses,
        };
        // Most of the rays that hit nothing have nothing else to do.
        if !P::COUNTS && matches!(ray_entry, Entry::Misses) && self.world.planes.is_empty() {
            return Hit { t: ray.t_max, primitive: triangle8::NONE };
        }
        // For what is called out of line. All else takes `ray` itself, which stays in registers.
        let stored = ray;
        let mut query = RayQuery::new(self.world, &stored, exclude);
        query.test_planes(&ray, probe);
        if ANY && query.hit().is_some() {
            return query.best;
        }
        if let Some(structure) = &self.structure {
            structure.run::<K, P, ANY>(kernel, &ray_entry, &mut query, probe);
        }
        query.best
    }
}

/// The search compiled for AVX2, along the ray of these four pairs. The proof takes no register.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
#[allow(clippy::too_many_arguments)]
fn run_avx2<P: Probe, const ANY: bool>(
    avx2: Avx2,
    caster: &Caster,
    a: DVec2,
    b: DVec2,
    c: DVec2,
    d: DVec2,
    exclude: u32,
    probe: &mut P,
) -> Hit {
    caster.run_with::<_, P, ANY>(avx2, Ray::of_pairs([a, b, c, d]), exclude, probe)
}
