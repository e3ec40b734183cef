//! Values that consecutive primitives share.

use std::ops::Range;

/// The values of primitives by their ids: the first id of each run of primitives with the same value, and the value.
#[derive(Clone, Debug)]
pub(super) struct Runs<T>(Vec<(u32, T)>);

impl<T> Default for Runs<T> {
    fn default() -> Self {
        Self(vec![])
    }
}

impl<T: PartialEq> Runs<T> {
    /// Sets the value of the ids from `first` on, which is not below any earlier one.
    pub fn push(&mut self, first: usize, value: T) {
        if self.0.last().is_none_or(|(_, last)| *last != value) {
            self.0.push((first as u32, value));
        }
    }

    /// Appends runs whose ids count from `start`.
    pub fn append(&mut self, start: usize, others: Self) {
        self.0.extend(others.0.into_iter().map(|(first, value)| (start as u32 + first, value)));
    }

    /// Returns the run that contains an id, and its value. The last run has no end.
    #[inline(always)]
    pub fn around(&self, id: u32) -> (Range<u32>, &T) {
        let next = self.0.partition_point(|&(first, _)| first <= id);
        let (first, value) = &self.0[next - 1];
        (*first..self.0.get(next).map_or(u32::MAX, |&(end, _)| end), value)
    }

    /// Returns the value of an id, or `None` if there are no runs.
    pub fn get(&self, id: u32) -> Option<&T> {
        if self.0.is_empty() { None } else { Some(self.around(id).1) }
    }

    pub fn values(&self) -> impl Iterator<Item = &T> {
        self.0.iter().map(|(_, value)| value)
    }
}
