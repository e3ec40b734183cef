//! Adjacent cells with the same primitives share their blocks. A large face in a fine grid has many such cells: the
//! blocks take less of the cache, and a ray that goes from one of them to the next need not test them again.

use super::{BlockIndex, COUNT_BITS, CellContents, MAX_COUNT};
use crate::grid::cell_table::EMPTY;
use crate::grid::lattice::Lattice;
use std::ops::Range;

impl CellContents {
    /// Gives cells the entry of the cell before them along an axis if it has the same primitives, and drops the blocks
    /// that nothing refers to any more.
    pub(super) fn share_blocks(&mut self, lattice: &Lattice) {
        let steps = lattice.strides();
        let mut kept = 0;
        for cell in lattice.x_runs().flatten() {
            let entry = self.entries[cell];
            if entry == EMPTY {
                continue;
            }
            let own = self.range(entry);
            let mut before = steps.iter().map(|step| self.entries[cell - step]);
            let same = before.find(|&other| other != EMPTY && self.are_same(other, &own));
            self.entries[cell] = same.unwrap_or((kept as u32) << COUNT_BITS | entry & MAX_COUNT);
            if same.is_none() {
                self.indices.copy_within(own.clone(), kept);
                kept += own.len();
            }
        }
        self.indices.truncate(kept);
    }

    /// Whether the cell with an entry has the same primitives as these blocks.
    fn are_same(&self, entry: u32, own: &Range<usize>) -> bool {
        let (one, other) = (&self.indices[self.range(entry)], &self.indices[own.clone()]);
        let others = |blocks: &[BlockIndex]| blocks.last().map(|last| self.non_triangles_of(last));
        one.len() == other.len()
            && one.iter().zip(other).all(|(a, b)| a.ids == b.ids)
            && others(one) == others(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::cell_lists::CellLists;
    use crate::math::aabb::Aabb;
    use crate::scene::parser::parse;
    use crate::world::World;
    use glam::DVec3;

    /// The entries of the first four cells in a row, and the number of blocks, of primitives that are in these cells.
    /// So many of them are triangles, the others spheres. One more sphere is in all of the many cells after these.
    fn entries(cells_of: &[&[u32]], triangles: usize, along: usize) -> (Vec<u32>, usize) {
        let objects = "Triangle { vertex0 0 0 0 vertex1 1 0 0 vertex2 0 1 0 } ".repeat(triangles)
            + &"Sphere { center 0 0 0 radius 1 } ".repeat(cells_of.len() - triangles + 1);
        let text = format!(
            "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
             Group {{ numObjects {} Material {{ }} {objects} }}",
            cells_of.len() + 1
        );
        let world = World::new(&parse(&text).unwrap(), &[]).unwrap();
        let mut counts = [1; 3];
        counts[along] = 100;
        let lattice = Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::ONE }, counts);
        let index = |k: u32| lattice.index([0; 3]) + k as usize * lattice.strides()[along];
        let cell_lists = CellLists::new(&lattice, cells_of.len() + 1, |i, touched| {
            match cells_of.get(i) {
                Some(cells) => cells.iter().for_each(|&k| touched.push(index(k) as u32)),
                None => (4..100).for_each(|k| touched.push(index(k) as u32)),
            }
            Ok(())
        });
        let cells = CellContents::new(&world, &lattice, &cell_lists.unwrap()).unwrap();
        ((0..4).map(|k| cells.entries[index(k)]).collect(), cells.block_count() - 1)
    }

    #[test]
    fn cells_in_a_row_with_the_same_primitives_share_their_blocks() {
        for along in 0..3 {
            let everywhere: &[u32] = &[0, 1, 2, 3];
            let mut cells_of = vec![everywhere; 8];
            let (found, blocks) = entries(&cells_of, 8, along);
            assert!(found[0] != EMPTY && found.iter().all(|&entry| entry == found[0]) && blocks == 1);
            // One triangle more or less, and a sphere, make a difference.
            cells_of[7] = &[0, 1, 3];
            let (found, blocks) = entries(&cells_of, 8, along);
            assert!(found[0] == found[1] && found[1] != found[2] && found[2] != found[3] && blocks == 3);
            cells_of[7] = everywhere;
            cells_of.push(&[1, 2]);
            let (found, blocks) = entries(&cells_of, 8, along);
            assert!(found[0] != found[1] && found[1] == found[2] && found[2] != found[3] && blocks == 3);
        }
    }

    #[test]
    fn a_cell_with_a_block_more_shares_nothing() {
        let (everywhere, apart): (&[u32], &[u32]) = (&[0, 1, 2, 3], &[1, 3]);
        let mut cells_of = vec![everywhere; 8];
        cells_of.push(apart);
        let (found, blocks) = entries(&cells_of, 9, 0);
        assert!(found.windows(2).all(|pair| pair[0] != pair[1]) && blocks == 6, "{found:?}");
    }

    #[test]
    fn an_empty_cell_shares_nothing() {
        let apart: &[u32] = &[0, 2];
        let (found, blocks) = entries(&[apart; 8], 8, 0);
        assert!(found[1] == EMPTY && found[3] == EMPTY && found[0] != found[2] && blocks == 2);
        assert_eq!(found[2] >> COUNT_BITS, 1);
    }
}
