//! The film: adds filtered samples up to the colours of pixels.
//!
//! No sample is stored. The thread that traces a row of pixels accumulates a [`Spread`], which has one row of
//! weighted sums for each row of the picture that the samples contribute to, and the [`Film`] adds the
//! spreads in the order of their rows. So the memory does not depend on the number of samples, and the sums
//! do not depend on the number of threads or their timing.

use super::filter::Filter;
use crate::scene::Color;
use glam::DVec2;
use std::collections::VecDeque;
use std::ops::RangeInclusive;

/// The weighted sum of the samples of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sum {
    color: Color,
    weight: f64,
}

impl Sum {
    /// Adds a sample.
    pub fn add(&mut self, weight: f64, color: Color) {
        // A sample of weight zero is skipped, since its product with a NaN or an infinity would be a NaN.
        if weight != 0.0 {
            self.join(Sum { color: weight * color, weight });
        }
    }

    /// Adds the sum of other samples.
    pub fn join(&mut self, other: Sum) {
        self.color += other.color;
        self.weight += other.weight;
    }

    /// The weighted mean of the samples, or black where no sample has weight.
    pub fn color(&self) -> Color {
        match self.weight {
            0.0 => Color::ZERO,
            // The usual case of a single sample needs no division.
            1.0 => self.color,
            weight => self.color / weight,
        }
    }
}

/// The weight for the pixel `target` of a sample of the pixel `own`, at `offset` from the latter's centre.
pub fn weight_for(target: [usize; 2], filter: Filter, own: [usize; 2], offset: DVec2) -> f64 {
    let from_target = DVec2::new(own[0] as f64 - target[0] as f64, own[1] as f64 - target[1] as f64);
    filter.weight(from_target + offset)
}

/// The contributions of the samples in one row of pixels to that row and the rows around it.
#[derive(Clone, Debug)]
pub struct Spread {
    filter: Filter,
    width: usize,
    /// The row of pixels that the samples lie in.
    row: usize,
    /// The rows of the picture that the samples contribute to.
    target_rows: RangeInclusive<usize>,
    support: usize,
    /// The sums of these rows, one row after the other.
    sums: Vec<Sum>,
}

impl Spread {
    /// An empty spread for row `row` of a picture with this width and height.
    pub fn new(filter: Filter, row: usize, [width, height]: [usize; 2]) -> Self {
        // A support beyond the picture's size makes no difference.
        let support = filter.support().min(width.max(height));
        let target_rows = row.saturating_sub(support)..=(row + support).min(height - 1);
        let rows = target_rows.end() - target_rows.start() + 1;
        Self { filter, width, row, support, sums: vec![Sum::default(); rows * width], target_rows }
    }

    /// The memory in bytes that the sums of one spread take at most.
    pub fn bytes(filter: Filter, [width, height]: [usize; 2]) -> usize {
        (2 * filter.support() + 1).min(height) * width * size_of::<Sum>()
    }

    /// Adds a sample of the pixel in column `x`, at `offset` from the pixel's centre.
    pub fn add(&mut self, x: usize, offset: DVec2, color: Color) {
        for row in self.target_rows.clone() {
            for column in x.saturating_sub(self.support)..=(x + self.support).min(self.width - 1) {
                self.add_to(column, row, x, offset, color);
            }
        }
    }

    fn add_to(&mut self, column: usize, row: usize, x: usize, offset: DVec2, color: Color) {
        let weight = weight_for([column, row], self.filter, [x, self.row], offset);
        self.sums[(row - self.target_rows.start()) * self.width + column].add(weight, color);
    }
}

/// Adds the spreads up, and emits each row of the picture as soon as no later spread contributes to it.
#[derive(Debug)]
pub struct Film {
    filter: Filter,
    size: [usize; 2],
    /// The rows that are not complete yet, from row `finished` on.
    open: VecDeque<Vec<Sum>>,
    /// The number of rows that have been emitted.
    finished: usize,
}

impl Film {
    /// An empty film. `size` is the picture's width and height in pixels.
    pub fn new(filter: Filter, size: [usize; 2]) -> Self {
        Self::starting_at(filter, size, 0)
    }

    /// A film that takes the rows of pixels from `row` on. The rows of the picture within the filter's reach of
    /// `row` lack the samples of the rows below it.
    pub fn starting_at(filter: Filter, size: [usize; 2], row: usize) -> Self {
        let finished = row.saturating_sub(filter.support());
        Self { filter, size, open: VecDeque::new(), finished }
    }

    /// Adds the spread of the next row of pixels, and passes the index and the colours of each row of the
    /// picture that it completes to `finish`. Both run upwards from the film's first row.
    pub fn add(&mut self, spread: Spread, mut finish: impl FnMut(usize, &mut dyn Iterator<Item = Color>)) {
        let [width, height] = self.size;
        for (row, sums) in spread.target_rows.zip(spread.sums.chunks(width)) {
            match self.open.get_mut(row - self.finished) {
                Some(open) => open.iter_mut().zip(sums).for_each(|(a, b)| a.join(*b)),
                None => self.open.push_back(sums.to_vec()),
            }
        }
        let is_last = spread.row + 1 == height;
        let complete = if is_last { height } else { (spread.row + 1).saturating_sub(self.filter.support()) };
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

    /// The picture that results when pixel (x, y) takes one sample of this colour at its centre.
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
    fn a_uniform_picture_stays_uniform_up_to_the_borders() {
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
    fn a_wide_box_averages_the_samples_within_the_picture() {
        let picture = filtered(Filter::Box { radius: 1.0 }, [4, 3], |x, y| Color::splat((x * 10 + y) as f64));
        assert_eq!(picture[0][0].x, (0.0 + 10.0 + 1.0 + 11.0) / 4.0);
        assert_eq!(picture[1][2].x, 21.0);
    }

    #[test]
    fn a_pixel_without_weighted_samples_is_black() {
        let mut film = Film::new(Filter::Box { radius: 0.1 }, [1, 1]);
        let mut spread = Spread::new(Filter::Box { radius: 0.1 }, 0, [1, 1]);
        spread.add(0, DVec2::splat(-0.5), Color::ONE);
        film.add(spread, |_, colors| assert_eq!(colors.next(), Some(Color::ZERO)));
    }

    #[test]
    fn a_row_is_emitted_with_the_last_spread_that_contributes_to_it() {
        let (filter, size) = (Filter::Box { radius: 1.7 }, [2, 6]);
        let mut film = Film::new(filter, size);
        let given: Vec<Vec<usize>> = (0..6)
            .map(|y| {
                let mut rows = vec![];
                film.add(Spread::new(filter, y, size), |row, _| rows.push(row));
                rows
            })
            .collect();
        // Samples contribute to two rows on either side.
        assert_eq!(given, [vec![], vec![], vec![0], vec![1], vec![2], vec![3, 4, 5]]);
    }

    #[test]
    fn a_sample_counts_by_its_distance_from_each_pixel_s_centre() {
        let (filter, size) = (Filter::Tent { radius: 2.5 }, [5, 5]);
        let (x, y, offset) = (1, 3, DVec2::new(0.25, -0.375));
        let mut spread = Spread::new(filter, y, size);
        spread.add(x, offset, Color::splat(2.0));
        assert_eq!(spread.target_rows, 1..=4);
        for (row, sums) in spread.target_rows.zip(spread.sums.chunks(5)) {
            for (column, sum) in sums.iter().enumerate() {
                let position = DVec2::new(1.0 - column as f64, 3.0 - row as f64) + offset;
                // The support is two pixels along each axis.
                let weight = if column <= 3 { filter.weight(position) } else { 0.0 };
                assert_eq!(*sum, Sum { color: Color::splat(2.0 * weight), weight }, "{column} {row}");
            }
        }
    }

    #[test]
    fn the_largest_spread_takes_the_bytes_that_are_announced() {
        for (radius, size) in [(2.7, [3, 9]), (9.0, [3, 4])] {
            let filter = Filter::Box { radius };
            let largest = (0..size[1]).map(|row| size_of_val(&*Spread::new(filter, row, size).sums)).max();
            assert_eq!(largest, Some(Spread::bytes(filter, size)));
        }
    }

    #[test]
    fn a_sample_of_weight_zero_is_ignored() {
        let mut sum = Sum::default();
        sum.add(0.0, Color::NAN);
        assert_eq!(sum.color(), Color::ZERO);
        sum.add(0.5, Color::ONE);
        sum.add(1.5, Color::splat(3.0));
        assert_eq!(sum.color(), Color::splat(2.5));
    }
}
