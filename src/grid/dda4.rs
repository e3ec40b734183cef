//! Four marches, set up together.

use super::Lattice;
use super::dda::{March, SHORTEST_WAY, Schedule, WAY};
use super::ray_aabb::Passages;
use crate::math::four::Four;
use crate::math::packet::Packet;

/// Where four rays start, and when they cross faces. Of a ray that misses the lattice it says nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Marches {
    axes: [Schedule; 3],
    /// The axes along which each ray runs backwards (bit 0 for x).
    backwards: [i32; 4],
    entry: [f64; 4],
    per_tick: [f64; 4],
}

impl Marches {
    /// Of rays with these passages through the lattice's bounds.
    #[inline(always)]
    pub fn new<F: Four>(lattice: &Lattice, packet: &Packet<F>, passages: &Passages<F>) -> Self {
        let Passages { entry, exit, .. } = *passages;
        let per_tick = exit.all(WAY) / (exit - entry).max(exit.all(SHORTEST_WAY));
        let [x, y, z] = &packet.axes;
        let (ahead, proof) = (&lattice.ahead, entry.proof());
        let backwards = x.inverse.sign_of(1.0) + y.inverse.sign_of(2.0) + z.inverse.sign_of(4.0);
        Self {
            axes: [
                Schedule::new(&ahead.faces_along(proof, 0), x, entry, per_tick),
                Schedule::new(&ahead.faces_along(proof, 1), y, entry, per_tick),
                Schedule::new(&ahead.faces_along(proof, 2), z, entry, per_tick),
            ],
            backwards: backwards.whole(),
            entry: entry.places(),
            per_tick: per_tick.places(),
        }
    }

    /// The march of one of the rays.
    #[inline(always)]
    pub fn march<'l>(&self, lattice: &'l Lattice, ray: usize) -> March<'l> {
        let [x, y, z] = &self.axes;
        let schedule = Schedule {
            cell: [x.cell[ray], y.cell[ray], z.cell[ray], 0],
            next: [x.next[ray], y.next[ray], z.next[ray], 0],
            between: [x.between[ray], y.between[ray], z.between[ray], 0],
        };
        let backwards = self.backwards[ray] as usize & 7;
        March::scheduled(lattice, &schedule, backwards, self.entry[ray], self.per_tick[ray])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::ray_aabb::{clip, clip_packet};
    use crate::math::aabb::Aabb;
    use crate::math::four::Plain;
    use crate::math::instructions::Portable;
    use crate::math::packet::Along;
    use crate::math::ray::Ray;
    use glam::DVec3;

    /// The cells and the ticks of a march through a lattice of `cells`, and a few steps beyond.
    fn way(mut march: March, cells: [usize; 3]) -> Vec<(usize, i32)> {
        let mut way = vec![];
        for _ in 0..cells.iter().sum() {
            way.push((march.index(), march.exit()));
            march.step();
        }
        way
    }

    #[test]
    fn four_rays_go_as_each_by_itself() {
        let cells = [9, 1, 20];
        let lattice = Lattice::new(Aabb { min: DVec3::new(-1.0, 2.0, 0.0), max: DVec3::splat(3.0) }, cells);
        let coordinate = |k: u32| (f64::from(k) * 0.618_034).fract() * 6.0 - 1.5;
        let ray = |k: u32| {
            let [origin, target] = [k, k + 50].map(|k| DVec3::from([1, 3, 7].map(|n| coordinate(n * k))));
            let direction =
                if k.is_multiple_of(5) { DVec3::AXES[k as usize / 5 % 3] } else { target - origin };
            let t_max = if k.is_multiple_of(3) { 0.5 } else { f64::INFINITY };
            Ray { t_max, ..Ray::new(origin, direction * if k.is_multiple_of(2) { 1.0 } else { -1.0 }) }
        };
        let mut entered = 0;
        for first in (0..4000).step_by(4) {
            let rays = [0, 1, 2, 3].map(|i| ray(first + i));
            let packet = Packet::<Plain>::new(Portable, rays.each_ref());
            let passages = clip_packet(lattice.slab(), &packet);
            let marches = Marches::new(&lattice, &packet, &passages);
            for (i, ray) in rays.iter().enumerate() {
                let passage =
                    clip(lattice.slab(), Along::<Plain>::all_axes(Portable, ray), ray.t_min, ray.t_max);
                assert_eq!(passages.set >> i & 1 != 0, passage.is_some(), "{ray:?}");
                if let Some(passage) = passage {
                    let (one, of_four) = (March::new(&lattice, &passage), marches.march(&lattice, i));
                    assert_eq!(way(of_four, cells), way(one, cells), "{ray:?}");
                    entered += 1;
                }
            }
        }
        assert!(entered > 500, "{entered}");
    }
}
