//! Processes that do the work of requests, one at a time each, and that are ended when nobody waits for it any more.
//!
//! No loop of the renderer, the parsers and the tools has to look at a clock for that, and a request that takes all the
//! memory there is takes a worker with it, and not the page.

use super::limits::MAX_WORKERS;
use super::wire::{Order, Question, Reply, receive, send};
use std::io::{self, BufReader, BufWriter};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// How long a question works before it makes room for one that may be shorter.
const MOMENT: Duration = Duration::from_millis(250);
/// How often is looked whether somebody still waits.
const LOOK: Duration = Duration::from_millis(20);
/// How long a worker may take to stop by itself, which keeps its scene, and then to end by itself, which removes its
/// files.
const TIME_TO_STOP: Duration = Duration::from_millis(300);
const TIME_TO_END: Duration = Duration::from_millis(100);
/// Workers that are kept while there is nothing to do.
const RESTING: usize = 2;

/// Why there is no reply.
#[derive(Debug)]
pub enum Unanswered<W> {
    /// Nobody waits for it any more, for this reason.
    Stopped(W),
    /// The worker has ended.
    Ended,
    /// No worker can be started, for this reason.
    NotStarted(String),
}

/// The revision of a scene that was typed in, and the page's question with its text.
pub type TypedScene = (u64, Arc<[u8]>);

/// What a request brings along for a worker that does not have it.
#[derive(Clone, Default)]
pub struct Luggage {
    /// The scene that was typed in.
    pub scene: Option<TypedScene>,
    /// The picture to compare with.
    pub reference: Option<Arc<Reference>>,
}

/// A picture's file, as it was dropped on the page.
pub struct Reference {
    pub id: u64,
    pub name: String,
    pub file: Vec<u8>,
}

/// The workers.
pub struct Workers {
    command: Box<dyn Fn() -> io::Result<Command> + Send + Sync>,
    /// The text of the command line's scene, as the first worker has read it.
    text: OnceLock<Vec<u8>>,
    state: Mutex<State>,
    freed: Condvar,
}

#[derive(Default)]
struct State {
    /// The one that worked last is the last.
    resting: Vec<Worker>,
    /// The questions that have a place, by their numbers, in the order in which they got it.
    placed: Vec<u64>,
    /// How many questions wait for their first place.
    waiting: usize,
    next: u64,
}

/// A question's place among those that are worked on. It is free again when this is dropped.
///
/// Where all places are taken and another question waits, the one that came last leaves after a moment, and then waits
/// until two places are free. So the last place serves short questions, however many long ones there are, and no
/// question leaves twice.
struct Place<'w> {
    workers: &'w Workers,
    number: u64,
}

struct Worker {
    child: Child,
    to: BufWriter<ChildStdin>,
    replies: Receiver<(Reply, Vec<u8>)>,
    number: u64,
    /// What it has beside the command line's scene and picture.
    scene: Option<u64>,
    reference: Option<u64>,
    /// Whether its last question was for a picture, for which it stays prepared.
    paints: bool,
}

impl Workers {
    /// Workers that are started by this command.
    pub fn new(command: impl Fn() -> io::Result<Command> + Send + Sync + 'static) -> Self {
        let (text, state, freed) = Default::default();
        Self { command: Box::new(command), text, state, freed }
    }

    /// Has a question answered. `gives_up` is asked often whether nobody waits any more, and why.
    pub fn ask<W>(
        &self,
        question: Question,
        body: &[u8],
        luggage: &Luggage,
        gives_up: &mut dyn FnMut() -> Option<W>,
    ) -> Result<(Reply, Vec<u8>), Unanswered<W>> {
        let mut places = MAX_WORKERS;
        loop {
            let place = self.place(places, gives_up).map_err(Unanswered::Stopped)?;
            let start = Instant::now();
            let mut stops = || match gives_up() {
                None if start.elapsed() > MOMENT && place.must_leave() => Some(None),
                why => why.map(Some),
            };
            return match self.ask_one(question.clone(), body, luggage, &mut stops) {
                Err(Unanswered::Stopped(None)) => {
                    places = MAX_WORKERS - 1;
                    continue;
                }
                Err(Unanswered::Stopped(Some(why))) => Err(Unanswered::Stopped(why)),
                Err(Unanswered::Ended) => Err(Unanswered::Ended),
                Err(Unanswered::NotStarted(reason)) => Err(Unanswered::NotStarted(reason)),
                Ok(found) => Ok(found),
            };
        }
    }

    /// Waits until fewer than `places` are taken, and takes one.
    fn place<W>(&self, places: usize, gives_up: &mut dyn FnMut() -> Option<W>) -> Result<Place<'_>, W> {
        let mut state = self.lock();
        let is_first = usize::from(places == MAX_WORKERS);
        state.waiting += is_first;
        let mut why = None;
        while state.placed.len() >= places && why.is_none() {
            state = self.freed.wait_timeout(state, LOOK).unwrap_or_else(PoisonError::into_inner).0;
            why = gives_up();
        }
        state.waiting -= is_first;
        if let Some(why) = why {
            return Err(why);
        }
        state.next += 1;
        let number = state.next;
        state.placed.push(number);
        Ok(Place { workers: self, number })
    }

    /// Has a question that has a place answered by one worker.
    fn ask_one<W>(
        &self,
        mut question: Question,
        body: &[u8],
        luggage: &Luggage,
        gives_up: &mut dyn FnMut() -> Option<W>,
    ) -> Result<(Reply, Vec<u8>), Unanswered<W>> {
        let paints = question.path == "/picture";
        let mut worker =
            self.take(luggage.scene.as_ref().map(|(revision, _)| *revision), paints, gives_up)?;
        worker.number += 1;
        question.number = worker.number;
        let number = question.number;
        let mut parts = vec![body];
        if let Some((revision, typed)) = luggage.scene.as_ref().filter(|(it, _)| worker.scene != Some(*it)) {
            question.opens = Some(*revision);
            parts.push(typed);
            worker.scene = None;
        }
        if let Some(reference) = luggage.reference.as_ref().filter(|it| worker.reference != Some(it.id)) {
            question.reference = Some(reference.name.clone());
            parts.push(&reference.file);
            worker.reference = None;
        }
        worker.paints = paints;
        let sent = send(&mut worker.to, &Order::Answer(question), &parts);
        let found = sent.map_err(|_| Unanswered::Ended).and_then(|()| worker.reply(number, gives_up));
        match found {
            Ok((reply, answer)) => {
                if let Some((revision, _)) = luggage.scene.as_ref().filter(|_| reply.has_opened) {
                    worker.scene = Some(*revision);
                }
                if let Some(reference) = luggage.reference.as_ref() {
                    worker.reference = Some(reference.id);
                }
                self.give_back(worker);
                Ok((reply, answer))
            }
            Err(Unanswered::Stopped(why)) if worker.stops(number) => {
                self.give_back(worker);
                Err(Unanswered::Stopped(why))
            }
            Err(other) => {
                worker.end();
                Err(other)
            }
        }
    }

    /// A worker that rests, or a new one.
    fn take<W>(
        &self,
        scene: Option<u64>,
        paints: bool,
        gives_up: &mut dyn FnMut() -> Option<W>,
    ) -> Result<Worker, Unanswered<W>> {
        let mut state = self.lock();
        let has = |worker: &Worker| scene.is_none() || worker.scene == scene;
        let fits = |worker: &Worker| (has(worker), worker.paints == paints);
        let best = (0..state.resting.len()).max_by_key(|&place| fits(&state.resting[place]));
        if let Some(best) = best {
            return Ok(state.resting.remove(best));
        }
        drop(state);
        self.start(gives_up)
    }

    /// Starts a worker, which opens the scene.
    fn start<W>(&self, gives_up: &mut dyn FnMut() -> Option<W>) -> Result<Worker, Unanswered<W>> {
        let failed = |error: io::Error| Unanswered::NotStarted(format!("cannot start a worker: {error}"));
        let mut worker = (self.command)().and_then(Worker::start).map_err(failed)?;
        let known: Vec<&[u8]> = self.text.get().map(Vec::as_slice).into_iter().collect();
        let sent = send(&mut worker.to, &Order::Open, &known);
        let opened = sent.map_err(|_| Unanswered::Ended).and_then(|()| worker.reply(0, gives_up));
        match opened {
            Ok((Reply { status: 200, .. }, text)) => {
                self.text.get_or_init(|| text);
                Ok(worker)
            }
            Ok((_, message)) => {
                worker.end();
                Err(Unanswered::NotStarted(String::from_utf8_lossy(&message).into_owned()))
            }
            Err(error) => {
                worker.end();
                Err(error)
            }
        }
    }

    fn give_back(&self, worker: Worker) {
        let mut state = self.lock();
        state.resting.push(worker);
        let surplus = (state.resting.len() > RESTING).then(|| state.resting.remove(0));
        drop(state);
        surplus.into_iter().for_each(Worker::end);
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Place<'_> {
    /// Returns true if another question needs this place more.
    fn must_leave(&self) -> bool {
        let state = self.workers.lock();
        state.waiting > 0 && state.placed.len() == MAX_WORKERS && state.placed.last() == Some(&self.number)
    }
}

impl Drop for Place<'_> {
    fn drop(&mut self) {
        self.workers.lock().placed.retain(|&number| number != self.number);
        self.workers.freed.notify_all();
    }
}

impl Worker {
    fn start(mut command: Command) -> io::Result<Self> {
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn()?;
        let (Some(to), Some(from)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(io::ErrorKind::BrokenPipe.into());
        };
        let (sender, replies) = channel();
        let listen = move || {
            let mut from = BufReader::new(from);
            while let Ok((reply, mut parts)) = receive::<Reply>(&mut from) {
                if sender.send((reply, parts.pop().unwrap_or_default())).is_err() {
                    return;
                }
            }
        };
        let mut worker = Self {
            child,
            to: BufWriter::new(to),
            replies,
            number: 0,
            scene: None,
            reference: None,
            paints: false,
        };
        match thread::Builder::new().name("listener".into()).spawn(listen) {
            Ok(_) => Ok(worker),
            Err(error) => {
                let _ = worker.child.kill().and_then(|()| worker.child.wait());
                Err(error)
            }
        }
    }

    /// Waits for the reply to a question.
    fn reply<W>(
        &mut self,
        number: u64,
        gives_up: &mut dyn FnMut() -> Option<W>,
    ) -> Result<(Reply, Vec<u8>), Unanswered<W>> {
        loop {
            match self.replies.recv_timeout(LOOK) {
                Ok(found) if found.0.number == number => return Ok(found),
                Ok(_) => {}
                Err(RecvTimeoutError::Disconnected) => return Err(Unanswered::Ended),
                Err(RecvTimeoutError::Timeout) => {
                    if let Some(why) = gives_up() {
                        return Err(Unanswered::Stopped(why));
                    }
                }
            }
        }
    }

    /// Tells the worker to stop, and whether it does.
    fn stops(&mut self, number: u64) -> bool {
        let end = Instant::now() + TIME_TO_STOP;
        let mut is_over = || (Instant::now() > end).then_some(());
        number > 0
            && send(&mut self.to, &Order::Stop { number }, &[]).is_ok()
            && self.reply(number, &mut is_over).is_ok()
    }

    /// Ends the worker: it ends by itself where nobody can say anything to it, or is ended.
    fn end(self) {
        let Self { mut child, to, .. } = self;
        // What is left of an order that the worker did not take would wait for it.
        drop(to.into_parts());
        let end = Instant::now() + TIME_TO_END;
        while matches!(child.try_wait(), Ok(None)) && Instant::now() < end {
            thread::sleep(Duration::from_millis(5));
        }
        let _ = child.kill();
        let _ = child.wait();
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// What comes of a worker that is this script, if nobody waits longer than a fifth of a second.
    fn ask(script: &'static str) -> (Unanswered<()>, Duration) {
        let command = move || {
            let mut command = Command::new("sh");
            command.args(["-c", script]);
            Ok(command)
        };
        let (workers, start) = (Workers::new(command), Instant::now());
        let mut gives_up = || (start.elapsed() > Duration::from_millis(200)).then_some(());
        let found = workers.ask(Question::default(), b"", &Luggage::default(), &mut gives_up);
        assert!(workers.lock().placed.is_empty() && workers.lock().resting.is_empty());
        (found.unwrap_err(), start.elapsed())
    }

    #[test]
    fn a_worker_that_does_not_answer_is_ended() {
        for script in ["cat > /dev/null; :", "exec sleep 1000", "trap '' INT TERM HUP; while :; do :; done"] {
            let (reason, took) = ask(script);
            assert!(matches!(reason, Unanswered::Stopped(())), "{script}: {reason:?}");
            assert!(took < Duration::from_secs(1), "{script}: {took:?}");
        }
    }

    #[test]
    fn a_worker_that_ends_is_noticed() {
        for script in ["exit 1", "head -c 1 > /dev/null", "kill -KILL $$"] {
            let (reason, took) = ask(script);
            assert!(matches!(reason, Unanswered::Ended | Unanswered::Stopped(())), "{script}: {reason:?}");
            assert!(took < Duration::from_secs(1), "{script}: {took:?}");
        }
    }

    #[test]
    fn a_worker_that_cannot_be_started_is_told_of() {
        let workers = Workers::new(|| Ok(Command::new("/no/such/program")));
        let found = workers.ask(Question::default(), b"", &Luggage::default(), &mut || None::<()>);
        assert!(
            matches!(found, Err(Unanswered::NotStarted(reason)) if reason.starts_with("cannot start a worker: "))
        );
    }
}
