//! How far away the origin of a ray may be for the error bounds of the filter and the DDA to hold.

use crate::math::aabb::Aabb;

/// Maximum distance of a ray's origin in cells, 2^31: the rounding errors of a hit point then stay below the
/// padding that `proofs/dda.g` assumes.
pub const MAX_ORIGIN_CELLS: f64 = 2147483648.0;

/// Maximum distance of a ray's origin in box sizes. That is at most 2^20 units of the filter's frame, for
/// which the proof of the filter holds.
const MAX_ORIGIN_BOXES: f64 = (1u32 << 19) as f64;

/// Maximum distance of a ray's origin from the centre of a box along each axis, for which the proofs of
/// filter and DDA hold. `min_cell_size` is the smallest edge length of the cells.
pub fn max_origin_distance(bounds: &Aabb, min_cell_size: f64) -> f64 {
    (bounds.extent().max_element() * MAX_ORIGIN_BOXES).min(min_cell_size * MAX_ORIGIN_CELLS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn an_origin_may_be_as_many_boxes_or_cells_away_as_the_proofs_hold_for() {
        let bounds = Aabb { min: DVec3::ONE, max: DVec3::new(2.0, 3.0, 5.0) };
        assert_eq!(max_origin_distance(&bounds, f64::INFINITY), 4.0 * MAX_ORIGIN_BOXES);
        assert_eq!(max_origin_distance(&bounds, 1.0 / 65536.0), MAX_ORIGIN_CELLS / 65536.0);
    }
}
