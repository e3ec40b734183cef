//! The end of paths that are no longer wanted.

use std::fmt;

/// The number of secondary rays that are followed between two questions: a few milliseconds' work.
const RAYS_AT_ONCE: u32 = 1 << 12;

/// The number of secondary rays of one camera ray that may wait at once, about: they take some 30 MB of each thread. Only
/// rays that split again and again come near it, and each bounce doubles their number.
pub const MOST_WAITING: usize = 1 << 18;

/// Asks now and then whether secondary rays are still to be followed, since one camera ray may cause more of them than
/// can ever be traced.
#[derive(Clone, Copy)]
pub(crate) struct Patience<'a> {
    is_over: &'a (dyn Fn(usize) -> bool + Sync),
    /// The number of rays until it asks again.
    left: u32,
    /// Whether rays were not followed.
    pub has_ended: bool,
}

impl<'a> Patience<'a> {
    /// Follows rays until this is true, given the number of rays that wait.
    pub fn until(is_over: &'a (dyn Fn(usize) -> bool + Sync)) -> Self {
        Self { is_over, left: RAYS_AT_ONCE, has_ended: false }
    }

    /// Follows all rays.
    pub fn endless() -> Self {
        Self::until(&|_| false)
    }

    /// Whether the next ray is not to be followed, nor any after it. So many rays wait.
    #[inline(always)]
    pub fn ends(&mut self, waiting: usize) -> bool {
        self.left -= 1;
        self.left == 0 && self.ask(waiting)
    }

    #[cold]
    fn ask(&mut self, waiting: usize) -> bool {
        self.has_ended = self.has_ended || (self.is_over)(waiting);
        self.left = if self.has_ended { 1 } else { RAYS_AT_ONCE };
        self.has_ended
    }
}

impl fmt::Debug for Patience<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Patience").field("left", &self.left).field("has_ended", &self.has_ended).finish()
    }
}
