//! A ray's way through a structure: its cells in order, and grids within cells, until no nearer hit can
//! follow.

use super::build::Structure;
use super::cell_table::{BORDER, EMPTY, Walk};
use super::cells::{Cells, NESTED};
use super::filter::Kernel;
use super::query::{Filtered, Search};
use super::triangle8::Block;
use crate::grid::ray_aabb::{Passage, clip};
use crate::math::four::Four;
#[cfg(target_arch = "x86_64")]
use crate::math::instructions::Avx2;
use crate::math::instructions::Portable;
use crate::math::packet::Along;
use crate::math::ray::Ray;
use crate::stats::Probe;

/// A kernel that can search structures within structures. A function searches one of them and is
/// called for each that a ray meets, so that the common case, a grid with nothing nested, keeps its
/// registers.
pub(crate) trait Nest: Kernel {
    fn search<P: Probe, const ANY: bool>(self, structure: &Structure, search: &mut Search, probe: &mut P);
}

impl Nest for Portable {
    #[inline(never)]
    fn search<P: Probe, const ANY: bool>(self, structure: &Structure, search: &mut Search, probe: &mut P) {
        structure.search::<_, P, ANY>(self, search, probe);
    }
}

#[cfg(target_arch = "x86_64")]
impl Nest for Avx2 {
    #[inline(always)]
    fn search<P: Probe, const ANY: bool>(self, structure: &Structure, search: &mut Search, probe: &mut P) {
        // SAFETY: `self` proves that the processor has all that the function is compiled for.
        unsafe { search_avx2::<P, ANY>(self, structure, search, probe) }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn search_avx2<P: Probe, const ANY: bool>(
    avx2: Avx2,
    structure: &Structure,
    search: &mut Search,
    probe: &mut P,
) {
    structure.search::<_, P, ANY>(avx2, search, probe);
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
    fn search<K: Nest, P: Probe, const ANY: bool>(&self, kernel: K, search: &mut Search, probe: &mut P) {
        let approach = self.approach::<K::Four>(kernel, search.ray, search.best.t);
        self.run::<K, P, ANY>(kernel, &approach, search, probe);
    }

    /// How the ray, as far as `last`, comes upon the structure.
    #[inline(always)]
    pub fn approach<F: Four>(&self, proof: F::Proof, ray: &Ray, last: f64) -> Approach<F> {
        let along = Along::<F>::all_axes(proof, ray);
        if !self.is_near::<F>(proof, ray) {
            return Approach::TooFar;
        }
        clip(&self.slab, along, ray.t_min, last).map_or(Approach::Misses, Approach::Passes)
    }

    /// The same as [`search`](Self::search), for a search whose ray has this approach.
    #[inline(always)]
    pub fn run<K: Nest, P: Probe, const ANY: bool>(
        &self,
        kernel: K,
        approach: &Approach<K::Four>,
        search: &mut Search,
        probe: &mut P,
    ) {
        let passage = match approach {
            Approach::TooFar => return self.run_all::<P, ANY>(search, probe),
            Approach::Passes(passage) if passage.entry <= search.best.t => *passage,
            _ => {
                // The course's program tests everything; what is outside the box misses.
                let untested = if self.words.is_none() { self.items.count(search.world) } else { 0 };
                return probe.intersections(untested);
            }
        };
        let blocks = self.cells.blocks.as_slice();
        let mut filtered = Filtered::on(&passage, &self.cells.frame, search.best.t);
        match &self.words {
            Some(words) => {
                self.march::<K, P, ANY>(kernel, words.walk(&passage), blocks, &mut filtered, search, probe);
            }
            None => {
                search.test_cell::<K, P, ANY>(kernel, &self.cells, blocks, &mut filtered, probe);
            }
        }
    }

    /// Whether the proofs of filter and march hold for the ray; not for one with a NaN.
    #[inline(always)]
    fn is_near<F: Four>(&self, proof: F::Proof, ray: &Ray) -> bool {
        let o = ray.origin;
        let from_middle = F::new(proof, [o.x, o.y, o.z, 0.0]) - F::new(proof, self.cells.frame.center);
        from_middle.abs().greatest() <= self.farthest
    }

    /// Tests the cells along the ray until no nearer hit can follow.
    #[inline(always)]
    pub fn march<K: Nest, P: Probe, const ANY: bool>(
        &self,
        kernel: K,
        mut walk: Walk,
        blocks: &[Block],
        filtered: &mut Filtered,
        search: &mut Search,
        probe: &mut P,
    ) {
        let mut last_tick = walk.tick(search.best.t);
        loop {
            if !P::COUNTS {
                walk.skip();
            }
            let word = walk.word();
            if word != EMPTY {
                unlikely();
                let changed = if word < NESTED {
                    let own = Cells::blocks_of(blocks, word);
                    search.test_cell::<K, P, ANY>(kernel, &self.cells, own, filtered, probe)
                } else if word != BORDER {
                    self.test_nested::<K, P, ANY>(kernel, word, filtered, search, probe)
                } else {
                    return;
                };
                if changed {
                    if ANY {
                        return;
                    }
                    last_tick = walk.tick(search.best.t);
                }
            }
            if last_tick <= walk.exit() {
                return;
            }
            let stays = walk.step();
            if P::COUNTS {
                (stays.count_ones()..3).for_each(|_| probe.cell());
            }
        }
    }

    /// Searches what a word names; says whether the best hit changed.
    #[inline(always)]
    fn test_nested<K: Nest, P: Probe, const ANY: bool>(
        &self,
        kernel: K,
        word: u32,
        filtered: &mut Filtered,
        search: &mut Search,
        probe: &mut P,
    ) -> bool {
        let before = search.best;
        let crowd = &self.nested[(word - NESTED) as usize];
        for structure in crowd.wide.iter().chain([&crowd.fine]) {
            kernel.search::<P, ANY>(structure, search, probe);
            if ANY && search.best != before {
                return true;
            }
        }
        filtered.cut(search.best.t);
        search.best != before
    }

    /// Without filter and march: every primitive by itself, unless the ray surely misses them all.
    #[cold]
    fn run_all<P: Probe, const ANY: bool>(&self, search: &mut Search, probe: &mut P) {
        let count = self.items.count(search.world);
        if self.slab.is_surely_missed(search.ray) {
            return probe.intersections(count);
        }
        for i in 0..count {
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
