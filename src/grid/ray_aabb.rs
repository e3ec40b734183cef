//! Where rays enter and leave a box: slab by slab (Kay and Kajiya, "Ray Tracing Complex Scenes",
//! SIGGRAPH 1986).

use crate::math::aabb::Aabb;
use crate::math::extremes::greater;
use crate::math::four::Four;
use crate::math::packet::{Along, Packet};
use crate::math::ray::Ray;
use crate::math::robust::UNIT_ROUNDOFF;
use glam::DVec3;

/// A box: two corners with a spare place each.
#[derive(Clone, Debug, PartialEq)]
pub struct Slab {
    pub low: [f64; 4],
    high: [f64; 4],
}

impl Slab {
    pub fn new(bounds: &Aabb) -> Self {
        let corner = |v: DVec3| [v.x, v.y, v.z, 0.0];
        Self { low: corner(bounds.min), high: corner(bounds.max) }
    }

    /// Whether a ray's line surely misses the box, from however far away it comes.
    ///
    /// A crossing is off by three roundings of the way to it, which may be many times the box. The box is
    /// widened by more than that.
    pub fn is_surely_missed(&self, ray: &Ray) -> bool {
        let corners = self.low.iter().chain(&self.high).fold(0.0, |most: f64, x| most.max(x.abs()));
        let largest = ray.origin.abs().max_element() + corners;
        let widening = 128.0 * UNIT_ROUNDOFF * largest + f64::MIN_POSITIVE;
        let (mut entry, mut exit) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            let (from, speed) = (ray.origin[axis], ray.direction[axis]);
            let ways = [self.low[axis] - widening - from, self.high[axis] + widening - from];
            if speed == 0.0 && ways[0] * ways[1] > 0.0 {
                return true;
            } else if speed != 0.0 {
                let [one, other] = ways.map(|way| way / speed);
                (entry, exit) = (entry.max(one.min(other)), exit.min(one.max(other)));
            }
        }
        entry > exit
    }

    /// The faces along all axes.
    #[inline(always)]
    fn all_axes<F: Four>(&self, proof: F::Proof) -> [F; 2] {
        [F::new(proof, self.low), F::new(proof, self.high)]
    }

    /// The faces along one axis.
    #[inline(always)]
    fn axis<F: Four>(&self, proof: F::Proof, axis: usize) -> [F; 2] {
        [F::splat(proof, self.low[axis]), F::splat(proof, self.high[axis])]
    }
}

/// Where rays cross two faces, the nearer first.
#[inline(always)]
fn crossings<F: Four>([low, high]: [F; 2], along: &Along<F>) -> [F; 2] {
    let low = (low - along.origin) * along.inverse;
    let high = (high - along.origin) * along.inverse;
    [low.min(high), low.max(high)]
}

/// Where a ray enters and leaves a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage<F> {
    pub entry: f64,
    pub exit: f64,
    /// The ray along all axes.
    pub along: Along<F>,
}

/// Where a ray from `t_min` on enters and leaves the box, if it does so before `t_max`.
#[inline(always)]
pub fn clip<F: Four>(slab: &Slab, along: Along<F>, t_min: f64, t_max: f64) -> Option<Passage<F>> {
    let [near, far] = crossings(slab.all_axes(along.origin.proof()), &along);
    let entry = greater(near.greatest(), t_min);
    let exit = far.least();
    // A ray within a face has a NaN there, and misses: nothing reaches the faces. One without
    // direction never gets out again.
    let passes = near.at_most(far) & 7 == 7 && entry <= exit && entry <= t_max && exit < f64::INFINITY;
    passes.then_some(Passage { entry, exit, along })
}

/// Where four rays enter and leave a box.
#[derive(Clone, Copy, Debug)]
pub struct Passages<F> {
    /// Those that do, bit 0 for the first ray; of the others nothing is said.
    pub set: u32,
    pub entry: F,
    pub exit: F,
}

/// The same for four rays as [`clip`] for one, with the same numbers.
#[inline(always)]
pub fn clip_packet<F: Four>(slab: &Slab, packet: &Packet<F>) -> Passages<F> {
    let [x, y, z] = &packet.axes;
    let proof = packet.t_min.proof();
    let [near_x, far_x] = crossings(slab.axis(proof, 0), x);
    let [near_y, far_y] = crossings(slab.axis(proof, 1), y);
    let [near_z, far_z] = crossings(slab.axis(proof, 2), z);
    let entry = near_x.max(near_y).max(near_z).max(packet.t_min);
    let exit = far_x.min(far_y).min(far_z);
    let precedes = near_x.at_most(far_x) & near_y.at_most(far_y) & near_z.at_most(far_z);
    let ends = exit.at_most(exit.all(f64::MAX));
    Passages { set: precedes & entry.at_most(exit) & entry.at_most(packet.t_max) & ends, entry, exit }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_ray_at_a_box_surely_misses_it_from_however_far() {
        let bounds = Aabb { min: DVec3::new(-1.0, 2.0, 3.0), max: DVec3::new(0.5, 2.5, 3.0) };
        let slab = Slab::new(&bounds);
        let mut missed = 0;
        for i in 0..20_000 {
            let part = |k: f64| libm::fmod(k * f64::from(i), 1.0);
            let target = bounds.min + DVec3::new(part(0.618), part(0.754), part(0.569)) * bounds.extent();
            let far = libm::exp2(60.0 * part(0.819));
            let origin = far * DVec3::new(part(0.137) - 0.5, part(0.273) - 0.5, part(0.391) - 0.5);
            // Rounded, the line may truly miss the box; by how little is what the widening is for.
            let direction = (target - origin).normalize();
            assert!(!slab.is_surely_missed(&Ray::new(origin, direction)), "{origin} {target}");
            assert!(!slab.is_surely_missed(&Ray::new(origin, direction * libm::exp2(-900.0))));
            let beside = Ray::new(origin, target + DVec3::splat(1e-9 * far + 3.0) - origin);
            missed += usize::from(slab.is_surely_missed(&beside));
        }
        assert!(missed > 19_000, "{missed}");
        let along = Ray::new(DVec3::new(0.0, 2.25, -9.0), DVec3::Z);
        assert!(!slab.is_surely_missed(&along));
        assert!(slab.is_surely_missed(&Ray { origin: along.origin + DVec3::Y, ..along }));
    }
}
