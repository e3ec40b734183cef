//! Pictures of floating-point numbers: PFM and OpenEXR files, written and read.

use crate::support::{CAMERA, Folder, sphere};
use raytracer::image_io::{Content, Exceptional, Format, OutputFile, read_picture};
use raytracer::picture::Color;

/// A file of numbers, read without the program's own code.
struct Floats {
    width: usize,
    height: usize,
    /// One or three for each pixel, in rows from the top.
    pixels: Vec<Vec<f32>>,
}

fn numbers(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap())).collect()
}

impl Floats {
    fn read(folder: &Folder, name: &str) -> Self {
        let bytes = folder.read(name);
        if name.ends_with(".pfm") { Self::pfm(&bytes) } else { Self::exr(&bytes) }
    }

    fn pfm(bytes: &[u8]) -> Self {
        let mut lines = bytes.splitn(4, |&byte| byte == b'\n');
        let mut line = || str::from_utf8(lines.next().unwrap()).unwrap().to_owned();
        let (kind, size, scale) = (line(), line(), line());
        let channels = match kind.as_str() {
            "PF" => 3,
            "Pf" => 1,
            other => panic!("{other}"),
        };
        assert_eq!(scale, "-1.0");
        let (width, height) = size.split_once(' ').unwrap();
        let (width, height) = (width.parse().unwrap(), height.parse().unwrap());
        let numbers = numbers(lines.next().unwrap());
        assert_eq!(numbers.len(), width * height * channels);
        let rows: Vec<_> = numbers.chunks(width * channels).rev().collect();
        let pixels = rows.iter().flat_map(|row| row.chunks(channels).map(<[f32]>::to_vec)).collect();
        Self { width, height, pixels }
    }

    /// The file must be as the program writes it: each row lies where the table says, by itself and uncompressed.
    fn exr(bytes: &[u8]) -> Self {
        assert_eq!(bytes[..8], [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0]);
        let int = |at: usize| i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let find = |text: &[u8]| bytes.windows(text.len()).position(|window| window == text).unwrap();
        let window = find(b"dataWindow\0box2i\0\x10\0\0\0") + 21;
        let top = int(window + 4);
        let (width, height) = (int(window + 8) + 1 - int(window), int(window + 12) + 1 - top);
        let full = |name: u8| [name, 0, 2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0];
        let list = find(b"channels\0chlist\0") + 20;
        let channels = if bytes[list] == b'Z' { 1 } else { 3 };
        let names: &[u8] = if channels == 1 { b"Z" } else { b"BGR" };
        assert!(
            bytes[list..]
                .starts_with(&[names.iter().flat_map(|&name| full(name)).collect(), vec![0]].concat())
        );
        let table = find(b"screenWindowWidth\0float\0\x04\0\0\0\0\0\x80\x3f\0") + 33;
        let mut pixels = vec![];
        for y in 0..height {
            let start = int(table + 8 * y);
            assert_eq!((int(start), int(start + 4)), (top + y, 4 * width * channels));
            let row = numbers(&bytes[start + 8..start + 8 + 4 * width * channels]);
            pixels.extend(
                (0..width).map(|x| (0..channels).rev().map(|c| row[c * width + x]).collect::<Vec<_>>()),
            );
        }
        assert_eq!(bytes.len(), table + 8 * height + height * (8 + 4 * width * channels));
        Self { width, height, pixels }
    }
}

/// The place of a pixel's centre on the plane through the origin, for the camera of the tests.
fn place(x: usize, y: usize, side: usize) -> (f64, f64) {
    let step = 2.0 / side as f64;
    ((x as f64 + 0.5) * step - 1.0, 1.0 - (y as f64 + 0.5) * step)
}

#[test]
fn distances_and_normals_are_those_of_the_sphere() {
    let folder = Folder::with_scene(&sphere());
    for end in ["pfm", "exr"] {
        folder.run(&format!("-input s.txt -size 20 20 -depth 1 2 d.{end} -normals n.{end}")).ok();
        let (depth, normals) =
            (Floats::read(&folder, &format!("d.{end}")), Floats::read(&folder, &format!("n.{end}")));
        assert_eq!((depth.width, depth.height, normals.width, normals.height), (20, 20, 20, 20));
        let mut hits = 0;
        for (index, (depth, normal)) in depth.pixels.iter().zip(&normals.pixels).enumerate() {
            let (x, y) = place(index % 20, index / 20, 20);
            let square = 0.49 - x * x - y * y;
            if square < 0.0 {
                assert_eq!((depth.as_slice(), normal.as_slice()), (&[f32::INFINITY][..], &[0.0; 3][..]));
                continue;
            }
            let z = square.sqrt();
            hits += 1;
            assert!((f64::from(depth[0]) - (9.0 - z)).abs() < 1e-6, "{x} {y} {depth:?}");
            let expected = [x, y, z].map(|coordinate| coordinate / 0.7);
            let is_near = |(&found, expected): (&f32, f64)| (f64::from(found) - expected).abs() < 1e-7;
            assert!(normal.iter().zip(expected).all(is_near), "{x} {y} {normal:?}");
            assert!(normal.len() == 3 && depth.len() == 1);
        }
        assert!(hits > 100 && hits < 300);
    }
}

const BRIGHT: &str = "Background { color .5 0 1.5 ambientLight 4 .3 1 }
    Lights { numLights 1 PointLight { position 0 0 0 color 0 0 0 } }
    Group { numObjects 1 Material { diffuseColor 1 .5 .25 } Sphere { center 0 0 0 radius .7 } }";

#[test]
fn colours_are_not_clamped_and_show_the_same_bytes() {
    let folder = Folder::with_scene(&format!("{CAMERA}{BRIGHT}"));
    folder.run("-input s.txt -size 8 6 -output o.tga").ok();
    let bytes = folder.tga("o.tga");
    for name in ["o.pfm", "o.exr"] {
        folder.run(&format!("-input s.txt -size 8 6 -output {name}")).ok();
        let floats = Floats::read(&folder, name);
        assert_eq!((floats.width, floats.height), (8, 6));
        assert_eq!(floats.pixels[0], [0.5, 0.0, 1.5]);
        assert_eq!(floats.pixels[3 * 8 + 4], [4.0, 0.15, 0.25]);
        for (floats, bytes) in floats.pixels.iter().zip(&bytes.pixels) {
            let cut: Vec<u8> = floats.iter().map(|&number| (255.0 * f64::from(number)) as u8).collect();
            assert_eq!(cut, bytes);
        }
    }
}

#[test]
fn a_part_has_its_place() {
    let folder = Folder::with_scene(&sphere());
    folder.run("-input s.txt -size 9 7 -region 2 3 4 3 -normals m.exr").ok();
    let part = Floats::read(&folder, "m.exr");
    assert_eq!((part.width, part.height), (4, 3));
    let bytes = folder.read("m.exr");
    let place = [2, 3, 5, 5, 0, 0, 8, 6].map(i32::to_le_bytes).concat();
    for (name, value) in [(&b"dataWindow"[..], &place[..16]), (b"displayWindow", &place[16..])] {
        let attribute = [name, b"\0box2i\0\x10\0\0\0", value].concat();
        assert!(bytes.windows(attribute.len()).any(|window| window == attribute));
    }
}

#[test]
fn floats_are_compared_with_bytes_as_the_bytes_that_they_show() {
    let folder = Folder::with_scene(&format!("{CAMERA}{BRIGHT}"));
    for name in ["o.tga", "o.pfm", "o.exr"] {
        folder.run(&format!("-input s.txt -size 8 6 -output {name}")).ok();
    }
    for (a, b) in [("o.pfm", "o.tga"), ("o.tga", "o.exr")] {
        let run = folder.run(&format!("-compare {a} -reference {b}")).ok();
        assert_eq!(run.value("pixels that differ"), "0 (0.0000%)", "{a} {b}");
        assert!(run.stderr.starts_with("note: 48 pixels of `o."), "{}", run.stderr);
    }
    // The rendered picture is written in bytes.
    let run = folder.run("-input s.txt -size 8 6 -output p.tga -compare o.pfm -tolerance 0 0").ok();
    assert!(run.stderr.starts_with("note: 48 pixels of `o.pfm` are outside 0 to 1"), "{}", run.stderr);
}

/// A file of grey numbers in a row.
fn write_grey(folder: &Folder, name: &str, numbers: &[f32]) {
    let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    folder.write(name, [format!("Pf\n{} 1\n-1.0\n", numbers.len()).as_bytes(), &bytes].concat());
}

#[test]
fn two_files_of_numbers_are_compared_by_their_numbers() {
    let folder = Folder::new();
    let infinity = f32::INFINITY;
    write_grey(&folder, "a.pfm", &[13.0, 2.0, infinity, 0.5, 1e9]);
    write_grey(&folder, "b.pfm", &[6.0, 2.0, infinity, 0.5, 1e9]);
    let run = folder.run("-compare a.pfm -reference b.pfm -difference d.png").ok();
    for (label, expected) in [
        ("pixels that differ", "1 (20.0000%)"),
        ("largest difference", "7 at (0, 0): 13 against 6"),
        ("largest relative", "1.1666666 at (0, 0): 13 against 6"),
        ("root mean square error", "3.5"),
        ("pixels that are NaN", "0 against 0"),
        ("pixels that are infinite", "1 against 1"),
    ] {
        assert_eq!(run.value(label), expected);
    }
    assert_eq!(run.stderr, "");
    let drawn = read_picture(&folder.path().join("d.png")).unwrap();
    assert_eq!((drawn.width(), drawn.get(18, 0), drawn.get(19, 0)), (23, Some([255; 3]), Some([0; 3])));
    for (tolerance, status) in [("7 0", 0), ("6.99 0", 3), ("6.99 1", 0), ("0 0", 3), ("1e3 0", 0)] {
        let run = folder.run(&format!("-compare a.pfm -reference b.pfm -tolerance {tolerance}"));
        assert_eq!(run.status, Some(status), "{tolerance}");
    }
}

#[test]
fn rendered_numbers_are_those_of_the_file() {
    let folder = Folder::with_scene(&format!("{CAMERA}{BRIGHT}"));
    folder.run("-input s.txt -size 8 6 -output o.exr -depth 1 2 d.pfm -normals n.pfm").ok();
    folder.write("t.txt", format!("{CAMERA}{BRIGHT}").replace("4 .3 1", "5 .3 1"));
    for (flags, file) in [
        ("-output p.pfm", "o.exr"),
        ("-adaptive_samples 4 1", "o.exr"),
        ("-depth 1 2 e.exr", "d.pfm"),
        ("-normals m.pfm", "n.pfm"),
    ] {
        for flag in ["-compare", "-reference"] {
            let line = format!("-input s.txt -size 8 6 {flags} {flag} {file} -tolerance 0 0");
            let run = folder.run(&line);
            // Adaptive samples have other colours at edges, but those of `o.exr` are compared as numbers too.
            let is_same = !flags.starts_with("-adaptive");
            assert!(!is_same || run.status == Some(0), "{line}: {run:?}");
            assert_eq!(run.value("compared as"), "floating-point numbers");
        }
    }
    // Both colours are white in bytes.
    let run = folder.run("-input t.txt -size 8 6 -compare o.exr -tolerance 0.5 0");
    assert_eq!((run.status, run.value("largest difference").split(' ').next()), (Some(3), Some("1")));
    assert!(!run.stdout.contains("cause"), "{}", run.stdout);
}

/// Files of 5 x 19 pixels that OpenEXR's own library has written.
const FOREIGN: [(&str, &[u8], f64); 3] = [
    ("none_half.exr", include_bytes!("float_files/none_half.exr"), 1e-3),
    ("zips_float.exr", include_bytes!("float_files/zips_float.exr"), 1e-7),
    ("zip_rgba.exr", include_bytes!("float_files/zip_rgba.exr"), 1e-3),
];

#[test]
fn files_of_other_programs_are_read() {
    let folder = Folder::new();
    for (name, bytes, error) in FOREIGN {
        folder.write(name, bytes);
        let picture = read_picture(&folder.path().join(name)).unwrap();
        assert_eq!((picture.width(), picture.height()), (5, 19));
        for (index, pixel) in picture.pixels().chunks(3).enumerate() {
            let (x, y) = (index % 5, index / 5);
            let colors = [x as f64 / 4.0, y as f64 / 12.0 - 0.25, ((x * 7 + y * 13) % 11) as f64 / 8.0];
            for (&byte, color) in pixel.iter().zip(colors) {
                let cut = |color: f64| (255.0 * color) as u8;
                assert!((cut(color - error)..=cut(color + error)).contains(&byte), "{name} {x} {y} {byte}");
            }
        }
    }
    // Damage leads to a picture or an error.
    for (_, bytes, _) in FOREIGN {
        for index in (0..bytes.len()).step_by(13) {
            let mut damaged = bytes.to_vec();
            damaged[index] = 0xff;
            folder.write("damaged.exr", damaged);
            let _ = read_picture(&folder.path().join("damaged.exr"));
        }
    }
    folder.write("grey.exr", include_bytes!("float_files/zip_uint_grey.exr"));
    let grey = read_picture(&folder.path().join("grey.exr")).unwrap();
    let expected = (0..95).flat_map(|index| [if (index % 5 + index / 5) % 2 == 1 { 255 } else { 0 }; 3]);
    assert_eq!(grey.pixels(), expected.collect::<Vec<u8>>());
    // The highest byte first, and two lines in one.
    let one = [0.25f32, 1.0].map(f32::to_be_bytes).concat();
    folder.write("big.pfm", [b"Pf 1\t2\r1\n".as_slice(), &one].concat());
    assert_eq!(read_picture(&folder.path().join("big.pfm")).unwrap().pixels(), [[255; 3], [63; 3]].concat());
}

#[test]
fn numbers_that_no_file_holds_are_counted() {
    let folder = Folder::new();
    let (nan, infinity, tiny) = (f64::NAN, f64::INFINITY, 1e-60);
    let colors = [
        Color::new(nan, infinity, 1.0),
        Color::new(-infinity, 2.0, 0.0),
        Color::splat(1e60),
        Color::splat(tiny),
        Color::new(-1.0, 1e30, 0.5),
    ];
    for (name, content, expected) in [
        ("a.tga", Content::Colors, Exceptional { black: 1, nan: 0, out_of_range: 0 }),
        ("a.pfm", Content::Colors, Exceptional { black: 0, nan: 1, out_of_range: 2 }),
        ("a.exr", Content::Colors, Exceptional { black: 0, nan: 1, out_of_range: 2 }),
        ("d.pfm", Content::Distances, Exceptional { black: 0, nan: 1, out_of_range: 2 }),
    ] {
        let path = folder.path().join(name);
        let file = OutputFile::prepare(&path).unwrap();
        let mut writer = file.begin(Format::of(&path).unwrap(), [5, 1], content, None).unwrap();
        writer.row(&colors).unwrap();
        assert_eq!(writer.exceptional, expected, "{name}");
        writer.complete().unwrap().put_in_place().unwrap();
    }
    let floats = Floats::read(&folder, "a.exr").pixels;
    assert!(floats[0][0].is_nan() && floats[0][1] == f32::INFINITY && floats[1][0] == f32::NEG_INFINITY);
    assert_eq!(
        (&floats[2], &floats[3], &floats[4]),
        (&vec![f32::INFINITY; 3], &vec![0.0; 3], &vec![-1.0, 1e30, 0.5])
    );
}

#[test]
fn a_warning_tells_of_colours_beyond_single_precision() {
    let bright = BRIGHT.replace("4 .3 1", "1e30 0 0").replace("1 .5 .25", "1e30 0 0");
    let folder = Folder::with_scene(&format!("{CAMERA}{bright}"));
    let said = |flags: &str| folder.run(&format!("-input s.txt -size 2 1 {flags}")).ok().stderr;
    assert!(said("-output o.pfm").contains("warning: pixels beyond single precision"));
    assert!(!said("-output o.tga -depth 1 2 d.pfm").contains("precision"));
}
