//! Triangles around the first corner of a polygon.

use super::projection::DroppedAxis;
use crate::math::exact::area_vector;
use glam::DVec3;

/// The triangles around the first corner, without those that have no area, by places among the corners. None if the
/// corner does not see the whole polygon within half a turn, as that of a convex polygon does.
pub fn triangles(corners: &[DVec3], projection: DroppedAxis) -> Option<Vec<[usize; 3]>> {
    let &[first, second, ..] = corners else { return None };
    let is_first = |corner: DVec3| projection.of(corner) == projection.of(first);
    let turns = |from: DVec3, to: DVec3| projection.orientation([first, from, to]);
    let mut direction = 0;
    for edge in corners[1..].windows(2) {
        let turn = turns(edge[0], edge[1]);
        direction = if direction == 0 { turn } else { direction };
        if turn * direction < 0 || turns(second, edge[1]) * direction < 0 || is_first(edge[1]) {
            return None;
        }
    }
    // One that is projected to a line may have an area in space, and then it closes a gap.
    let has_area = |triangle: &[usize; 3]| {
        let triangle = triangle.map(|place| corners[place]);
        projection.orientation(triangle) != 0 || area_vector(triangle).iter().any(|area| area.sign() != 0)
    };
    let all = (1..corners.len() - 1).map(|place| [0, place, place + 1]);
    (direction != 0 && !is_first(second)).then(|| all.filter(has_area).collect())
}
