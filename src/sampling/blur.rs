//! The filter of assignment 5 of 2012: a picture is blurred and then reduced to a third of its size, row by row.

use crate::picture::Color;
use std::collections::VecDeque;

/// The pixels of the picture along each axis that become one of the reduced picture.
pub const REDUCTION: usize = 3;

/// The weights of a pixel's neighbours and of the pixel itself, along each axis. They add up to a little more than one.
const WEIGHTS: [f64; 5] = [0.1201, 0.2339, 0.2921, 0.2339, 0.1201];
/// The number of neighbours on either side.
const REACH: usize = WEIGHTS.len() / 2;

/// The size of a picture after the reduction.
pub fn reduced(size: [usize; 2]) -> [usize; 2] {
    size.map(|n| n / REDUCTION)
}

/// Takes the rows of a picture from the top, and gives those of the reduced one.
#[derive(Debug)]
pub struct Blur {
    /// The topmost rows of the picture that are part of none of the reduced picture, which is counted from the bottom.
    surplus: usize,
    /// The last rows, blurred along themselves.
    rows: VecDeque<Vec<Color>>,
    /// The rows that have been blurred along both axes, and their sum since the last row of the reduced picture.
    finished: usize,
    sum: Vec<Color>,
}

impl Blur {
    /// For a picture of so many rows.
    pub fn new(rows: usize) -> Self {
        Self { surplus: rows % REDUCTION, rows: VecDeque::new(), finished: 0, sum: vec![] }
    }

    /// Takes the next row. Returns the row of the reduced picture that it completes, if it does.
    pub fn add(&mut self, row: &[Color]) -> Option<Vec<Color>> {
        let blurred: Vec<Color> = (0..row.len()).map(|x| weighted(row.len(), x, |x| row[x])).collect();
        if self.rows.is_empty() {
            // Beyond the border the picture goes on with the pixels there.
            self.rows.extend([blurred.clone(), blurred.clone()]);
        }
        self.rows.push_back(blurred);
        self.finish()
    }

    /// The rows that are left when the last row has been taken: at most one.
    pub fn end(&mut self) -> Option<Vec<Color>> {
        let mut last = None;
        for _ in 0..REACH {
            if let Some(row) = self.rows.back().cloned() {
                self.rows.push_back(row);
                last = self.finish().or(last);
            }
        }
        last
    }

    /// Blurs the row in the middle of the last five, if there are as many.
    fn finish(&mut self) -> Option<Vec<Color>> {
        if self.rows.len() < WEIGHTS.len() {
            return None;
        }
        let width = self.rows[0].len();
        self.sum.resize(width, Color::ZERO);
        if self.surplus > 0 {
            self.surplus -= 1;
            self.rows.pop_front();
            return None;
        }
        for (x, sum) in self.sum.iter_mut().enumerate() {
            *sum += self.rows.iter().zip(WEIGHTS).map(|(row, weight)| row[x] * weight).sum::<Color>();
        }
        self.rows.pop_front();
        self.finished += 1;
        if !self.finished.is_multiple_of(REDUCTION) {
            return None;
        }
        let pixels = self.sum.chunks_exact(REDUCTION);
        let reduced =
            pixels.map(|pixels| pixels.iter().sum::<Color>() / (REDUCTION * REDUCTION) as f64).collect();
        self.sum.fill(Color::ZERO);
        Some(reduced)
    }
}

/// The weighted sum around a place, where places beyond the ends are the ends.
fn weighted(count: usize, place: usize, color: impl Fn(usize) -> Color) -> Color {
    let neighbour = |i: usize| (place + i).saturating_sub(REACH).min(count - 1);
    WEIGHTS.into_iter().enumerate().map(|(i, weight)| color(neighbour(i)) * weight).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blurred(size: [usize; 2], color: impl Fn(usize, usize) -> f64) -> Vec<Vec<Color>> {
        let (mut blur, mut rows) = (Blur::new(size[1]), vec![]);
        for y in 0..size[1] {
            let row: Vec<Color> = (0..size[0]).map(|x| Color::splat(color(x, y))).collect();
            rows.extend(blur.add(&row));
        }
        rows.extend(blur.end());
        rows
    }

    #[test]
    fn sizes_are_cut_to_thirds() {
        for size in [[9, 9], [10, 11], [3, 4], [30, 5]] {
            let rows = blurred(size, |_, _| 1.0);
            assert_eq!([rows[0].len(), rows.len()], reduced(size));
            let sum: f64 = WEIGHTS.iter().sum();
            assert!(rows.iter().flatten().all(|color| (color.x - sum * sum).abs() < 1e-12), "{size:?}");
        }
        assert_eq!(blurred([5, 2], |_, _| 1.0), Vec::<Vec<Color>>::new());
    }

    #[test]
    fn a_point_spreads_by_the_weights() {
        // It is in the middle of the middle one of nine pixels.
        let rows = blurred([9, 9], |x, y| f64::from(u8::from([x, y] == [4, 4])));
        let [side, middle] = [0.1201, 0.2921 + 2.0 * 0.2339];
        for (y, row) in rows.iter().enumerate() {
            for (x, color) in row.iter().enumerate() {
                let factor = |place| if place == 1 { middle } else { side };
                assert!((color.x - factor(x) * factor(y) / 9.0).abs() < 1e-12, "{x} {y}");
            }
        }
    }
}
