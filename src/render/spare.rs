//! Memory for rows of colours that is used again: the first access to new memory costs more than filling it.

use crate::memory::NoMemory;
use crate::scene::Color;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Lists of colours that are no longer used.
#[derive(Debug, Default)]
pub struct Spare(Mutex<Vec<Vec<Color>>>);

impl Spare {
    /// An empty list with room for a number of colours.
    pub fn list(&self, room: usize) -> Result<Vec<Color>, NoMemory> {
        let mut list = self.lists().pop().unwrap_or_default();
        list.clear();
        list.try_reserve_exact(room).map_err(|_| NoMemory::for_list::<Color>(room))?;
        Ok(list)
    }

    /// Keeps a list for later.
    pub fn put(&self, list: Vec<Color>) {
        self.lists().push(list);
    }

    /// The number of lists that are kept.
    #[cfg(test)]
    pub fn count(&self) -> usize {
        self.lists().len()
    }

    fn lists(&self) -> MutexGuard<'_, Vec<Vec<Color>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
