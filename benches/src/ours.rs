//! This project's caster.

use crate::contestant::{Cast, FlatRay};
use raytracer::caster::{Caster, Insertion, Instructions};
use raytracer::grid::build::GridTooLarge;
use raytracer::grid::resolution::Resolution;
use raytracer::stats::Quiet;
use raytracer::world::World;

impl Cast for Caster<'_> {
    #[inline(always)]
    fn closest(&self, ray: &FlatRay) -> f64 {
        Caster::closest(self, &ray.exact(), &mut Quiet).map_or(f64::INFINITY, |hit| hit.t)
    }

    #[inline(always)]
    fn any(&self, ray: &FlatRay) -> bool {
        Caster::any(self, &ray.exact(), &mut Quiet)
    }
}

/// The cells that `-grid auto` chooses for a picture of so many rays that building does not count.
pub fn cells(world: &World) -> [usize; 3] {
    Resolution::Auto.cells(&world.bounds, world.finite_count(), 1 << 30)
}

pub fn caster(world: &World, cells: [usize; 3]) -> Result<Caster<'_>, GridTooLarge> {
    Caster::with(world, Some(cells), Insertion::Nested, Instructions::available()[0])
}
