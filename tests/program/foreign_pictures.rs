//! Pictures that other programs wrote, under wrong names, with other line ends, windows, maxima or no pixels: they are
//! read right, or refused with what was found.

use crate::support::{Folder, only_line, sphere};

/// The size and the bytes of a picture, which is read without a word.
fn pixels(folder: &Folder, name: &str) -> ([usize; 2], Vec<u8>) {
    let run = folder.run(&format!("-convert {name} -output out.ppm")).ok();
    assert_eq!(run.stderr, "", "{name}");
    written(folder)
}

fn written(folder: &Folder) -> ([usize; 2], Vec<u8>) {
    let bytes = folder.read("out.ppm");
    let mut lines = bytes.splitn(4, |&byte| byte == b'\n');
    let mut line = || str::from_utf8(lines.next().unwrap()).unwrap().to_owned();
    let (kind, size, white) = (line(), line(), line());
    assert_eq!((kind.as_str(), white.as_str()), ("P6", "255"));
    let (width, height) = size.split_once(' ').unwrap();
    ([width, height].map(|side| side.parse().unwrap()), lines.next().unwrap().to_vec())
}

/// Why a picture is not read, with the hint after a semicolon.
fn refusal(folder: &Folder, name: &str) -> String {
    let message = folder.run(&format!("-convert {name} -output out.ppm")).message(1);
    let message = message.replace("\n  hint: ", "; ");
    let reason = only_line(&message).strip_prefix(&format!("error: cannot read `{name}`: "));
    reason.unwrap_or_else(|| panic!("{name}: {message}")).to_owned()
}

fn assert_refused(folder: &Folder, name: &str, words: &[&str]) {
    let reason = refusal(folder, name);
    assert!(words.iter().all(|word| reason.contains(word)), "{name}: {reason}");
}

fn crlf(bytes: &[u8]) -> Vec<u8> {
    bytes.iter().flat_map(|&byte| if byte == b'\n' { vec![b'\r', b'\n'] } else { vec![byte] }).collect()
}

#[test]
fn the_first_bytes_decide_the_format_and_the_name_is_checked() {
    let folder = Folder::with_scene(&sphere());
    let endings = ["tga", "png", "bmp", "ppm", "pfm", "exr"];
    for from in endings {
        folder.run(&format!("-input s.txt -size 9 7 -output a.{from}")).ok();
        for to in ["tga", "png"].into_iter().filter(|&to| to != from) {
            folder.write(&format!("b.{to}"), folder.read(&format!("a.{from}")));
            let found = format!(" {} file; name it `b.{from}`", from.to_uppercase());
            assert_refused(&folder, &format!("b.{to}"), &[&found]);
        }
    }
    for line in ["-merge b.png -output m.png", "-input t.txt -edition 2012a4 -size 4 4 -output t.tga"] {
        folder.write("b.png", folder.read("a.tga"));
        folder.write("t.txt", textured("b.png"));
        let message = folder.run(line).message(1);
        assert!(message.contains("it is a TGA file\n") && message.contains("name it `b.tga`"), "{message}");
    }
    let (_, expected) = pixels(&folder, "a.tga");
    for name in ["a.pgm", "a.pbm", "a.PNM", "a.pam"] {
        folder.write(name, folder.read("a.ppm"));
        assert_eq!(pixels(&folder, name), ([9, 7], expected.clone()));
    }
    for (start, found) in [
        (&b"\xff\xd8\xff\xe0\0\x10JFIF\0"[..], "it is a JPEG file; convert it"),
        (b"GIF89a\x01\0", "it is a GIF file; convert it"),
        (b"MM\0*\0\0\0\x08", "it is a TIFF file; convert it"),
        (b"version https://git-lfs.github.com/spec/v1\n", "`git lfs pull`"),
        (b"no picture\n", "it is not a PNG file, since it begins with `no picture`"),
    ] {
        folder.write("a.png", start);
        assert_refused(&folder, "a.png", &[found]);
    }
}

#[test]
fn samples_are_rounded_to_the_nearest_level() {
    let folder = Folder::new();
    let levels = |white: u32| (0..=white).map(move |sample| (2 * 255 * sample + white) / (2 * white));
    let expected = |white| levels(white).flat_map(|level| [level as u8; 3]).collect::<Vec<_>>();
    let samples = || (0..=u16::MAX).flat_map(u16::to_be_bytes);
    let mut png = vec![];
    let mut encoder = png::Encoder::new(&mut png, 256, 256);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    let rows: Vec<u8> = samples().collect();
    encoder.write_header().unwrap().write_image_data(&rows).unwrap();
    folder.write("a.png", png);
    assert!(pixels(&folder, "a.png").1 == expected(65535));
    for white in [1, 7, 254, 255, 256, 1023, 65534, 65535] {
        let raw = (0..=white).flat_map(|sample| match white {
            ..256 => vec![sample as u8],
            _ => (sample as u16).to_be_bytes().to_vec(),
        });
        let header = |kind| format!("{kind} {} 1 {white}\n", white + 1).into_bytes();
        folder.write("a.pgm", [header("P5"), raw.collect()].concat());
        assert!(pixels(&folder, "a.pgm").1 == expected(white), "{white}");
        let words: String = (0..=white).map(|sample| format!("{sample}\n")).collect();
        folder.write("a.pgm", [header("P2"), words.into_bytes()].concat());
        assert!(pixels(&folder, "a.pgm").1 == expected(white), "{white}");
    }
    folder.write("a.pgm", b"P5 2 1 100\n\x64\x65");
    assert_refused(&folder, "a.pgm", &["row 1", "above 100"]);
}

/// A scene of 2012 with this texture.
fn textured(name: &str) -> String {
    format!(
        "PerspectiveCamera {{ center 0 0 9 direction 0 0 -1 up 0 1 0 angle 20 }}
        Materials {{ numMaterials 1 Material {{ texture {name} }} }}
        Group {{ numObjects 1 MaterialIndex 0 Sphere {{ center 0 0 0 radius 1 }} }}"
    )
}

/// Files whose width or height is 0, in every format.
fn empty_files() -> Vec<(String, Vec<u8>)> {
    let mut files = vec![];
    for [width, height] in [[0u8, 20], [20, 0], [0, 0]] {
        let mut add = |name: &str, bytes: Vec<u8>| files.push((format!("{width}x{height}{name}"), bytes));
        for kind in ["P1", "P4"] {
            add(&format!("{kind}.pbm"), format!("{kind}\n{width} {height}\n").into_bytes());
        }
        for kind in ["P2", "P3", "P5", "P6"] {
            add(&format!("{kind}.ppm"), format!("{kind}\n{width} {height}\n255\n").into_bytes());
        }
        let pam = format!("P7\nWIDTH {width}\nHEIGHT {height}\nDEPTH 3\nMAXVAL 255\nTUPLTYPE RGB\nENDHDR\n");
        add(".pam", pam.into_bytes());
        add(".pfm", format!("PF\n{width} {height}\n-1.0\n").into_bytes());
        add(".tga", vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, width, 0, height, 0, 24, 32]);
        let bmp = [&b"BM\x36\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0"[..], &[width, 0, 0, 0, height, 0, 0, 0]];
        add(".bmp", [&bmp.concat()[..], &[1, 0, 24, 0], &[0; 24]].concat());
        let header = [&b"IHDR\0\0\0"[..], &[width, 0, 0, 0, height, 8, 2, 0, 0, 0]].concat();
        let check = crc32fast::hash(&header).to_be_bytes();
        add(".png", [b"\x89PNG\r\n\x1a\n\0\0\0\x0d", &header[..], &check].concat());
        let [right, bottom] = [width, height].map(|side| i32::from(side) - 1);
        add(".exr", Exr { display: [0, 0, right, bottom], ..Exr::new([0, 0, 3, 3]) }.file(0));
    }
    files
}

#[test]
fn a_picture_without_pixels_is_an_error_everywhere() {
    let folder = Folder::with_scene(&sphere());
    folder.run("-input s.txt -size 4 4 -output o.tga").ok();
    for (name, bytes) in empty_files() {
        folder.write(&name, &bytes);
        assert_eq!(refusal(&folder, &name), "the picture has no pixels");
    }
    folder.write("t.txt", textured("0x20.png"));
    for line in [
        "-compare 0x20.tga -reference o.tga",
        "-input s.txt -size 4 4 -reference 0x20.tga",
        "-input t.txt -edition 2012a4 -size 4 4 -output t.tga",
    ] {
        assert!(folder.run(line).message(1).contains("the picture has no pixels"), "{line}");
    }
}

#[test]
fn line_ends_of_windows_do_not_shift_raw_pictures() {
    let folder = Folder::new();
    // Bytes of line ends are among the samples.
    let samples = [10, 13, 11, 200, 13, 13, 10, 10, 13, 0, 255, 10];
    let floats: Vec<u8> =
        [0.25f32, 1.0, 8.5e-33, 0.5].iter().flat_map(|number| number.to_le_bytes()).collect();
    let wide = [0x0a, 0x0d, 0xff, 0xff, 0x0d, 0x0a, 0, 0];
    let pam = "P7\nWIDTH 2\nHEIGHT 2\nDEPTH 3\nMAXVAL 255\nTUPLTYPE RGB\nENDHDR\n";
    for (name, header, samples) in [
        ("a.ppm", "P6\n2 2\n255\n", &samples[..]),
        ("a.ppm", "P6\n# a comment\n2\n2\n255\n", &samples),
        ("a.ppm", "P6 2 2 255\n", &samples),
        ("a.pgm", "P5\n4 3\n255\n", &samples),
        ("a.pgm", "P5\n2 2\n65535\n", &wide),
        ("a.pbm", "P4\n13 2\n", &[10, 13, 13, 10]),
        ("a.pam", pam, &samples),
        ("a.pfm", "Pf\n2 2\n-1.0\n", &floats),
    ] {
        folder.write(name, [header.as_bytes(), samples].concat());
        let right = pixels(&folder, name);
        let windows = crlf(header.as_bytes());
        for (kind, file) in
            [("header", [&windows, samples].concat()), ("text mode", [&windows[..], &crlf(samples)].concat())]
        {
            folder.write(name, file);
            assert_eq!(pixels(&folder, name), right, "{kind}: {header}");
        }
    }
    // The header ends in CR, and the first sample is LF.
    for header in ["P6\r2 2\r255\r", "P6 2 2 255\r"] {
        folder.write("a.ppm", [header.as_bytes(), &samples].concat());
        assert_eq!(pixels(&folder, "a.ppm").1, samples);
    }
}

#[test]
fn raw_files_that_are_too_long_or_a_byte_too_short_are_refused() {
    let folder = Folder::new();
    let samples = [90, 13, 11, 200, 13, 13, 10, 10, 13, 0, 255, 77];
    let file = |header: &str, samples: &[u8], rest: &[u8]| [header.as_bytes(), samples, rest].concat();
    for (name, file, words) in [
        ("a.ppm", file("P6\n2 2\n255\n", &samples, b"abc"), "3 bytes too long for 2 x 2 pixels"),
        // Two line ends before the samples.
        ("a.ppm", file("P6\n2 2\n255\n\n", &samples, b""), "1 byte too long for 2 x 2 pixels"),
        ("a.ppm", file("P6\r\n2 2\r\n255\r\n", &samples, b"abc"), "4 bytes too long"),
        ("a.ppm", file("P6\r\n2 2\r\n255\r\n", &samples[..11], b""), "too short for 2 x 2 pixels"),
        ("a.ppm", file("P6\n2 2\n255\n", &samples, &samples), "12 bytes too long"),
        // One of the line feeds is alone.
        ("a.ppm", file("P6\r\n2 2\r\n255\r\n", &crlf(&samples), b"\n"), "4 bytes too long"),
        ("a.pfm", file("Pf\n1 1\n-1\n\n", &1f32.to_le_bytes(), b""), "1 byte too long for 1 x 1 pixels"),
        ("a.pfm", file("PF\n-1 1\n-1.0\n", b"", b""), "line 2: `-1` "),
        ("a.pfm", file("PF\n1 1\n0\n", b"", b""), "line 3: `0` "),
    ] {
        folder.write(name, &file);
        assert_refused(&folder, name, &[words]);
    }
    folder.write("a.ppm", file("P6\n2 2\n255\n", &samples, b"\r\n"));
    let run = folder.run("-convert a.ppm -output out.ppm").ok();
    assert_eq!(run.stderr, "note: ignored a line end after the last pixel of `a.ppm`\n");
    assert_eq!(written(&folder), ([2, 2], samples.to_vec()));
}

#[test]
fn plain_pictures_are_read_with_comments_anywhere() {
    let folder = Folder::new();
    let right = ([2, 1], vec![255, 2, 3, 4, 0, 6]);
    for file in [
        "P3\n2 1\n255\n255 2 3\n4 0 6\n",
        "P3 # kind\n2 1 # size\n255\n255 2 3 # first\n# second\n4#x\n0 6",
        "P3\r\n2 1\r\n255\r\n255 2 3 # first\r\n4 0 6\r\n",
        "\u{feff}P3\n2 1\n255\n255 2 3 4 0 6\n",
    ] {
        folder.write("a.ppm", file);
        assert_eq!(pixels(&folder, "a.ppm"), right, "{file}");
    }
    folder.write("a.pbm", "P1\n3 2\n010 # first\n1\n 0 1");
    assert_eq!(pixels(&folder, "a.pbm").1, [255, 0, 255, 0, 255, 0].map(|level| [level; 3]).concat());
}

#[test]
fn plain_pictures_are_refused_with_line_value_and_limit() {
    let folder = Folder::new();
    for (body, words) in [
        ("1 2 3\n4 256 6", &["line 5: `256`", "from 0 to 255", "clamp"][..]),
        ("-2147483648 2 3\n4 5 6", &["line 4: `-2147483648`", "NaN", "clamp"]),
        ("1 2 0.5\n4 5 6", &["line 4: `0.5`", "whole number"]),
        ("1 2 3 # one\n4 5 6\n7", &["line 6: `7` follows the last of 2 x 1 pixels"]),
        ("1 2 3\n4 5 6\nDone.", &["line 6: `Done.` follows the last", "std::cerr"]),
        ("1 2 3\nScanlines: 1\n4 5 6", &["line 5: `Scanlines:`", "std::cerr"]),
        ("1 2 3\n4 5", &["too short for 2 x 1 pixels"]),
    ] {
        folder.write("a.ppm", format!("P3\n2 1\n255\n{body}\n"));
        assert_refused(&folder, "a.ppm", words);
    }
    let wide = "\u{feff}P3\n1 1\n255\n1 2 3\n".encode_utf16().flat_map(u16::to_le_bytes);
    for (file, words) in [
        (b"Rendering: 10%\nP3\n1 1\n255\n1 2 3\n".to_vec(), &["line 2", "`Rendering: 10%`", "std::cerr"][..]),
        (b"P3\n1 1\n70000\n1 2 3\n".to_vec(), &["line 3: `70000`", "from 1 to 65535"]),
        (wide.clone().collect(), &["UTF-16", "PowerShell"]),
        (wide.skip(2).collect(), &["UTF-16", "PowerShell"]),
    ] {
        folder.write("a.ppm", file);
        assert_refused(&folder, "a.ppm", words);
    }
}

/// An OpenEXR file of the channels B, G and R in single precision. Windows are the first column and row and the last.
#[derive(Clone)]
struct Exr {
    data: [i32; 4],
    display: [i32; 4],
    flags: u8,
    names: [&'static str; 3],
    compression: u8,
    /// Rows are stored from the bottom.
    is_reversed: bool,
}

impl Exr {
    fn new(data: [i32; 4]) -> Self {
        Self { data, display: data, flags: 0, names: ["B", "G", "R"], compression: 0, is_reversed: false }
    }

    /// The value of a channel, which is different in each place.
    fn value([x, y]: [i32; 2], channel: usize) -> f32 {
        ((x * 7 + y * 13 + channel as i32 * 5).rem_euclid(29) as f32 + 0.5) / 30.0
    }

    /// The bytes of the display window.
    fn pixels(&self) -> ([usize; 2], Vec<u8>) {
        let [[l, t, r, b], [left, top, right, bottom]] = [self.data, self.display];
        let pixel = |x: i32, y: i32| match (l..=r).contains(&x) && (t..=b).contains(&y) {
            true => [2, 1, 0].map(|channel| (255.0 * f64::from(Self::value([x, y], channel))) as u8),
            false => [0; 3],
        };
        let bytes = (top..=bottom).flat_map(|y| (left..=right).flat_map(move |x| pixel(x, y)));
        ([(right - left + 1) as usize, (bottom - top + 1) as usize], bytes.collect())
    }

    /// The file, whose numbers are compressed by runs if `run` is not 0: these are at least so long.
    fn file(&self, run: usize) -> Vec<u8> {
        let [l, t, r, b] = self.data;
        let mut bytes = vec![0x76, 0x2f, 0x31, 0x01, 2, self.flags, 0, 0];
        let mut attribute = |name: &str, kind: &str, value: &[u8]| {
            bytes.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat());
            bytes.extend((value.len() as i32).to_le_bytes());
            bytes.extend(value);
        };
        let ints =
            |numbers: &[i32]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<_>>();
        let channel = |name: &str| [name.as_bytes(), b"\0", &ints(&[2, 0, 1, 1])].concat();
        attribute("channels", "chlist", &[self.names.map(channel).concat(), vec![0]].concat());
        attribute("compression", "compression", &[self.compression]);
        attribute("dataWindow", "box2i", &ints(&self.data));
        attribute("displayWindow", "box2i", &ints(&self.display));
        attribute("lineOrder", "lineOrder", &[self.is_reversed.into()]);
        bytes.push(0);
        let row = |y: i32| {
            let numbers = (0..3).flat_map(|channel| (l..=r).map(move |x| Self::value([x, y], channel)));
            let raw: Vec<u8> = numbers.flat_map(f32::to_le_bytes).collect();
            let packed = if run > 0 { packed(&raw, run) } else { raw.clone() };
            let packed = if packed.len() < raw.len() { packed } else { raw };
            [ints(&[y, packed.len() as i32]), packed].concat()
        };
        let mut rows: Vec<_> = (t..=b).map(row).collect();
        if self.is_reversed {
            rows.reverse();
        }
        // The places of the rows are not needed.
        bytes.extend(vec![0; 8 * rows.len()]);
        [bytes, rows.concat()].concat()
    }
}

/// The differences of the even bytes, then of the odd ones, in runs and stretches.
fn packed(raw: &[u8], run: usize) -> Vec<u8> {
    let sorted: Vec<u8> = raw.iter().step_by(2).chain(raw.iter().skip(1).step_by(2)).copied().collect();
    let differences = sorted.windows(2).map(|pair| pair[1].wrapping_sub(pair[0]).wrapping_add(128));
    let bytes: Vec<u8> = sorted[..1].iter().copied().chain(differences).collect();
    let (mut packed, mut stretch) = (vec![], vec![]);
    let flush = |stretch: &mut Vec<u8>, packed: &mut Vec<u8>| {
        stretch
            .chunks(127)
            .for_each(|part| packed.extend([&[(part.len() as u8).wrapping_neg()], part].concat()));
        stretch.clear();
    };
    for same in bytes.chunk_by(|a, b| a == b) {
        if same.len() < run {
            stretch.extend(same);
            continue;
        }
        flush(&mut stretch, &mut packed);
        same.chunks(128).for_each(|part| packed.extend([part.len() as u8 - 1, part[0]]));
    }
    flush(&mut stretch, &mut packed);
    packed
}

#[test]
fn an_openexr_picture_is_its_display_window() {
    let folder = Folder::new();
    for (data, display) in [
        ([0, 0, 7, 5], [0, 0, 7, 5]),
        ([-2, -1, 5, 4], [0, 0, 3, 2]),
        ([2, 1, 5, 3], [0, 0, 7, 5]),
        ([10, 20, 17, 25], [10, 20, 17, 25]),
        ([-9, -9, -2, -3], [-7, -10, -4, -1]),
        ([5, 4, 9, 9], [0, 0, 7, 5]),
        ([-20, 0, -17, 3], [0, 0, 7, 5]),
    ] {
        for is_reversed in [false, true] {
            let exr = Exr { display, is_reversed, ..Exr::new(data) };
            folder.write("a.exr", exr.file(0));
            assert_eq!(pixels(&folder, "a.exr"), exr.pixels(), "{data:?} {display:?}");
        }
    }
}

#[test]
fn openexr_files_with_runs_are_read_and_others_are_named() {
    let folder = Folder::new();
    for (data, run) in [([0, 0, 199, 3], 2), ([0, 0, 199, 3], 3), ([-4, 2, 9, 9], 2), ([0, 0, 600, 1], 200)] {
        let exr = Exr { compression: 1, ..Exr::new(data) };
        folder.write("a.exr", exr.file(run));
        assert_eq!(pixels(&folder, "a.exr"), exr.pixels(), "{data:?}");
    }
    let exr = Exr::new([0, 0, 3, 3]);
    for (compression, name) in [(4, "PIZ"), (5, "PXR24"), (6, "B44;"), (7, "B44A"), (8, "DWAA"), (9, "DWAB")]
    {
        folder.write("a.exr", Exr { compression, ..exr.clone() }.file(0));
        assert_refused(&folder, "a.exr", &["compression is", name, "oiiotool", "--compression zip"]);
    }
    for (flags, name) in [(2, "tiles"), (8, "deep data"), (16, "several parts")] {
        folder.write("a.exr", Exr { flags, ..exr.clone() }.file(0));
        assert_refused(&folder, "a.exr", &[name, "oiiotool"]);
    }
    let names = ["ViewLayer.Combined.B", "ViewLayer.Combined.G", "ViewLayer.Combined.R"];
    folder.write("a.exr", Exr { names, ..exr.clone() }.file(0));
    assert_refused(&folder, "a.exr", &[&names.join(", "), "--ch R=ViewLayer.Combined.R,G="]);
    // A row that is there twice leaves another out.
    let mut twice = exr.file(0);
    let row = twice.len() - 8 - 4 * 3 * 4;
    twice[row] = 0;
    folder.write("a.exr", twice);
    assert_refused(&folder, "a.exr", &["a row occurs twice"]);
}
