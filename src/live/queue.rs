//! The requests that are worked on: a bounded number of them, each on threads of its own, until nobody waits for its
//! answer any more.
//!
//! Work ends by its [`Stop`], which it asks often. Its place is free when it has ended. Where all places are taken and
//! another request waits, the one that came last leaves after a moment, and starts again when two places are free. So the
//! last place serves short requests, however many long ones there are, and no request leaves twice.

use super::http::Answer;
use super::limits::{FEW_BYTES, MAX_BYTES, MAX_PLACES};
use crate::tools::explain::Stop;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::collections::HashMap;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How long a request is worked on before it makes room for one that may be shorter.
const MOMENT: Duration = Duration::from_millis(250);
/// How often is looked whether somebody still waits.
const LOOK: Duration = Duration::from_millis(20);
/// How many pages and kinds of their questions are remembered.
const MAX_TURNS: usize = 64;

pub struct Queue {
    /// The number of threads for each request.
    threads: usize,
    state: Mutex<State>,
    freed: Condvar,
}

#[derive(Default)]
struct State {
    /// The numbers and the bytes of the requests that have a place, in the order in which they got it.
    placed: Vec<(u64, u64)>,
    /// The bytes of those that wait for their first place.
    waiting: Vec<u64>,
    next: u64,
    /// The threads of the free places, as far as they have been started.
    threads: Vec<Arc<ThreadPool>>,
    /// The newest number of each page and kind.
    turns: HashMap<(u64, &'static str), u64>,
}

/// A request's place, which is free again when this is dropped.
struct Place {
    queue: Arc<Queue>,
    number: u64,
    threads: Arc<ThreadPool>,
}

/// The number of a question among those of a kind that a page asks.
pub type Turn = (u64, &'static str, u64);

impl State {
    /// Returns true if there is memory for another request of so many bytes, if those of one that leaves are free.
    fn has_room(&self, bytes: u64, leaving: u64) -> bool {
        let taken = self.placed.iter().fold(0, |sum: u64, (_, bytes)| sum.saturating_add(*bytes));
        bytes <= FEW_BYTES || taken == leaving || (taken - leaving).saturating_add(bytes) <= MAX_BYTES
    }
}

impl Queue {
    pub fn new(threads: usize) -> Arc<Self> {
        Arc::new(Self { threads, state: Mutex::default(), freed: Condvar::new() })
    }

    /// Notes that a page asks a question of a kind, with a number; by default it comes after all before it.
    pub fn turn(&self, page: u64, kind: &'static str, number: Option<u64>) -> Turn {
        let mut state = self.lock();
        state.next += 1;
        let number = number.unwrap_or(state.next);
        if state.turns.len() >= MAX_TURNS {
            // The older ones of what is forgotten are answered, too.
            state.turns.clear();
        }
        let newest = state.turns.entry((page, kind)).or_default();
        *newest = number.max(*newest);
        (page, kind, number)
    }

    /// Returns true if the page has asked for something later.
    pub fn is_overtaken(&self, (page, kind, number): Turn) -> bool {
        self.lock().turns.get(&(page, kind)).is_some_and(|&newest| newest > number)
    }

    /// Does work that takes this number of bytes when there is a place for it, and returns the result. `gives_up` is asked
    /// often whether its client has left, and what to answer then.
    pub fn run<T: Send + 'static>(
        self: &Arc<Self>,
        bytes: u64,
        deadline: Instant,
        gives_up: &mut dyn FnMut() -> Option<Answer>,
        work: impl Fn(&Stop) -> T + Send + Sync + 'static,
    ) -> Result<T, Answer> {
        let work = Arc::new(work);
        let mut places = MAX_PLACES;
        loop {
            let place = self.place(places, bytes, gives_up)?;
            let (number, threads, start) = (place.number, place.threads.clone(), Instant::now());
            let (stop, (sender, receiver)) = (Arc::new(Stop::at(deadline)), channel());
            let (own_work, own_stop) = (work.clone(), stop.clone());
            threads.spawn(move || {
                let found = own_work(&own_stop);
                drop(place);
                // Its client may have left.
                let _ = sender.send(found);
            });
            let mut leaves = false;
            loop {
                match receiver.recv_timeout(LOOK) {
                    Ok(found) if !leaves => return Ok(found),
                    Ok(_) => break,
                    Err(RecvTimeoutError::Disconnected) => {
                        return Err(Answer::text(503, "the work has ended without a result"));
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                }
                if let Some(answer) = gives_up() {
                    stop.cancel();
                    return Err(answer);
                }
                if !leaves && start.elapsed() > MOMENT && self.must_leave(number) {
                    leaves = true;
                    stop.cancel();
                }
            }
            places = MAX_PLACES - 1;
        }
    }

    /// Waits until fewer than `places` are taken and there is enough memory, and takes a place.
    fn place(
        self: &Arc<Self>,
        places: usize,
        bytes: u64,
        gives_up: &mut dyn FnMut() -> Option<Answer>,
    ) -> Result<Place, Answer> {
        let is_first = places == MAX_PLACES;
        self.lock().waiting.extend(is_first.then_some(bytes));
        let stop_waiting = |state: &mut State| {
            if is_first && let Some(own) = state.waiting.iter().position(|&waiting| waiting == bytes) {
                state.waiting.swap_remove(own);
            }
        };
        let mut state = loop {
            // It may look at the state.
            if let Some(answer) = gives_up() {
                stop_waiting(&mut self.lock());
                return Err(answer);
            }
            let state = self.lock();
            if state.placed.len() < places && state.has_room(bytes, 0) {
                break state;
            }
            drop(self.freed.wait_timeout(state, LOOK));
        };
        stop_waiting(&mut state);
        let build = || ThreadPoolBuilder::new().num_threads(self.threads).build().map(Arc::new);
        let threads = state.threads.pop().map_or_else(build, Ok);
        let threads = threads.map_err(|error| Answer::text(503, &format!("no threads: {error}")))?;
        state.next += 1;
        let number = state.next;
        state.placed.push((number, bytes));
        Ok(Place { queue: self.clone(), number, threads })
    }

    /// Returns true if the request with this number has the last place, and another one could have it.
    fn must_leave(&self, number: u64) -> bool {
        let state = self.lock();
        let last =
            state.placed.last().filter(|(last, _)| *last == number && state.placed.len() == MAX_PLACES);
        last.is_some_and(|&(_, own)| state.waiting.iter().any(|&bytes| state.has_room(bytes, own)))
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut state = self.queue.lock();
        state.placed.retain(|&(number, _)| number != self.number);
        state.threads.push(self.threads.clone());
        drop(state);
        self.queue.freed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread;

    fn busy(stop: &Stop) -> bool {
        while !stop.is_over() {
            thread::sleep(Duration::from_millis(1));
        }
        false
    }

    fn in_a_minute() -> Instant {
        Instant::now() + Duration::from_secs(60)
    }

    #[test]
    fn a_turn_overtakes_those_before_it_on_its_own_page() {
        let queue = Queue::new(1);
        let (first, other, kind) =
            (queue.turn(1, "a", None), queue.turn(2, "a", None), queue.turn(1, "b", None));
        assert!(!queue.is_overtaken(first));
        let second = queue.turn(1, "a", None);
        let overtaken = [first, second, other, kind].map(|turn| queue.is_overtaken(turn));
        assert_eq!(overtaken, [true, false, false, false]);
        let late = queue.turn(1, "a", Some(1));
        assert!(queue.is_overtaken(late), "one that comes late is overtaken at once");
        for page in 3..3 * MAX_TURNS as u64 {
            queue.turn(page, "a", None);
        }
        assert!(queue.lock().turns.len() <= MAX_TURNS);
    }

    #[test]
    fn a_request_that_is_overtaken_needs_no_place() {
        let queue = Queue::new(1);
        let first = queue.turn(1, "a", None);
        queue.turn(1, "a", None);
        let mut gives_up = || queue.is_overtaken(first).then(|| Answer::text(409, "overtaken"));
        assert_eq!(queue.run(0, in_a_minute(), &mut gives_up, |_| ()).unwrap_err().status, 409);
        assert!(queue.lock().waiting.is_empty());
    }

    #[test]
    fn work_ends_when_nobody_waits_for_it_and_frees_its_place() {
        let queue = Queue::new(1);
        let mut looks = 0;
        let mut gives_up = || {
            looks += 1;
            (looks > 2).then(|| Answer::text(408, "left"))
        };
        assert_eq!(queue.run(0, in_a_minute(), &mut gives_up, busy).unwrap_err().status, 408);
        while !queue.lock().placed.is_empty() {
            thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn the_last_place_serves_others_and_the_work_on_it_starts_again() {
        let queue = Queue::new(1);
        let end = Stop::at(in_a_minute());
        thread::scope(|scope| {
            let mut long = vec![];
            for _ in 0..MAX_PLACES {
                long.push(scope.spawn(|| {
                    let mut gives_up = || end.is_over().then(|| Answer::text(408, "left"));
                    queue.run(0, in_a_minute(), &mut gives_up, busy).unwrap_err().status
                }));
            }
            while queue.lock().placed.len() < MAX_PLACES {
                thread::sleep(Duration::from_millis(1));
            }
            assert!((0..3).all(|_| queue.run(0, in_a_minute(), &mut || None, |_| true).unwrap()));
            assert_eq!(queue.lock().placed.len(), MAX_PLACES - 1);
            end.cancel();
            assert!(long.into_iter().all(|long| long.join().unwrap() == 408));
        });
    }

    #[test]
    fn memory_is_shared_and_one_that_needs_all_of_it_is_alone() {
        let queue = Queue::new(1);
        let place = |bytes| {
            let mut looks = 0;
            queue.place(MAX_PLACES, bytes, &mut || {
                looks += 1;
                (looks > 2).then(|| Answer::text(408, "left"))
            })
        };
        let huge = place(u64::MAX).unwrap();
        assert!(place(FEW_BYTES + 1).is_err() && place(FEW_BYTES).is_ok());
        drop(huge);
        let half = place(MAX_BYTES / 2).unwrap();
        assert!(place(MAX_BYTES / 2 + 1).is_err() && place(MAX_BYTES / 2).is_ok());
        drop(half);
    }
}
