//! Ends long work early. This is one rule for all work that may be long: it asks its [`Patience`] at least every few
//! milliseconds. If that is over, the work returns at once, and its result is not used.

use std::fmt;

/// Decides if work ends early. Any thread may ask.
pub trait Patience: Sync {
    /// Returns true if the work should end. From then on, it returns true every time.
    fn is_over(&self) -> bool;

    /// Returns an error if the work should end.
    fn check(&self) -> Result<(), Ended> {
        if self.is_over() { Err(Ended) } else { Ok(()) }
    }
}

/// The patience of work that runs to its end.
#[derive(Clone, Copy, Debug)]
pub struct Endless;

impl Patience for Endless {
    fn is_over(&self) -> bool {
        false
    }
}

impl fmt::Debug for dyn Patience + '_ {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Patience")
    }
}

/// The error of work that ended early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ended;

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("it was stopped")
    }
}

impl std::error::Error for Ended {}

/// Asks a patience once in some thousand steps. A step takes up to some hundred nanoseconds.
pub struct Steps<'a> {
    patience: &'a dyn Patience,
    left: usize,
}

/// The number of steps between two questions.
const STEPS: usize = 1 << 12;

impl<'a> Steps<'a> {
    /// Starts to count.
    pub fn new(patience: &'a dyn Patience) -> Self {
        Self { patience, left: STEPS }
    }

    /// Notes that this number of steps was taken. Returns an error if the work should end.
    #[inline]
    pub fn take(&mut self, steps: usize) -> Result<(), Ended> {
        if steps >= self.left {
            return self.ask(steps);
        }
        self.left -= steps;
        Ok(())
    }

    #[cold]
    fn ask(&mut self, steps: usize) -> Result<(), Ended> {
        // Many steps at once are as many questions, so that tests can count steps by the questions.
        let beyond = steps - self.left;
        self.left = STEPS - beyond % STEPS;
        (0..=beyond / STEPS).try_for_each(|_| self.patience.check())
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Counts the questions, and is over after a number of them.
    pub struct Counted {
        asked: AtomicUsize,
        most: usize,
    }

    impl Counted {
        pub fn up_to(most: usize) -> Self {
            Self { asked: AtomicUsize::new(0), most }
        }

        pub fn asked(&self) -> usize {
            self.asked.load(Ordering::Relaxed)
        }
    }

    impl Patience for Counted {
        fn is_over(&self) -> bool {
            self.asked.fetch_add(1, Ordering::Relaxed) >= self.most
        }
    }

    #[test]
    fn there_is_a_question_for_each_few_thousand_steps() {
        for steps in [1, 3, STEPS - 1, STEPS, 5 * STEPS + 7] {
            let patience = Counted::up_to(usize::MAX);
            let mut all = Steps::new(&patience);
            let count = 20 * STEPS / steps + 1;
            (0..count).for_each(|_| all.take(steps).unwrap());
            assert!(patience.asked().abs_diff(count * steps / STEPS) <= 1, "{steps}");
        }
    }

    #[test]
    fn the_first_question_after_the_end_ends_the_work() {
        let patience = Counted::up_to(2);
        let mut all = Steps::new(&patience);
        let taken = (0..100).take_while(|_| all.take(STEPS / 2).is_ok()).count();
        assert!((4..8).contains(&taken), "{taken}");
        assert_eq!(all.take(9 * STEPS), Err(Ended));
        assert!(!Endless.is_over());
    }
}
