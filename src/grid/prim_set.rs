//! The set of primitives that an acceleration structure is built from.

use crate::world::World;

/// A set of finite primitives of a world. Its members are numbered from 0 in the order of their ids in the
/// world.
#[derive(Debug)]
pub enum PrimSet {
    /// All finite primitives.
    All,
    /// The primitives with these ids, which are in ascending order.
    Subset(Vec<u32>),
}

impl PrimSet {
    /// The number of primitives.
    pub fn count(&self, world: &World) -> usize {
        match self {
            Self::All => world.finite_count(),
            Self::Subset(ids) => ids.len(),
        }
    }

    /// The number of triangles, which come first.
    pub fn triangles(&self, world: &World) -> usize {
        let all = world.triangles.len();
        match self {
            Self::All => all,
            Self::Subset(ids) => ids.partition_point(|&id| (id as usize) < all),
        }
    }

    /// The id in the world of the i-th primitive.
    #[inline]
    pub fn id(&self, i: usize) -> u32 {
        match self {
            Self::All => i as u32,
            Self::Subset(ids) => ids[i],
        }
    }
}
