//! Agreement with the reference implementation.
//!
//! The expected values were computed by NVIDIA's implementation, the Python package `flip-evaluator`, version 1.7, from
//! the PNG files written by `writes_the_pictures_for_the_reference_implementation`:
//!
//! ```python
//! import flip_evaluator, sys
//! for name in sys.argv[1:]:
//!     print(name, flip_evaluator.evaluate(f"{name}_b.png", f"{name}_a.png", "LDR")[1])
//! ```

use super::*;
use crate::base::patience::Endless;
use crate::image_io::{Format, OutputFile, read_picture};
use std::path::Path;

/// The reference implementation computes in f32. Where a flat picture of ones has derivatives of 1e-7 instead of 0, the
/// square root of the feature difference turns them into 3e-4.
const TOLERANCE: f64 = 2e-5;

/// A picture, its reference, and the mean error computed by the reference implementation.
struct Case {
    name: &'static str,
    size: [u32; 2],
    a: fn(u32, u32) -> [u8; 3],
    b: fn(u32, u32) -> [u8; 3],
    mean: f64,
}

const CASES: [Case; 9] = [
    Case { name: "ramps", size: [96, 64], a: |x, y| ramp(x + 9, y), b: ramp, mean: 0.172_725_007 },
    Case {
        name: "noise",
        size: [64, 48],
        a: |x, y| noise(1, x, y),
        b: |x, y| noise(2, x, y),
        mean: 0.435_340_136,
    },
    Case { name: "speckles", size: [80, 70], a: speckled, b: ramp, mean: 0.075_681_411 },
    Case { name: "shifted edges", size: [100, 80], a: |x, y| disc(x + 1, y), b: disc, mean: 0.196_534_172 },
    Case {
        name: "several tiles",
        size: [203, 131],
        a: shadowed,
        b: |x, y| disc(x / 2, y / 2),
        mean: 0.061_818_458,
    },
    Case {
        name: "smaller than the filters",
        size: [7, 5],
        a: |x, y| noise(3, x, y),
        b: ramp,
        mean: 0.954_333_365,
    },
    Case { name: "one pixel", size: [41, 41], a: dot, b: |_, _| [100; 3], mean: 0.003_172_06 },
    Case {
        name: "black and white",
        size: [16, 16],
        a: |_, _| [0; 3],
        b: |_, _| [255; 3],
        mean: 0.967_390_954,
    },
    Case { name: "green and blue", size: [16, 16], a: |_, _| [0, 255, 0], b: |_, _| [0, 0, 255], mean: 1.0 },
];

impl Case {
    fn pictures(&self) -> [Picture; 2] {
        let [width, height] = self.size;
        [self.a, self.b].map(|color| {
            let pixels = (0..width * height).flat_map(|i| color(i % width, i / width)).collect();
            Picture::from_rgb(width, height, pixels)
        })
    }
}

fn ramp(x: u32, y: u32) -> [u8; 3] {
    [2 * x, 3 * y, 255 - x - y].map(|level| level.min(255) as u8)
}

/// Returns the high bytes of a linear congruential generator.
fn noise(seed: u32, x: u32, y: u32) -> [u8; 3] {
    let next = |state: u32| state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let mixed = next(next(seed.wrapping_mul(0x9E37_79B9) ^ next(x * 65_537 + y * 257 + 1)));
    [mixed, next(mixed), next(next(mixed))].map(|state| (state >> 24) as u8)
}

fn speckled(x: u32, y: u32) -> [u8; 3] {
    let [chance, ..] = noise(4, x, y);
    if chance < 8 { [0; 3] } else { ramp(x, y) }
}

/// A disc on a checkerboard.
fn disc(x: u32, y: u32) -> [u8; 3] {
    let square = x.abs_diff(50).pow(2) + y.abs_diff(40).pow(2);
    match (square < 900, (x / 10 + y / 10) % 2) {
        (true, _) => [230 - (square / 5) as u8, 40, 30],
        (false, 0) => [20, 60, 110],
        (false, _) => [210, 200, 180],
    }
}

/// The enlarged disc with a shadow over part of it.
fn shadowed(x: u32, y: u32) -> [u8; 3] {
    let color = disc(x / 2, y / 2);
    let dark = x > 120 && y > 70 && x + y < 260;
    if dark { color.map(|level| level / 2) } else { color }
}

fn dot(x: u32, y: u32) -> [u8; 3] {
    if [x, y] == [20, 20] { [255, 100, 100] } else { [100; 3] }
}

#[test]
fn means_agree_with_the_reference_implementation() {
    if let Ok(folder) = std::env::var("FLIP_PICTURES") {
        write_pictures(&folder);
    }
    for case in &CASES {
        let [a, b] = case.pictures();
        let mean = mean_flip(&a, &b, &Endless).unwrap();
        println!("{}: {mean:.7} for {:.7}", case.name, case.mean);
        assert!((mean - case.mean).abs() < TOLERANCE, "{}: {mean} instead of {}", case.name, case.mean);
    }
}

/// Writes the pictures, for which the reference implementation computes the means, into a folder.
fn write_pictures(folder: &str) {
    for case in &CASES {
        for (picture, letter) in case.pictures().iter().zip(["a", "b"]) {
            let path = Path::new(folder).join(format!("{}_{letter}.png", case.name));
            let file = OutputFile::prepare(&path).unwrap().picture(Format::Png, picture).unwrap();
            file.put_in_place().unwrap();
            assert_eq!(&read_picture(&path).unwrap(), picture);
        }
    }
}

#[test]
fn equal_pictures_have_no_error() {
    let [a, _] = CASES[1].pictures();
    assert_eq!(mean_flip(&a, &a, &Endless), Ok(0.0));
}

#[test]
fn what_lies_outside_the_filters_has_no_influence() {
    // The dot is in the first of four tiles. The others are skipped.
    let size = 2 * 64 + 1;
    let black = Picture::new(size, size).unwrap();
    let mut bytes = black.pixels().to_vec();
    bytes[3 * (20 * size as usize + 20)..][..3].fill(255);
    let dotted = Picture::from_rgb(size, size, bytes);
    let small = |picture: &Picture| {
        let pixels =
            colors(picture).chunks(size as usize).take(50).flat_map(|row| row[..50].concat()).collect();
        Picture::from_rgb(50, 50, pixels)
    };
    let mean = mean_flip(&dotted, &black, &Endless).unwrap();
    let expected = mean_flip(&small(&dotted), &small(&black), &Endless).unwrap() * 2500.0;
    assert!((mean * f64::from(size * size) - expected).abs() < 1e-12 && mean > 0.0);
}
