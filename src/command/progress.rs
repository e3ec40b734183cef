//! Progress: one line on standard error that tells how far a run has come.

use super::log::has_reader;
use raytracer::cli::ShowProgress;
use raytracer::render;
use std::io::{Write, stderr};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Erases the line and returns to its start.
const ERASE: &str = "\r\x1b[2K";

/// The time after which a terminal shows the line, so that short runs have none.
const DELAY: Duration = Duration::from_secs(1);
/// The time between two texts of the line on a terminal.
const INTERVAL: Duration = Duration::from_millis(200);
/// The time between two lines elsewhere.
const LINE_INTERVAL: Duration = Duration::from_secs(10);

/// Where the line goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sink {
    Nothing,
    /// One line, which is written again and again.
    Terminal,
    /// A line after the other.
    Lines,
}

/// The line that tells how far a run has come.
pub struct ProgressLine {
    sink: Sink,
    start: Instant,
    /// When there is to be another text.
    next: Mutex<Duration>,
}

impl ProgressLine {
    /// The progress of work that starts now.
    pub fn new(wish: ShowProgress) -> Self {
        let sink = Sink::of(wish, has_reader());
        let next = Mutex::new(if sink == Sink::Lines { LINE_INTERVAL } else { DELAY });
        Self { sink, start: Instant::now(), next }
    }

    /// Shows the text for the time that has passed, if it is time for another one. The text must be escaped.
    pub fn show(&self, text: impl FnOnce(Duration) -> String) {
        if self.sink == Sink::Nothing {
            return;
        }
        let passed = self.start.elapsed();
        if let Ok(mut next) = self.next.try_lock()
            && passed >= *next
        {
            *next = passed + self.sink.interval();
            self.print(&text(passed));
        }
    }

    /// Erases the line.
    pub fn end(&self) {
        if self.sink == Sink::Terminal && self.next.lock().is_ok_and(|next| *next > DELAY) {
            write(ERASE);
        }
    }

    fn print(&self, text: &str) {
        match self.sink {
            Sink::Nothing => {}
            Sink::Terminal => write(&format!("{ERASE}{text}")),
            Sink::Lines => write(&format!("{text}\n")),
        }
    }
}

impl Sink {
    fn of(wish: ShowProgress, is_terminal: bool) -> Self {
        match (wish, is_terminal) {
            (ShowProgress::Never, _) | (ShowProgress::OnTerminal, false) => Self::Nothing,
            (_, true) => Self::Terminal,
            (ShowProgress::Always, false) => Self::Lines,
        }
    }

    fn interval(self) -> Duration {
        if self == Self::Lines { LINE_INTERVAL } else { INTERVAL }
    }
}

/// Where nobody reads it there is nobody to tell.
fn write(text: &str) {
    let mut terminal = stderr();
    let _ = terminal.write_all(text.as_bytes()).and_then(|()| terminal.flush());
}

/// How far work on rows has come after this time, how long all of it takes at this speed, and how many rays are cast in
/// a second if they are counted.
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

    #[test]
    fn the_line_is_for_terminals_unless_it_is_asked_for() {
        use ShowProgress::{Always, Never, OnTerminal};
        for (wish, on_terminal, elsewhere) in [
            (OnTerminal, Sink::Terminal, Sink::Nothing),
            (Always, Sink::Terminal, Sink::Lines),
            (Never, Sink::Nothing, Sink::Nothing),
        ] {
            assert_eq!([true, false].map(|is| Sink::of(wish, is)), [on_terminal, elsewhere], "{wish:?}");
        }
    }

    #[test]
    fn texts_come_after_a_delay_and_then_at_intervals() {
        let told = Mutex::new(0);
        let count = |progress: &ProgressLine| {
            progress.show(|_| {
                *told.lock().unwrap() += 1;
                String::new()
            });
            *told.lock().unwrap()
        };
        for (sink, first) in [(Sink::Terminal, DELAY), (Sink::Lines, LINE_INTERVAL)] {
            *told.lock().unwrap() = 0;
            let Some(start) = Instant::now().checked_sub(first) else { return };
            let next = |wait| Mutex::new(wait);
            let late = ProgressLine { sink, start, next: next(first) };
            assert_eq!([count(&late), count(&late)], [1, 1], "{sink:?}");
            let early = ProgressLine { sink, start, next: next(first + Duration::from_secs(3600)) };
            assert_eq!(count(&early), 1);
        }
        let silent = ProgressLine { sink: Sink::Nothing, start: Instant::now(), next: Mutex::default() };
        assert_eq!(count(&silent), 1);
    }
}
