//! One 32-bit entry for each cell of a lattice, and cursors that read the entries along a ray without bounds
//! tests. What an entry means is decided in [`crate::caster::cell_contents`].

use crate::caster::error::GridTooLarge;
use crate::caster::grid::dda::Dda;
use crate::caster::grid::lattice::Lattice;
use crate::caster::ray_aabb::RayInterval;
use fearless_simd::Simd;

/// The entry of an empty cell.
pub const EMPTY: u32 = 0;
/// The entry of every border cell. A cursor steps on from any other entry, but never from this one.
pub const BORDER: u32 = u32::MAX;

/// The entries of the cells of a lattice and of its border.
///
/// There is one entry for each index of the lattice, and the entry of every index that is not a cell's is
/// [`BORDER`]. Neither the lattice nor the entries ever change, and the memory safety of cursors relies on
/// that.
#[derive(Debug)]
pub struct CellTable {
    lattice: Lattice,
    entries: Box<[u32]>,
}

impl CellTable {
    /// A table with these entries, by index of the lattice. Those of the border are overwritten, and missing
    /// ones are border cells; an error when the lattice does not fit into 32-bit indices.
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

    /// The entry at an index of the lattice.
    pub fn entry(&self, index: usize) -> u32 {
        self.entries[index]
    }

    /// The lattice of the cells.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// A cursor along a ray with this interval in the lattice's bounds.
    #[inline(always)]
    pub fn cursor<S: Simd>(&self, interval: &RayInterval<S>) -> CellCursor<'_> {
        self.start(Dda::new(&self.lattice, interval))
    }

    /// A cursor at the first cell of a DDA, or at the border when the DDA's index is not in this table.
    #[inline(always)]
    fn start<'t>(&'t self, dda: Dda<'t>) -> CellCursor<'t> {
        let entry = self.entries.get(dda.index()).copied().unwrap_or(BORDER);
        CellCursor { entries: &self.entries, dda, entry }
    }
}

/// The position of a ray in a [`CellTable`], and the DDA that advances it. Unless the current entry is
/// [`BORDER`], the DDA is at a cell of the table's lattice.
#[derive(Clone, Copy, Debug)]
pub struct CellCursor<'t> {
    entries: &'t [u32],
    dda: Dda<'t>,
    entry: u32,
}

impl CellCursor<'_> {
    /// The entry of the current cell.
    #[inline(always)]
    pub fn entry(&self) -> u32 {
        self.entry
    }

    /// Advances to the first cell that is not empty, which may be the current one.
    #[inline(always)]
    pub fn skip(&mut self) {
        while self.entry == EMPTY {
            self.step();
        }
    }

    /// The fixed-point t at which the ray leaves the current cell.
    #[inline(always)]
    pub fn exit(&self) -> i32 {
        self.dda.exit()
    }

    /// The smallest fixed-point t that is not before `t`.
    #[inline(always)]
    pub fn fixed_t(&self, t: f64) -> i32 {
        self.dda.fixed_t(t)
    }

    /// Advances to the next cell and returns the set of axes that did not step, as [`Dda::step`] does. At the
    /// border nothing happens, and no axis steps.
    #[inline(always)]
    pub fn step(&mut self) -> usize {
        const NO_AXIS_STEPS: usize = 7;
        // The test costs nothing where the caller has already compared the entry.
        if self.entry == BORDER {
            return NO_AXIS_STEPS;
        }
        let unstepped = self.dda.step();
        // SAFETY: every index that is not a cell's has the entry `BORDER`, so the DDA was at a cell of the
        // lattice. A step of at most one cell along each axis leads from a cell to another cell or to the
        // border around them, and `entries` has an entry for each of these indices.
        self.entry = unsafe { *self.entries.get_unchecked(self.dda.index()) };
        unstepped
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::aabb::Aabb;
    use crate::math::ray::Ray;
    use glam::DVec3;

    fn lattice(cells: [usize; 3]) -> Lattice {
        Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::ONE }, cells)
    }

    /// Rays through and past the unit box, with directions of all signs.
    fn rays() -> impl Iterator<Item = Ray> {
        let coordinate = |k: u32| (f64::from(k) * 0.618_034).fract() * 3.0 - 1.0;
        let point = move |k: u32| DVec3::from([1, 3, 7].map(|n| coordinate(n * k)));
        (0..400).map(move |k| Ray::new(point(k), point(k + 50) - point(k)))
    }

    /// The entries given for the border, and the number of entries given, make no difference.
    #[test]
    fn a_cursor_ends_at_the_border_and_stays_there() {
        const CELLS: [usize; 3] = [4, 1, 3];
        let mut entered = 0;
        for given in [0, 50, lattice(CELLS).index_count(), 1000] {
            let table = CellTable::new(lattice(CELLS), vec![EMPTY; given]).unwrap();
            for ray in rays() {
                let Some((dda, _)) = Dda::of_ray(table.lattice(), &ray) else { continue };
                let mut cursor = table.start(dda);
                cursor.skip();
                let end = (cursor.entry(), cursor.dda.index(), cursor.step(), cursor.dda.index());
                assert_eq!(end, (BORDER, end.1, 7, end.1), "{ray:?}");
                entered += 1;
            }
        }
        assert!(entered > 400, "{entered}");
    }

    #[test]
    fn a_dda_of_another_lattice_starts_at_the_border() {
        let (large, small) = (lattice([1000; 3]), CellTable::new(lattice([2; 3]), vec![]).unwrap());
        for origin in [0.7, 0.9].map(DVec3::splat) {
            let ray = Ray::new(origin, DVec3::ONE);
            let (dda, _) = Dda::of_ray(&large, &ray).unwrap();
            assert_eq!(small.start(dda).entry(), BORDER);
        }
    }

    #[test]
    fn a_cursor_has_the_fixed_t_of_its_dda() {
        let table = CellTable::new(lattice([4, 1, 3]), vec![]).unwrap();
        for ray in rays() {
            let Some((dda, [entry, exit])) = Dda::of_ray(table.lattice(), &ray) else { continue };
            let cursor = table.start(dda);
            let t = 0.5 * (entry + exit);
            assert_eq!((cursor.exit(), cursor.fixed_t(t)), (cursor.dda.exit(), cursor.dda.fixed_t(t)));
        }
    }
}
