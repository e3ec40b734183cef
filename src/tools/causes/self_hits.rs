//! Rays that hit the surface that they leave, by rounding.
//!
//! Which rays do depends on every rounding, so their picture cannot be reproduced. But a pixel can have only few such
//! colours, one for each choice of the rays that hit their own surface.

use super::paint::Painter;
use super::student::HitsItself;
use crate::picture::Color;
use glam::DVec2;
use std::iter;
use std::sync::atomic::{AtomicU32, Ordering};

/// The largest number of choices of rays tried for a pixel.
const MAX_CHOICES: usize = 256;
/// The largest number of rays of a pixel that have a choice.
const MAX_RAYS: u32 = 32;

/// Returns the colours that a pixel has, with its point moved, when some of the rays that `may_hit` its own surface do.
/// `pixel` is its column and row from the top left.
pub fn possible_colors(
    painter: &Painter,
    pixel: [usize; 2],
    moved: DVec2,
    may_hit: HitsItself,
) -> impl Iterator<Item = Color> {
    let mut choice = Some(0_u32);
    let next_color = move || {
        let chosen = choice?;
        let started = AtomicU32::new(0);
        let hits_itself = |kind, surface: &_, direction| {
            let has_choice = may_hit(kind, surface, direction);
            let ray = if has_choice { started.fetch_add(1, Ordering::Relaxed) } else { MAX_RAYS };
            ray < MAX_RAYS && chosen >> ray & 1 != 0
        };
        let color = painter.pixel_with_self_hits(pixel, moved, &hits_itself);
        choice = next_choice(chosen, started.into_inner().min(MAX_RAYS));
        Some(color)
    };
    iter::from_fn(next_color).take(MAX_CHOICES)
}

/// Returns the next choice after one with which this number of rays started: it adds the last ray not chosen, and
/// removes those after it. A choice has a bit for each ray, in the order in which they start.
fn next_choice(chosen: u32, started: u32) -> Option<u32> {
    let last = (0..started).rev().find(|ray| chosen >> ray & 1 == 0)?;
    Some(chosen & ((1 << last) - 1) | 1 << last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_count_through_all_rays() {
        let choices: Vec<u32> = iter::successors(Some(0), |&chosen| next_choice(chosen, 3)).collect();
        assert_eq!(choices, [0b000, 0b100, 0b010, 0b110, 0b001, 0b101, 0b011, 0b111]);
        // A ray that is chosen may end the path, so fewer rays start.
        assert_eq!((next_choice(0b010, 2), next_choice(0b010, 4)), (Some(0b001), Some(0b1010)));
        assert_eq!(
            (next_choice(0, 0), next_choice(0, 32), next_choice(u32::MAX, 32)),
            (None, Some(1 << 31), None)
        );
    }
}
