//! Where no thread takes the signals, they are noted.

/// Nothing.
#[derive(Default)]
pub struct Taker;

impl Taker {
    /// Does nothing.
    pub fn set(&mut self, _: Box<dyn FnOnce() + Send>) {}
}
