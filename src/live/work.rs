//! A worker: answers the questions that the server hands it, one after the other, and ends when the server says so or is
//! gone.

use super::answers::{App, Setup};
use super::cancel::Cancel;
use super::http::Refusal;
use super::painter::Easel;
use super::wire::{Order, Reply, receive, send};
use crate::undisturbed::{undisturbed, without_signals};
use std::io::{self, BufWriter, stdin, stdout};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::thread;

/// Answers questions from standard input to standard output until there are no more.
pub fn work(setup: &Setup) {
    let (sender, orders) = channel();
    let stopped = Arc::new(AtomicU64::new(0));
    let noted = stopped.clone();
    let listen = move || {
        let mut from = stdin().lock();
        loop {
            let goes_on = match receive::<Order>(&mut from) {
                Ok((Order::Stop { number }, _)) => {
                    noted.fetch_max(number, Ordering::Relaxed);
                    true
                }
                Ok(order) => sender.send(order).is_ok(),
                Err(_) => false,
            };
            if !goes_on {
                // Whatever is under way is for nobody. Files that must not keep their names lose them first.
                undisturbed(|| std::process::exit(0));
            }
        }
    };
    let started = without_signals(|| thread::Builder::new().name("listener".into()).spawn(listen));
    if started.is_ok() {
        // The server is gone.
        let _ = serve(setup, &orders, &stopped);
    }
}

type Orders = Receiver<(Order, Vec<Vec<u8>>)>;

/// Answers until nobody takes an answer.
fn serve(setup: &Setup, orders: &Orders, stopped: &AtomicU64) -> io::Result<()> {
    let next = || match orders.recv() {
        Ok((Order::Answer(question), parts)) => Ok((question, parts)),
        _ => Err(io::Error::from(io::ErrorKind::UnexpectedEof)),
    };
    let Some(mut app) = opened(setup, orders)? else { return Ok(()) };
    let mut task = app.unpack(next()?);
    loop {
        // The scene stays prepared for the next picture of it.
        let scene = task.scene.clone();
        let mut easel = Easel::new(&scene.renderer);
        while Arc::ptr_eq(&task.scene, &scene) {
            let stop = Cancel::new(stopped, task.question.number);
            let found = app.answer(&mut task, &mut easel, &stop);
            let (status, answer) = match found {
                Ok(answer) => (200, answer),
                Err(Refusal { status, text }) => (status, text.into_bytes()),
            };
            reply(Reply { number: task.question.number, status, has_opened: task.has_opened }, &answer)?;
            task = app.unpack(next()?);
        }
    }
}

/// The scene of the command line, opened; none if that fails.
fn opened(setup: &Setup, orders: &Orders) -> io::Result<Option<App>> {
    let Ok((Order::Open, parts)) = orders.recv() else { return Ok(None) };
    let text = parts.into_iter().next().map(|text| String::from_utf8_lossy(&text).into_owned());
    let (status, answer, app) = match App::open(setup, text) {
        Ok(app) => (200, app.text().as_bytes().to_vec(), Some(app)),
        Err(message) => (422, message.into_bytes(), None),
    };
    reply(Reply { status, ..Reply::default() }, &answer)?;
    Ok(app)
}

fn reply(reply: Reply, answer: &[u8]) -> io::Result<()> {
    send(&mut BufWriter::new(stdout().lock()), &reply, &[answer])
}
