//! Which primitives a structure holds.

use crate::world::World;

/// Finite primitives of a world, counted from 0 in the order of their numbers.
#[derive(Debug)]
pub enum PrimSet {
    All,
    /// Those of these numbers, which ascend.
    Subset(Vec<u32>),
}

impl PrimSet {
    pub fn count(&self, world: &World) -> usize {
        match self {
            Self::All => world.finite_count(),
            Self::Subset(ids) => ids.len(),
        }
    }

    /// How many are triangles; those come first.
    pub fn triangles(&self, world: &World) -> usize {
        let all = world.triangles.len();
        match self {
            Self::All => all,
            Self::Subset(ids) => ids.partition_point(|&id| (id as usize) < all),
        }
    }

    /// The number in the world of the i-th.
    #[inline]
    pub fn id(&self, i: usize) -> u32 {
        match self {
            Self::All => i as u32,
            Self::Subset(ids) => ids[i],
        }
    }
}
