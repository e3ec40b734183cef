//! Stops the tracing of secondary rays, when a render is cancelled or too many rays wait.

use std::fmt;

/// The number of rays between two calls of the callback. Such rare calls take no measurable time, and still come soon
/// enough if each ray is tested against a hundred thousand triangles.
const RAYS_AT_ONCE: usize = 1 << 9;

/// The approximate number of secondary rays of one camera ray that may wait at once. They take about 30 MB per thread.
/// Only rays that split again and again come near this limit: each bounce doubles their number.
pub const MOST_WAITING: usize = 1 << 18;

/// Calls a callback now and then, which decides whether to trace more rays. One camera ray may cause more secondary
/// rays than can ever be traced.
#[derive(Clone, Copy)]
pub struct Patience<'a> {
    is_over: &'a (dyn Fn(usize) -> bool + Sync),
    /// The number of rays between two calls, without shadow rays.
    at_once: u32,
    /// The number of rays until the next call.
    left: u32,
    /// True if no more rays are traced.
    pub has_ended: bool,
}

impl<'a> Patience<'a> {
    /// Returns a patience that ends when `is_over` returns true for the number of rays that wait. Each ray may cause a
    /// shadow ray to each of `lights` lights.
    pub fn until(is_over: &'a (dyn Fn(usize) -> bool + Sync), lights: usize) -> Self {
        let at_once = (RAYS_AT_ONCE / (1 + lights)).max(1) as u32;
        Self { is_over, at_once, left: at_once, has_ended: false }
    }

    /// Returns a patience that never ends.
    pub fn endless() -> Self {
        Self::until(&|_| false, 0)
    }

    /// Returns true if neither the next ray nor any later one is to be traced. `waiting` is the number of rays that
    /// wait.
    #[inline(always)]
    pub fn ends(&mut self, waiting: usize) -> bool {
        self.left -= 1;
        self.left == 0 && self.ask(waiting)
    }

    /// Notes that this number of camera rays was traced.
    pub fn spend(&mut self, rays: usize) {
        self.left = self.left.saturating_sub(rays as u32);
        if self.left == 0 {
            self.ask(0);
        }
    }

    #[cold]
    fn ask(&mut self, waiting: usize) -> bool {
        self.has_ended = self.has_ended || (self.is_over)(waiting);
        self.left = if self.has_ended { 1 } else { self.at_once };
        self.has_ended
    }
}

impl fmt::Debug for Patience<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Patience").field("left", &self.left).field("has_ended", &self.has_ended).finish()
    }
}
