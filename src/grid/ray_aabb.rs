//! Where rays enter and leave a box: slab by slab (Kay and Kajiya, "Ray Tracing Complex Scenes",
//! SIGGRAPH 1986).

use crate::math::aabb::Aabb;
use crate::math::extremes::max;
use crate::math::f64x4::F64x4;
use crate::math::ray::Ray;
use crate::math::ray_lanes::{RayLanes, RayPacket4};
use crate::math::robust::UNIT_ROUNDOFF;
use glam::DVec3;

/// A box: two corners with a spare place each.
#[derive(Clone, Debug, PartialEq)]
pub struct SimdAabb {
    pub low: [f64; 4],
    high: [f64; 4],
}

impl SimdAabb {
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
    fn all_axes<F: F64x4>(&self, proof: F::Proof) -> [F; 2] {
        [F::new(proof, self.low), F::new(proof, self.high)]
    }

    /// The faces along one axis.
    #[inline(always)]
    fn axis<F: F64x4>(&self, proof: F::Proof, axis: usize) -> [F; 2] {
        [F::splat(proof, self.low[axis]), F::splat(proof, self.high[axis])]
    }
}

/// Where rays cross two faces, the nearer first.
#[inline(always)]
fn crossings<F: F64x4>([low, high]: [F; 2], ray_lanes: &RayLanes<F>) -> [F; 2] {
    let low = (low - ray_lanes.origin) * ray_lanes.inv_direction;
    let high = (high - ray_lanes.origin) * ray_lanes.inv_direction;
    [low.min(high), low.max(high)]
}

/// Where a ray enters and leaves a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayInterval<F> {
    pub entry: f64,
    pub exit: f64,
    /// The ray along all axes.
    pub ray_lanes: RayLanes<F>,
}

/// Where a ray from `t_min` on enters and leaves the box, if it does so before `t_max`.
#[inline(always)]
pub fn intersect_aabb<F: F64x4>(
    simd_bounds: &SimdAabb,
    ray_lanes: RayLanes<F>,
    t_min: f64,
    t_max: f64,
) -> Option<RayInterval<F>> {
    let [near, far] = crossings(simd_bounds.all_axes(ray_lanes.origin.proof()), &ray_lanes);
    let entry = max(near.max3(), t_min);
    let exit = far.min3();
    // A ray within a face has a NaN there, and misses: nothing reaches the faces. One without
    // direction never gets out again.
    let passes = near.le_mask(far) & 7 == 7 && entry <= exit && entry <= t_max && exit < f64::INFINITY;
    passes.then_some(RayInterval { entry, exit, ray_lanes })
}

/// Where four rays enter and leave a box.
#[derive(Clone, Copy, Debug)]
pub struct RayIntervals<F> {
    /// Those that do, bit 0 for the first ray; of the others nothing is said.
    pub set: u32,
    pub entry: F,
    pub exit: F,
}

/// The same for four rays as [`intersect_aabb`] for one, with the same numbers.
#[inline(always)]
pub fn intersect_aabb4<F: F64x4>(simd_bounds: &SimdAabb, packet: &RayPacket4<F>) -> RayIntervals<F> {
    let [x, y, z] = &packet.axes;
    let proof = packet.t_min.proof();
    let [near_x, far_x] = crossings(simd_bounds.axis(proof, 0), x);
    let [near_y, far_y] = crossings(simd_bounds.axis(proof, 1), y);
    let [near_z, far_z] = crossings(simd_bounds.axis(proof, 2), z);
    let entry = near_x.max(near_y).max(near_z).max(packet.t_min);
    let exit = far_x.min(far_y).min(far_z);
    let precedes = near_x.le_mask(far_x) & near_y.le_mask(far_y) & near_z.le_mask(far_z);
    let ends = exit.le_mask(exit.broadcast(f64::MAX));
    RayIntervals { set: precedes & entry.le_mask(exit) & entry.le_mask(packet.t_max) & ends, entry, exit }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_ray_at_a_box_surely_misses_it_from_however_far() {
        let bounds = Aabb { min: DVec3::new(-1.0, 2.0, 3.0), max: DVec3::new(0.5, 2.5, 3.0) };
        let simd_bounds = SimdAabb::new(&bounds);
        let mut missed = 0;
        for i in 0..20_000 {
            let part = |k: f64| libm::fmod(k * f64::from(i), 1.0);
            let target = bounds.min + DVec3::new(part(0.618), part(0.754), part(0.569)) * bounds.extent();
            let far = libm::exp2(60.0 * part(0.819));
            let origin = far * DVec3::new(part(0.137) - 0.5, part(0.273) - 0.5, part(0.391) - 0.5);
            // Rounded, the line may truly miss the box; by how little is what the widening is for.
            let direction = (target - origin).normalize();
            assert!(!simd_bounds.is_surely_missed(&Ray::new(origin, direction)), "{origin} {target}");
            assert!(!simd_bounds.is_surely_missed(&Ray::new(origin, direction * libm::exp2(-900.0))));
            let beside = Ray::new(origin, target + DVec3::splat(1e-9 * far + 3.0) - origin);
            missed += usize::from(simd_bounds.is_surely_missed(&beside));
        }
        assert!(missed > 19_000, "{missed}");
        let ray_lanes = Ray::new(DVec3::new(0.0, 2.25, -9.0), DVec3::Z);
        assert!(!simd_bounds.is_surely_missed(&ray_lanes));
        assert!(simd_bounds.is_surely_missed(&Ray { origin: ray_lanes.origin + DVec3::Y, ..ray_lanes }));
    }
}
