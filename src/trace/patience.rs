//! The end of rays that are no longer wanted.

use std::fmt;

/// The number of rays that are traced between two questions. Asking this rarely takes no measurable time, and the answer
/// still comes soon where each ray meets a hundred thousand triangles.
const RAYS_AT_ONCE: usize = 1 << 9;

/// The number of secondary rays of one camera ray that may wait at once, about: they take some 30 MB of each thread. Only
/// rays that split again and again come near it, and each bounce doubles their number.
pub const MOST_WAITING: usize = 1 << 18;

/// Asks now and then whether rays are still to be traced, since one camera ray may cause more of them than can ever be
/// traced.
#[derive(Clone, Copy)]
pub struct Patience<'a> {
    is_over: &'a (dyn Fn(usize) -> bool + Sync),
    /// The number of rays between two questions, without those to lights.
    at_once: u32,
    /// The number of rays until it asks again.
    left: u32,
    /// Whether no more rays are traced.
    pub has_ended: bool,
}

impl<'a> Patience<'a> {
    /// Follows rays until this is true, given the number of rays that wait. Each may cause a ray to each of `lights` lights.
    pub fn until(is_over: &'a (dyn Fn(usize) -> bool + Sync), lights: usize) -> Self {
        let at_once = (RAYS_AT_ONCE / (1 + lights)).max(1) as u32;
        Self { is_over, at_once, left: at_once, has_ended: false }
    }

    /// Follows all rays.
    pub fn endless() -> Self {
        Self::until(&|_| false, 0)
    }

    /// Whether the next ray is not to be followed, nor any after it. So many rays wait.
    #[inline(always)]
    pub fn ends(&mut self, waiting: usize) -> bool {
        self.left -= 1;
        self.left == 0 && self.ask(waiting)
    }

    /// Notes that this number of rays from the camera was traced.
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
