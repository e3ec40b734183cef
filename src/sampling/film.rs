//! The film: sums filtered samples and computes the colours of pixels.
//!
//! No sample is stored. The thread that traces a row of pixels accumulates a [`Spread`], which has one row of weighted
//! sums for each row of the picture that the samples contribute to. The [`Film`] adds the spreads in the order of their
//! rows. So the memory does not depend on the number of samples, and the sums do not depend on the number of threads or
//! their timing.

use super::filter::Filter;
use super::spread::Spread;
use super::sum::Sum;
use crate::picture::Color;
use std::collections::VecDeque;

/// Adds spreads, and emits each row of the picture as soon as no later spread contributes to it.
#[derive(Debug)]
pub struct Film {
    filter: Filter,
    size: [usize; 2],
    /// The incomplete rows, from row `finished` on.
    open: VecDeque<Vec<Sum>>,
    /// The number of rows emitted.
    finished: usize,
}

impl Film {
    /// Creates an empty film that takes the rows of pixels from `row` on. `size` is the picture's width and height in
    /// pixels. Rows of the picture within the filter's reach of `row` lack the samples of the rows below it.
    pub fn new(filter: Filter, size: [usize; 2], row: usize) -> Self {
        let finished = row.saturating_sub(filter.support());
        Self { filter, size, open: VecDeque::new(), finished }
    }

    /// Adds the spread of the next row of pixels. Passes the index and the colours of each completed row of the picture
    /// to `finish`. Both run upwards from the film's first row.
    pub fn add(
        &mut self,
        mut spread: Spread,
        mut finish: impl FnMut(usize, &mut dyn Iterator<Item = Color>),
    ) {
        let [_, height] = self.size;
        for (row, sums) in spread.sums() {
            match self.open.get_mut(row - self.finished) {
                Some(open) => open.iter_mut().zip(sums).for_each(|(a, b)| a.join(*b)),
                None => self.open.push_back(sums.to_vec()),
            }
        }
        let is_last = spread.row() + 1 == height;
        let complete =
            if is_last { height } else { (spread.row() + 1).saturating_sub(self.filter.support()) };
        while self.finished < complete {
            let Some(sums) = self.open.pop_front() else { break };
            finish(self.finished, &mut sums.iter().map(Sum::color));
            self.finished += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::instructions::Level;
    use glam::DVec2;

    #[test]
    fn a_row_is_emitted_with_the_last_spread_that_contributes_to_it() {
        let (filter, size) = (Filter::Box { radius: 1.7 }, [2, 6]);
        let mut film = Film::new(filter, size, 0);
        let given: Vec<Vec<usize>> = (0..6)
            .map(|y| {
                let mut rows = vec![];
                let mut finish = |row: usize, _: &mut dyn Iterator<Item = Color>| rows.push(row);
                let spread = Spread::new(filter, Level::baseline(), y, size);
                film.add(spread, &mut finish);
                rows
            })
            .collect();
        // Samples contribute to two rows on either side.
        assert_eq!(given, [vec![], vec![], vec![0], vec![1], vec![2], vec![3, 4, 5]]);
    }

    #[test]
    fn a_pixel_without_weighted_samples_is_black() {
        let mut film = Film::new(Filter::Box { radius: 0.1 }, [1, 1], 0);
        let filter = Filter::Box { radius: 0.1 };
        let mut spread = Spread::new(filter, Level::baseline(), 0, [1, 1]);
        spread.add(0, DVec2::splat(-0.5), Color::ONE, 1.0);
        let mut finished = vec![];
        let mut finish = |_: usize, colors: &mut dyn Iterator<Item = Color>| finished.extend(colors);
        film.add(spread, &mut finish);
        assert_eq!(finished, [Color::ZERO]);
    }
}
