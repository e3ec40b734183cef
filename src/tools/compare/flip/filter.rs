//! The filters of FLIP. Each is a sum of separable filters along rows and columns.

use super::PIXELS_PER_DEGREE;
use std::f64::consts::PI;

/// The number of outputs computed side by side.
pub const LANES: usize = 8;

/// An odd number of weights. The middle one belongs to the pixel itself.
#[derive(Clone, Debug)]
pub struct Convolution(Vec<f64>);

impl Convolution {
    fn new(radius: usize, weight: impl Fn(f64) -> f64) -> Self {
        Self((0..=2 * radius).map(|at| weight(at as f64 - radius as f64)).collect())
    }

    /// Returns the number of weights on each side of the middle.
    pub fn radius(&self) -> usize {
        self.0.len() / 2
    }

    fn sum(&self) -> f64 {
        self.0.iter().sum()
    }

    fn scaled(mut self, factor: f64) -> Self {
        self.0.iter_mut().for_each(|weight| *weight *= factor);
        self
    }

    /// Scales the positive weights to a sum of 1 and the negative ones to a sum of -1.
    fn balanced(mut self) -> Self {
        let positive: f64 = self.0.iter().filter(|&&weight| weight > 0.0).sum();
        let negative: f64 = -self.0.iter().filter(|&&weight| weight < 0.0).sum::<f64>();
        self.0.iter_mut().for_each(|weight| *weight /= if *weight > 0.0 { positive } else { negative });
        self
    }

    /// Computes each output `x` as the sum of the weights times the values at `x`, `x + stride`, `x + 2 stride`...
    pub fn convolve(&self, values: &[f64], stride: usize, output: &mut [f64]) {
        let (blocks, rest) = output.as_chunks_mut::<LANES>();
        let done = blocks.len() * LANES;
        for (block, x) in blocks.iter_mut().zip((0..).step_by(LANES)) {
            *block = self.sums(&values[x..], stride);
        }
        rest.iter_mut().zip(done..).for_each(|(sum, x)| [*sum] = self.sums(&values[x..], stride));
    }

    /// Computes outputs side by side, which the compiler maps to SIMD lanes.
    fn sums<const COUNT: usize>(&self, values: &[f64], stride: usize) -> [f64; COUNT] {
        let mut sums = [0.0; COUNT];
        let rows = (0..).step_by(stride).map_while(|start| values.get(start..)?.first_chunk::<COUNT>());
        for (&weight, row) in self.0.iter().zip(rows) {
            sums = std::array::from_fn(|lane| sums[lane] + weight * row[lane]);
        }
        sums
    }
}

/// The eye's blur, from the contrast sensitivity for each axis of YCxCz.
#[derive(Clone, Debug)]
pub struct SpatialFilters {
    /// The filters of Y and Cx, used along rows and along columns.
    pub gaussians: [Convolution; 2],
    /// The two filters whose sum blurs Cz, each used along rows and along columns.
    pub blue_yellow: [Convolution; 2],
}

/// The spread of the Gaussians of Y and Cx, in square degrees.
const SPREADS: [f64; 2] = [0.0047, 0.0053];
/// The height and the spread of the two Gaussians of Cz.
const BLUE_YELLOW: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];
/// The spread of the widest Gaussian.
const WIDEST_SPREAD: f64 = 0.04;

impl SpatialFilters {
    pub fn new() -> Self {
        let radius = (3.0 * (WIDEST_SPREAD / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as usize;
        let gaussian = |spread: f64| {
            Convolution::new(radius, |x| libm::exp(-(PI * x / PIXELS_PER_DEGREE).powi(2) / spread))
        };
        let normalized = |kernel: Convolution| kernel.clone().scaled(1.0 / kernel.sum());
        // The combined weight of both filters of Cz is the sum of squares, because each is applied twice.
        let blue_yellow = BLUE_YELLOW
            .map(|(height, spread)| gaussian(spread).scaled((height * (PI / spread).sqrt()).sqrt()));
        let weight = blue_yellow.iter().map(|kernel| kernel.sum().powi(2)).sum::<f64>().sqrt();
        Self {
            gaussians: SPREADS.map(|spread| normalized(gaussian(spread))),
            blue_yellow: blue_yellow.map(|kernel| kernel.scaled(1.0 / weight)),
        }
    }

    /// Returns the radius of the widest kernel.
    pub fn radius(&self) -> usize {
        self.blue_yellow[0].radius()
    }
}

/// Filters for the edges and points that the eye notices: derivatives of a blurred picture.
#[derive(Clone, Debug)]
pub struct FeatureFilters {
    /// The blur perpendicular to the direction of a derivative.
    pub gaussian: Convolution,
    /// The first derivative, largest at edges, and the second derivative, largest at points.
    pub derivatives: [Convolution; 2],
}

/// The width of the features that the eye notices most, in degrees.
const FEATURE_WIDTH: f64 = 0.082;

impl FeatureFilters {
    pub fn new() -> Self {
        let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
        let radius = (3.0 * deviation).ceil() as usize;
        let gaussian = |x: f64| libm::exp(-(x / deviation).powi(2) / 2.0);
        let first = Convolution::new(radius, |x| -x * gaussian(x));
        let second = Convolution::new(radius, |x| ((x / deviation).powi(2) - 1.0) * gaussian(x));
        Self {
            gaussian: Convolution::new(radius, gaussian).balanced(),
            derivatives: [first.balanced(), second.balanced()],
        }
    }

    /// Returns the radius of all kernels.
    pub fn radius(&self) -> usize {
        self.gaussian.radius()
    }
}
