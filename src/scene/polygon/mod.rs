//! Triangulates the polygons of a mesh: any number of corners in space, which need be neither convex nor exactly
//! flat.
//!
//! What a polygon covers is decided in the coordinate plane that it faces most, by exact orientations. So it depends
//! neither on the size of the polygon nor on its place, its first corner or its direction. The triangles are those of
//! the first of three ways that covers the polygon:
//!
//! 1. a fan around the first corner, as for every convex polygon;
//! 2. ears, cut off one by one: every polygon whose outline does not cross itself;
//! 3. trapezoids between the heights of the corners: what an outline that crosses itself goes around.
//!
//! A fan takes linear time. Ears take time nearly linear in the number of corners where edges near each other follow each
//! other along the outline, as in a comb, and quadratic where they do not, as in a star of needles: a second for 20,000
//! corners, half a minute for 100,000. The time of trapezoids is bounded.

mod box_tree;
mod ears;
mod fan;
mod outline;
mod projection;
mod trapezoids;

#[cfg(test)]
mod tests;

use glam::DVec3;
use outline::Outline;
use projection::DroppedAxis;

/// The triangles of a polygon, counter-clockwise where the polygon is.
#[derive(Debug, Default, PartialEq)]
pub struct Triangulation {
    /// Indices of corners. Those from the number of corners on are indices of `new_points`.
    pub triangles: Vec<[usize; 3]>,
    /// Further vertices on the edges of an outline that crosses itself.
    pub new_points: Vec<DVec3>,
    /// Whether the outline crosses itself, by more than its corners may be off by rounding.
    pub crosses_itself: bool,
}

impl From<Vec<[usize; 3]>> for Triangulation {
    fn from(triangles: Vec<[usize; 3]>) -> Self {
        Self { triangles, new_points: vec![], crosses_itself: false }
    }
}

/// Triangulates a polygon of at least three corners, which are finite.
///
/// A polygon without area becomes a fan of triangles without area. Any other has triangles with an area only. Where
/// the outline crosses itself, the polygon covers the points around which it goes, however often it does.
pub fn triangulate(corners: &[DVec3]) -> Triangulation {
    let outline = Outline::new(corners);
    let Some(projection) = DroppedAxis::facing(&outline) else { return whole_fan(corners.len()) };
    if let Some(triangles) = fan::triangles(&outline, projection) {
        return triangles.into();
    }
    let ring = outline.ring();
    let found = match ears::triangles(&ring, projection) {
        Some(triangles) => triangles.into(),
        None => trapezoids::triangulation(&ring, projection, corners.len()),
    };
    if found.triangles.is_empty() { whole_fan(corners.len()) } else { found }
}

/// The triangles around the first corner, whether or not they have an area.
fn whole_fan(corners: usize) -> Triangulation {
    (1..corners.max(2) - 1).map(|k| [0, k, k + 1]).collect::<Vec<_>>().into()
}
