//! The choice of the acceleration structure: a list, a uniform grid, an automatic grid, or the insertion of
//! the course's program. All policies are here, and nowhere else.

use crate::math::aabb::Aabb;
use crate::world::World;
use serde::Serialize;

/// Into which cells a primitive is inserted. The rule never changes a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellRule {
    /// The cells it touches.
    Exact,
    /// The cells it touches, in a grid of bounded size. A cell with more than `max_per_cell` primitives gets a tree of
    /// boxes.
    Trees {
        /// The largest number of primitives in a cell without a tree.
        max_per_cell: usize,
    },
    /// The cells into which the course's program inserts it, so that counters compare with the course's.
    Course {
        /// Whether the size of the grid is bounded, at the cost of a coarser resolution than requested.
        is_bounded: bool,
    },
}

/// The acceleration structure to build for the finite primitives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridOptions {
    /// The number of cells along each axis, or none for a list of all primitives.
    pub cells: Option<[usize; 3]>,
    /// Into which of them a primitive is inserted.
    pub rule: CellRule,
}

impl GridOptions {
    /// A list of all primitives.
    pub const NONE: Self = Self { cells: None, rule: CellRule::Exact };

    /// A uniform grid with exactly this number of cells along each axis.
    pub fn uniform(cells: [usize; 3]) -> Self {
        Self { cells: Some(cells), rule: CellRule::Exact }
    }

    /// The structure with the least total time for building and for about this number of rays.
    pub fn automatic(world: &World, rays: usize) -> Self {
        let count = world.finite_count();
        let cells = Resolution::Auto.cells(&world.bounds, count, rays);
        Self { cells: Some(cells), rule: CellRule::Trees { max_per_cell: max_per_cell(count, rays) } }
    }

    /// The options for the requested resolution, or for a list if none is requested, in a world for about
    /// this number of rays. `use_course_rule` selects the insertion of the course's program, so that counters
    /// compare with it.
    pub fn new(requested: Option<Resolution>, world: &World, rays: usize, use_course_rule: bool) -> Self {
        let options = match requested {
            None => Self::NONE,
            Some(Resolution::Cells(cells)) => Self::uniform(cells),
            Some(Resolution::Auto) => Self::automatic(world, rays),
        };
        let is_bounded = requested == Some(Resolution::Auto);
        if use_course_rule { Self { rule: CellRule::Course { is_bounded }, ..options } } else { options }
    }
}

/// The acceleration structure that is asked for. Pictures are the same with each of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Structure {
    /// The one with the least total time.
    #[default]
    Any,
    /// A list of all primitives.
    List,
    /// A uniform grid.
    Grid(Resolution),
}

impl Structure {
    /// The grid to build, or none for a list of all primitives. `rays` is about the number of rays that are cast
    /// through it.
    ///
    /// Measured, a grid pays from 36 triangles on, and a sphere takes as long as 9 triangles. A grid of many
    /// primitives takes as long to build as 32 rays through their list.
    pub fn resolution(self, world: &World, rays: usize) -> Option<Resolution> {
        const MIN_TRIANGLES: usize = 36;
        const TRIANGLES_PER_OTHER: usize = 9;
        const MIN_RAYS: usize = 32;
        match self {
            Self::Grid(resolution) => Some(resolution),
            Self::List => None,
            Self::Any => {
                let others = world.finite_count() - world.triangles.len();
                let triangles = world.hittable_count() - others;
                let work = triangles.saturating_add(TRIANGLES_PER_OTHER * others);
                (work >= MIN_TRIANGLES && rays >= MIN_RAYS).then_some(Resolution::Auto)
            }
        }
    }
}

/// The requested number of cells along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Resolution {
    /// Exactly this number, whatever it costs.
    Cells([usize; 3]),
    /// Chosen according to the scene and the number of rays.
    Auto,
}

impl Resolution {
    /// The number of cells along each axis for `count` primitives in a box and about this number of rays.
    ///
    /// The automatic choice is cubic cells, one per primitive. Measured, half or twice as many cells cost a
    /// few percent of time, and eight times as many a quarter. If there are so few rays that building
    /// dominates, there are 0.4 cells per primitive. For many rays through many primitives there are only a
    /// few crowded cells, each with a tree: with 2.56 million primitives rays are 1.5 to 2.1 times as fast as in
    /// one level.
    pub fn cells(self, bounds: &Aabb, count: usize, rays: usize) -> [usize; 3] {
        let per_primitive = match self {
            Self::Cells(cells) => return cells,
            Self::Auto if rays < MANY_RAYS * count => 0.4,
            Self::Auto if count < MANY_PRIMITIVES => 1.0,
            Self::Auto => 1.0 / 1024.0,
        };
        cubic(bounds, per_primitive * count as f64)
    }
}

/// From this number of primitives on, trees are faster than a cell for each primitive. At 40,000 they are slower.
const MANY_PRIMITIVES: usize = 100_000;

/// From this number of rays per primitive on, the time per ray matters more than the time to build.
const MANY_RAYS: usize = 8;

/// The largest number of primitives in a cell for which a tree does not pay.
///
/// 96 is five times the mean of the occupied cells of an evenly tessellated mesh of 40,000 triangles. Of many
/// primitives almost all are in trees anyway, and 32 is a few percent faster. For few rays a tree pays only in cells
/// that would take each of them microseconds.
fn max_per_cell(count: usize, rays: usize) -> usize {
    match count {
        _ if rays < MANY_RAYS * count => 2048,
        MANY_PRIMITIVES.. => 32,
        _ => 96,
    }
}

/// The number of cells along each axis for about `total` cubic cells in a box. A side counts as at least a
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
    use glam::DVec3;

    fn auto(extent: DVec3, count: usize, rays: usize) -> [usize; 3] {
        Resolution::Auto.cells(&Aabb { min: DVec3::ONE, max: DVec3::ONE + extent }, count, rays)
    }

    #[test]
    fn there_is_about_one_cell_per_primitive() {
        assert_eq!(auto(DVec3::ONE, 1000, 1_000_000), [10, 10, 10]);
        assert_eq!(auto(DVec3::new(4.0, 2.0, 1.0), 8000, 1_000_000), [40, 20, 10]);
        let few_rays: usize = auto(DVec3::ONE, 40_000, 40_000).iter().product();
        assert!((12_000..20_000).contains(&few_rays));
    }

    #[test]
    fn flat_and_empty_scenes_get_cells_along_their_sides() {
        assert_eq!(auto(DVec3::new(1.0, 0.0, 1.0), 1000, 1_000_000), [100, 1, 100]);
        assert_eq!(auto(DVec3::ZERO, 5, 100), [1; 3]);
        assert_eq!(Resolution::Auto.cells(&Aabb::EMPTY, 0, 100), [1; 3]);
    }

    #[test]
    fn a_side_counts_as_at_least_a_thousandth_of_the_largest() {
        assert_eq!(
            auto(DVec3::new(1.0, 1e-9, 1e-3), 1_000, 1 << 20),
            auto(DVec3::new(1.0, 1e-3, 0.0), 1_000, 1 << 20)
        );
        assert_eq!(
            cubic(&Aabb { min: DVec3::ZERO, max: DVec3::new(8.0, 8e-3, 0.0) }, 1e9),
            [100_000, 100, 100]
        );
        assert_eq!(cubic(&Aabb { min: DVec3::ZERO, max: DVec3::splat(4.0) }, 0.0), [1; 3]);
    }

    #[test]
    fn eight_rays_per_primitive_are_many() {
        assert_eq!(auto(DVec3::ONE, 2160, 8 * 2160 - 1), [10; 3]);
        assert_eq!(auto(DVec3::ONE, 2197, 8 * 2197), [13; 3]);
        assert!(max_per_cell(1000, 7999) > max_per_cell(1000, 8000));
    }

    #[test]
    fn many_rays_through_many_primitives_get_crowded_cells() {
        assert_eq!(auto(DVec3::ONE, 216 * 1024, 1 << 30), [6; 3]);
        assert_eq!(auto(DVec3::ONE, 91_125, 1 << 30), [45; 3]);
        // This is the least number of primitives that counts as many.
        assert_eq!(auto(DVec3::ONE, MANY_PRIMITIVES, 1 << 30), [5; 3]);
        assert_eq!(
            [MANY_PRIMITIVES - 1, MANY_PRIMITIVES].map(|count| max_per_cell(count, 1 << 30)),
            [96, 32]
        );
    }

    #[test]
    fn few_rays_get_few_trees() {
        assert!(max_per_cell(1_000_000, 1_000_000) > max_per_cell(1_000_000, 100_000_000));
    }

    fn world(triangles: usize, spheres: usize) -> World {
        let triangles = "Triangle { vertex0 0 0 0 vertex1 1 0 0 vertex2 0 1 0 }\n".repeat(triangles);
        let spheres = "Sphere { center 0 0 0 radius 1 }\n".repeat(spheres);
        let count = triangles.lines().count() + spheres.lines().count() + 1;
        let text = format!(
            "OrthographicCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 0 size 3 }}
             Group {{ numObjects {count} Material {{ }} {triangles} {spheres} Plane {{ normal 0 1 0 offset 0 }} }}"
        );
        World::new(&crate::scene::parser::parse(&text).unwrap(), &[]).unwrap()
    }

    #[test]
    fn where_any_structure_will_do_a_grid_is_built_if_it_pays() {
        let has_grid = |triangles, spheres, rays| {
            Structure::Any.resolution(&world(triangles, spheres), rays) == Some(Resolution::Auto)
        };
        assert_eq!(
            [(35, 0), (36, 0), (0, 3), (0, 4), (27, 1)].map(|(t, s)| has_grid(t, s, 32)),
            [false, true, false, true, true]
        );
        assert!(!has_grid(1000, 0, 31) && !has_grid(0, 0, 1000));
    }

    #[test]
    fn what_is_asked_for_is_built() {
        let world = world(1000, 0);
        assert_eq!(Structure::List.resolution(&world, 1000), None);
        for grid in [Resolution::Auto, Resolution::Cells([1, 2, 3])] {
            assert_eq!(Structure::Grid(grid).resolution(&world, 0), Some(grid));
        }
    }

    #[test]
    fn a_requested_number_of_cells_is_used_exactly() {
        assert_eq!(Resolution::Cells([5, 1, 9]).cells(&Aabb::EMPTY, 7, 7), [5, 1, 9]);
    }
}
