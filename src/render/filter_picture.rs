//! The picture of a reconstruction filter.

use super::{Color, Progress, Stopped, Watch};
use crate::diagnostic::Diagnostic;
use crate::sampling::filter::Filter;
use glam::DVec2;

/// Draws the weights of a filter around the middle pixel. Each pixel is enlarged `zoom` times.
///
/// As in the course's program, the middle is half the width along both axes, pixels beyond the filter's
/// support are dark blue, and blue lines separate the pixels.
pub fn render_filter(
    filter: Filter,
    [width, height]: [usize; 2],
    zoom: usize,
    watch: Watch,
    take_row: &mut dyn FnMut(&[Color]) -> Result<(), Diagnostic>,
) -> Result<(), Stopped> {
    let middle = width / 2;
    let supported = middle.saturating_sub(filter.support())..=middle + filter.support();
    // The offset from the middle pixel's centre, in pixels.
    let offset = |k: usize| k as f64 / zoom as f64 - (middle as f64 + 0.5);
    for y in (0..=height * zoom).rev() {
        if watch(Progress { done: 0, rows: height, rays: 0 }).is_break() {
            return Err(Stopped::Cancelled { rows: 0 });
        }
        let color = |x: usize| {
            if x.is_multiple_of(zoom) || y.is_multiple_of(zoom) {
                Color::Z
            } else if supported.contains(&(x / zoom)) && supported.contains(&(y / zoom)) {
                Color::splat(filter.weight(DVec2::new(offset(x), offset(y))))
            } else {
                0.5 * Color::Z
            }
        };
        take_row(&(0..width * zoom + 1).map(color).collect::<Vec<_>>()).map_err(Stopped::Output)?;
    }
    Ok(())
}
