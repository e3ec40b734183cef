//! Filling the grid: in which cells each primitive stands.

use super::Lattice;
use super::budget::{Budget, TouchedCells};
use crate::math::aabb::Aabb;
use glam::DVec3;
use rayon::prelude::*;

/// The cells of each primitive.
#[derive(Clone, Debug)]
pub struct Rows {
    /// [`PER_RUN`] primitives each, but for the last.
    runs: Vec<Run>,
}

/// The cells of some primitives, one primitive's after the other's.
#[derive(Clone, Debug)]
struct Run {
    /// Where each primitive's cells end.
    ends: Vec<u32>,
    cells: Vec<u32>,
    /// What finding the cells has cost, in the units of a [`Budget`].
    cost: usize,
}

const PER_RUN: usize = 4096;

/// Why a grid cannot be built: its cells or their contents do not fit into memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridTooLarge;

impl std::fmt::Display for GridTooLarge {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "the grid does not fit into memory: use fewer cells")
    }
}

impl std::error::Error for GridTooLarge {}

impl Rows {
    /// Of the primitives numbered below `count`; `cells_of` appends the indices of one's cells. The
    /// cells are found on all threads, and the result depends on none.
    pub fn new(
        lattice: &Lattice,
        count: usize,
        cells_of: impl Fn(usize, &mut TouchedCells) -> Result<(), GridTooLarge> + Sync,
    ) -> Result<Self, GridTooLarge> {
        Self::within(&Budget::unlimited(), lattice, count, cells_of)
    }

    /// The same as far as a budget allows, or an error.
    pub fn within(
        budget: &Budget,
        lattice: &Lattice,
        count: usize,
        cells_of: impl Fn(usize, &mut TouchedCells) -> Result<(), GridTooLarge> + Sync,
    ) -> Result<Self, GridTooLarge> {
        lattice.fits()?;
        let runs: Vec<Run> = (0..Self::run_count(count))
            .into_par_iter()
            .map(|k| Run::new(budget, k * PER_RUN..count.min((k + 1) * PER_RUN), &cells_of))
            .collect::<Result<_, _>>()?;
        let rows = Self { runs };
        if rows.entries() <= u32::MAX as usize { Ok(rows) } else { Err(GridTooLarge) }
    }

    /// How many lists the cells of so many primitives are kept in.
    pub fn run_count(count: usize) -> usize {
        count.div_ceil(PER_RUN)
    }

    /// How many cells all primitives have together.
    pub fn entries(&self) -> usize {
        self.runs.iter().map(|run| run.cells.len()).sum()
    }

    /// What finding the cells has cost, in the units of a [`Budget`].
    pub fn cost(&self) -> usize {
        self.runs.iter().map(|run| run.cost).sum()
    }

    /// How many primitives each cell holds, by index.
    pub fn counts(&self, lattice: &Lattice) -> Result<Vec<u32>, GridTooLarge> {
        let mut counts = filled_with(0u32, lattice.index_count())?;
        for &cell in self.runs.iter().flat_map(|run| &run.cells) {
            counts[cell as usize] += 1;
        }
        Ok(counts)
    }

    /// Takes out the cells that hold more than `crowd` primitives, as [`counts`](Self::counts) has counted
    /// them; gives them in ascending order, with what they hold.
    pub fn take_crowded(
        &mut self,
        counts: &[u32],
        crowd: usize,
    ) -> Result<Vec<(u32, Vec<u32>)>, GridTooLarge> {
        let crowded = counts.iter().enumerate().filter(|&(_, &count)| count as usize > crowd);
        let mut crowded = crowded
            .map(|(cell, &count)| Ok((cell as u32, with_room_for(count as usize)?)))
            .collect::<Result<Vec<_>, _>>()?;
        if !crowded.is_empty() {
            for (run, first) in self.runs.iter_mut().zip((0..).step_by(PER_RUN)) {
                run.take(first, counts, crowd, &mut crowded);
            }
        }
        Ok(crowded)
    }

    /// The cells of all primitives numbered below `number`, in some pieces.
    pub fn cells_below(&self, number: usize) -> impl Iterator<Item = &[u32]> {
        self.runs.iter().enumerate().map_while(move |(k, run)| {
            let last = number.checked_sub(k * PER_RUN + 1)?.min(run.ends.len() - 1);
            Some(&run.cells[..run.ends[last] as usize])
        })
    }

    /// The indices of a primitive's cells.
    #[inline]
    pub fn cells_of(&self, number: usize) -> &[u32] {
        let Run { ends, cells, .. } = &self.runs[number / PER_RUN];
        let place = number % PER_RUN;
        let start = if place == 0 { 0 } else { ends[place - 1] };
        &cells[start as usize..ends[place] as usize]
    }
}

impl Run {
    fn new(
        budget: &Budget,
        numbers: std::ops::Range<usize>,
        cells_of: &impl Fn(usize, &mut TouchedCells) -> Result<(), GridTooLarge>,
    ) -> Result<Self, GridTooLarge> {
        let mut touched = TouchedCells::new(budget);
        touched.indices.reserve(4 * numbers.len());
        let mut ends = Vec::with_capacity(numbers.len());
        for number in numbers {
            let before = touched.indices.len();
            cells_of(number, &mut touched)?;
            touched.pay_entries(before)?;
            ends.push(touched.indices.len() as u32);
        }
        Ok(Self { ends, cost: touched.spent, cells: touched.indices })
    }

    /// Moves what stands in crowded cells from here to the list of its cell.
    fn take(&mut self, first: u32, counts: &[u32], crowd: usize, crowded: &mut [(u32, Vec<u32>)]) {
        let all = std::mem::take(&mut self.cells);
        let mut start = 0;
        for (number, end) in (first..).zip(&mut self.ends) {
            for &cell in &all[start..*end as usize] {
                if counts[cell as usize] as usize <= crowd {
                    self.cells.push(cell);
                } else if let Ok(place) = crowded.binary_search_by_key(&cell, |c| c.0) {
                    crowded[place].1.push(number);
                }
            }
            start = *end as usize;
            *end = self.cells.len() as u32;
        }
    }
}

/// A list of exactly this length, or an error where the memory is not to be had.
pub fn filled_with<T: Clone>(value: T, count: usize) -> Result<Vec<T>, GridTooLarge> {
    let mut list = with_room_for(count)?;
    list.resize(count, value);
    Ok(list)
}

/// An empty list for so many, or an error where the memory is not to be had.
pub fn with_room_for<T>(count: usize) -> Result<Vec<T>, GridTooLarge> {
    let mut list = Vec::new();
    list.try_reserve_exact(count).map_err(|_| GridTooLarge)?;
    Ok(list)
}

/// The box a little larger, so that no hit lies outside by rounding, and never flat.
pub fn widened(bounds: Aabb) -> Aabb {
    let extent = bounds.extent();
    let coordinate = bounds.min.abs().max(bounds.max.abs()).max_element();
    let largest = extent.max_element();
    // Powers of two, so that a scene scaled by a power of two has the same cells.
    let thinnest = (largest * 0.5f64.powi(10)).max(coordinate * 0.5f64.powi(30)).max(f64::MIN_POSITIVE);
    let margin = [0, 1, 2].map(|axis| {
        let flat = extent[axis] < thinnest;
        if flat { thinnest } else { extent[axis] * 0.5f64.powi(20) }
    });
    let margin = DVec3::from_array(margin);
    Aabb { min: bounds.min - margin, max: bounds.max + margin }
}

#[cfg(test)]
mod tests {
    use super::super::voxelize;
    use super::*;

    #[test]
    fn rows_hold_the_cells_of_each_box() {
        let boxes: Vec<Aabb> = (0..10_000)
            .map(|i| DVec3::new((i * 7 % 20) as f64, (i * 3 % 20) as f64, 0.0))
            .map(|p| Aabb { min: p, max: p + 1.0 })
            .collect();
        let lattice =
            Lattice::new(widened(Aabb { min: DVec3::ZERO, max: DVec3::new(20.0, 20.0, 1.0) }), [7, 5, 2]);
        let rows =
            Rows::new(&lattice, boxes.len(), |i, out| voxelize::of_box(&lattice, &boxes[i], 1e-6, out))
                .unwrap();
        let below = |number| rows.cells_below(number).flatten().count();
        assert_eq!(below(0), 0);
        let mut cells = 0;
        for (i, b) in boxes.iter().enumerate() {
            let budget = Budget::unlimited();
            let mut expected = TouchedCells::new(&budget);
            voxelize::of_box(&lattice, b, 1e-6, &mut expected).unwrap();
            assert_eq!(rows.cells_of(i), expected.indices);
            cells += expected.indices.len();
            assert_eq!(below(i + 1), cells);
        }
    }

    #[test]
    fn a_flat_or_single_point_scene_still_has_cells() {
        for p in [DVec3::ZERO, DVec3::splat(3.0), DVec3::new(1.0, 2.0, 0.0)] {
            let lattice = Lattice::new(widened(Aabb { min: DVec3::ZERO, max: p }), [3, 3, 3]);
            assert!(lattice.cell_size.min_element() > 0.0);
        }
    }

    #[test]
    fn a_widened_box_is_larger_by_little_on_all_sides_and_thin_nowhere() {
        let bounds = Aabb { min: DVec3::new(-1.0, 3.0, 5.0), max: DVec3::new(1.0, 4.0, 5.0) };
        let wide = widened(bounds);
        let [below, above] = [bounds.min - wide.min, wide.max - bounds.max];
        assert_eq!(below, DVec3::new(2.0 / 1048576.0, 1.0 / 1048576.0, 2.0 / 1024.0));
        assert_eq!(below, above);
        // Far from the origin, where coordinates are coarse.
        let far = DVec3::new(1.0, -1048576.0, 2.0);
        let wide = widened(Aabb { min: far, max: far });
        assert_eq!(
            (far - wide.min, wide.max - far),
            (DVec3::splat(1.0 / 1024.0), DVec3::splat(1.0 / 1024.0))
        );
    }

    /// Two runs of primitives, of which all but a few stand in cells of their own.
    #[test]
    fn crowded_cells_are_taken_out_with_what_they_hold() {
        let lattice = Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::ONE }, [20, 20, 20]);
        let (crowd, count) = (3, PER_RUN + 100);
        let cells_of = |number: usize| -> Vec<u32> {
            let own = 100 + number as u32 % 2000;
            if number.is_multiple_of(1000) { vec![7, own, 9] } else { vec![own] }
        };
        let mut rows = Rows::new(&lattice, count, |number, out| {
            cells_of(number).into_iter().for_each(|cell| out.push(cell));
            Ok(())
        })
        .unwrap();
        let counts = rows.counts(&lattice).unwrap();
        let holders = |cell: u32| (0..count as u32).filter(move |&n| cells_of(n as usize).contains(&cell));
        for (cell, &held) in counts.iter().enumerate().step_by(37).chain(counts.iter().enumerate().take(20)) {
            assert_eq!(held as usize, holders(cell as u32).count(), "{cell}");
        }
        let taken = rows.take_crowded(&counts, crowd).unwrap();
        let crowded: Vec<u32> = (0..counts.len() as u32).filter(|&c| counts[c as usize] > 3).collect();
        assert_eq!(taken.iter().map(|(cell, _)| *cell).collect::<Vec<_>>(), crowded);
        assert_eq!(crowded, [7, 9]);
        for (cell, held) in &taken {
            assert_eq!(*held, holders(*cell).collect::<Vec<_>>());
        }
        for number in 0..count {
            let left: Vec<u32> = cells_of(number).into_iter().filter(|c| !crowded.contains(c)).collect();
            assert_eq!(rows.cells_of(number), left, "{number}");
        }
        assert_eq!(rows.entries(), count);
        assert_eq!(rows.cost(), super::super::budget::ENTRY_COST * (count + 2 * 5));
    }

    #[test]
    fn an_absurd_grid_is_an_error() {
        let unit = Aabb { min: DVec3::ZERO, max: DVec3::ONE };
        let lattice = Lattice::new(unit, [1 << 20, 1 << 20, 1 << 20]);
        assert_eq!(Rows::new(&lattice, 0, |_, _| Ok(())).err(), Some(GridTooLarge));
    }
}
