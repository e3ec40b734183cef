//! Optional accelerations. They never change the picture.
//!
//! The feature `fast` turns them on. With the feature `ablation`, the environment variable `WITHOUT` names the ones to
//! leave out, to measure what each of them saves.

use std::sync::OnceLock;

/// An optional acceleration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shortcut {
    /// Rasterization finds the first hits of camera rays.
    FirstHits,
    /// Rasterization finds the surfaces that a light reaches.
    ShadowMaps,
    /// AVX2 instructions are used where the processor has them.
    Avx2,
    /// A special reader reads meshes that have only positions and triangles.
    PlainMeshes,
}

impl Shortcut {
    /// All shortcuts.
    pub const ALL: [Self; 4] = [Self::FirstHits, Self::ShadowMaps, Self::Avx2, Self::PlainMeshes];

    /// Its name in the environment variable.
    pub fn name(self) -> &'static str {
        match self {
            Self::FirstHits => "first_hits",
            Self::ShadowMaps => "shadow_maps",
            Self::Avx2 => "avx2",
            Self::PlainMeshes => "plain_meshes",
        }
    }

    /// Returns true if it is used. This is a constant, except with the feature `ablation`.
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
