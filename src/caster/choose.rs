//! Chooses the acceleration structure: a list, a uniform grid or a tree.
//!
//! *Memory.* A grid of chosen resolution for n primitives holds at most max(16 n, 65,536) references. (A reference is a
//! primitive listed in a cell.) It has about as many cells as there are primitives, and fewer if their boxes would
//! touch too many cells. A tree holds each primitive once, and has fewer nodes than leaves.

use crate::caster::block::LANES;
use crate::caster::insertion::{bounds_of, most_references};
use crate::caster::lattice::Lattice;
use crate::math::aabb::Aabb;
use crate::world::World;
use serde::Serialize;

/// An acceleration structure that can be built. All of them find the same hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// A list of the primitives.
    List,
    /// A uniform grid with this number of cells along each axis.
    Grid([usize; 3]),
    /// A tree of boxes.
    Tree,
}

/// The acceleration structure that a request asks for. All of them give the same pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Structure {
    /// A tree, or a list of few primitives.
    #[default]
    Any,
    /// A list of all primitives.
    List,
    /// A uniform grid.
    Grid(Resolution),
}

/// The requested number of cells along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Resolution {
    /// Exactly this number, at any cost.
    Cells([usize; 3]),
    /// Chosen according to the scene and the number of rays.
    Auto,
}

/// Measured: a tree pays from this number of triangles on, where a sphere counts as eight triangles.
const LEAST_FOR_TREE: usize = 32;

/// Measured: from this number of rays per primitive on, the time per ray matters more than the time to build a grid.
const MANY_RAYS: usize = 8;

impl Structure {
    /// Returns the layout to build for a world and about this number of rays from the camera.
    pub fn layout(self, world: &World, camera_rays: usize) -> Layout {
        let triangles = world.visible_count() + (LANES - 1) * world.shapes.len();
        match self {
            Self::Any if triangles >= LEAST_FOR_TREE => Layout::Tree,
            Self::Any | Self::List => Layout::List,
            Self::Grid(Resolution::Cells(cells)) => Layout::Grid(cells),
            Self::Grid(Resolution::Auto) => {
                Layout::Grid(affordable_cells(world, wanted_cells(world, camera_rays)))
            }
        }
    }
}

impl Layout {
    /// Returns the number of cells along each axis if this is a grid.
    pub fn cells(self) -> Option<[usize; 3]> {
        if let Self::Grid(cells) = self { Some(cells) } else { None }
    }
}

/// Returns the number of cells along each axis for one cubic cell per primitive. Measured, half or twice as many cells
/// cost a few percent of time, and eight times as many a quarter. If there are so few rays that building dominates,
/// there are 0.4 cells per primitive.
fn wanted_cells(world: &World, rays: usize) -> [usize; 3] {
    let count = world.finite_count();
    let per_primitive = if rays < count.saturating_mul(MANY_RAYS) { 0.4 } else { 1.0 };
    cubic(&world.bounds, per_primitive * count as f64)
}

/// Returns the wanted cells, or fewer, so that the number of cells that the primitives' boxes touch is affordable.
fn affordable_cells(world: &World, wanted: [usize; 3]) -> [usize; 3] {
    let (most, bounds) = (affordable_references(world), bounds_of(world));
    let fewer = |cells: &[usize; 3]| Some(cells.map(|n| (3 * n / 4).max(1))).filter(|fewer| fewer != cells);
    let mut tried = std::iter::successors(Some(wanted), fewer);
    tried.find(|&cells| most_references(world, &Lattice::new(bounds, cells)) <= most).unwrap_or([1; 3])
}

/// Returns the number of references that a grid of chosen resolution may hold.
fn affordable_references(world: &World) -> u64 {
    (16 * world.finite_count() as u64).max(65_536)
}

/// Returns the number of cells along each axis for about `total` cubic cells in a box. A side counts as at least a
/// thousandth of the largest side, so that a flat scene is divided along its two long sides.
pub fn cubic(bounds: &Aabb, total: f64) -> [usize; 3] {
    const MIN_RELATIVE_SIDE: f64 = 1e-3;
    let extent = bounds.extent();
    let largest = extent.max_element();
    if bounds.is_empty() || largest == 0.0 {
        return [1; 3];
    }
    // Sides are relative to the largest one, since the volume of the box may overflow or underflow.
    let sides = (extent / largest).max(glam::DVec3::splat(MIN_RELATIVE_SIDE)).to_array();
    let edge = libm::cbrt(sides.iter().product::<f64>() / total.max(1.0));
    sides.map(|side| ((side / edge).round() as usize).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::test_worlds::{world_of, world_of_triangles};
    use glam::DVec3;

    fn boxed(extent: DVec3, total: f64) -> [usize; 3] {
        cubic(&Aabb { min: DVec3::ONE, max: DVec3::ONE + extent }, total)
    }

    #[test]
    fn cells_are_cubic() {
        assert_eq!(boxed(DVec3::ONE, 1000.0), [10, 10, 10]);
        assert_eq!(boxed(DVec3::new(4.0, 2.0, 1.0), 8000.0), [40, 20, 10]);
        assert_eq!(boxed(DVec3::new(1.0, 0.0, 1.0), 1000.0), [100, 1, 100]);
        assert_eq!(boxed(DVec3::ZERO, 5.0), [1; 3]);
        assert_eq!(cubic(&Aabb::EMPTY, 9.0), [1; 3]);
        assert_eq!(boxed(DVec3::splat(4.0), 0.0), [1; 3]);
    }

    #[test]
    fn a_side_counts_as_at_least_a_thousandth_of_the_largest() {
        let sides = [1e-9, 0.0].map(|y| boxed(DVec3::new(1.0, y, 1e-3), 1000.0));
        assert_eq!(sides[0], sides[1]);
        let flat = Aabb { min: DVec3::ZERO, max: DVec3::new(8.0, 8e-3, 0.0) };
        assert_eq!(cubic(&flat, 1e9), [100_000, 100, 100]);
    }

    /// Returns a world of this many triangles and spheres, and a plane, all in one place.
    fn nested(triangles: usize, spheres: usize) -> World {
        let sizes = |count| 1..=count;
        let triangle = |i| format!("Triangle {{ vertex0 0 0 0 vertex1 {i} 0 0 vertex2 0 {i} 0 }}");
        let sphere = |i| format!("Sphere {{ center 0 0 0 radius {i} }}");
        let plane = "Plane { normal 0 1 0 offset 0 }".to_string();
        let finite = sizes(triangles).map(triangle).chain(sizes(spheres).map(sphere));
        world_of(&finite.chain([plane]).collect::<Vec<_>>())
    }

    /// Returns a world of small triangles around points that fill the unit cube evenly.
    fn scattered(count: u32) -> World {
        let corner = |i: u32| (DVec3::new(0.618, 0.754, 0.569) * f64::from(i)).fract();
        let small = |corner: DVec3| [DVec3::ZERO, DVec3::X, DVec3::Y].map(|side| corner + 0.01 * side);
        world_of_triangles((0..count).map(corner).chain([DVec3::ONE]).map(small), &[])
    }

    #[test]
    fn few_primitives_are_a_list_and_many_a_tree() {
        let layouts = [(31, 0), (32, 0), (0, 3), (0, 4), (24, 1), (0, 0)]
            .map(|(triangles, spheres)| Structure::Any.layout(&nested(triangles, spheres), 1000));
        let [list, tree] = [Layout::List, Layout::Tree];
        assert_eq!(layouts, [list, tree, list, tree, tree, list]);
    }

    #[test]
    fn for_few_rays_there_are_fewer_cells() {
        let world = scattered(2196);
        let automatic = |rays| Structure::Grid(Resolution::Auto).layout(&world, rays);
        assert_eq!(automatic(8 * 2197), Layout::Grid([13; 3]));
        assert_eq!(automatic(8 * 2197 - 1), Layout::Grid([10; 3]));
    }

    #[test]
    fn what_is_asked_for_is_built() {
        let world = nested(1000, 0);
        assert_eq!(Structure::List.layout(&world, 1000), Layout::List);
        let cells = Structure::Grid(Resolution::Cells([5, 1, 9]));
        assert_eq!(cells.layout(&world, 0), Layout::Grid([5, 1, 9]));
    }
}
