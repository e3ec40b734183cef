//! The number of primitives in each cell of a grid, and from it the steps that the course's program takes along a ray.
//! They are counted apart from the search for the hit, which leaves out primitives that no ray sees.

use crate::base::patience::{Ended, Patience, Steps};
use crate::caster::bounds::{Entry, Region};
use crate::caster::dda::Dda;
use crate::caster::insertion::{bounds_of, push_cells, runs_of_box};
use crate::caster::lattice::{Lattice, NotBuilt};
use crate::math::aabb::Aabb;
use crate::math::ray::Ray;
use crate::world::World;
use fearless_simd::Simd;
use std::cmp::Reverse;

/// The number of primitives in each cell of a lattice.
#[derive(Debug)]
pub struct CellCounts {
    /// The cells.
    pub lattice: Lattice,
    region: Region,
    /// The counts by the index of the cell, with [`BORDER`] in the cells around the lattice.
    counts: Vec<u32>,
}

const BORDER: u32 = u32::MAX;

/// The steps that the course's program takes along a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CourseSteps {
    /// Tests against a primitive.
    pub tests: u64,
    /// Steps from one cell to the next, or out of the grid.
    pub cells: u64,
}

/// How full the cells of a grid are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fullness {
    /// The fullest cells by their indices along the axes, each with its number of primitives. Equally full cells are in
    /// ascending order of their indices, along z before y before x.
    pub fullest: Vec<([usize; 3], usize)>,
    /// Cells without a primitive.
    pub empty: usize,
    /// All cells.
    pub cells: usize,
}

impl CellCounts {
    /// Returns counts of zero.
    pub fn empty(lattice: Lattice) -> Result<Self, NotBuilt> {
        lattice.ask_for_entries()?;
        let mut counts = vec![BORDER; lattice.index_count()];
        lattice.x_runs().for_each(|run| counts[run].fill(0));
        let region = Region::new(&lattice.bounds, lattice.cell_size.min_element());
        Ok(Self { lattice, region, counts })
    }

    /// Counts the finite primitives of a world in this number of cells along each axis, as long as there is patience.
    pub fn of_world(world: &World, cells: [usize; 3], patience: &dyn Patience) -> Result<Self, NotBuilt> {
        let mut all = Self::empty(Lattice::new(bounds_of(world), cells))?;
        let (mut own, mut steps) = (vec![], Steps::new(patience));
        for id in 0..world.finite_count() as u32 {
            own.clear();
            push_cells(world, id, &all.lattice, &mut own);
            all.add(&own);
            steps.take(1 + own.len())?;
        }
        Ok(all)
    }

    /// Adds a primitive to some cells.
    pub fn add(&mut self, cells: &[u32]) {
        cells.iter().for_each(|&cell| self.counts[cell as usize] += 1);
    }

    /// Adds a primitive to the cells that a box touches, each padded by `padding` cells.
    pub fn add_box(&mut self, bounds: &Aabb, padding: f64, steps: &mut Steps) -> Result<(), Ended> {
        // A list of the cells would take as much memory as all counts.
        for run in runs_of_box(&self.lattice, bounds, padding) {
            steps.take(1 + run.len() / 8)?;
            self.counts[run].iter_mut().for_each(|count| *count += 1);
        }
        Ok(())
    }

    /// Returns the number of primitives in a cell, or `None` on the border.
    #[inline(always)]
    pub fn at(&self, index: usize) -> Option<u32> {
        self.counts.get(index).copied().filter(|&count| count != BORDER)
    }

    /// Returns how full the cells are, with this number of the fullest.
    pub fn fullness(&self, fullest: usize) -> Fullness {
        let [nx, ny, nz] = self.lattice.cells();
        let all = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        let count = |cell: [usize; 3]| self.counts[self.lattice.index(cell)] as usize;
        let mut full: Vec<_> = all.map(|cell| (cell, count(cell))).filter(|(_, count)| *count > 0).collect();
        let cells = nx * ny * nz;
        let empty = cells - full.len();
        full.sort_by_key(|&(_, count)| Reverse(count));
        full.truncate(fullest);
        Fullness { fullest: full, empty, cells }
    }

    /// Returns the steps along a ray whose nearest hit is at `t`, or which ends there. The course's program tests all
    /// primitives of a cell, and ends after the cell in which the nearest hit lies. `last` is the t up to which others
    /// may lie in the place of the nearest hit.
    #[inline(always)]
    pub fn steps<S: Simd>(&self, simd: S, world: &World, ray: &Ray, t: f64, last: f64) -> CourseSteps {
        match self.region.entry(simd, ray, ray.t_max) {
            Entry::TooFar => CourseSteps { tests: world.finite_count() as u64, cells: 0 },
            Entry::Passes(interval) if interval.entry <= last => {
                let mut dda = Dda::new(&self.lattice, &interval);
                let (end, mut steps) = (dda.fixed_t(t), CourseSteps::default());
                while let Some(count) = self.at(dda.index()) {
                    steps.tests += u64::from(count);
                    if end <= dda.exit() {
                        break;
                    }
                    steps.cells += u64::from(3 - dda.step().count_ones());
                }
                steps
            }
            _ => CourseSteps::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::patience::Endless;
    use crate::scene::parser::parse;

    /// Three crossed triangles near the origin and one triangle far away, with a small sphere beside it.
    fn crossed() -> World {
        let triangle =
            |p: &str, q: &str, r: &str| format!("Triangle {{ vertex0 {p} vertex1 {q} vertex2 {r} }}");
        let objects = [
            triangle("0.1 0.1 0.1", "0.4 0.1 0.1", "0.1 0.4 0.1"),
            triangle("0.1 0.1 0.1", "0.4 0.1 0.1", "0.1 0.1 0.4"),
            triangle("0.1 0.1 0.1", "0.1 0.4 0.1", "0.1 0.1 0.4"),
            triangle("3.6 3.6 3.6", "3.9 3.6 3.6", "3.6 3.9 3.9"),
            "Sphere { center 3.8 3.8 3.8 radius 0.1 }".into(),
        ];
        let text = format!(
            "OrthographicCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 0 size 5 }}
             Materials {{ numMaterials 1 Material {{ }} }}
             Group {{ numObjects 5 MaterialIndex 0 {} }}",
            objects.join(" ")
        );
        World::new(&parse(&text).unwrap(), &[]).unwrap()
    }

    #[test]
    fn the_fullest_cells_come_first() {
        let world = crossed();
        let counts = CellCounts::of_world(&world, [4, 4, 4], &Endless).unwrap();
        let expected = Fullness { fullest: vec![([0; 3], 3), ([3; 3], 2)], empty: 62, cells: 64 };
        assert_eq!(counts.fullness(5), expected);
        assert_eq!(counts.fullness(1), Fullness { fullest: vec![([0; 3], 3)], ..expected.clone() });
    }
}
