//! Four marches, set up together.

use super::Lattice;
use super::march::{March, SHORTEST_WAY, Schedule, WAY};
use super::passage::Passages;
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
        let per_tick = F::splat(WAY) / (exit - entry).max(F::splat(SHORTEST_WAY));
        let [x, y, z] = &packet.axes;
        let ahead = &lattice.ahead;
        let backwards = x.inverse.sign_of(1.0) + y.inverse.sign_of(2.0) + z.inverse.sign_of(4.0);
        Self {
            axes: [
                Schedule::new(&ahead.faces_along(0), x, entry, per_tick),
                Schedule::new(&ahead.faces_along(1), y, entry, per_tick),
                Schedule::new(&ahead.faces_along(2), z, entry, per_tick),
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
