//! How the finite primitives are arranged for rays: in one list, in a uniform grid, in an automatic one, or as the
//! course's program does. This is the only place that decides.

use crate::math::aabb::Aabb;
use crate::world::World;

/// Which cells a primitive is entered in. More cells change no hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellRule {
    /// Those it touches.
    Exact,
    /// Those it touches, in a grid that is no finer than a bound on its size allows, in which a cell with
    /// more than `max_per_cell` primitives is cut into cells of its own where these separate them.
    Nested {
        /// More primitives than this in a cell are a crowd.
        max_per_cell: usize,
    },
    /// Those that the course's program enters it in, for counters that compare with the course's.
    Course {
        /// Whether the grid is no finer than a bound on its size allows.
        is_bounded: bool,
    },
}

/// How the finite primitives are arranged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridOptions {
    /// Cells along each axis; none for a list of everything.
    pub cells: Option<[usize; 3]>,
    /// Which of them a primitive is entered in.
    pub rule: CellRule,
}

impl GridOptions {
    /// A list of everything.
    pub const NONE: Self = Self { cells: None, rule: CellRule::Exact };

    /// A grid of just these cells.
    pub fn uniform(cells: [usize; 3]) -> Self {
        Self { cells: Some(cells), rule: CellRule::Exact }
    }

    /// The fastest arrangement of a world for about so many rays, building included.
    pub fn automatic(world: &World, rays: usize) -> Self {
        let count = world.finite_count();
        let cells = Resolution::Auto.cells(&world.bounds, count, rays);
        Self { cells: Some(cells), rule: CellRule::Nested { max_per_cell: max_per_cell(count, rays) } }
    }

    /// What is asked for, in a world for about so many rays; with cells entered as the course's program enters
    /// them where counters are to compare with the course's.
    pub fn new(asked: Option<Resolution>, world: &World, rays: usize, as_course: bool) -> Self {
        let options = match asked {
            None => Self::NONE,
            Some(Resolution::Cells(cells)) => Self::uniform(cells),
            Some(Resolution::Auto) => Self::automatic(world, rays),
        };
        let is_bounded = asked == Some(Resolution::Auto);
        if as_course { Self { rule: CellRule::Course { is_bounded }, ..options } } else { options }
    }
}

/// The number of cells along each axis, as asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resolution {
    /// Taken literally, whatever it costs.
    Cells([usize; 3]),
    /// As the scene and the number of rays suggest.
    Auto,
}

impl Resolution {
    /// The cells for `count` primitives in a box and about so many rays.
    ///
    /// Cubic cells, one for each primitive: measured, half or twice as many cost a few percent, and
    /// eight times as many a quarter. With so few rays that filling the cells counts, 0.4 for each.
    /// Many rays through many primitives want few cells, which are crowded and cut again, each to fit
    /// what it holds: at 2.5 million rays are 24 to 46% faster, and building takes 1.5 to 2.3 times as long.
    pub fn cells(self, bounds: &Aabb, count: usize, rays: usize) -> [usize; 3] {
        const MANY_BLOCKS: usize = 200_000;
        let per_primitive = match self {
            Self::Cells(cells) => return cells,
            Self::Auto if rays < MANY_RAYS * count => 0.4,
            Self::Auto if count < MANY_BLOCKS => 1.0,
            Self::Auto => 1.0 / 1024.0,
        };
        cubic(bounds, per_primitive * count as f64)
    }
}

/// From so many rays for each primitive on, what a ray takes counts more than filling the cells.
const MANY_RAYS: usize = 8;

/// How many primitives a cell may hold before it pays to cut it again.
///
/// 96 is five times what the cells of an even mesh of 40,000 hold that hold any. Where few rays come,
/// only a cell is cut that would take each of them microseconds.
fn max_per_cell(count: usize, rays: usize) -> usize {
    if rays < MANY_RAYS * count { 2048 } else { 96 }
}

/// About `total` cubic cells. A box that is flat in comparison to its largest side counts as a
/// little thick, so that a flat scene is cut along its two sides.
pub fn cubic(bounds: &Aabb, total: f64) -> [usize; 3] {
    const FLAT: f64 = 1e-3;
    let extent = bounds.extent();
    let largest = extent.max_element();
    if bounds.is_empty() || largest == 0.0 {
        return [1; 3];
    }
    // In units of the largest side, whose powers may leave the range of floats.
    let sides = (extent / largest).max(glam::DVec3::splat(FLAT)).to_array();
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
    fn about_a_cell_for_each_primitive() {
        assert_eq!(auto(DVec3::ONE, 1000, 1_000_000), [10, 10, 10]);
        assert_eq!(auto(DVec3::new(4.0, 2.0, 1.0), 8000, 1_000_000), [40, 20, 10]);
        let few_rays: usize = auto(DVec3::ONE, 40_000, 40_000).iter().product();
        assert!((12_000..20_000).contains(&few_rays));
    }

    #[test]
    fn flat_and_empty_scenes() {
        assert_eq!(auto(DVec3::new(1.0, 0.0, 1.0), 1000, 1_000_000), [100, 1, 100]);
        assert_eq!(auto(DVec3::ZERO, 5, 100), [1; 3]);
        assert_eq!(Resolution::Auto.cells(&Aabb::EMPTY, 0, 100), [1; 3]);
    }

    #[test]
    fn a_side_counts_as_at_least_a_thousandth_of_the_largest() {
        // Ten layers of cells, each a tenth as thick as the box counts.
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
    fn eight_rays_for_each_primitive_are_many() {
        assert_eq!(auto(DVec3::ONE, 2160, 8 * 2160 - 1), [10; 3]);
        assert_eq!(auto(DVec3::ONE, 2197, 8 * 2197), [13; 3]);
        assert!(max_per_cell(1000, 7999) > max_per_cell(1000, 8000));
    }

    #[test]
    fn many_rays_through_many_primitives_want_crowded_cells() {
        assert_eq!(auto(DVec3::ONE, 216 * 1024, 1 << 30), [6; 3]);
        assert_eq!(auto(DVec3::ONE, 125_000, 1 << 30), [50; 3]);
    }

    #[test]
    fn few_rays_want_few_grids_within_grids() {
        assert!(max_per_cell(1_000_000, 1_000_000) > max_per_cell(1_000_000, 100_000_000));
    }

    #[test]
    fn cells_are_taken_literally() {
        assert_eq!(Resolution::Cells([5, 1, 9]).cells(&Aabb::EMPTY, 7, 7), [5, 1, 9]);
    }
}
