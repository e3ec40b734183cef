//! Reconstruction filters: the weight of a sample as a function of its position relative to a pixel's centre.

use crate::math::simd::{Number, exp_of_negative};
use fearless_simd::{Simd, f64x4};
use glam::DVec2;
use serde::Serialize;

/// A reconstruction filter. Its lengths are in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Filter {
    /// 1 within the radius along both axes.
    Box {
        /// Half the width.
        radius: f64,
    },
    /// Falls from 1 at the centre to 0 at the radius.
    Tent {
        /// Half the width.
        radius: f64,
    },
    /// exp(-d^2 / (2 sigma^2)) at the distance d, not truncated within the pixels of its support.
    Gaussian {
        /// The standard deviation.
        sigma: f64,
    },
    /// The product of Mitchell and Netravali's cubics with B = C = 1/3 along both axes, scaled to reach 0 at
    /// the radius ("Reconstruction Filters in Computer Graphics", SIGGRAPH 1988).
    Mitchell {
        /// Half the width.
        radius: f64,
    },
}

impl Filter {
    /// Averages only the pixel's own samples.
    pub const PIXEL: Self = Self::Box { radius: 0.5 };

    /// Returns the radius, or the standard deviation.
    pub fn size(&self) -> f64 {
        match *self {
            Self::Box { radius } | Self::Tent { radius } | Self::Mitchell { radius } => radius,
            Self::Gaussian { sigma } => sigma,
        }
    }

    /// Returns a filter of this kind with another radius or standard deviation.
    pub fn with_size(&self, size: f64) -> Self {
        match *self {
            Self::Box { .. } => Self::Box { radius: size },
            Self::Tent { .. } => Self::Tent { radius: size },
            Self::Gaussian { .. } => Self::Gaussian { sigma: size },
            Self::Mitchell { .. } => Self::Mitchell { radius: size },
        }
    }

    /// Returns the flag of the command line that asks for this filter, with its value.
    pub fn flag(&self) -> String {
        let name = match self {
            Self::Box { .. } => "box",
            Self::Tent { .. } => "tent",
            Self::Gaussian { .. } => "gaussian",
            Self::Mitchell { .. } => "mitchell",
        };
        format!("-{name}_filter {}", self.size())
    }

    /// Returns the weight of a sample at `position`, relative to the pixel's centre.
    pub fn weight(&self, position: DVec2) -> f64 {
        self.combined(self.axis_term(position.x), self.axis_term(position.y), libm::exp)
    }

    /// Returns the weights of four samples from their terms along both axes. A Gaussian must have a support of at least
    /// one pixel, so that it falls by no more than a factor of e^36 within it.
    #[inline(always)]
    pub(super) fn weights<S: Simd>(&self, x: f64x4<S>, y: f64x4<S>) -> f64x4<S> {
        self.combined(x, y, exp_of_negative)
    }

    /// Returns the term of a sample's weight for one axis, at this distance from the pixel's centre along it.
    #[inline(always)]
    pub(crate) fn axis_term<N: Number>(&self, distance: N) -> N {
        let splat = |x: f64| distance.broadcast(x);
        match *self {
            Self::Box { radius } => splat(radius).select_lt(distance.abs(), splat(0.0), splat(1.0)),
            Self::Tent { .. } | Self::Gaussian { .. } => distance * distance,
            Self::Mitchell { radius } => mitchell(distance.abs() * splat(2.0 / radius)),
        }
    }

    /// Combines the terms of both axes to the weight of a sample.
    #[inline(always)]
    fn combined<N: Number>(&self, x: N, y: N, exp: impl Fn(N) -> N) -> N {
        let splat = |a: f64| x.broadcast(a);
        match *self {
            Self::Box { .. } | Self::Mitchell { .. } => x * y,
            Self::Tent { radius } => (splat(1.0) - (x + y).sqrt() / splat(radius)).max(splat(0.0)),
            Self::Gaussian { sigma } => exp((x + y) / splat(-2.0 * sigma * sigma)),
        }
    }

    /// Returns the number of pixels that a sample reaches along each axis beyond its own pixel.
    pub fn support(&self) -> usize {
        let radius = if let Self::Gaussian { sigma } = self { 2.0 * sigma } else { self.size() };
        (radius - 0.5).ceil().max(0.0) as usize
    }
}

/// Mitchell and Netravali's cubic at x >= 0. It is zero from 2 on.
#[inline(always)]
fn mitchell<N: Number>(x: N) -> N {
    let splat = |a: f64| x.broadcast(a);
    let (two, six) = (splat(2.0), splat(6.0));
    let square = splat(12.0) * x * x;
    let near = (splat(7.0) * x * x * x - square + splat(16.0 / 3.0)) / six;
    let far = (splat(-7.0 / 3.0) * x * x * x + square - splat(20.0) * x + splat(32.0 / 3.0)) / six;
    x.select_lt(splat(1.0), near, x.select_lt(two, far, splat(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_against_closed_forms() {
        let at = |f: Filter, x: f64, y: f64| f.weight(DVec2::new(x, y));
        let wide = Filter::Box { radius: 1.7 };
        assert_eq!([at(wide, 1.7, -1.7), at(wide, 1.71, 0.0)], [1.0, 0.0]);
        let tent = Filter::Tent { radius: 2.0 };
        assert_eq!([at(tent, 0.0, 0.0), at(tent, 0.6, 0.8), at(tent, 2.0, 2.0)], [1.0, 0.5, 0.0]);
        let gaussian = Filter::Gaussian { sigma: 0.5 };
        assert!((at(gaussian, 0.3, 0.4) - (-0.5f64).exp()).abs() < 1e-15);
        let cubic = Filter::Mitchell { radius: 2.0 };
        assert!((at(cubic, 0.0, 0.0) - (8.0f64 / 9.0).powi(2)).abs() < 1e-15);
        assert!(at(cubic, 1.5, 0.0) < 0.0 && at(cubic, 2.0, 0.0) == 0.0);
    }
}
