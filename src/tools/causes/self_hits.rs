//! Rays that hit the surface that they leave, by rounding.
//!
//! Which rays do depends on every rounding, so their picture cannot be reproduced. But a pixel can have only few such
//! colours, one for each choice of the rays that hit their own surface.

use super::paint::Painter;
use super::student::HitsItself;
use crate::picture::Color;
use glam::DVec2;
use std::sync::atomic::{AtomicU32, Ordering};

/// The largest number of choices of rays tried for a pixel.
const MAX_CHOICES: usize = 256;
/// The largest number of rays of a pixel that have a choice.
const MAX_RAYS: u32 = 32;

/// Returns true if a pixel, with its point moved, has an accepted colour when some of the rays that `may_hit` its own
/// surface do. `pixel` is its column and row from the top left.
pub fn is_made(
    painter: &Painter,
    pixel: [usize; 2],
    moved: DVec2,
    may_hit: HitsItself,
    accepts: &dyn Fn(Color) -> bool,
) -> bool {
    // One bit for each ray with a choice, in the order in which they start.
    let mut chosen = 0_u32;
    for _ in 0..MAX_CHOICES {
        let started = AtomicU32::new(0);
        let hits_itself = |why, surface: &_, direction| {
            let has_choice = may_hit(why, surface, direction);
            let number = if has_choice { started.fetch_add(1, Ordering::Relaxed) } else { MAX_RAYS };
            number < MAX_RAYS && chosen >> number & 1 != 0
        };
        let color = painter.with_self_hits(&hits_itself, |painter| painter.pixels(&[pixel], moved)[0]);
        if accepts(color) {
            return true;
        }
        // The next choice sets the last ray not chosen, and clears those after it.
        let started = started.into_inner().min(MAX_RAYS);
        let Some(last) = (0..started).rev().find(|ray| chosen >> ray & 1 == 0) else { return false };
        chosen = chosen & ((1 << last) - 1) | 1 << last;
    }
    false
}
