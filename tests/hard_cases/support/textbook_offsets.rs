//! The textbooks' methods to keep a secondary ray from hitting the surface that it leaves.

use glam::Vec3;

/// The usual t_min of a secondary ray.
pub const FIXED: f64 = 1e-4;

/// The point moved along the normal by a number of units in the last place of its coordinates, and by a fixed
/// distance near zero (Waechter, Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray
/// Tracing Gems, ch. 6).
pub fn integer_offset(point: Vec3, normal: Vec3) -> Vec3 {
    const ORIGIN: f32 = 1.0 / 32.0;
    const FLOAT_SCALE: f32 = 1.0 / 65536.0;
    const INT_SCALE: f32 = 256.0;
    let moved = |p: f32, n: f32| {
        if p.abs() < ORIGIN {
            return p + FLOAT_SCALE * n;
        }
        let step = (INT_SCALE * n) as i32;
        f32::from_bits((p.to_bits() as i32 + if p < 0.0 { -step } else { step }) as u32)
    };
    Vec3::new(moved(point.x, normal.x), moved(point.y, normal.y), moved(point.z, normal.z))
}
