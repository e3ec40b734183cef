//! Lists of the cells that shapes touch, and what filling them may cost.

use super::cell_lists::GridTooLarge;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The cost of entering a shape in a cell, where looking at a cell costs 1: an entry takes up memory and is
/// copied several times.
pub const REFERENCE_COST: usize = 16;

/// What all threads together may still spend on filling a grid.
#[derive(Debug)]
pub struct Budget {
    left: AtomicUsize,
    /// A list takes so much at once.
    portion: usize,
}

impl Budget {
    /// Budgets `most` for `lists` lists of cells. A list takes a sixteenth of its fair share at once, so that
    /// threads rarely meet here, and all lists together leave less than a sixteenth of the whole unspent.
    pub fn new(most: usize, lists: usize) -> Self {
        Self { left: AtomicUsize::new(most), portion: (most / lists.max(1) / 16).max(1) }
    }

    /// Grants whatever is asked for: 2^20 portions would be more than lists of 32-bit indices can spend.
    pub fn unlimited() -> Self {
        Self { left: AtomicUsize::new(usize::MAX), portion: usize::MAX >> 20 }
    }

    /// Takes enough portions for `cost`. Whether any list is refused does not depend on the order in which
    /// the lists ask, since nothing is given back: one is refused if and only if they ask for too much in all.
    #[cold]
    fn take(&self, cost: usize) -> Result<usize, GridTooLarge> {
        let taken = cost.next_multiple_of(self.portion);
        let left =
            self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(taken));
        left.map(|_| taken).map_err(|_| GridTooLarge)
    }
}

/// The indices of the cells that shapes touch, one shape's after the other's. The list grows only as far as
/// there are memory and budget, since a grid may be as fine as its user likes.
#[derive(Debug)]
pub struct TouchedCells<'a> {
    /// By the lattice's numbering, in the order of entering.
    pub indices: Vec<u32>,
    budget: &'a Budget,
    granted: usize,
    /// What the list has cost so far.
    pub spent: usize,
}

impl<'a> TouchedCells<'a> {
    /// An empty list that is paid for from `budget`.
    pub fn new(budget: &'a Budget) -> Self {
        Self { indices: vec![], budget, granted: 0, spent: 0 }
    }

    /// Makes room for some cells that are about to be looked at, and pays for looking at them.
    #[inline(always)]
    pub fn look_at(&mut self, cells: u32) -> Result<(), GridTooLarge> {
        self.pay(cells as usize)?;
        self.indices.try_reserve(cells as usize).map_err(|_| GridTooLarge)
    }

    /// Enters the shape in a cell for which there is room.
    #[inline(always)]
    pub fn push(&mut self, index: u32) {
        self.indices.push(index);
    }

    /// Pays for what was entered since there were `before` entries.
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

    fn refused(budget: &Budget, costs: [u32; 2]) -> bool {
        let mut lists = costs.map(|_| TouchedCells::new(budget));
        // In turns, one cell after the other.
        (0..costs[0].max(costs[1])).any(|k| (0..2).any(|i| k < costs[i] && lists[i].look_at(1).is_err()))
    }

    #[test]
    fn lists_share_a_budget() {
        for costs in [[400, 400], [800, 1], [0, 900]] {
            assert!(!refused(&Budget::new(1000, 2), costs), "{costs:?}");
        }
        for costs in [[501, 501], [0, 1001], [1001, 1]] {
            assert!(refused(&Budget::new(1000, 2), costs), "{costs:?}");
        }
        assert!(!refused(&Budget::unlimited(), [5000, 5000]));
    }

    #[test]
    fn entries_cost_more_than_looking() {
        let budget = Budget::unlimited();
        let mut list = TouchedCells::new(&budget);
        list.look_at(5).unwrap();
        list.push(7);
        list.pay_references(0).unwrap();
        assert_eq!((list.spent, list.indices), (5 + REFERENCE_COST, vec![7]));
    }
}
