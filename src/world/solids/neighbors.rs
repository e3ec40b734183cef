//! Finds the boxes that overlap, by a uniform grid.

use crate::math::aabb::Aabb;
use glam::DVec3;
use std::ops::Range;

/// The maximum number of cells for each box, and of times that a box is listed, on average.
const MAX_CELLS: f64 = 4.0;
const MAX_REFERENCES: usize = 32;

/// Whether a condition holds for all pairs of boxes that overlap. Also false if the boxes would be listed too often.
pub fn all_overlapping(boxes: &[Aabb], mut holds: impl FnMut(usize, usize) -> bool) -> bool {
    let grid = Grid::around(boxes);
    let cells = grid.cells.iter().product::<usize>();
    let mut ends: Vec<u32> = vec![0; cells + 1];
    let mut references = 0;
    for cell in boxes.iter().flat_map(|bounds| grid.cells_of(bounds)) {
        ends[cell + 1] += 1;
        references += 1;
        if references > MAX_REFERENCES * boxes.len() {
            return false;
        }
    }
    (0..cells).for_each(|cell| ends[cell + 1] += ends[cell]);
    let mut listed: Vec<u32> = vec![0; references];
    for (bounds, id) in boxes.iter().zip(0..) {
        for cell in grid.cells_of(bounds) {
            listed[ends[cell] as usize] = id;
            ends[cell] += 1;
        }
    }
    // Now each entry is the end of its cell's list.
    let list = |cell: usize| if cell == 0 { 0 } else { ends[cell - 1] as usize }..ends[cell] as usize;
    (0..cells).all(|cell| all_in_cell(&grid, boxes, (cell, &listed[list(cell)]), &mut holds))
}

/// The same for the pairs of one cell's list. A pair counts in the cell of the first corner of what its boxes share.
fn all_in_cell(
    grid: &Grid,
    boxes: &[Aabb],
    (cell, listed): (usize, &[u32]),
    holds: &mut impl FnMut(usize, usize) -> bool,
) -> bool {
    for (k, &one) in listed.iter().enumerate() {
        let bounds = boxes[one as usize];
        for &other in &listed[k + 1..] {
            let with = &boxes[other as usize];
            let (min, max) = (bounds.min.max(with.min), bounds.max.min(with.max));
            if min.cmple(max).all()
                && grid.index(grid.cell(min)) == cell
                && !holds(one as usize, other as usize)
            {
                return false;
            }
        }
    }
    true
}

/// A box divided into equal cells.
struct Grid {
    min: DVec3,
    per_length: f64,
    cells: [usize; 3],
}

impl Grid {
    fn around(boxes: &[Aabb]) -> Self {
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, &bounds| all.union(bounds));
        let count = boxes.len() as f64;
        let mean = boxes.iter().map(|bounds| bounds.extent().max_element()).sum::<f64>() / count;
        let cells = |size: f64| (bounds.extent() / size).to_array().map(|n| (1.0 + n.floor()).max(1.0));
        let mut size = f64::max(mean, bounds.extent().max_element() / count);
        while cells(size).iter().product::<f64>() > MAX_CELLS * count + 8.0 {
            size *= 1.25;
        }
        Self { min: bounds.min, per_length: 1.0 / size, cells: cells(size).map(|n| n as usize) }
    }

    /// The cell of a point. It depends on each coordinate alone, and does not fall with it.
    fn cell(&self, point: DVec3) -> [usize; 3] {
        let cell = (point - self.min) * self.per_length;
        [0, 1, 2].map(|i| (cell[i] as usize).min(self.cells[i] - 1))
    }

    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.cells[0] * (j + self.cells[1] * k)
    }

    /// The indices of the cells that a box may touch.
    fn cells_of(&self, bounds: &Aabb) -> impl Iterator<Item = usize> + '_ {
        let [first, last] = [bounds.min, bounds.max].map(|corner| self.cell(corner));
        let [x, y, z]: [Range<usize>; 3] = [0, 1, 2].map(|i| first[i]..last[i] + 1);
        z.flat_map(move |k| y.clone().map(move |j| (j, k)))
            .flat_map(move |(j, k)| x.clone().map(move |i| self.index([i, j, k])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_of_boxes_that_overlap_is_seen_once() {
        let fraction = |k: usize, step: f64| (k as f64 * step).fract();
        for (count, size) in [(1, 0.1), (2, 2.0), (400, 0.05), (400, 0.3)] {
            let corner =
                |k| DVec3::new(fraction(k, 0.618), 3.0 * fraction(k, 0.324), 0.1 * fraction(k, 0.754));
            let extent = |k| size * DVec3::new(fraction(k, 0.21), fraction(k, 0.43), 0.1).powf(2.0);
            let boxes: Vec<Aabb> =
                (0..count).map(|k| Aabb { min: corner(k), max: corner(k) + extent(k) }).collect();
            let overlap = |i: usize, j: usize| {
                boxes[i].min.cmple(boxes[j].max).all() && boxes[j].min.cmple(boxes[i].max).all()
            };
            let mut found = vec![];
            assert!(all_overlapping(&boxes, |i, j| {
                found.push((i.min(j), i.max(j)));
                true
            }));
            found.sort_unstable();
            let expected: Vec<_> = (0..count)
                .flat_map(|i| (i + 1..count).map(move |j| (i, j)))
                .filter(|&(i, j)| overlap(i, j))
                .collect();
            assert_eq!(found, expected, "{count} {size}");
            assert_eq!(all_overlapping(&boxes, |_, _| false), expected.is_empty());
        }
    }

    #[test]
    fn boxes_that_would_be_listed_too_often_are_not_compared() {
        let speck = |x: f64| Aabb { min: DVec3::splat(x), max: DVec3::splat(x) };
        let boxes = |large: usize| -> Vec<Aabb> {
            let whole = Aabb { min: DVec3::ZERO, max: DVec3::ONE };
            (0..1000).map(|k| if k < large { whole } else { speck(k as f64 / 1e3) }).collect()
        };
        assert!(all_overlapping(&boxes(0), |_, _| true));
        assert!(all_overlapping(&boxes(1), |_, _| true));
        assert!(!all_overlapping(&boxes(40), |_, _| true));
    }
}
