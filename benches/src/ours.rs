//! This project's caster.

use crate::contestant::{Cast, FlatRay};
use raytracer::caster::choose::{Layout, Rays};
use raytracer::caster::packet::{PACKET_SIZE, PacketRay};
use raytracer::caster::{Caster, GridTooLarge, Instructions};
use raytracer::math::ray::{Ray, Visible};
use raytracer::stats::Quiet;
use raytracer::world::World;

impl Cast for Caster<'_> {
    #[inline(always)]
    fn closest(&self, ray: &FlatRay) -> f64 {
        Caster::closest(self, &ray.exact(), &mut Quiet).map_or(f64::INFINITY, |hit| hit.t)
    }

    fn count_closest(&self, rays: &[FlatRay]) -> usize {
        rays.chunks(PACKET_SIZE).map(|rays| count_hits(self, rays)).sum()
    }

    #[inline(always)]
    fn any(&self, ray: &FlatRay) -> bool {
        Caster::any(self, &ray.exact(), &mut Quiet)
    }
}

fn count_hits(caster: &Caster, rays: &[FlatRay]) -> usize {
    let ray = |i: usize| rays[i.min(rays.len() - 1)].exact();
    let mut asked: [Asked; PACKET_SIZE] = std::array::from_fn(|i| Asked { ray: ray(i), hits: false });
    let asked = &mut asked[..rays.len()];
    caster.nearest_of_packet(asked);
    asked.iter().filter(|asked| asked.hits).count()
}

/// A ray and its hit.
struct Asked {
    ray: Ray,
    hits: bool,
}

impl PacketRay for Asked {
    #[inline(always)]
    fn ray(&self) -> &Ray {
        &self.ray
    }

    #[inline(always)]
    fn set_visible(&mut self, visible: Option<Visible>) {
        self.hits = visible.is_some();
    }
}

/// A number of rays for which the time of building is negligible.
const RAYS: usize = 1 << 30;

/// The caster that `-grid auto` chooses.
pub fn caster(world: &World) -> Result<Caster<'_>, GridTooLarge> {
    Caster::with(world, Layout::chosen(world, Rays::cast(RAYS)), Instructions::available()[0])
}
