//! The film: samples of a row of pixels spread over the rows around it, rows added up in order.
//!
//! No sample is kept. A row of pixels leaves one row of sums for each row of the picture that its
//! samples reach, and the film adds these in the order of the rows they come from. So memory does
//! not depend on the number of samples, and no sum on who computed it when.

use super::filter::Filter;
use crate::scene::Color;
use glam::DVec2;
use std::collections::VecDeque;
use std::ops::RangeInclusive;

/// Weighted samples on their way to a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sum {
    color: Color,
    weight: f64,
}

impl Sum {
    /// Adds a sample.
    pub fn add(&mut self, weight: f64, color: Color) {
        // Without weight even a colour that is not a number leaves no trace.
        if weight != 0.0 {
            self.join(Sum { color: weight * color, weight });
        }
    }

    fn join(&mut self, other: Sum) {
        self.color += other.color;
        self.weight += other.weight;
    }

    /// Black where no sample counts.
    pub fn color(&self) -> Color {
        match self.weight {
            0.0 => Color::ZERO,
            // The usual single sample needs no division.
            1.0 => self.color,
            weight => self.color / weight,
        }
    }
}

/// What the samples of one row of pixels add to the rows around it.
#[derive(Clone, Debug)]
pub struct Spread {
    filter: Filter,
    width: usize,
    /// The row of pixels that the samples lie in.
    row: usize,
    /// The rows of the picture they reach.
    reached: RangeInclusive<usize>,
    support: usize,
    /// The reached rows one after the other.
    sums: Vec<Sum>,
}

impl Spread {
    /// Of row `row` in a picture of this size.
    pub fn new(filter: Filter, row: usize, [width, height]: [usize; 2]) -> Self {
        // Beyond the picture there is nothing to reach.
        let support = filter.support().min(width.max(height));
        let reached = row.saturating_sub(support)..=(row + support).min(height - 1);
        let rows = reached.end() - reached.start() + 1;
        Self { filter, width, row, support, sums: vec![Sum::default(); rows * width], reached }
    }

    /// Bytes of sums that one row of pixels leaves.
    pub fn bytes(filter: Filter, [width, height]: [usize; 2]) -> usize {
        (2 * filter.support() + 1).min(height) * width * size_of::<Sum>()
    }

    /// Adds a sample in the pixel `x` of the row, `offset` from the pixel's centre.
    pub fn add(&mut self, x: usize, offset: DVec2, color: Color) {
        for row in self.reached.clone() {
            for column in x.saturating_sub(self.support)..=(x + self.support).min(self.width - 1) {
                self.add_to(column, row, x, offset, color);
            }
        }
    }

    fn add_to(&mut self, column: usize, row: usize, x: usize, offset: DVec2, color: Color) {
        let away = DVec2::new(x as f64 - column as f64, self.row as f64 - row as f64);
        let weight = self.filter.weight(away + offset);
        self.sums[(row - self.reached.start()) * self.width + column].add(weight, color);
    }
}

/// Adds up what the rows spread, and gives out each row of the picture once nothing more can come.
#[derive(Debug)]
pub struct Film {
    filter: Filter,
    size: [usize; 2],
    /// The rows in progress; the first is row `finished`.
    open: VecDeque<Vec<Sum>>,
    finished: usize,
}

impl Film {
    /// `size` is the picture's width and height in pixels.
    pub fn new(filter: Filter, size: [usize; 2]) -> Self {
        Self::starting_at(filter, size, 0)
    }

    /// A film that takes the rows of pixels from `row` on. The rows of the picture that samples below `row` reach
    /// come out without these.
    pub fn starting_at(filter: Filter, size: [usize; 2], row: usize) -> Self {
        let finished = row.saturating_sub(filter.support());
        Self { filter, size, open: VecDeque::new(), finished }
    }

    /// Takes the spread of the next row of pixels, and hands the rows of the picture that are complete with it to
    /// `finish`. Both run upwards from the film's first row.
    pub fn add(&mut self, spread: Spread, mut finish: impl FnMut(usize, &mut dyn Iterator<Item = Color>)) {
        let [width, height] = self.size;
        for (row, sums) in spread.reached.zip(spread.sums.chunks(width)) {
            match self.open.get_mut(row - self.finished) {
                Some(open) => open.iter_mut().zip(sums).for_each(|(a, b)| a.join(*b)),
                None => self.open.push_back(sums.to_vec()),
            }
        }
        let last = spread.row + 1 == height;
        let complete = if last { height } else { (spread.row + 1).saturating_sub(self.filter.support()) };
        while self.finished < complete {
            let Some(sums) = self.open.pop_front() else { return };
            finish(self.finished, &mut sums.iter().map(Sum::color));
            self.finished += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture whose pixel (x, y) takes one centred sample of the given colour.
    fn filtered(
        filter: Filter,
        [width, height]: [usize; 2],
        color: impl Fn(usize, usize) -> Color,
    ) -> Vec<Vec<Color>> {
        let mut film = Film::new(filter, [width, height]);
        let mut picture = vec![];
        for y in 0..height {
            let mut spread = Spread::new(filter, y, [width, height]);
            (0..width).for_each(|x| spread.add(x, DVec2::ZERO, color(x, y)));
            film.add(spread, |row, colors| {
                assert_eq!(row, picture.len());
                picture.push(colors.collect());
            });
        }
        assert_eq!(picture.len(), height);
        picture
    }

    #[test]
    fn the_pixel_box_changes_nothing() {
        let color = |x: usize, y: usize| Color::new(x as f64 / 3.0, y as f64 / 7.0, 0.1);
        let picture = filtered(Filter::PIXEL, [5, 4], color);
        assert!((0..4).all(|y| (0..5).all(|x| picture[y][x] == color(x, y))));
    }

    #[test]
    fn an_even_picture_stays_even_up_to_the_borders() {
        for filter in [
            Filter::Box { radius: 1.7 },
            Filter::Tent { radius: 3.0 },
            Filter::Gaussian { sigma: 1.0 },
            Filter::Mitchell { radius: 2.0 },
            Filter::Box { radius: 1e6 },
        ] {
            let picture = filtered(filter, [6, 5], |_, _| Color::splat(0.25));
            assert!(picture.iter().flatten().all(|c| (*c - 0.25).abs().max_element() < 1e-15), "{filter:?}");
        }
    }

    #[test]
    fn a_wide_box_averages_what_lies_within_cropped_at_the_border() {
        let picture = filtered(Filter::Box { radius: 1.0 }, [4, 3], |x, y| Color::splat((x * 10 + y) as f64));
        assert_eq!(picture[0][0].x, (0.0 + 10.0 + 1.0 + 11.0) / 4.0);
        assert_eq!(picture[1][2].x, 21.0);
    }

    #[test]
    fn samples_that_no_pixel_counts_leave_black() {
        let mut film = Film::new(Filter::Box { radius: 0.1 }, [1, 1]);
        let mut spread = Spread::new(Filter::Box { radius: 0.1 }, 0, [1, 1]);
        spread.add(0, DVec2::splat(-0.5), Color::ONE);
        film.add(spread, |_, colors| assert_eq!(colors.next(), Some(Color::ZERO)));
    }

    #[test]
    fn a_row_is_given_out_with_the_last_that_reaches_it() {
        let (filter, size) = (Filter::Box { radius: 1.7 }, [2, 6]);
        let mut film = Film::new(filter, size);
        let given: Vec<Vec<usize>> = (0..6)
            .map(|y| {
                let mut rows = vec![];
                film.add(Spread::new(filter, y, size), |row, _| rows.push(row));
                rows
            })
            .collect();
        // Its samples reach two rows each way.
        assert_eq!(given, [vec![], vec![], vec![0], vec![1], vec![2], vec![3, 4, 5]]);
    }

    #[test]
    fn a_sample_counts_by_its_distance_from_each_pixel_s_centre() {
        let (filter, size) = (Filter::Tent { radius: 2.5 }, [5, 5]);
        let (x, y, offset) = (1, 3, DVec2::new(0.25, -0.375));
        let mut spread = Spread::new(filter, y, size);
        spread.add(x, offset, Color::splat(2.0));
        assert_eq!(spread.reached, 1..=4);
        for (row, sums) in spread.reached.zip(spread.sums.chunks(5)) {
            for (column, sum) in sums.iter().enumerate() {
                let place = DVec2::new(1.0 - column as f64, 3.0 - row as f64) + offset;
                // Two columns and rows are within reach.
                let weight = if column <= 3 { filter.weight(place) } else { 0.0 };
                assert_eq!(*sum, Sum { color: Color::splat(2.0 * weight), weight }, "{column} {row}");
            }
        }
    }

    #[test]
    fn a_sum_takes_no_more_memory_than_was_said() {
        for (radius, size) in [(2.7, [3, 9]), (9.0, [3, 4])] {
            let filter = Filter::Box { radius };
            let most = (0..size[1]).map(|row| size_of_val(&*Spread::new(filter, row, size).sums)).max();
            assert_eq!(most, Some(Spread::bytes(filter, size)));
        }
    }

    #[test]
    fn a_sample_without_weight_leaves_no_trace() {
        let mut sum = Sum::default();
        sum.add(0.0, Color::NAN);
        assert_eq!(sum.color(), Color::ZERO);
        sum.add(0.5, Color::ONE);
        sum.add(1.5, Color::splat(3.0));
        assert_eq!(sum.color(), Color::splat(2.5));
    }
}
