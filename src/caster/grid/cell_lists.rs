//! The cells of each primitive: the result of insertion, before the primitives are laid out by cell.

use crate::caster::error::GridTooLarge;
use crate::caster::grid::lattice::Lattice;
use crate::caster::grid::touched_cells::TouchedCells;
use crate::math::aabb::Aabb;
use glam::DVec3;
use rayon::prelude::*;

/// The cells of each primitive.
#[derive(Clone, Debug)]
pub struct CellLists {
    /// Chunks of [`PRIMS_PER_CHUNK`] primitives; the last one may be smaller.
    chunks: Vec<Chunk>,
}

/// The cells of consecutive primitives, primitive by primitive.
#[derive(Clone, Debug)]
struct Chunk {
    /// The end of each primitive's cells in `cells`.
    ends: Vec<u32>,
    /// Indices of the lattice.
    cells: Vec<u32>,
}

/// The number of primitives that one task inserts.
const PRIMS_PER_CHUNK: usize = 4096;

impl CellLists {
    /// The lists of primitives 0 to `count`, excluding `count`; `cells_of` appends the cells of one of them.
    /// The work is done on all threads, and the result does not depend on their number.
    pub fn new(
        lattice: &Lattice,
        count: usize,
        cells_of: impl Fn(usize, &mut TouchedCells) + Sync,
    ) -> Result<Self, GridTooLarge> {
        lattice.ask_for_entries()?;
        let chunks: Vec<Chunk> = (0..count.div_ceil(PRIMS_PER_CHUNK))
            .into_par_iter()
            .map(|k| Chunk::new(k * PRIMS_PER_CHUNK..count.min((k + 1) * PRIMS_PER_CHUNK), &cells_of))
            .collect();
        let cell_lists = Self { chunks };
        if cell_lists.references() <= u32::MAX as usize { Ok(cell_lists) } else { Err(GridTooLarge) }
    }

    /// The number of references: the cells of all primitives together.
    pub fn references(&self) -> usize {
        self.chunks.iter().map(|chunk| chunk.cells.len()).sum()
    }

    /// The cells of all primitives before `id`, as slices.
    pub fn cells_below(&self, id: usize) -> impl Iterator<Item = &[u32]> {
        self.chunks.iter().enumerate().map_while(move |(k, chunk)| {
            let last = id.checked_sub(k * PRIMS_PER_CHUNK + 1)?.min(chunk.ends.len() - 1);
            Some(&chunk.cells[..chunk.ends[last] as usize])
        })
    }

    /// The indices of a primitive's cells.
    #[inline]
    pub fn cells_of(&self, id: usize) -> &[u32] {
        let Chunk { ends, cells, .. } = &self.chunks[id / PRIMS_PER_CHUNK];
        let i = id % PRIMS_PER_CHUNK;
        let start = if i == 0 { 0 } else { ends[i - 1] };
        &cells[start as usize..ends[i] as usize]
    }
}

impl Chunk {
    fn new(ids: std::ops::Range<usize>, cells_of: &impl Fn(usize, &mut TouchedCells)) -> Self {
        let mut touched = TouchedCells { indices: Vec::with_capacity(4 * ids.len()) };
        let mut ends = Vec::with_capacity(ids.len());
        for id in ids {
            cells_of(id, &mut touched);
            ends.push(touched.indices.len() as u32);
        }
        Self { ends, cells: touched.indices }
    }
}

/// A slightly larger box, which contains all hits in spite of rounding and has a positive extent along every
/// axis.
pub fn widened(bounds: Aabb) -> Aabb {
    let extent = bounds.extent();
    let max_abs_coord = bounds.min.abs().max(bounds.max.abs()).max_element();
    let max_extent = extent.max_element();
    // The factors are powers of two, so that a scene scaled by a power of two has the same cells.
    let min_extent = (max_extent * 2f64.powi(-10)).max(max_abs_coord * 2f64.powi(-30)).max(f64::MIN_POSITIVE);
    let padding = [0, 1, 2]
        .map(|axis| if extent[axis] < min_extent { min_extent } else { extent[axis] * 2f64.powi(-20) });
    let padding = DVec3::from_array(padding);
    Aabb { min: bounds.min - padding, max: bounds.max + padding }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caster::grid::voxelize;

    #[test]
    fn cell_lists_hold_the_cells_of_each_box() {
        let boxes: Vec<Aabb> = (0..10_000)
            .map(|i| DVec3::new((i * 7 % 20) as f64, (i * 3 % 20) as f64, 0.0))
            .map(|p| Aabb { min: p, max: p + 1.0 })
            .collect();
        let lattice =
            Lattice::new(widened(Aabb { min: DVec3::ZERO, max: DVec3::new(20.0, 20.0, 1.0) }), [7, 5, 2]);
        let cell_lists =
            CellLists::new(&lattice, boxes.len(), |i, out| voxelize::of_box(&lattice, &boxes[i], 1e-6, out))
                .unwrap();
        let below = |id| cell_lists.cells_below(id).flatten().count();
        assert_eq!(below(0), 0);
        let mut cells = 0;
        for (i, b) in boxes.iter().enumerate() {
            let mut expected = TouchedCells::default();
            voxelize::of_box(&lattice, b, 1e-6, &mut expected);
            assert_eq!(cell_lists.cells_of(i), expected.indices);
            cells += expected.indices.len();
            assert_eq!(below(i + 1), cells);
        }
    }

    #[test]
    fn flat_and_single_point_scenes_have_cells_of_positive_size() {
        for p in [DVec3::ZERO, DVec3::splat(3.0), DVec3::new(1.0, 2.0, 0.0)] {
            let lattice = Lattice::new(widened(Aabb { min: DVec3::ZERO, max: p }), [3, 3, 3]);
            assert!(lattice.cell_size.min_element() > 0.0);
        }
    }

    #[test]
    fn a_widened_box_is_slightly_larger_on_all_sides_and_never_flat() {
        let bounds = Aabb { min: DVec3::new(-1.0, 3.0, 5.0), max: DVec3::new(1.0, 4.0, 5.0) };
        let larger = widened(bounds);
        let [below, above] = [bounds.min - larger.min, larger.max - bounds.max];
        assert_eq!(below, DVec3::new(2.0 / 1048576.0, 1.0 / 1048576.0, 2.0 / 1024.0));
        assert_eq!(below, above);
        // Far from the origin, where the spacing of floats is large.
        let far = DVec3::new(1.0, -1048576.0, 2.0);
        let larger = widened(Aabb { min: far, max: far });
        assert_eq!(
            (far - larger.min, larger.max - far),
            (DVec3::splat(1.0 / 1024.0), DVec3::splat(1.0 / 1024.0))
        );
    }
}
