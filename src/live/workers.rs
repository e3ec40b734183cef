//! Runs requests, each on threads of its own, until its client leaves.
//!
//! Work checks its [`Stop`] often, which ends it. Requests have no order: the system shares the processors among them,
//! so that a long one does not delay a short one. The number of connections bounds their number. Their memory is
//! bounded here.

use super::http::Response;
use super::limits::{FEW_BYTES, MAX_BYTES, MAX_CONNECTIONS, STACK_BYTES};
use super::lock;
use crate::base::memory;
use crate::render::Stop;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Mutex;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// The interval at which a request looks whether its client still waits, and whether there is memory.
const LOOK: Duration = Duration::from_millis(20);

pub struct Workers {
    /// The number of threads for each request.
    threads: usize,
    /// The bytes that requests may take together.
    budget: u64,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// The bytes that the requests take.
    taken: u64,
    /// The threads that have been started and do nothing.
    idle: Vec<ThreadPool>,
}

impl Workers {
    pub fn new(threads: usize) -> Self {
        let connections = MAX_CONNECTIONS as u64 * STACK_BYTES;
        let budget = memory::free_space(MAX_BYTES + connections).saturating_sub(connections);
        Self { threads, budget, state: Mutex::default() }
    }

    /// Waits for memory, runs `work`, and returns its result. It may take this memory, and this time with the time for
    /// which it waits for others. `has_left` is called often, and stops the work if it returns true.
    pub fn run<T: Send>(
        &self,
        time: Duration,
        mut bytes: u64,
        has_left: &mut dyn FnMut() -> bool,
        work: impl FnOnce(&Stop) -> Result<T, Response> + Send,
    ) -> Result<T, Response> {
        let stop = &Stop::at(Instant::now() + time);
        if self.budget < MAX_BYTES {
            // In a limited address space the threads of a request count too, with something to spare.
            bytes = bytes.saturating_add((self.threads as u64 + 2) * STACK_BYTES);
        }
        let threads = self.start(bytes, stop, has_left)?;
        let (mut found, mut has_memory) = (None, true);
        threads.in_place_scope(|scope| {
            let (done, is_done) = channel::<()>();
            let found = &mut found;
            scope.spawn(move |_| {
                *found = Some(work(stop));
                drop(done);
            });
            while is_done.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                has_memory &= memory::has_reserve();
                if has_left() || !has_memory {
                    stop.cancel();
                }
            }
        });
        let mut state = lock(&self.state);
        state.taken -= bytes;
        if has_memory {
            state.idle.push(threads);
        } else {
            // Threads take memory too.
            state.idle.clear();
        }
        // The result of stopped work is incomplete. Complete work is kept, though its time may be over by now.
        found.filter(|_| !stop.has_stopped()).ok_or_else(if has_memory { too_long } else { no_memory })?
    }

    /// Waits until there is enough memory, and returns threads.
    fn start(
        &self,
        bytes: u64,
        stop: &Stop,
        has_left: &mut dyn FnMut() -> bool,
    ) -> Result<ThreadPool, Response> {
        let mut state = lock(&self.state);
        let is_small = bytes <= FEW_BYTES && self.budget == MAX_BYTES;
        while !is_small && state.taken > 0 && state.taken.saturating_add(bytes) > self.budget {
            drop(state);
            thread::sleep(LOOK);
            if has_left() || stop.is_over() {
                return Err(too_long());
            }
            state = lock(&self.state);
        }
        // With the lock, so that several requests do not start their threads where there is room for one.
        memory::keep_reserve().map_err(|_| no_memory())?;
        let build =
            || ThreadPoolBuilder::new().num_threads(self.threads).stack_size(STACK_BYTES as usize).build();
        let threads = state.idle.pop().map_or_else(build, Ok);
        let threads = threads.map_err(|error| Response::text(503, &format!("no threads: {error}")))?;
        state.taken += bytes;
        Ok(threads)
    }
}

/// The refusal of work that was stopped. A client that has left seldom reads it.
fn too_long() -> Response {
    Response::text(422, "this takes longer than a page may: choose a smaller picture, or fewer samples")
}

/// The refusal of work for which there is no memory, or which was ended for want of it.
fn no_memory() -> Response {
    Response::text(503, "not enough memory: try again, or choose a smaller picture")
}

#[cfg(test)]
mod tests {
    use super::*;

    const MINUTE: Duration = Duration::from_secs(60);

    fn busy(stop: &Stop) -> Result<(), Response> {
        while !stop.is_over() {
            thread::sleep(Duration::from_millis(1));
        }
        Ok(())
    }

    /// Leaves after a moment.
    fn leaves() -> impl FnMut() -> bool {
        let mut looks = 0;
        move || {
            looks += 1;
            looks > 2
        }
    }

    #[test]
    fn complete_work_is_kept_after_its_deadline_and_stopped_work_is_not() {
        let (workers, time) = (Workers::new(1), Duration::ZERO);
        assert_eq!(workers.run(time, 1, &mut || false, |_| Ok(7)), Ok(7));
        assert_eq!(workers.run(time, 1, &mut || false, busy), Err(too_long()));
    }

    #[test]
    fn memory_is_shared_and_one_that_needs_all_of_it_waits_for_all() {
        let workers = Workers::new(1);
        let start = |taken: u64, bytes| {
            lock(&workers.state).taken = taken;
            let stop = Stop::at(Instant::now() + MINUTE);
            workers.start(bytes, &stop, &mut leaves()).is_ok()
        };
        let huge = 2 * MAX_BYTES;
        assert!(start(0, huge) && !start(1, huge));
        assert!(start(huge, FEW_BYTES) && !start(huge, FEW_BYTES + 1));
        assert!(start(MAX_BYTES / 2, MAX_BYTES / 2) && !start(MAX_BYTES / 2, MAX_BYTES / 2 + 1));
    }
}
