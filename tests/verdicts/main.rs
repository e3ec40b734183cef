//! Verdicts on the pictures of a student's ray tracer.
//!
//! [`single`] is such a tracer, with a switch for each [`Mistake`]. It shares the reader of scenes with this program,
//! and nothing else.
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

/// Pairs of mistakes in the finished picture or before it.
const PAIRS: &[[Mistake; 2]] = &[
    [Mistake::UpsideDown, Mistake::RedAndBlueSwapped],
    [Mistake::Gamma, Mistake::RedAndBlueSwapped],
    [Mistake::Gamma, Mistake::OneBounceFewer],
    [Mistake::Mirrored, Mistake::Rounded],
    [Mistake::Times256, Mistake::UpsideDown],
];

/// A mistake is visible if at least this number of pixels differ by more than a level.
const VISIBLE: usize = 4;

fn render(case: &Opened, mistakes: &[Mistake]) -> Picture {
    single::render(&case.scene, &case.options, case.layer, mistakes)
}

/// Returns for each pixel, row by row from the top, if a channel differs by more than a level.
fn differing(a: &Picture, b: &Picture) -> Vec<bool> {
    let channels = a.pixels().iter().zip(b.pixels()).map(|(a, b)| a.abs_diff(*b) > 1);
    channels.collect::<Vec<_>>().chunks(3).map(|pixel| pixel.contains(&true)).collect()
}

fn count(pixels: &[bool]) -> usize {
    pixels.iter().filter(|&&differs| differs).count()
}

/// Writes the right picture of each case, the picture of each mistake and each pair that is visible in it, and a list
/// of them, to the folder of `VERDICTS_DIR`.
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
        let mut visible = vec![];
        let singles = Mistake::ALL.iter().map(|&mistake| vec![mistake]);
        for mistakes in singles.chain(PAIRS.iter().map(|pair| pair.to_vec())) {
            if mistakes.len() > 1 && !mistakes.iter().all(|mistake| visible.contains(mistake)) {
                continue;
            }
            let picture = render(&opened, &mistakes);
            let pixels = count(&differing(&right, &picture));
            if pixels >= VISIBLE {
                let names: Vec<String> = mistakes.iter().map(|mistake| mistake.name()).collect();
                let name = names.join("+");
                write(format!("{}.{name}", case.name), &picture);
                writeln!(manifest, "{}\t{}\t{name}\t{pixels}", case.name, case.flags).unwrap();
                visible.extend(mistakes);
            }
        }
    }
    fs::write(folder.join("manifest.tsv"), manifest).unwrap();
}
