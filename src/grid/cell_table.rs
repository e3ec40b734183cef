//! A word for each cell of a lattice, and walks that read them along a ray without a bounds test.

use crate::grid::Lattice;
use crate::grid::cell_lists::GridTooLarge;
use crate::grid::dda::March;
use crate::grid::dda4::Marches;
use crate::grid::ray_aabb::Passage;
use crate::math::four::Four;

/// The word of an empty cell.
pub const EMPTY: u32 = 0;
/// The word of whatever is no cell: a walk goes on from every other word, and never from this.
pub const BORDER: u32 = u32::MAX;

/// The words of a lattice's cells and its border.
///
/// There is one for each index of the lattice, and that of every index which is not a cell's is
/// [`BORDER`]. Neither the lattice nor a word ever changes: walks rely on that.
#[derive(Debug)]
pub struct Words {
    lattice: Lattice,
    words: Box<[u32]>,
}

impl Words {
    /// Of words by the lattice's index; the border's may be anything.
    pub fn new(lattice: Lattice, mut words: Vec<u32>) -> Result<Self, GridTooLarge> {
        lattice.fits()?;
        words.resize(lattice.index_count(), BORDER);
        let mut end = 0;
        for row in lattice.rows() {
            words[end..row.start].fill(BORDER);
            end = row.end;
        }
        words[end..].fill(BORDER);
        Ok(Self { lattice, words: words.into_boxed_slice() })
    }

    /// The lattice of the cells.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Along a ray with this passage through the lattice's bounds.
    #[inline(always)]
    pub fn walk<F: Four>(&self, passage: &Passage<F>) -> Walk<'_> {
        self.start(March::new(&self.lattice, passage))
    }

    /// Along one of four rays.
    #[inline(always)]
    pub fn walk_of(&self, marches: &Marches, ray: usize) -> Walk<'_> {
        self.start(marches.march(&self.lattice, ray))
    }

    /// From where a march through this lattice begins; at the border, where that is nowhere.
    #[inline(always)]
    fn start<'w>(&'w self, march: March<'w>) -> Walk<'w> {
        let word = self.words.get(march.index()).copied().unwrap_or(BORDER);
        Walk { words: &self.words, march, word }
    }
}

/// A ray's walk through the cells of [`Words`], whose lattice its march goes through. Unless its word is
/// [`BORDER`], the march is at a cell.
#[derive(Clone, Copy, Debug)]
pub struct Walk<'w> {
    words: &'w [u32],
    march: March<'w>,
    word: u32,
}

impl Walk<'_> {
    /// The word of the current cell.
    #[inline(always)]
    pub fn word(&self) -> u32 {
        self.word
    }

    /// Goes on to the first cell that is not empty, from the current one on.
    #[inline(always)]
    pub fn skip(&mut self) {
        while self.word == EMPTY {
            self.step();
        }
    }

    /// The tick at which the ray leaves the current cell.
    #[inline(always)]
    pub fn exit(&self) -> i32 {
        self.march.exit()
    }

    /// The first tick not before `t`.
    #[inline(always)]
    pub fn tick(&self, t: f64) -> i32 {
        self.march.tick(t)
    }

    /// Goes on as [`March::step`] does, unless the walk has come to the border, where it stays.
    #[inline(always)]
    pub fn step(&mut self) -> usize {
        const NO_AXIS_STEPS: usize = 7;
        // Costs nothing where the caller has looked at the word.
        if self.word == BORDER {
            return NO_AXIS_STEPS;
        }
        let stays = self.march.step();
        // SAFETY: every index that is not a cell's has the word `BORDER`, so the march was at a cell of
        // the lattice. A step of at most one cell along each axis leads from a cell to another or to the
        // border around them, and `words` has one for each of these indices.
        self.word = unsafe { *self.words.get_unchecked(self.march.index()) };
        stays
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::ray_aabb::{clip, clip_packet};
    use crate::math::aabb::Aabb;
    use crate::math::four::Plain;
    use crate::math::instructions::Portable;
    use crate::math::packet::{Along, Packet};
    use crate::math::ray::Ray;
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
            let words = Words::new(lattice(CELLS), vec![EMPTY; given]).unwrap();
            for ray in rays() {
                let along = Along::<Plain>::all_axes(Portable, &ray);
                let slab = words.lattice().slab();
                let Some(passage) = clip(slab, along, ray.t_min, ray.t_max) else { continue };
                let mut walk = words.walk(&passage);
                walk.skip();
                let end = (walk.word(), walk.march.index(), walk.step(), walk.march.index());
                assert_eq!(end, (BORDER, end.1, 7, end.1), "{ray:?}");
                entered += 1;
            }
        }
        assert!(entered > 400, "{entered}");
    }

    #[test]
    fn marches_through_another_lattice_lead_nowhere() {
        let (large, small) = (lattice([1000; 3]), Words::new(lattice([2; 3]), vec![]).unwrap());
        let [a, b] = [DVec3::splat(0.7), DVec3::splat(0.9)].map(|origin| Ray::new(origin, DVec3::ONE));
        let packet = Packet::<Plain>::new(Portable, [&a, &b, &a, &b]);
        let marches = Marches::new(&large, &packet, &clip_packet(large.slab(), &packet));
        assert_eq!([0, 1, 2, 3].map(|ray| small.walk_of(&marches, ray).word()), [BORDER; 4]);
    }
}
