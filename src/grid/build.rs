//! Filling the grid: which primitives stand in which cell, as compressed rows.

use super::Lattice;
use crate::math::aabb::Aabb;
use crate::math::robust::UNIT_ROUNDOFF;
use glam::DVec3;

/// How far beyond its box a primitive is inserted, in cells. It covers the marcher's drift (below
/// 1e-9 cell, see [`super::march`]) and the rounding of a hit, with room for three digits.
pub const PADDING: f64 = 1e-6;

/// The primitives of each cell, by their numbers, in increasing order.
#[derive(Clone, Debug)]
pub struct Grid {
    pub lattice: Lattice,
    /// Where each cell's numbers start in `items`, and one more for the end.
    starts: Vec<u32>,
    items: Vec<u32>,
    /// A ray that begins farther out than this is placed less exactly than the padding allows.
    pub farthest_origin: f64,
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

impl Grid {
    /// Cuts `bounds` into cells and enters the boxes, numbered from 0. Two passes: the first counts,
    /// so that the second fills buffers of exactly the right size.
    pub fn new(bounds: Aabb, cells: [usize; 3], boxes: &[Aabb]) -> Result<Self, GridTooLarge> {
        let lattice = Lattice::new(widened(bounds), cells);
        let mut starts = zeros(lattice.cell_count() + 1)?;
        let mut total = 0u64;
        for b in boxes {
            lattice.for_each_cell(b, PADDING, |cell| {
                starts[cell] += 1;
                total += 1;
            });
        }
        let mut items = zeros(u32::try_from(total).map_err(|_| GridTooLarge)? as usize)?;
        let mut end = 0;
        for start in &mut starts {
            end += *start;
            *start = end;
        }
        // Filled from the back, so that every start walks down to its place and numbers ascend.
        for (number, b) in boxes.iter().enumerate().rev() {
            lattice.for_each_cell(b, PADDING, |cell| {
                starts[cell] -= 1;
                items[starts[cell] as usize] = number as u32;
            });
        }
        let farthest_origin = PADDING * lattice.cell_size.min_element() / (8.0 * UNIT_ROUNDOFF);
        Ok(Self { lattice, starts, items, farthest_origin })
    }

    /// The numbers of the primitives in a cell, in increasing order.
    pub fn items(&self, cell: usize) -> &[u32] {
        &self.items[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }
}

/// A zeroed buffer, or an error where the memory is not to be had.
fn zeros(len: usize) -> Result<Vec<u32>, GridTooLarge> {
    let mut buffer = Vec::new();
    buffer.try_reserve_exact(len).map_err(|_| GridTooLarge)?;
    buffer.resize(len, 0);
    Ok(buffer)
}

/// The box a little larger, so that no hit lies outside by rounding, and never flat.
fn widened(bounds: Aabb) -> Aabb {
    let extent = bounds.extent();
    let coordinate = bounds.min.abs().max(bounds.max.abs()).max_element();
    let largest = extent.max_element();
    // Powers of two, so that a scene scaled by a power of two has the same cells.
    let thinnest = (largest * 0.5f64.powi(10)).max(coordinate * 0.5f64.powi(30)).max(f64::MIN_POSITIVE);
    let margin = DVec3::from_array([0, 1, 2].map(|axis| {
        let flat = extent[axis] < thinnest;
        if flat { thinnest } else { extent[axis] * 0.5f64.powi(20) }
    }));
    Aabb { min: bounds.min - margin, max: bounds.max + margin }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_boxes(n: usize) -> Vec<Aabb> {
        (0..n)
            .map(|i| DVec3::new(i as f64, (i * 7 % n) as f64, 0.0))
            .map(|p| Aabb { min: p, max: p + 1.0 })
            .collect()
    }

    #[test]
    fn a_box_stands_in_every_cell_it_touches_and_in_no_other() {
        let boxes = unit_boxes(20);
        let bounds = boxes.iter().fold(Aabb::EMPTY, |a, &b| a.union(b));
        let grid = Grid::new(bounds, [7, 5, 1], &boxes).unwrap();
        let l = &grid.lattice;
        for z in 0..1 {
            for y in 0..5 {
                for x in 0..7 {
                    let min = l.bounds.min + l.cell_size * DVec3::new(x as f64, y as f64, z as f64);
                    let max = min + l.cell_size;
                    // Padded by nothing, and by twice the padding.
                    let touching = |pad: DVec3| -> Vec<u32> {
                        let touches =
                            |b: &Aabb| (b.min - pad).cmple(max).all() && (b.max + pad).cmpge(min).all();
                        (0..20u32).filter(|&i| touches(&boxes[i as usize])).collect()
                    };
                    let items = grid.items(l.index([x, y, z]));
                    assert!(touching(DVec3::ZERO).iter().all(|i| items.contains(i)));
                    assert!(items.iter().all(|i| touching(2.0 * PADDING * l.cell_size).contains(i)));
                    assert!(items.is_sorted());
                }
            }
        }
    }

    #[test]
    fn a_flat_or_single_point_scene_still_has_cells() {
        for p in [DVec3::ZERO, DVec3::splat(3.0), DVec3::new(1.0, 2.0, 0.0)] {
            let b = Aabb { min: DVec3::ZERO, max: p };
            let grid = Grid::new(b, [3, 3, 3], &[b]).unwrap();
            assert!(grid.lattice.cell_size.min_element() > 0.0);
            assert!((0..27).any(|c| !grid.items(c).is_empty()));
        }
    }

    #[test]
    fn an_absurd_grid_is_an_error() {
        let b = Aabb { min: DVec3::ZERO, max: DVec3::ONE };
        let huge = Grid::new(b, [1 << 20, 1 << 20, 1 << 20], &[b]);
        assert_eq!(huge.err(), Some(GridTooLarge));
    }
}
