//! A ray's way through a structure: its cells in order, and grids within cells, until no nearer hit can
//! follow.

use super::block::Block;
use super::cells::{BORDER, Cells, EMPTY, NESTED};
use super::filter::{Kernel, Portable};
use super::search::{Filtered, Search};
use super::structure::Structure;
use crate::grid::march::March;
use crate::grid::passage::{Passage, clip};
use crate::math::four::Four;
use crate::math::packet::Along;
use crate::math::ray::Ray;
use crate::stats::Probe;

/// A kernel that can search structures within structures. A function searches one of them and is
/// called for each that a ray meets, so that the common case, a grid with nothing nested, keeps its
/// registers.
pub trait Nest: Kernel {
    fn search<P: Probe, const ANY: bool>(structure: &Structure, search: &mut Search, probe: &mut P);
}

impl Nest for Portable {
    #[inline(never)]
    fn search<P: Probe, const ANY: bool>(structure: &Structure, search: &mut Search, probe: &mut P) {
        structure.search::<Self, P, ANY>(search, probe);
    }
}

#[cfg(target_arch = "x86_64")]
impl Nest for super::filter::Avx2 {
    #[inline(always)]
    fn search<P: Probe, const ANY: bool>(structure: &Structure, search: &mut Search, probe: &mut P) {
        // SAFETY: only `super::Caster` names this kernel, after its instructions were detected.
        unsafe { search_avx2::<P, ANY>(structure, search, probe) }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn search_avx2<P: Probe, const ANY: bool>(structure: &Structure, search: &mut Search, probe: &mut P) {
    structure.search::<super::filter::Avx2, P, ANY>(search, probe);
}

/// How a ray comes upon a structure.
#[derive(Clone, Copy, Debug)]
pub enum Approach<F> {
    Misses,
    Passes(Passage<F>),
    /// From so far that the proofs of filter and march do not hold.
    TooFar,
}

impl Structure {
    /// Looks for a better hit than the search has, in the structure's cells.
    #[inline(always)]
    fn search<K: Nest, P: Probe, const ANY: bool>(&self, search: &mut Search, probe: &mut P) {
        let approach = self.approach::<K::Four>(search.ray, search.best.t);
        self.run::<K, P, ANY>(&approach, search, probe);
    }

    /// How the ray, as far as `last`, comes upon the structure.
    #[inline(always)]
    pub fn approach<F: Four>(&self, ray: &Ray, last: f64) -> Approach<F> {
        if !self.is_near::<F>(ray) {
            return Approach::TooFar;
        }
        clip(&self.slab, Along::<F>::all_axes(ray), ray.t_min, last)
            .map_or(Approach::Misses, Approach::Passes)
    }

    /// The same as [`search`](Self::search), for a search whose ray has this approach.
    #[inline(always)]
    pub fn run<K: Nest, P: Probe, const ANY: bool>(
        &self,
        approach: &Approach<K::Four>,
        search: &mut Search,
        probe: &mut P,
    ) {
        let passage = match approach {
            Approach::TooFar => return self.run_all::<P, ANY>(search, probe),
            Approach::Passes(passage) if passage.entry <= search.best.t => *passage,
            _ => {
                // The course's program tests everything; what is outside the box misses.
                let untested = if self.lattice.is_none() { self.items.count(search.world) } else { 0 };
                return probe.intersections(untested);
            }
        };
        let blocks = self.cells.blocks.as_slice();
        let mut filtered = Filtered::on(&passage, &self.cells.frame, search.best.t);
        match &self.lattice {
            Some(lattice) => {
                let march = March::new(lattice, &passage);
                self.march::<K, P, ANY>(march, blocks, &mut filtered, search, probe);
            }
            None => {
                search.test_cell::<K, P, ANY>(&self.cells, blocks, &mut filtered, probe);
            }
        }
    }

    /// Whether the proofs of filter and march hold for the ray; not for one with a NaN.
    #[inline(always)]
    fn is_near<F: Four>(&self, ray: &Ray) -> bool {
        let o = ray.origin;
        let from_middle = F::new([o.x, o.y, o.z, 0.0]) - F::new(self.cells.frame.center);
        from_middle.abs().greatest() <= self.farthest
    }

    /// Goes on to the first cell that is not empty, from the current one on; gives its word.
    #[inline(always)]
    pub fn skip(&self, march: &mut March) -> u32 {
        let mut word = self.word_at(march);
        while word == EMPTY {
            march.step();
            word = self.word_at(march);
        }
        word
    }

    /// Tests the cells along the ray until no nearer hit can follow.
    #[inline(always)]
    pub fn march<K: Nest, P: Probe, const ANY: bool>(
        &self,
        mut march: March,
        blocks: &[Block],
        filtered: &mut Filtered,
        search: &mut Search,
        probe: &mut P,
    ) {
        let mut last_tick = march.tick(search.best.t);
        loop {
            let word = self.word_at(&march);
            if word != EMPTY {
                unlikely();
                let changed = if word < NESTED {
                    let own = Cells::blocks_of(blocks, word);
                    search.test_cell::<K, P, ANY>(&self.cells, own, filtered, probe)
                } else if word != BORDER {
                    self.test_nested::<K, P, ANY>(word, filtered, search, probe)
                } else {
                    return;
                };
                if changed {
                    if ANY {
                        return;
                    }
                    last_tick = march.tick(search.best.t);
                }
            }
            if (P::COUNTS || word != EMPTY) && last_tick <= march.exit() {
                return;
            }
            let stays = march.step();
            if P::COUNTS {
                (stays.count_ones()..3).for_each(|_| probe.cell());
            }
        }
    }

    /// Searches what a word names; says whether the best hit changed.
    #[inline(always)]
    fn test_nested<K: Nest, P: Probe, const ANY: bool>(
        &self,
        word: u32,
        filtered: &mut Filtered,
        search: &mut Search,
        probe: &mut P,
    ) -> bool {
        let before = search.best;
        let crowd = &self.nested[(word - NESTED) as usize];
        for structure in crowd.wide.iter().chain([&crowd.fine]) {
            K::search::<P, ANY>(structure, search, probe);
            if ANY && search.best != before {
                return true;
            }
        }
        filtered.cut(search.best.t);
        search.best != before
    }

    #[inline(always)]
    fn word_at(&self, march: &March) -> u32 {
        // SAFETY: the march goes through this structure's lattice. It begins in a cell, and goes on
        // only from words that are not the border's, so from a cell; and a step of at most one cell
        // along each axis leads from a cell to another or to the border, which also has its words.
        unsafe { self.cells.word(march.index()) }
    }

    /// Without filter and march: every primitive by itself.
    #[cold]
    fn run_all<P: Probe, const ANY: bool>(&self, search: &mut Search, probe: &mut P) {
        for i in 0..self.items.count(search.world) {
            probe.intersections(1);
            if search.test(self.items.number(i)) && ANY {
                return;
            }
        }
    }
}

/// Marks the branch that calls it.
#[inline(always)]
#[cold]
fn unlikely() {}
