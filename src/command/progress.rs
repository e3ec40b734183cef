//! The progress of a run, in a line on standard error.

use super::log::has_reader;
use crate::cli::ShowProgress;
use crate::render;
use std::io::{Write, stderr};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// The way to show one text after another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Style {
    /// The time before the first text.
    delay: Duration,
    /// The time between two texts.
    interval: Duration,
    /// Comes before a text, and after the last one.
    before: &'static str,
    /// Comes after each text.
    after: &'static str,
}

/// One line that each text overwrites. Short runs have none.
const TERMINAL: Style = Style {
    delay: Duration::from_secs(1),
    interval: Duration::from_millis(200),
    // Erases the line and returns to its start.
    before: "\r\x1b[2K",
    after: "",
};
/// A new line for each text.
const LINES: Style =
    Style { delay: Duration::from_secs(10), interval: Duration::from_secs(10), before: "", after: "\n" };

/// The line that shows the progress. Dropping it erases the line.
pub struct ProgressLine {
    /// None shows nothing.
    style: Option<Style>,
    start: Instant,
    /// The time of the next text.
    next: Mutex<Duration>,
}

impl ProgressLine {
    /// The progress of work that starts now.
    pub fn new(wish: ShowProgress) -> Self {
        Self::styled(style(wish, has_reader()), Instant::now())
    }

    fn styled(style: Option<Style>, start: Instant) -> Self {
        Self { style, start, next: Mutex::new(style.map_or(Duration::MAX, |style| style.delay)) }
    }

    /// Shows the text for the time that has passed, if it is time for another one. The text must be escaped.
    pub fn show(&self, text: impl FnOnce(Duration) -> String) {
        let Some(style) = self.style else { return };
        let passed = self.start.elapsed();
        if let Ok(mut next) = self.next.try_lock()
            && passed >= *next
        {
            *next = passed + style.interval;
            let text = [style.before, &text(passed), style.after].concat();
            // An error is ignored: there may be no reader.
            let _ = stderr().write_all(text.as_bytes());
        }
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        if let (Some(style), Ok(next)) = (self.style, self.next.get_mut())
            && *next > style.delay
        {
            let _ = stderr().write_all(style.before.as_bytes());
        }
    }
}

fn style(wish: ShowProgress, is_terminal: bool) -> Option<Style> {
    match (wish, is_terminal) {
        (ShowProgress::Never, _) | (ShowProgress::OnTerminal, false) => None,
        (_, true) => Some(TERMINAL),
        (ShowProgress::Always, false) => Some(LINES),
    }
}

/// Formats the progress of work on rows after this time, with the time for all rows at this speed, and the rays per
/// second if they are counted.
pub fn rows_text(doing: &str, progress: render::Progress, passed: Duration) -> String {
    let render::Progress { done, rows, rays } = progress;
    let whole = passed.mul_f64(rows as f64 / done.max(1) as f64);
    let percent = 100 * done / rows.max(1);
    let rate = rays as f64 / passed.as_secs_f64() / 1e6;
    let rate = if rays > 0 { format!("  {rate:.1} Mrays/s") } else { String::new() };
    format!("{doing} {percent:3} %  row {done}/{rows}  {} of about {}{rate}", clock(passed), clock(whole))
}

/// Minutes and seconds, and hours if there are any.
fn clock(time: Duration) -> String {
    let seconds = time.as_secs();
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    if hours > 0 { format!("{hours}:{minutes:02}:{seconds:02}") } else { format!("{minutes}:{seconds:02}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

    #[test]
    fn the_line_is_for_terminals_unless_it_is_asked_for() {
        use ShowProgress::{Always, Never, OnTerminal};
        for (wish, on_terminal, elsewhere) in
            [(OnTerminal, Some(TERMINAL), None), (Always, Some(TERMINAL), Some(LINES)), (Never, None, None)]
        {
            assert_eq!([true, false].map(|is| style(wish, is)), [on_terminal, elsewhere], "{wish:?}");
        }
    }

    #[test]
    fn texts_come_after_a_delay_and_then_at_intervals() {
        let count = |style: Option<Style>, start: Instant| {
            let told = AtomicUsize::new(0);
            let progress = ProgressLine::styled(style, start);
            for _ in 0..2 {
                progress.show(|_| told.fetch_add(1, Relaxed).to_string());
            }
            told.into_inner()
        };
        let now = Instant::now();
        for style in [TERMINAL, LINES] {
            let Some(start) = now.checked_sub(style.delay) else { return };
            assert_eq!(count(Some(Style { interval: Duration::from_secs(3600), ..style }), start), 1);
            assert_eq!(count(Some(Style { delay: Duration::from_secs(3600), ..style }), start), 0);
        }
        assert_eq!(count(None, now), 0);
    }

    #[test]
    fn the_line_tells_the_share_the_row_the_time_and_the_speed() {
        let text = |done, rows, rays, seconds| {
            rows_text("rendering", render::Progress { done, rows, rays }, Duration::from_secs(seconds))
        };
        assert_eq!(
            text(1480, 4000, 260_400_000, 21),
            "rendering  37 %  row 1480/4000  0:21 of about 0:56  12.4 Mrays/s"
        );
        assert_eq!(text(4000, 4000, 0, 3700), "rendering 100 %  row 4000/4000  1:01:40 of about 1:01:40");
        assert_eq!(
            text(1, 30_000, 4, 61),
            "rendering   0 %  row 1/30000  1:01 of about 508:20:00  0.0 Mrays/s"
        );
    }
}
