//! A grid within a cell, searched by a function of its own.

use super::Structure;
use super::filter::{Kernel, Portable};
use super::search::Search;
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
        structure.run::<Self, P, ANY>(search.ray(), search, probe);
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
    structure.run::<super::filter::Avx2, P, ANY>(search.ray(), search, probe);
}
