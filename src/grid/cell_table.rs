//! A word for each cell of a lattice, and walks that read them along a ray without a bounds test.

use crate::grid::Lattice;
use crate::grid::cell_lists::GridTooLarge;
use crate::grid::dda::Dda;
use crate::grid::dda4::Dda4;
use crate::grid::ray_aabb::RayInterval;
use crate::math::f64x4::F64x4;

/// The word of an empty cell.
pub const EMPTY: u32 = 0;
/// The word of whatever is no cell: a walk goes on from every other word, and never from this.
pub const BORDER: u32 = u32::MAX;

/// The words of a lattice's cells and its border.
///
/// There is one for each index of the lattice, and that of every index which is not a cell's is
/// [`BORDER`]. Neither the lattice nor a word ever changes: walks rely on that.
#[derive(Debug)]
pub struct CellTable {
    lattice: Lattice,
    entries: Box<[u32]>,
}

impl CellTable {
    /// Of words by the lattice's index; the border's may be anything.
    pub fn new(lattice: Lattice, mut entries: Vec<u32>) -> Result<Self, GridTooLarge> {
        lattice.fits()?;
        entries.resize(lattice.index_count(), BORDER);
        let mut end = 0;
        for run in lattice.x_runs() {
            entries[end..run.start].fill(BORDER);
            end = run.end;
        }
        entries[end..].fill(BORDER);
        Ok(Self { lattice, entries: entries.into_boxed_slice() })
    }

    /// The lattice of the cells.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Along a ray with this passage through the lattice's bounds.
    #[inline(always)]
    pub fn cursor<F: F64x4>(&self, interval: &RayInterval<F>) -> CellCursor<'_> {
        self.start(Dda::new(&self.lattice, interval))
    }

    /// Along one of four rays.
    #[inline(always)]
    pub fn cursor_of(&self, dda4: &Dda4, ray: usize) -> CellCursor<'_> {
        self.start(dda4.dda(&self.lattice, ray))
    }

    /// From where a march through this lattice begins; at the border, where that is nowhere.
    #[inline(always)]
    fn start<'w>(&'w self, dda: Dda<'w>) -> CellCursor<'w> {
        let entry = self.entries.get(dda.index()).copied().unwrap_or(BORDER);
        CellCursor { entries: &self.entries, dda, entry }
    }
}

/// A ray's walk through the cells of [`CellTable`], whose lattice its march goes through. Unless its word is
/// [`BORDER`], the march is at a cell.
#[derive(Clone, Copy, Debug)]
pub struct CellCursor<'w> {
    entries: &'w [u32],
    dda: Dda<'w>,
    entry: u32,
}

impl CellCursor<'_> {
    /// The word of the current cell.
    #[inline(always)]
    pub fn entry(&self) -> u32 {
        self.entry
    }

    /// Goes on to the first cell that is not empty, from the current one on.
    #[inline(always)]
    pub fn skip(&mut self) {
        while self.entry == EMPTY {
            self.step();
        }
    }

    /// The tick at which the ray leaves the current cell.
    #[inline(always)]
    pub fn exit(&self) -> i32 {
        self.dda.exit()
    }

    /// The first tick not before `t`.
    #[inline(always)]
    pub fn fixed_t(&self, t: f64) -> i32 {
        self.dda.fixed_t(t)
    }

    /// Goes on as [`Dda::step`] does, unless the walk has come to the border, where it stays.
    #[inline(always)]
    pub fn step(&mut self) -> usize {
        const NO_AXIS_STEPS: usize = 7;
        // Costs nothing where the caller has looked at the word.
        if self.entry == BORDER {
            return NO_AXIS_STEPS;
        }
        let stays = self.dda.step();
        // SAFETY: every index that is not a cell's has the word `BORDER`, so the march was at a cell of
        // the lattice. A step of at most one cell along each axis leads from a cell to another or to the
        // border around them, and `entries` has one for each of these indices.
        self.entry = unsafe { *self.entries.get_unchecked(self.dda.index()) };
        stays
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::ray_aabb::{intersect_aabb, intersect_aabb4};
    use crate::math::aabb::Aabb;
    use crate::math::f64x4::Scalar;
    use crate::math::instructions::Portable;
    use crate::math::ray::Ray;
    use crate::math::ray_lanes::{RayLanes, RayPacket4};
    use glam::DVec3;

    fn lattice(cells: [usize; 3]) -> Lattice {
        Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::ONE }, cells)
    }

    /// Through the unit box, in directions of all signs.
    fn rays() -> impl Iterator<Item = Ray> {
        let coordinate = |k: u32| (f64::from(k) * 0.618_034).fract() * 3.0 - 1.0;
        let point = move |k: u32| DVec3::from([1, 3, 7].map(|n| coordinate(n * k)));
        (0..400).map(move |k| Ray::new(point(k), point(k + 50) - point(k)))
    }

    /// What is given for the border, and how many words are given, makes no difference.
    #[test]
    fn a_walk_ends_at_the_border_and_stays_there() {
        const CELLS: [usize; 3] = [4, 1, 3];
        let mut entered = 0;
        for given in [0, 50, lattice(CELLS).index_count(), 1000] {
            let entries = CellTable::new(lattice(CELLS), vec![EMPTY; given]).unwrap();
            for ray in rays() {
                let along = RayLanes::<Scalar>::all_axes(Portable, &ray);
                let simd_bounds = entries.lattice().simd_bounds();
                let Some(interval) = intersect_aabb(simd_bounds, along, ray.t_min, ray.t_max) else {
                    continue;
                };
                let mut cursor = entries.cursor(&interval);
                cursor.skip();
                let end = (cursor.entry(), cursor.dda.index(), cursor.step(), cursor.dda.index());
                assert_eq!(end, (BORDER, end.1, 7, end.1), "{ray:?}");
                entered += 1;
            }
        }
        assert!(entered > 400, "{entered}");
    }

    #[test]
    fn marches_through_another_lattice_lead_nowhere() {
        let (large, small) = (lattice([1000; 3]), CellTable::new(lattice([2; 3]), vec![]).unwrap());
        let [a, b] = [DVec3::splat(0.7), DVec3::splat(0.9)].map(|origin| Ray::new(origin, DVec3::ONE));
        let packet = RayPacket4::<Scalar>::new(Portable, [&a, &b, &a, &b]);
        let dda4 = Dda4::new(&large, &packet, &intersect_aabb4(large.simd_bounds(), &packet));
        assert_eq!([0, 1, 2, 3].map(|ray| small.cursor_of(&dda4, ray).entry()), [BORDER; 4]);
    }
}
