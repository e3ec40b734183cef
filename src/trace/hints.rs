//! Hints: results of rays that are known before the rays are cast.

use crate::math::ray::{Ray, Visible};
use crate::world::{SurfacePoint, World};
use glam::DVec3;

/// The first hit of a camera ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FirstHit {
    /// The ray hits nothing.
    Nothing,
    /// The ray hits this primitive first.
    Primitive(Visible),
    /// The ray must be cast.
    Unknown,
}

/// The primitives other than planes that a ray from a point to a light may hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blocker {
    /// No primitive.
    Nothing,
    /// This triangle or no primitive.
    Only(u32),
    /// Any primitive.
    Any,
    /// Some primitive certainly blocks the ray.
    Certain,
}

/// Knows the results of some rays. They are the same as if the rays were cast. By default no result is known.
pub trait Hints: Sync {
    /// Returns the first hit of a camera ray through the pixel in this column and row.
    #[inline(always)]
    fn first_hit(&self, _world: &World, _ray: &Ray, _pixel: [usize; 2]) -> FirstHit {
        FirstHit::Unknown
    }

    /// Returns the primitives that may be between a surface and the light with this index, in this direction.
    #[inline(always)]
    fn blocker(&self, _world: &World, _light: usize, _surface: &SurfacePoint, _direction: DVec3) -> Blocker {
        Blocker::Any
    }
}

/// Knows nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoHints;

impl Hints for NoHints {}
