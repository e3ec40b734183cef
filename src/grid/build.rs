//! Filling the grid: which primitives stand in which cell, as compressed rows.

use super::Lattice;
use crate::math::aabb::Aabb;
use glam::DVec3;
use rayon::prelude::*;

/// The numbers of the primitives in each cell.
#[derive(Clone, Debug)]
pub struct Rows {
    /// Where each index' numbers start in `items`, and one more for the end.
    starts: Vec<u32>,
    items: Vec<u32>,
}

/// Why a grid cannot be built: its cells or their contents do not fit into memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridTooLarge;

impl std::fmt::Display for GridTooLarge {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "the grid does not fit into memory: use fewer cells")
    }
}

impl std::error::Error for GridTooLarge {}

/// The cells of a run of primitives: how many cells each has, and the cells one after the other.
struct Run {
    first: usize,
    counts: Vec<u32>,
    cells: Vec<u32>,
}

impl Rows {
    /// Enters the primitives numbered below `count`; `cells_of` appends the indices of one's cells.
    ///
    /// The cells are found on all threads. Then they are counted, and buffers of exactly the right
    /// size are filled, in the order of the numbers, so that the result depends on no thread.
    pub fn new(
        lattice: &Lattice,
        count: usize,
        cells_of: impl Fn(usize, &mut Vec<u32>) + Sync,
    ) -> Result<Self, GridTooLarge> {
        const PER_RUN: usize = 4096;
        lattice.fits()?;
        let runs: Vec<Run> = (0..count.div_ceil(PER_RUN))
            .into_par_iter()
            .map(|k| Run::new(k * PER_RUN..count.min((k + 1) * PER_RUN), &cells_of))
            .collect();
        let mut starts = zeros(lattice.index_count() + 1)?;
        for &cell in runs.iter().flat_map(|run| &run.cells) {
            starts[cell as usize + 1] += 1;
        }
        let mut total = 0u64;
        for start in &mut starts {
            total += *start as u64;
            *start = u32::try_from(total).map_err(|_| GridTooLarge)?;
        }
        let mut items = zeros(total as usize)?;
        runs.iter().for_each(|run| run.scatter(&mut starts, &mut items));
        // Every start has walked to the next one's place.
        starts.rotate_right(1);
        starts[0] = 0;
        Ok(Self { starts, items })
    }

    /// The numbers in a cell, in increasing order.
    pub fn items(&self, index: usize) -> &[u32] {
        &self.items[self.starts[index] as usize..self.starts[index + 1] as usize]
    }
}

impl Run {
    fn new(numbers: std::ops::Range<usize>, cells_of: &impl Fn(usize, &mut Vec<u32>)) -> Self {
        let first = numbers.start;
        let mut cells = Vec::with_capacity(4 * numbers.len());
        let mut counts = Vec::with_capacity(numbers.len());
        for number in numbers {
            let before = cells.len();
            cells_of(number, &mut cells);
            counts.push((cells.len() - before) as u32);
        }
        Self { first, counts, cells }
    }

    fn scatter(&self, starts: &mut [u32], items: &mut [u32]) {
        let mut cells = self.cells.iter();
        for (i, &count) in self.counts.iter().enumerate() {
            for &cell in cells.by_ref().take(count as usize) {
                let place = &mut starts[cell as usize];
                items[*place as usize] = (self.first + i) as u32;
                *place += 1;
            }
        }
    }
}

/// A zeroed buffer, or an error where the memory is not to be had.
fn zeros(len: usize) -> Result<Vec<u32>, GridTooLarge> {
    // Asked for first, since a zeroed allocation aborts where it fails.
    Vec::<u32>::new().try_reserve_exact(len).map_err(|_| GridTooLarge)?;
    Ok(vec![0; len])
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
    use super::super::footprint;
    use super::*;

    #[test]
    fn rows_hold_each_box_in_the_cells_it_touches_in_order() {
        let boxes: Vec<Aabb> = (0..10_000)
            .map(|i| DVec3::new((i * 7 % 20) as f64, (i * 3 % 20) as f64, 0.0))
            .map(|p| Aabb { min: p, max: p + 1.0 })
            .collect();
        let lattice =
            Lattice::new(widened(Aabb { min: DVec3::ZERO, max: DVec3::new(20.0, 20.0, 1.0) }), [7, 5, 2]);
        let rows =
            Rows::new(&lattice, boxes.len(), |i, out| footprint::of_box(&lattice, &boxes[i], 1e-6, out))
                .unwrap();
        for index in 0..lattice.index_count() {
            let mut expected = vec![];
            for (i, b) in boxes.iter().enumerate() {
                let mut cells = vec![];
                footprint::of_box(&lattice, b, 1e-6, &mut cells);
                if cells.contains(&(index as u32)) {
                    expected.push(i as u32);
                }
            }
            assert_eq!(rows.items(index), expected);
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
    fn an_absurd_grid_is_an_error() {
        let unit = Aabb { min: DVec3::ZERO, max: DVec3::ONE };
        let lattice = Lattice::new(unit, [1 << 20, 1 << 20, 1 << 20]);
        assert_eq!(Rows::new(&lattice, 0, |_, _| {}).err(), Some(GridTooLarge));
    }
}
