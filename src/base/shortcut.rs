//! The shortcuts of the program: ways to find sooner what the tracer finds.
//!
//! None changes a picture. Without the feature `fast` none is taken, and with the feature `ablation` those are left out
//! that the environment variable `WITHOUT` names, to measure what each of them saves.

use std::sync::OnceLock;

/// A way to find something sooner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shortcut {
    /// The first hits of camera rays are found by rasterization.
    FirstHits,
    /// What stands before a light is found by rasterization.
    ShadowMaps,
    /// The instructions of AVX2 are used where the processor has them.
    Avx2,
    /// Those of SSE4.2 are used where the processor has them, and not AVX2.
    Sse4_2,
    /// Meshes of positions and triangles alone have a reader of their own.
    PlainMeshes,
}

impl Shortcut {
    /// All shortcuts.
    pub const ALL: [Self; 5] =
        [Self::FirstHits, Self::ShadowMaps, Self::Avx2, Self::Sse4_2, Self::PlainMeshes];

    /// Its name in the environment variable.
    pub fn name(self) -> &'static str {
        match self {
            Self::FirstHits => "first_hits",
            Self::ShadowMaps => "shadow_maps",
            Self::Avx2 => "avx2",
            Self::Sse4_2 => "sse4_2",
            Self::PlainMeshes => "plain_meshes",
        }
    }

    /// Whether it is taken. This is known when the program is compiled, except with the feature `ablation`.
    #[inline(always)]
    pub fn is_taken(self) -> bool {
        cfg!(feature = "fast") && !(cfg!(feature = "ablation") && self.is_left_out())
    }

    fn is_left_out(self) -> bool {
        static LEFT_OUT: OnceLock<[bool; Shortcut::ALL.len()]> = OnceLock::new();
        let left_out = LEFT_OUT.get_or_init(|| {
            let names = std::env::var("WITHOUT").unwrap_or_default();
            Self::ALL.map(|shortcut| names.split(',').any(|name| name == shortcut.name()))
        });
        left_out[self as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_shortcut_has_a_name_and_its_place_in_the_list() {
        for (i, shortcut) in Shortcut::ALL.into_iter().enumerate() {
            assert_eq!(shortcut as usize, i);
            assert_eq!(Shortcut::ALL.iter().filter(|other| other.name() == shortcut.name()).count(), 1);
        }
    }
}
