//! A colour scale from black to white with evenly increasing brightness.

use std::f64::consts::TAU;

/// Returns the colour of a value from 0 (black) to 1 (white): Green's cubehelix, "A colour scheme for the display of
/// astronomical intensity images", Bulletin of the Astronomical Society of India 39, 2011, section 3, with its default
/// parameters. Values outside the range are clamped.
pub fn cubehelix(value: f64) -> [u8; 3] {
    const START: f64 = 0.5;
    const ROTATIONS: f64 = -1.5;
    let value = value.clamp(0.0, 1.0);
    let angle = TAU * (START / 3.0 + 1.0 + ROTATIONS * value);
    let amplitude = 0.5 * value * (1.0 - value);
    let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
    [[-0.14861, 1.78277], [-0.29227, -0.90649], [1.97294, 0.0]]
        .map(|[c, s]| (255.0 * (value + amplitude * (c * cosine + s * sine))).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_perceived_brightness_grows_with_the_value() {
        let brightness = |value: f64| {
            let [red, green, blue] = cubehelix(value).map(f64::from);
            0.30 * red + 0.59 * green + 0.11 * blue
        };
        for i in 0..64 {
            let [value, next] = [i, i + 1].map(|i| f64::from(i) / 64.0);
            let step = brightness(next) - brightness(value);
            assert!((2.0..6.0).contains(&step), "{value}: {step}");
        }
        assert_eq!((cubehelix(0.0), cubehelix(1.0), cubehelix(9.0)), ([0; 3], [255; 3], [255; 3]));
    }
}
