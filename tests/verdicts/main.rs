//! Verdicts on the pictures of a student's ray tracer.
//!
//! [`single`] is such a tracer, in single precision, with a switch for each [`Mistake`]. It shares the reader of scenes
//! with this program, and nothing else.
//!
//! `VERDICTS_DIR=folder cargo test --test verdicts dump` writes its pictures of all cases and mistakes to a folder.

mod cases;
mod mistake;
mod objects;
mod single;
mod textures;

use cases::{CASES, Opened};
use mistake::Mistake;
use raytracer::image_io::OutputFile;
use raytracer::picture::Picture;
use std::fmt::Write;
use std::path::Path;
use std::{env, fs};

/// Pairs of mistakes, at least one of them in the finished picture.
const PAIRS: &[[Mistake; 2]] = &[
    [Mistake::UpsideDown, Mistake::RedAndBlueSwapped],
    [Mistake::Gamma, Mistake::RedAndBlueSwapped],
    [Mistake::Gamma, Mistake::OneBounceFewer],
    [Mistake::Mirrored, Mistake::Rounded],
    [Mistake::Times256, Mistake::UpsideDown],
];

/// The number of pixels in which a mistake shows at least.
const VISIBLE: usize = 4;

/// Renders the picture of a case by the student's tracer.
fn render(case: &Opened, mistakes: &[Mistake]) -> Picture {
    single::render(&case.scene, &case.options, case.layer, mistakes)
}

/// Returns for each pixel, row by row from the top, if a channel differs by more than this number of levels.
fn differing(a: &Picture, b: &Picture, levels: u8) -> Vec<bool> {
    let channels: Vec<bool> =
        a.pixels().iter().zip(b.pixels()).map(|(a, b)| a.abs_diff(*b) > levels).collect();
    channels.chunks(3).map(|pixel| pixel.contains(&true)).collect()
}

fn count(pixels: &[bool]) -> usize {
    pixels.iter().filter(|&&differs| differs).count()
}

/// Returns true if there is a square of 3 x 3 pixels that all differ.
fn has_block(pixels: &[bool], width: usize) -> bool {
    let rows: Vec<&[bool]> = pixels.chunks(width).collect();
    let differs_at = |x: usize, rows: &[&[bool]]| rows.iter().all(|row| row[x..x + 3] == [true; 3]);
    rows.windows(3).any(|rows| (0..width - 2).any(|x| differs_at(x, rows)))
}

#[test]
fn the_student_s_pictures_are_right_but_for_rounding() {
    for case in CASES {
        let opened = case.open();
        let pixels = differing(&render(&opened, &[]), &opened.render(), 1);
        assert!(count(&pixels) <= pixels.len() / 100, "{}: {} pixels", case.name, count(&pixels));
        assert!(!has_block(&pixels, opened.options.size[0]), "{}", case.name);
    }
}

#[test]
fn every_mistake_shows_in_a_case() {
    let mut hidden = Mistake::ALL.to_vec();
    for case in CASES {
        let mut opened = case.open();
        opened.options.size = opened.options.size.map(|side| side / 4);
        let right = render(&opened, &[]);
        hidden.retain(|&mistake| right == render(&opened, &[mistake]));
    }
    assert_eq!(hidden, []);
}

/// Writes pictures to the folder `VERDICTS_DIR`: the right one of each case, those of the mistakes that are visible in
/// it, those of pairs, and a list of them.
#[test]
fn dump() {
    let Some(folder) = env::var_os("VERDICTS_DIR") else { return };
    let folder = Path::new(&folder);
    fs::create_dir_all(folder).unwrap();
    let write = |name: String, picture: &Picture| {
        OutputFile::prepare(&folder.join(name + ".tga")).unwrap().write(picture).unwrap();
    };
    let mut manifest = String::from("case\tflags\tmistake\tpixels\n");
    for case in CASES {
        let opened = case.open();
        let right = render(&opened, &[]);
        write(format!("{}.right", case.name), &right);
        let mut shown = vec![];
        let singles = Mistake::ALL.iter().map(|&mistake| vec![mistake]);
        for mistakes in singles.chain(PAIRS.iter().map(|pair| pair.to_vec())) {
            let is_pair = mistakes.len() > 1;
            if is_pair && !mistakes.iter().all(|mistake| shown.contains(mistake)) {
                continue;
            }
            let picture = render(&opened, &mistakes);
            let pixels = count(&differing(&right, &picture, 1));
            if pixels >= VISIBLE {
                let names: Vec<String> = mistakes.iter().map(|mistake| mistake.name()).collect();
                let name = names.join("+");
                write(format!("{}.{name}", case.name), &picture);
                writeln!(manifest, "{}\t{}\t{name}\t{pixels}", case.name, case.flags).unwrap();
            }
            // In a pair, a mistake may show by a single level, as rounding does.
            if count(&differing(&right, &picture, 0)) >= VISIBLE {
                shown.extend(mistakes);
            }
        }
    }
    fs::write(folder.join("manifest.tsv"), manifest).unwrap();
}
