//! Runs requests, each on threads of its own, until its client leaves.
//!
//! Work checks its [`Stop`] often, which ends it. Requests have no order: the system shares the processors among them,
//! so that a long one does not delay a short one. The number of connections bounds their number. Their memory is
//! bounded here.

use super::http::Answer;
use super::limits::{FEW_BYTES, MAX_BYTES};
use crate::tools::explain::Stop;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::collections::HashMap;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// The interval at which a request looks whether its client still waits, and whether there is memory.
const LOOK: Duration = Duration::from_millis(20);
/// The number of pairs of a page and a kind of question that are remembered.
const MAX_TURNS: usize = 64;

pub struct Workers {
    /// The number of threads for each request.
    threads: usize,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// The bytes that the requests take.
    taken: u64,
    /// The threads that have been started and do nothing.
    idle: Vec<ThreadPool>,
    /// The newest number of each page and kind.
    turns: HashMap<(u64, &'static str), u64>,
}

/// A page, a kind of question, and the number of a question of this kind.
pub type Turn = (u64, &'static str, u64);

impl Workers {
    pub fn new(threads: usize) -> Self {
        Self { threads, state: Mutex::default() }
    }

    /// Notes that a page asks a question of a kind. Those with larger numbers come later.
    pub fn note(&self, (page, kind, number): Turn) {
        let turns = &mut self.lock().turns;
        if turns.len() >= MAX_TURNS {
            // Older questions of a forgotten pair are answered too.
            turns.clear();
        }
        let newest = turns.entry((page, kind)).or_default();
        *newest = number.max(*newest);
    }

    /// Returns true if the page has asked for something later.
    pub fn is_overtaken(&self, (page, kind, number): Turn) -> bool {
        self.lock().turns.get(&(page, kind)).is_some_and(|&newest| newest > number)
    }

    /// Waits for memory of this number of bytes, runs `work`, and returns its result. `gives_up` is called often, and
    /// returns an answer if the work is to end.
    pub fn run<T: Send>(
        &self,
        bytes: u64,
        deadline: Instant,
        gives_up: &mut dyn FnMut() -> Option<Answer>,
        work: impl FnOnce(&Stop) -> T + Send,
    ) -> Result<T, Answer> {
        let threads = self.start(bytes, gives_up)?;
        let (stop, mut refusal) = (Stop::at(deadline), None);
        let (sender, receiver) = channel();
        let found = threads.in_place_scope(|scope| {
            scope.spawn(|_| drop(sender.send(work(&stop))));
            loop {
                match receiver.recv_timeout(LOOK) {
                    Err(RecvTimeoutError::Timeout) if refusal.is_none() => {
                        refusal = gives_up();
                        refusal.iter().for_each(|_| stop.cancel());
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                    found => break found,
                }
            }
        });
        let mut state = self.lock();
        state.taken -= bytes;
        state.idle.push(threads);
        drop(state);
        // The result of stopped work is incomplete.
        match refusal.or_else(|| stop.is_over().then(gives_up).flatten()) {
            Some(answer) => Err(answer),
            None => found.map_err(|_| Answer::text(503, "the work has ended without a result")),
        }
    }

    /// Waits until there is enough memory, and returns threads.
    fn start(&self, bytes: u64, gives_up: &mut dyn FnMut() -> Option<Answer>) -> Result<ThreadPool, Answer> {
        let mut state = loop {
            // It may look at the state.
            if let Some(answer) = gives_up() {
                return Err(answer);
            }
            let state = self.lock();
            let all = state.taken.saturating_add(bytes);
            if bytes <= FEW_BYTES || state.taken == 0 || all <= MAX_BYTES {
                break state;
            }
            drop(state);
            thread::sleep(LOOK);
        };
        let build = || ThreadPoolBuilder::new().num_threads(self.threads).build();
        let threads = state.idle.pop().map_or_else(build, Ok);
        let threads = threads.map_err(|error| Answer::text(503, &format!("no threads: {error}")))?;
        state.taken += bytes;
        Ok(threads)
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn busy(stop: &Stop) -> bool {
        while !stop.is_over() {
            thread::sleep(Duration::from_millis(1));
        }
        false
    }

    /// Gives up after a moment.
    fn leaves() -> impl FnMut() -> Option<Answer> {
        let mut looks = 0;
        move || {
            looks += 1;
            (looks > 2).then(|| Answer::text(408, "left"))
        }
    }

    fn in_a_minute() -> Instant {
        Instant::now() + Duration::from_secs(60)
    }

    #[test]
    fn a_turn_overtakes_those_before_it_on_its_own_page() {
        let workers = Workers::new(1);
        let turns = [(1, "a", 7), (1, "a", 9), (2, "a", 1), (1, "b", 1)];
        turns.into_iter().for_each(|turn| workers.note(turn));
        assert_eq!(turns.map(|turn| workers.is_overtaken(turn)), [true, false, false, false]);
        workers.note((1, "a", 8));
        assert!(workers.is_overtaken((1, "a", 8)), "one that comes late is overtaken at once");
        for page in 3..3 * MAX_TURNS as u64 {
            workers.note((page, "a", 1));
        }
        assert!(workers.lock().turns.len() <= MAX_TURNS);
    }

    #[test]
    fn a_request_that_is_given_up_is_not_worked_on() {
        let workers = Workers::new(1);
        let mut gives_up = || Some(Answer::text(409, "overtaken"));
        let found = workers.run(0, in_a_minute(), &mut gives_up, |_| panic!("it is worked on"));
        assert_eq!(found.map(|()| 200).unwrap_err().status, 409);
    }

    #[test]
    fn work_ends_when_nobody_waits_for_it_and_frees_its_memory() {
        let workers = Workers::new(1);
        assert_eq!(workers.run(1, in_a_minute(), &mut leaves(), busy).unwrap_err().status, 408);
        let state = workers.lock();
        assert_eq!((state.taken, state.idle.len()), (0, 1));
    }

    #[test]
    fn short_work_waits_for_no_long_one() {
        let workers = Workers::new(1);
        let end = Stop::at(in_a_minute());
        thread::scope(|scope| {
            let long: Vec<_> = (0..9)
                .map(|_| {
                    scope.spawn(|| {
                        let mut gives_up = || end.is_over().then(|| Answer::text(408, "left"));
                        workers.run(1, in_a_minute(), &mut gives_up, busy).unwrap_err().status
                    })
                })
                .collect();
            while workers.lock().taken < 9 {
                thread::sleep(Duration::from_millis(1));
            }
            assert!((0..3).all(|_| workers.run(0, in_a_minute(), &mut || None, |_| true).unwrap()));
            assert_eq!(workers.lock().taken, 9);
            end.cancel();
            assert!(long.into_iter().all(|long| long.join().unwrap() == 408));
        });
    }

    #[test]
    fn memory_is_shared_and_one_that_needs_all_of_it_waits_for_all() {
        let workers = Workers::new(1);
        let start = |taken: u64, bytes| {
            workers.lock().taken = taken;
            workers.start(bytes, &mut leaves()).is_ok()
        };
        let huge = 2 * MAX_BYTES;
        assert!(start(0, huge) && !start(1, huge));
        assert!(start(huge, FEW_BYTES) && !start(huge, FEW_BYTES + 1));
        assert!(start(MAX_BYTES / 2, MAX_BYTES / 2) && !start(MAX_BYTES / 2, MAX_BYTES / 2 + 1));
    }
}
