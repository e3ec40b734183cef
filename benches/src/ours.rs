//! This project's caster.

use crate::contestant::{Cast, FlatRay};
use raytracer::caster::{Caster, Insertion, Instructions};
use raytracer::grid::build::GridTooLarge;
use raytracer::grid::resolution::{Resolution, crowd};
use raytracer::stats::Quiet;
use raytracer::world::World;

impl Cast for Caster<'_> {
    #[inline(always)]
    fn closest(&self, ray: &FlatRay) -> f64 {
        Caster::closest(self, &ray.exact(), &mut Quiet).map_or(f64::INFINITY, |hit| hit.t)
    }

    #[inline(always)]
    fn finds_closest(&self, ray: &FlatRay) -> bool {
        self.nearest(&ray.exact(), None, &mut Quiet).is_some()
    }

    #[inline(always)]
    fn any(&self, ray: &FlatRay) -> bool {
        Caster::any(self, &ray.exact(), &mut Quiet)
    }
}

/// So many that building does not count.
const RAYS: usize = 1 << 30;

/// The cells that `-grid auto` chooses.
pub fn cells(world: &World) -> [usize; 3] {
    Resolution::Auto.cells(&world.bounds, world.finite_count(), RAYS)
}

pub fn caster(world: &World, cells: [usize; 3]) -> Result<Caster<'_>, GridTooLarge> {
    let insertion = Insertion::Nested { crowd: crowd(world.finite_count(), RAYS) };
    Caster::with(world, Some(cells), insertion, Instructions::available()[0])
}
