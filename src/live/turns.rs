//! Which requests of a page are overtaken by a later one.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Pages whose turns are remembered.
const PAGES: usize = 16;

/// The newest turn of each page, the page that asked first coming first.
#[derive(Default)]
pub struct Turns(Mutex<Vec<(u64, Arc<AtomicU64>)>>);

/// A request's place among those of its page.
#[derive(Clone)]
pub struct Turn {
    number: u64,
    newest: Arc<AtomicU64>,
}

impl Turn {
    /// Whether the page has asked for something later.
    pub fn is_overtaken(&self) -> bool {
        self.newest.load(Ordering::Relaxed) > self.number
    }
}

impl Turns {
    /// Notes that a page asks.
    pub fn turn(&self, page: u64, number: u64) -> Turn {
        let mut turns = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let newest = match turns.iter().find(|(known, _)| *known == page) {
            Some((_, newest)) => newest.clone(),
            None => {
                let surplus = (turns.len() + 1).saturating_sub(PAGES);
                turns.drain(..surplus);
                turns.push((page, Arc::default()));
                turns[turns.len() - 1].1.clone()
            }
        };
        newest.fetch_max(number, Ordering::Relaxed);
        Turn { number, newest }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_overtakes_those_before_it_on_its_own_page() {
        let turns = Turns::default();
        let (first, other) = (turns.turn(1, 1), turns.turn(2, 1));
        assert!(!first.is_overtaken());
        let second = turns.turn(1, 2);
        assert_eq!([&first, &second, &other].map(Turn::is_overtaken), [true, false, false]);
        assert!(turns.turn(1, 1).is_overtaken(), "what comes late is overtaken at once");
    }

    #[test]
    fn pages_are_forgotten_in_their_order() {
        let turns = Turns::default();
        (0..3 * PAGES as u64).for_each(|page| drop(turns.turn(page, 7)));
        assert_eq!(turns.0.lock().unwrap().len(), PAGES);
        assert!(!turns.turn(0, 1).is_overtaken() && turns.turn(3 * PAGES as u64 - 1, 1).is_overtaken());
    }
}
