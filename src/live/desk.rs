//! Hands the questions of pages to workers, and knows when nobody waits for an answer any more.

use super::answers::framed;
use super::http::{Answer, Refusal};
use super::limits::{MAX_PICTURE_FILE, MAX_QUESTION, answer_time};
use super::questions::{Asked, Edited, understood};
use super::turns::Turns;
use super::wire::{Question, Reply};
use super::workers::{Luggage, Reference, TypedScene, Unanswered, Workers};
use serde_json::json;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// How many typed scenes are remembered, so that each of a few pages has its own.
const KEPT: usize = 4;

/// Where questions are taken.
pub struct Desk {
    workers: Workers,
    turns: Turns,
    /// The questions with the scenes that were typed in last, by their revisions.
    typed: Mutex<Vec<TypedScene>>,
    /// The picture that was dropped last.
    reference: Mutex<Option<Arc<Reference>>>,
    /// Of a scene or a picture.
    next: AtomicU64,
}

/// Why nobody waits for an answer.
enum GivenUp {
    /// The page has asked for a later one.
    Overtaken,
    TooSlow,
    /// Whoever has asked is gone.
    Left,
}

impl Desk {
    pub fn new(workers: Workers) -> Self {
        let (turns, typed, reference) = Default::default();
        // Revision 0 is the command line's scene.
        Self { workers, turns, typed, reference, next: AtomicU64::new(1) }
    }

    /// The most bytes of a question to this path.
    pub fn longest_body(path: &str) -> usize {
        if path == "/reference" { MAX_PICTURE_FILE } else { MAX_QUESTION }
    }

    /// Opens the scene of the command line; an error is a message.
    pub fn open(&self) -> Result<(), String> {
        let question = Question { path: "/start".into(), ..Question::default() };
        let found = self.workers.ask(question, b"{}", &Luggage::default(), &mut || None::<()>);
        match found {
            Ok((Reply { status: 200, .. }, _)) => Ok(()),
            Ok((_, message)) => Err(String::from_utf8_lossy(&message).into_owned()),
            Err(Unanswered::NotStarted(message)) => Err(message),
            Err(_) => Err("error: cannot serve the page: its worker has ended".into()),
        }
    }

    /// Answers a question. `has_left` is asked often whether whoever has asked is gone.
    pub fn answer(
        &self,
        path: &str,
        query: &str,
        body: Vec<u8>,
        has_left: &mut dyn FnMut() -> bool,
    ) -> Result<Answer, Refusal> {
        let deadline = Instant::now() + answer_time(path);
        let (mut luggage, mut body) = (Luggage::default(), body);
        let mut turn = None;
        match path {
            "/scene" => {
                understood::<Edited>(&body)?;
                let typed = std::mem::take(&mut body).into();
                luggage.scene = Some((self.next.fetch_add(1, Ordering::Relaxed), typed));
            }
            "/reference" => {
                let name = query.strip_prefix("name=").unwrap_or_default().to_owned();
                let id = self.next.fetch_add(1, Ordering::Relaxed);
                luggage.reference = Some(Arc::new(Reference { id, name, file: std::mem::take(&mut body) }));
            }
            _ => {
                let asked: Asked = understood(&body)?;
                luggage.scene = self.scene(asked.scene())?;
                if matches!(path, "/start" | "/compare" | "/cause") {
                    luggage.reference = self.reference.lock().unwrap_or_else(PoisonError::into_inner).clone();
                }
                turn = asked.page.zip(asked.turn).map(|(page, turn)| self.turns.turn(page, turn));
            }
        }
        let mut gives_up = || match () {
            () if turn.as_ref().is_some_and(|turn| turn.is_overtaken()) => Some(GivenUp::Overtaken),
            () if Instant::now() > deadline => Some(GivenUp::TooSlow),
            () => has_left().then_some(GivenUp::Left),
        };
        let question = Question { path: path.into(), query: query.into(), ..Question::default() };
        // One that is overtaken needs no worker.
        let found = match gives_up() {
            Some(why) => Err(Unanswered::Stopped(why)),
            None => self.workers.ask(question, &body, &luggage, &mut gives_up),
        };
        let (reply, answer) = match found {
            Ok(found) => found,
            // This is no failure, and a browser lists failures.
            Err(Unanswered::Stopped(GivenUp::Overtaken)) => {
                return Ok(Answer::bytes(framed(json!({ "overtaken": true }), &[])));
            }
            Err(unanswered) => return Err(unanswered.into()),
        };
        if reply.status != 200 {
            return Err(Refusal::new(reply.status, String::from_utf8_lossy(&answer)));
        }
        match path {
            "/scene" if reply.has_opened => self.keep(luggage.scene),
            "/reference" => {
                *self.reference.lock().unwrap_or_else(PoisonError::into_inner) = luggage.reference;
            }
            _ => {}
        }
        Ok(Answer::bytes(answer))
    }

    /// The scene of this revision, if it is a typed one.
    fn scene(&self, revision: u64) -> Result<Option<TypedScene>, Refusal> {
        if revision == 0 {
            return Ok(None);
        }
        let mut typed = self.typed.lock().unwrap_or_else(PoisonError::into_inner);
        let place = typed.iter().position(|(known, _)| *known == revision);
        let place = place.ok_or_else(|| Refusal::new(410, "the scene is closed"))?;
        // The one that was used last is the last.
        let used = typed.remove(place);
        typed.push(used.clone());
        Ok(Some(used))
    }

    fn keep(&self, scene: Option<TypedScene>) {
        let mut typed = self.typed.lock().unwrap_or_else(PoisonError::into_inner);
        typed.extend(scene);
        let surplus = typed.len().saturating_sub(KEPT);
        typed.drain(..surplus);
    }
}

impl From<Unanswered<GivenUp>> for Refusal {
    fn from(reason: Unanswered<GivenUp>) -> Self {
        match reason {
            Unanswered::Stopped(GivenUp::TooSlow) => Self::new(
                422,
                "this takes longer than a page may: choose a smaller picture, or fewer samples",
            ),
            Unanswered::Stopped(_) => Self::new(408, "nobody waits for this answer"),
            Unanswered::Ended => Self::new(422, "the work on this has ended, perhaps for want of memory"),
            Unanswered::NotStarted(message) => Self::new(503, message),
        }
    }
}
