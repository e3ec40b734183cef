//! `-compare` and `-reference`: two pictures, or one and what a scene shows.

use crate::support::{Folder, write_picture};
use raytracer::picture::Picture;

const SCENE: &str = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 4 }
    Background { color 0 0 0 ambientLight 1 1 1 }
    Materials { numMaterials 1 Material { diffuseColor 1 .5 .25 } }
    Group { numObjects 1 MaterialIndex 0 Sphere { center 0 0 0 radius 1 } }";

/// A folder with the scene, and with its picture as `o.tga` and `o.png`.
fn folder() -> Folder {
    let folder = Folder::with_scene(SCENE);
    folder.run("-input s.txt -size 40 30 -output o.tga").ok();
    folder.run("-input s.txt -size 40 30 -output o.png").ok();
    folder
}

/// Writes a picture that differs from `o.tga` by `levels` in `pixels` pixels from the top left.
fn write_changed(folder: &Folder, name: &str, levels: u8, pixels: usize) {
    let original = folder.tga("o.tga");
    let mut bytes = original.pixels.concat();
    bytes[..3 * pixels].iter_mut().for_each(|byte| *byte += levels);
    let picture = Picture::from_rgb(original.width as u32, original.height as u32, bytes);
    write_picture(&folder.path().join(name), &picture).unwrap();
}

#[test]
fn two_pictures_need_no_scene() {
    let folder = folder();
    write_changed(&folder, "a.tga", 3, 5);
    let run = folder.run("-compare a.tga -reference o.png").ok();
    assert!(run.stdout.starts_with("****"), "{}", run.stdout);
    assert_eq!(run.value("size"), "40x30");
    assert_eq!(run.value("pixels that differ"), "5 (0.4167%)");
    assert_eq!(run.value("largest difference"), "3 at (0, 0): (3, 3, 3) against (0, 0, 0)");
    assert_eq!(folder.names(), ["a.tga", "o.png", "o.tga", "s.txt"]);
    folder.run("-input s.txt -size 80 60 -output twice.png").ok();
    let message = folder.run("-compare twice.png -reference o.tga").message(1);
    assert!(message.ends_with("; the first is twice the size\n"), "{message}");
}

#[test]
fn a_missing_picture_is_the_rendered_one() {
    let folder = folder();
    write_changed(&folder, "a.tga", 3, 5);
    for (flags, largest) in [
        ("-compare a.tga", "3 at (0, 0): (3, 3, 3) against (0, 0, 0)"),
        ("-reference a.tga", "3 at (0, 0): (0, 0, 0) against (3, 3, 3)"),
        ("-compare o.tga", "0"),
        ("-reference o.png -output again.tga -normals n.tga", "0"),
    ] {
        let run = folder.run(&format!("-input s.txt -size 40 30 {flags}")).ok();
        assert_eq!(run.value("largest difference"), largest, "{flags}");
    }
    assert_eq!(folder.read("again.tga"), folder.read("o.tga"));
}

#[test]
fn the_only_picture_that_is_written_is_the_one_that_is_compared() {
    let folder = folder();
    let colors = "-output o2.png";
    for flags in ["-depth 4 6 NEW.png", "-normals NEW.pfm", "-render_samples NEW.png 3"] {
        let new = flags.split(' ').find(|word| word.starts_with("NEW")).expect("a name");
        let old = new.replace("NEW", "old");
        folder.run(&format!("-input s.txt -size 40 30 {}", flags.replace("NEW", "old"))).ok();
        for flag in ["-compare", "-reference"] {
            let run = folder.run(&format!("-input s.txt -size 40 30 {flags} {flag} {old}")).ok();
            assert_eq!(run.value("largest difference"), "0", "{flags} {flag}");
            // Where colours are written, they are compared.
            let line = format!("-input s.txt -size 40 30 {flags} {colors} {flag} o.tga -tolerance 0 0");
            assert_eq!(folder.run(&line).status, Some(0), "{line}");
        }
    }
    // The sizes are those of the picture that is compared, and no hint is given that does not help.
    let line = "-input s.txt -size 40 30 -render_samples m.png 3 -compare o.tga";
    let message = folder.run(line).message(1);
    assert!(message.contains("40 x 30 pixels against 120 x 90") && !message.contains("-size"), "{message}");
    for flags in ["-cost_map tests c.png -reference o.tga", "-normals n.png -depth 1 9 d.png -compare o.tga"]
    {
        let message = folder.run(&format!("-input s.txt {flags}")).message(2);
        assert!(message.contains("give -output too"), "{message}");
    }
    let line = "-input s.txt -size 40 30 -cost_map tests c.png -output p.png -compare o.tga -tolerance 0 0";
    assert_eq!(folder.run(line).status, Some(0));
}

#[test]
fn a_tolerance_makes_it_a_check() {
    let folder = folder();
    write_changed(&folder, "a.tga", 3, 5);
    let rows =
        [("", 0), ("0 4", 3), ("0 5", 0), ("2 4", 3), ("2.9 4", 3), ("3 0", 0), ("3.5 0", 0), ("255 0", 0)];
    for (tolerance, status) in rows {
        let flag = if tolerance.is_empty() { String::new() } else { format!("-tolerance {tolerance}") };
        let run = folder.run(&format!("-compare a.tga -reference o.tga {flag}"));
        assert_eq!((run.status, run.stderr.as_str()), (Some(status), ""), "{tolerance}");
        assert!(run.stdout.contains("PICTURE COMPARISON"));
    }
}

#[test]
fn alpha_that_is_not_opaque_is_noted() {
    let folder = Folder::new();
    folder.write("o.ppm", b"P6\n2 1\n255\nabcdef");
    let pam = |alpha: [u8; 2]| {
        let head = b"P7\nWIDTH 2\nHEIGHT 1\nDEPTH 4\nMAXVAL 255\nTUPLTYPE RGB_ALPHA\nENDHDR\n";
        [&head[..], b"abc", &alpha[..1], b"def", &alpha[1..]].concat()
    };
    let tga = |bits: u8, alpha: [u8; 2]| {
        let head = [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 0, 32, 32 | bits];
        [&head[..], b"cba", &alpha[..1], b"fed", &alpha[1..]].concat()
    };
    for (name, bytes, transparent) in [
        ("a.pam", pam([255, 254]), 1),
        ("b.pam", pam([255, 255]), 0),
        ("a.tga", tga(8, [0, 0]), 2),
        ("b.tga", tga(8, [255, 255]), 0),
        // The fourth byte is no alpha.
        ("c.tga", tga(0, [0, 0]), 0),
    ] {
        folder.write(name, bytes);
        let run = folder.run(&format!("-compare {name} -reference o.ppm -tolerance 0 0")).ok();
        let note = format!("note: ignored the alpha of `{name}`: {transparent} of ");
        assert_eq!(
            (run.stderr.is_empty(), run.stderr.starts_with(&note)),
            (transparent == 0, transparent > 0)
        );
    }
}
