//! Lists of the cells that shapes touch, with a budget for finding them. [`super::voxelize`] fills the lists,
//! and `super::allowance` says how large the budget of an automatic grid is.

use super::error::GridTooLarge;
use crate::memory;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The cost of inserting a shape into a cell, relative to testing a cell: a reference takes memory and is
/// copied several times.
pub const REFERENCE_COST: usize = 16;

/// What all threads together may still spend on finding the cells of a grid, in tests of a cell.
#[derive(Debug)]
pub struct Budget {
    left: AtomicUsize,
    /// The amount that a list takes at once.
    portion: usize,
}

impl Budget {
    /// A budget of `total` for `lists` lists of cells. A list takes a sixteenth of its fair share at once, so
    /// that threads rarely contend for the counter, and all lists together leave less than a sixteenth of the
    /// total unspent.
    pub fn new(total: usize, lists: usize) -> Self {
        Self { left: AtomicUsize::new(total), portion: (total / lists.max(1) / 16).max(1) }
    }

    /// A budget that is never exhausted: lists of 32-bit indices cannot spend its 2^20 portions.
    pub fn unlimited() -> Self {
        Self { left: AtomicUsize::new(usize::MAX), portion: usize::MAX >> 20 }
    }

    /// Takes enough portions for `cost`, and returns what was taken. Since nothing is given back, a list
    /// fails if and only if all lists together need too much; whether that happens does not depend on the
    /// order of the calls.
    #[cold]
    fn take(&self, cost: usize) -> Result<usize, GridTooLarge> {
        let taken = cost.next_multiple_of(self.portion);
        let left =
            self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(taken));
        left.map(|_| taken).map_err(|_| GridTooLarge)
    }
}

/// The indices of the cells that shapes touch, shape by shape. Since a user may ask for an arbitrarily fine
/// grid, the list reports an error instead of exceeding the available memory or the budget.
#[derive(Debug)]
pub struct TouchedCells<'a> {
    /// Indices of the lattice, in the order of insertion.
    pub indices: Vec<u32>,
    budget: &'a Budget,
    /// What the list has taken from the budget.
    granted: usize,
    /// What the list has cost so far.
    pub spent: usize,
}

impl<'a> TouchedCells<'a> {
    /// An empty list that spends from `budget`.
    pub fn new(budget: &'a Budget) -> Self {
        Self { indices: vec![], budget, granted: 0, spent: 0 }
    }

    /// Reserves memory for this number of cells, which are about to be tested, and pays for the tests.
    #[inline(always)]
    pub fn reserve(&mut self, cells: u32) -> Result<(), GridTooLarge> {
        self.pay(cells as usize)?;
        memory::make_room(&mut self.indices, cells as usize).map_err(|_| GridTooLarge)
    }

    /// Adds a cell that the shape touches, for which memory has been reserved.
    #[inline(always)]
    pub fn push(&mut self, index: u32) {
        self.indices.push(index);
    }

    /// Pays for the references added since the list had `before` of them.
    #[inline(always)]
    pub fn pay_references(&mut self, before: usize) -> Result<(), GridTooLarge> {
        self.pay(REFERENCE_COST * (self.indices.len() - before))
    }

    #[inline(always)]
    fn pay(&mut self, cost: usize) -> Result<(), GridTooLarge> {
        self.spent += cost;
        if self.spent > self.granted {
            self.granted += self.budget.take(self.spent - self.granted)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether two lists that test these numbers of cells, in turns, exceed the budget.
    fn is_exceeded(budget: &Budget, costs: [u32; 2]) -> bool {
        let mut lists = costs.map(|_| TouchedCells::new(budget));
        (0..costs[0].max(costs[1])).any(|k| (0..2).any(|i| k < costs[i] && lists[i].reserve(1).is_err()))
    }

    #[test]
    fn lists_share_a_budget() {
        for costs in [[400, 400], [800, 1], [0, 900]] {
            assert!(!is_exceeded(&Budget::new(1000, 2), costs), "{costs:?}");
        }
        for costs in [[501, 501], [0, 1001], [1001, 1]] {
            assert!(is_exceeded(&Budget::new(1000, 2), costs), "{costs:?}");
        }
        assert!(!is_exceeded(&Budget::unlimited(), [5000, 5000]));
    }

    #[test]
    fn a_reference_costs_more_than_a_test() {
        let budget = Budget::unlimited();
        let mut list = TouchedCells::new(&budget);
        list.reserve(5).unwrap();
        list.push(7);
        list.pay_references(0).unwrap();
        assert_eq!((list.spent, list.indices), (5 + REFERENCE_COST, vec![7]));
    }
}
