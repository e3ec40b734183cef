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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parser::parse;

    #[test]
    fn triangles_come_first() {
        let text = "OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }
             Group { numObjects 3 Material { } Sphere { center 0 0 0 radius 1 }
             Triangle { vertex0 0 0 0 vertex1 1 0 0 vertex2 0 1 0 }
             Triangle { vertex0 0 0 1 vertex1 1 0 1 vertex2 0 1 1 } }";
        let world = World::new(&parse(text).unwrap(), &[]).unwrap();
        let triangles = |ids: &[u32]| PrimSet::Subset(ids.to_vec()).triangles(&world);
        assert_eq!(PrimSet::All.triangles(&world), 2);
        assert_eq!([&[0, 1, 2][..], &[1, 2], &[0, 1], &[2], &[]].map(triangles), [2, 1, 2, 0, 0]);
    }
}
