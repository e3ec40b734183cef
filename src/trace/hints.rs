//! What may be known of rays before they are cast.

use crate::math::ray::{Ray, Visible};
use crate::world::World;
use glam::DVec3;

/// The first hit of a camera ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FirstHit {
    /// The ray hits nothing.
    Nothing,
    /// The ray hits this primitive first.
    Primitive(Visible),
    /// The ray has to be cast.
    Unknown,
}

/// The primitives other than planes that a ray from a point to a light may hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blocker {
    /// None.
    Nothing,
    /// This triangle or none.
    Only(u32),
    /// Any.
    Any,
}

/// Knows results of rays, which are those of casting them. By default it knows none.
pub trait Hints: Sync {
    /// Returns the first hit of a camera ray through the pixel in this column and row.
    #[inline(always)]
    fn first_hit(&self, _world: &World, _ray: &Ray, _pixel: [usize; 2]) -> FirstHit {
        FirstHit::Unknown
    }

    /// Returns what may be between a point and the light with this index.
    #[inline(always)]
    fn blocker(&self, _light: usize, _point: DVec3) -> Blocker {
        Blocker::Any
    }
}

/// Knows nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoHints;

impl Hints for NoHints {}
