//! The filter of assignment 5 of 2012: blurs a picture and then reduces it to a third of its size, row by row.

use crate::picture::Color;
use std::collections::VecDeque;

/// The number of pixels along each axis that are averaged into one.
pub const REDUCTION: usize = 3;

/// The weights of a pixel and its neighbours along each axis. Their sum is slightly above one.
const WEIGHTS: [f64; 5] = [0.1201, 0.2339, 0.2921, 0.2339, 0.1201];
/// The number of neighbours on either side.
const REACH: usize = WEIGHTS.len() / 2;

/// Returns the size of a picture after the reduction.
pub fn reduced(size: [usize; 2]) -> [usize; 2] {
    size.map(|n| n / REDUCTION)
}

/// Takes the rows of a picture from the top, and returns the rows of the reduced picture.
#[derive(Debug)]
pub struct Blur {
    /// The number of topmost rows that the reduced picture leaves out, because it is aligned to the bottom.
    surplus: usize,
    /// The last rows, blurred horizontally.
    rows: VecDeque<Vec<Color>>,
    /// The number of rows blurred along both axes, and their sum since the last reduced row.
    finished: usize,
    sum: Vec<Color>,
}

impl Blur {
    /// Creates a filter for a picture with this number of rows.
    pub fn new(rows: usize) -> Self {
        Self { surplus: rows % REDUCTION, rows: VecDeque::new(), finished: 0, sum: vec![] }
    }

    /// Takes the next row. Returns a reduced row if this completes one.
    pub fn add(&mut self, row: &[Color]) -> Option<Vec<Color>> {
        let blurred: Vec<Color> = (0..row.len()).map(|x| weighted(row.len(), x, |x| row[x])).collect();
        if self.rows.is_empty() {
            // Beyond the border, the border pixels are repeated.
            self.rows.extend([blurred.clone(), blurred.clone()]);
        }
        self.rows.push_back(blurred);
        self.finish()
    }

    /// Returns the remaining reduced row, if any, after the last row has been taken.
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

    /// Blurs the middle of the last five rows, if there are five.
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

/// Returns the weighted sum around an index. Beyond the ends, the end values are repeated.
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
        // The point is in the middle of the central block of nine.
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
