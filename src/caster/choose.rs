//! Chooses the acceleration structure: a list, a uniform grid or a tree. All policies are in this module.
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

/// The acceleration structure to build. All of them find the same hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// A list of the primitives that rays may hit.
    List,
    /// A uniform grid with this number of cells along each axis.
    Grid([usize; 3]),
    /// A tree of boxes.
    Tree,
    /// As in the course's program, so that the counts are comparable: a list of all primitives, or a grid with this
    /// number of cells along each axis.
    Course(Option<[usize; 3]>),
}

/// The requested acceleration structure. All of them give the same pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Structure {
    /// The structure with the least total time.
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

/// The approximate number of rays for which a structure is built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rays {
    /// Rays from the camera.
    pub camera: usize,
    /// Rays of all kinds that are cast through the structure.
    pub cast: usize,
}

impl Rays {
    /// Returns the counts for this number of camera rays, all of which are cast.
    pub fn cast(camera: usize) -> Self {
        Self { camera, cast: camera }
    }
}

impl Structure {
    /// Returns the layout to build for a world and this approximate number of rays. If the rays are counted,
    /// [`Structure::Any`] gives a list, as in the course's program.
    pub fn layout(self, world: &World, rays: Rays, is_counted: bool) -> Layout {
        let grid = match self {
            Self::Any if !is_counted => return Layout::chosen(world, rays),
            Self::Any | Self::List => None,
            Self::Grid(Resolution::Cells(cells)) => Some(cells),
            Self::Grid(Resolution::Auto) => Some(affordable_cells(world, wanted_cells(world, rays.camera))),
        };
        match grid {
            _ if is_counted => Layout::Course(grid),
            Some(cells) => Layout::Grid(cells),
            None => Layout::List,
        }
    }
}

/// Measured: a grid pays from this number of triangles on, where a sphere counts as eight triangles. Building it takes
/// as long as testing this number of rays against all primitives.
const LEAST: usize = 32;

/// Measured: from this number of rays per primitive on, the time per ray matters more than the time to build.
const MANY_RAYS: usize = 8;

/// Measured: from this number of primitives on, a tree is faster than a grid, although the grid takes a third of the
/// time to build.
const LARGE: usize = 20_000;

/// Measured: a tree is faster if a primitive shares its cell with more than this number on average. This is five times
/// the mean over the occupied cells of an evenly tessellated mesh. For one ray per primitive, building the tree takes
/// as long as testing this number of primitives.
const CROWDED: usize = 96;

impl Layout {
    /// Returns the number of cells along each axis if this is a grid.
    pub fn cells(self) -> Option<[usize; 3]> {
        match self {
            Self::Grid(cells) => Some(cells),
            Self::Course(cells) => cells,
            Self::List | Self::Tree => None,
        }
    }

    /// Returns the uniform grid of `-grid auto` for about this number of rays from the camera.
    pub fn automatic(world: &World, rays: usize) -> Self {
        Self::Grid(affordable_cells(world, wanted_cells(world, rays)))
    }

    /// Returns the layout with the least total time for building and for these rays. A tree is chosen for very many
    /// primitives, and for primitives that no uniform grid separates, because most of them are close together or extend
    /// through many cells.
    pub fn chosen(world: &World, rays: Rays) -> Self {
        let count = world.finite_count();
        let tests = world.visible_count() + (LANES - 1) * world.shapes.len();
        if tests < LEAST || rays.cast < LEAST {
            return Self::List;
        }
        let is_large = count >= LARGE && rays.cast >= count.saturating_mul(MANY_RAYS);
        let cells = wanted_cells(world, rays.camera);
        let fits =
            most_references(world, &Lattice::new(bounds_of(world), cells)) <= affordable_references(world);
        if is_large || !fits || is_crowded(world, cells, rays.cast) { Self::Tree } else { Self::Grid(cells) }
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

/// Returns true if the cells are so crowded, counted by the primitives' centres, that a tree pays for these rays.
fn is_crowded(world: &World, cells: [usize; 3], rays: usize) -> bool {
    let count = world.finite_count();
    let lattice = Lattice::new(bounds_of(world), cells);
    let mut counts = vec![0u32; lattice.index_count()];
    for id in 0..count as u32 {
        let Aabb { min, max } = world.box_of(id);
        let middle = lattice.to_cells(0.5 * (min + max));
        counts[lattice.index([0, 1, 2].map(|axis| lattice.cell_at(axis, middle[axis])))] += 1;
    }
    let squares: u64 = counts.iter().map(|&n| u64::from(n) * u64::from(n)).sum();
    let mean = squares / count.max(1) as u64;
    mean > CROWDED.saturating_mul(1 + count / rays.max(1)) as u64
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
    use crate::scene::parser::parse;
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

    fn world(objects: &[String]) -> World {
        let text = format!(
            "OrthographicCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 0 size 3 }}
             Group {{ numObjects {} Material {{ }} {} }}",
            objects.len(),
            objects.join(" ")
        );
        World::new(&parse(&text).unwrap(), &[]).unwrap()
    }

    /// Returns a world of this many triangles and spheres, and a plane, all in one place.
    fn nested(triangles: usize, spheres: usize) -> World {
        let sizes = |count| 1..=count;
        let triangle = |i| format!("Triangle {{ vertex0 0 0 0 vertex1 {i} 0 0 vertex2 0 {i} 0 }}");
        let sphere = |i| format!("Sphere {{ center 0 0 0 radius {i} }}");
        let plane = "Plane { normal 0 1 0 offset 0 }".to_string();
        let finite = sizes(triangles).map(triangle).chain(sizes(spheres).map(sphere));
        world(&finite.chain([plane]).collect::<Vec<_>>())
    }

    /// Returns a world of small triangles around points that fill the unit cube, or a part of it, evenly.
    fn scattered(count: usize, part: f64, size: f64) -> World {
        let triangle = |i: usize| {
            let [x, y, z] = (part * (DVec3::new(0.618, 0.754, 0.569) * i as f64).fract()).to_array();
            let (right, up) = (x + size, y + size);
            format!("Triangle {{ vertex0 {x} {y} {z} vertex1 {right} {y} {z} vertex2 {x} {up} {z} }}")
        };
        let far = "Triangle { vertex0 1 1 1 vertex1 1.01 1 1 vertex2 1 1.01 1 }".to_string();
        world(&(0..count).map(triangle).chain([far]).collect::<Vec<_>>())
    }

    #[test]
    fn where_any_structure_will_do_a_list_is_built_unless_another_pays() {
        let is_list = |(triangles, spheres), cast| {
            Layout::chosen(&nested(triangles, spheres), Rays::cast(cast)) == Layout::List
        };
        assert_eq!(
            [(31, 0), (32, 0), (0, 3), (0, 4), (24, 1)].map(|counts| is_list(counts, 32)),
            [true, false, true, false, false]
        );
        assert!(is_list((1000, 0), 31) && is_list((0, 0), 1000));
    }

    #[test]
    fn even_primitives_get_a_grid_and_crowded_ones_a_tree() {
        let rays = Rays::cast(1 << 20);
        assert_eq!(Layout::chosen(&scattered(2000, 1.0, 0.02), rays), Layout::Grid([13, 13, 12]));
        assert_eq!(Layout::chosen(&scattered(2000, 0.01, 0.0002), rays), Layout::Tree);
        // The triangles are evenly spaced, but each is in many cells.
        assert_eq!(Layout::chosen(&scattered(2000, 0.2, 9.0), rays), Layout::Tree);
    }

    #[test]
    fn a_tree_is_built_for_enough_rays_only() {
        let crowded = scattered(2000, 0.01, 0.0002);
        assert!(matches!(Layout::chosen(&crowded, Rays::cast(50)), Layout::Grid(_)));
        assert_eq!(Layout::chosen(&crowded, Rays::cast(1000)), Layout::Tree);
    }

    #[test]
    fn a_tree_pays_for_middling_worlds_that_many_rays_are_cast_into() {
        let chosen =
            |world: &World, camera, cast| Layout::chosen(world, Rays { camera, cast }) == Layout::Tree;
        let middling = scattered(20_000, 1.0, 0.005);
        let many = 8 * middling.finite_count();
        assert_eq!([many - 1, many].map(|cast| chosen(&middling, 0, cast)), [false, true]);
        assert!(!chosen(&scattered(10_000, 1.0, 0.005), 0, many));
    }

    #[test]
    fn for_few_rays_there_are_fewer_cells() {
        let world = scattered(2196, 1.0, 0.01);
        assert_eq!(Layout::automatic(&world, 8 * 2197), Layout::Grid([13; 3]));
        assert_eq!(Layout::automatic(&world, 8 * 2197 - 1), Layout::Grid([10; 3]));
    }

    #[test]
    fn what_is_asked_for_is_built() {
        let (world, rays) = (nested(1000, 0), Rays::cast(1000));
        assert_eq!(Structure::List.layout(&world, rays, false), Layout::List);
        let literal = Structure::Grid(Resolution::Cells([5, 1, 9]));
        assert_eq!(literal.layout(&world, Rays::default(), false), Layout::Grid([5, 1, 9]));
        assert_eq!(literal.layout(&world, rays, true), Layout::Course(Some([5, 1, 9])));
        for structure in [Structure::Any, Structure::List] {
            assert_eq!(structure.layout(&world, rays, true), Layout::Course(None));
        }
        let automatic = Structure::Grid(Resolution::Auto).layout(&world, rays, false);
        assert_eq!(automatic, Layout::automatic(&world, 1000));
    }
}
