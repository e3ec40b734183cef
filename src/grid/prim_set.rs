//! Which primitives a structure holds.

use crate::world::World;

/// Finite primitives of a world, counted from 0 in the order of their numbers.
#[derive(Debug)]
pub enum Items {
    All,
    /// Those of these numbers, which ascend.
    These(Vec<u32>),
}

impl Items {
    pub fn count(&self, world: &World) -> usize {
        match self {
            Self::All => world.finite_count(),
            Self::These(numbers) => numbers.len(),
        }
    }

    /// How many are triangles; those come first.
    pub fn triangles(&self, world: &World) -> usize {
        let all = world.triangles.len();
        match self {
            Self::All => all,
            Self::These(numbers) => numbers.partition_point(|&number| (number as usize) < all),
        }
    }

    /// The number in the world of the i-th.
    #[inline]
    pub fn number(&self, i: usize) -> u32 {
        match self {
            Self::All => i as u32,
            Self::These(numbers) => numbers[i],
        }
    }
}
