//! Triangles around the first corner of a polygon, where every point of it is seen from there.

use super::outline::{Corner, Outline};
use super::projection::DroppedAxis;
use crate::math::predicate::area_vector;

/// The triangles of a fan around the file's first corner, without those that have no area. None if the fan does not
/// cover the polygon.
pub fn triangles(outline: &Outline, projection: DroppedAxis) -> Option<Vec<[usize; 3]>> {
    if !covers(outline.in_file_order(), projection) {
        return None;
    }
    let [first, others @ ..] = outline.in_file_order() else { return None };
    let mut triangles = Vec::with_capacity(others.len().saturating_sub(1));
    for edge in others.windows(2) {
        let corners = [*first, edge[0], edge[1]];
        // One that is projected to a line may have an area in space, and then it closes a gap.
        let has_area = projection.orientation(corners.map(|corner| corner.point)) != 0
            || area_vector(corners.map(|corner| corner.point)).iter().any(|area| area.sign() != 0);
        if has_area {
            triangles.push(corners.map(|corner| corner.index));
        }
    }
    Some(triangles)
}

/// Whether the corners go around the first one in one direction, and less than once.
fn covers(corners: &[Corner], projection: DroppedAxis) -> bool {
    let [first, second, ..] = corners else { return false };
    let [x, y] = projection.of(first.point);
    // The quadrant of a corner, seen from the first, without the axes' two half-lines being told apart.
    let side = |corner: &Corner| {
        let [a, b] = projection.of(corner.point);
        [a.total_cmp(&x) as i32 * i32::from(a != x), b.total_cmp(&y) as i32 * i32::from(b != y)]
    };
    let is_opposite = |a: &Corner, b: &Corner| {
        let ([ax, ay], [bx, by]) = (side(a), side(b));
        ax * bx < 0 || ay * by < 0
    };
    let (mut direction, mut reached) = (0, 0);
    for edge in corners[1..].windows(2) {
        let [from, to] = edge else { continue };
        let turn = projection.orientation([first.point, from.point, to.point]);
        if turn * direction < 0 {
            return false;
        }
        direction = if direction == 0 { turn } else { direction };
        // How many quarters of a turn from the second corner, with those in between counted as odd.
        let quarters = match direction * projection.orientation([first.point, second.point, to.point]) {
            1 => 1,
            0 if !is_opposite(second, to) => 0,
            0 => 2,
            _ => 3,
        };
        if quarters < reached {
            return false;
        }
        reached = quarters;
    }
    direction != 0 && side(second) != [0, 0]
}
