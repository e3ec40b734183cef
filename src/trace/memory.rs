//! The memory of a tracer: the secondary rays that wait, and when to stop tracing them.

use super::secondary::SecondaryRay;
use crate::shading::phong::Mixture;

/// The number of rays between two calls of [`IsOver`]. Such rare calls take no measurable time, and still come soon
/// enough if each ray is tested against a hundred thousand triangles.
const RAYS_AT_ONCE: usize = 1 << 9;

/// The approximate number of secondary rays of one camera ray that may wait at once. They take about 30 MB per thread.
/// Only rays that split again and again come near this limit: each bounce doubles their number.
pub const MOST_WAITING: usize = 1 << 18;

/// Returns true if no more rays are to be traced. The parameter is the number of rays that wait. It is called now and
/// then, since one camera ray may cause more secondary rays than can ever be traced.
pub type IsOver<'a> = &'a (dyn Fn(usize) -> bool + Sync);

/// The memory of a tracer, kept from one camera ray to the next.
pub struct Memory<'a> {
    /// The secondary rays that wait to be traced. The stack is empty between two camera rays.
    pub(super) pending: Vec<SecondaryRay>,
    pub(super) mixture: Mixture,
    is_over: IsOver<'a>,
    /// The number of rays between two calls of `is_over`, without shadow rays.
    at_once: u32,
    /// The number of rays until the next call.
    left: u32,
    is_cut: bool,
}

impl<'a> Memory<'a> {
    /// Returns a memory whose secondary rays are traced until `is_over` returns true. Each ray may cause a shadow ray
    /// to each of `lights` lights.
    pub fn until(is_over: IsOver<'a>, lights: usize) -> Self {
        let at_once = (RAYS_AT_ONCE / (1 + lights)).max(1) as u32;
        let (pending, mixture) = Default::default();
        Self { pending, mixture, is_over, at_once, left: at_once, is_cut: false }
    }

    /// Returns true if rays were left out.
    pub(crate) fn is_cut(&self) -> bool {
        self.is_cut
    }

    /// Notes that this number of camera rays was traced.
    pub(crate) fn spend(&mut self, rays: usize) {
        self.left = self.left.saturating_sub(rays as u32);
        if self.left == 0 {
            self.ask();
        }
    }

    /// Returns true if neither the next secondary ray nor any later one is to be traced.
    #[inline(always)]
    pub(super) fn ends(&mut self) -> bool {
        self.left -= 1;
        self.left == 0 && self.ask()
    }

    #[cold]
    fn ask(&mut self) -> bool {
        self.is_cut = self.is_cut || (self.is_over)(self.pending.len());
        self.left = if self.is_cut { 1 } else { self.at_once };
        self.is_cut
    }
}

impl Default for Memory<'_> {
    /// Returns a memory whose secondary rays are all traced.
    fn default() -> Self {
        Self::until(&|_| false, 0)
    }
}
