//! Curves of error against samples and against time.

/// A measured point: a cost and an error.
pub type Point = [f64; 2];

/// Returns which points are on the Pareto front: no other point is cheaper with at most the same error, or as cheap
/// with a smaller one.
pub fn front(points: &[Point]) -> Vec<bool> {
    let beats = |[cost, error]: Point, [other_cost, other_error]: Point| {
        cost <= other_cost && error <= other_error && (cost < other_cost || error < other_error)
    };
    points.iter().map(|&point| !points.iter().any(|&other| beats(other, point))).collect()
}

/// Returns the exponent p of error = c samples^p, fitted by least squares in logarithms. `None` if fewer than two
/// points have different numbers of samples. Points without an error have no logarithm and are ignored.
pub fn slope(points: &[Point]) -> Option<f64> {
    let logarithms: Vec<Point> =
        points.iter().filter(|[x, y]| *x > 0.0 && *y > 0.0).map(|point| point.map(libm::log)).collect();
    let count = logarithms.len() as f64;
    let mean = |axis: usize| logarithms.iter().map(|point| point[axis]).sum::<f64>() / count;
    let [x, y] = [mean(0), mean(1)];
    let (mut products, mut squares) = (0.0, 0.0);
    for point in &logarithms {
        products += (point[0] - x) * (point[1] - y);
        squares += (point[0] - x) * (point[0] - x);
    }
    (squares > 0.0).then(|| products / squares)
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
        assert_eq!(front(&points), [true, false, true, false, true, true, false]);
        assert_eq!(front(&[]), [false; 0]);
    }

    #[test]
    fn the_slope_of_a_power_is_its_exponent() {
        let points = [4.0f64, 16.0, 64.0, 256.0].map(|n| [n, 30.0 * n.powf(-0.75)]);
        assert!((slope(&points).unwrap() + 0.75).abs() < 1e-12);
        assert_eq!(slope(&[[4.0, 1.0], [4.0, 2.0], [16.0, 0.0]]), None);
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
