//! Curves of error against samples and against time.

/// A measured point: a cost and an error.
pub type Point = [f64; 2];

/// Returns the items on the Pareto front, the cheapest first: no other item is cheaper with at most the same error, or
/// as cheap with a smaller one.
pub fn front<T>(items: Vec<T>, point: impl Fn(&T) -> Point) -> Vec<T> {
    let beats = |[cost, error]: Point, [other_cost, other_error]: Point| {
        cost <= other_cost && error <= other_error && (cost < other_cost || error < other_error)
    };
    let points: Vec<Point> = items.iter().map(&point).collect();
    let is_on = |item: &T| !points.iter().any(|&other| beats(other, point(item)));
    let mut front: Vec<T> = items.into_iter().filter(is_on).collect();
    front.sort_by(|a, b| point(a)[0].total_cmp(&point(b)[0]));
    front
}

/// The curve error = c samples^p that fits points best.
pub struct Power {
    /// The exponent p.
    pub slope: f64,
    /// The ends of the curve.
    pub ends: [Point; 2],
}

impl Power {
    /// Fits the curve by least squares in logarithms. `None` if fewer than two points have different numbers of samples.
    /// Points without an error have no logarithm and are ignored.
    pub fn fit(points: impl Iterator<Item = Point>) -> Option<Self> {
        let logarithms: Vec<Point> =
            points.filter(|[x, y]| *x > 0.0 && *y > 0.0).map(|point| point.map(libm::log)).collect();
        let count = logarithms.len() as f64;
        let [x, y] = [0, 1].map(|axis| logarithms.iter().map(|point| point[axis]).sum::<f64>() / count);
        let products: f64 = logarithms.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
        let squares: f64 = logarithms.iter().map(|point| (point[0] - x) * (point[0] - x)).sum();
        let slope = (squares > 0.0).then(|| products / squares)?;
        let samples = || logarithms.iter().map(|point| point[0]);
        let ends = [samples().fold(f64::MAX, f64::min), samples().fold(f64::MIN, f64::max)];
        Some(Self { slope, ends: ends.map(|end| [end, y + slope * (end - x)].map(libm::exp)) })
    }
}

/// Returns the cost of an error along a curve, by logarithmic interpolation. Points must be in the order of their
/// costs. `None` if the curve does not reach the error.
pub fn cost_of(error: f64, points: &[Point]) -> Option<f64> {
    let reached = points.iter().position(|point| point[1] <= error)?;
    let [cost, found] = points[reached];
    let Some(&[cheaper, larger]) = reached.checked_sub(1).map(|before| &points[before]) else {
        return Some(cost);
    };
    if found <= 0.0 || cheaper <= 0.0 {
        return Some(cost);
    }
    let share = libm::log(larger / error) / libm::log(larger / found);
    Some(cheaper * libm::exp(share * libm::log(cost / cheaper)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [[1.0, 9.0], [2.0, 9.0], [2.0, 4.0], [3.0, 5.0], [4.0, 1.0], [4.0, 1.0], [9.0, 1.0]];
        let shuffled = points.into_iter().rev().collect();
        assert_eq!(front(shuffled, |point| *point), [points[0], points[2], points[4], points[5]]);
    }

    #[test]
    fn the_slope_of_a_power_is_its_exponent() {
        let points = [4.0f64, 16.0, 64.0, 256.0].map(|n| [n, 30.0 * n.powf(-0.75)]);
        let found = Power::fit(points.into_iter()).unwrap();
        assert!((found.slope + 0.75).abs() < 1e-12);
        let expected = [points[0], points[3]].as_flattened().to_vec();
        assert!(expected.iter().zip(found.ends.as_flattened()).all(|(a, b)| (a - b).abs() < 1e-9));
        assert!(Power::fit([[4.0, 1.0], [4.0, 2.0], [16.0, 0.0]].into_iter()).is_none());
    }

    #[test]
    fn costs_are_interpolated_in_logarithms() {
        let points = [[1.0, 8.0], [4.0, 2.0], [16.0, 0.5], [64.0, 0.0]];
        assert!((cost_of(4.0, &points).unwrap() - 2.0).abs() < 1e-12);
        assert!((cost_of(2.0, &points).unwrap() - 4.0).abs() < 1e-12);
        assert_eq!(cost_of(10.0, &points), Some(1.0));
        assert_eq!(cost_of(0.2, &points), Some(64.0));
        assert_eq!(cost_of(0.2, &points[..3]), None);
    }
}
