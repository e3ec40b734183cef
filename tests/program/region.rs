//! `-region` and `-merge`: parts of pictures, and pictures of parts.

use crate::support::{CAMERA, Folder, Tga};
use raytracer::image_io::{self, Part};
use std::fs;

/// A mirror over a plane, under two lights.
fn mirrors() -> String {
    format!(
        "{CAMERA}Lights {{ numLights 2 DirectionalLight {{ direction 1 -1 -2 color .8 .7 .6 }}
            PointLight {{ position -1 2 3 color .3 .4 .5 attenuation 1 0 0 }} }}
         Background {{ color .1 .2 .4 ambientLight .1 .1 .1 }}
         Materials {{ numMaterials 2 Material {{ diffuseColor .6 .7 .3 }}
            Material {{ diffuseColor .2 .2 .2 reflectiveColor .7 .7 .7 }} }}
         Group {{ numObjects 3 MaterialIndex 1 Sphere {{ center .2 .1 0 radius .6 }}
            MaterialIndex 0 Sphere {{ center -.5 .4 .5 radius .2 }} TriangleMesh {{ obj_file one.obj }} }}"
    )
}

const TRIANGLE: &str = "v -2 -.9 1\nv 2 -.9 1\nv 0 -.2 -2\nf 1 2 3\n";

fn folder() -> Folder {
    let folder = Folder::with_scene(&mirrors());
    folder.write("one.obj", TRIANGLE);
    folder
}

/// The flags of every picture that has parts, in files that end in this.
fn pictures(name: &str, end: &str) -> String {
    format!(
        "-output {name}c.{end} -depth 7 11 {name}d.{end} -normals {name}n.{end} -render_samples {name}s.{end} 3"
    )
}

const LAYERS: [(&str, usize); 4] = [("c", 1), ("d", 1), ("n", 1), ("s", 3)];

#[test]
fn a_region_has_the_bytes_of_the_whole_in_every_layer() {
    let folder = folder();
    for flags in [
        "",
        "-jittered_samples 4 -mitchell_filter 2 -shadows -bounces 3 -seed 5",
        "-adaptive_samples 16 1 -tent_filter 1.3 -shadows",
        "-visualize_grid -grid 4 4 4",
    ] {
        let of = |name: &str| format!("-input s.txt -size 23 17 {flags} {}", pictures(name, "tga"));
        folder.run(&of("w")).ok();
        for window in [[5, 3, 9, 6], [22, 16, 1, 1], [0, 9, 23, 8]] {
            let [x, y, width, height] = window;
            folder.run(&format!("{} -region {x} {y} {width} {height}", of("p"))).ok();
            for (layer, zoom) in LAYERS {
                let [left, top, width, height] = window.map(|n| n * zoom);
                let (_, part, _) = folder.part(&format!("p{layer}.tga"));
                let whole = folder.tga(&format!("w{layer}.tga"));
                let rows = whole.pixels.chunks(whole.width).skip(top).take(height);
                let expected = rows.flat_map(|row| row[left..left + width].to_vec());
                assert!(part.pixels == expected.collect::<Vec<_>>(), "{flags} {layer} {window:?}");
            }
        }
    }
}

impl Folder {
    /// A part, read without the program's own code: its header, its pixels and its image ID.
    fn part(&self, name: &str) -> ([u8; 18], Tga, String) {
        let bytes = self.read(name);
        let header: [u8; 18] = bytes[..18].try_into().unwrap();
        let id = 18 + usize::from(header[0]);
        let plain = [&header, &bytes[id..]].concat();
        self.write("plain.tga", plain);
        (header, self.tga("plain.tga"), String::from_utf8(bytes[18..id].to_vec()).unwrap())
    }
}

#[test]
fn a_file_says_where_its_part_lies() {
    let folder = folder();
    let line = "-input s.txt -size 23 17 -region 5 3 9 6";
    folder.run(&format!("{line} {}", pictures("", "tga"))).ok();
    folder.run(&format!("{line} {}", pictures("", "png"))).ok();
    for (layer, zoom) in LAYERS {
        let (header, tga, id) = folder.part(&format!("{layer}.tga"));
        // The origin is that of the lower left corner, from the lower left corner of the whole.
        let (x, y, below) = (5 * zoom, 3 * zoom, 8 * zoom);
        assert_eq!(header[8..12], [x as u8, 0, below as u8, 0], "{layer}");
        let place = format!("part of {} x {} at {x}, {y}; fingerprint ", 23 * zoom, 17 * zoom);
        assert!(id.starts_with(&place), "{id}");

        let png = folder.read(&format!("{layer}.png"));
        let chunk = |kind: &[u8; 4]| {
            let at = png.windows(4).position(|bytes| bytes == kind).expect("the chunk");
            let length = u32::from_be_bytes(png[at - 4..at].try_into().unwrap()) as usize;
            png[at + 4..at + 4 + length].to_vec()
        };
        assert_eq!(chunk(b"oFFs"), [0, 0, 0, x as u8, 0, 0, 0, y as u8, 0]);
        assert_eq!(chunk(b"tEXt"), [b"Comment\0", id.as_bytes()].concat());

        // For every other program it is a picture.
        let [read, other] = ["tga", "png"].map(|end| {
            image_io::read_picture(&folder.path().join(layer).with_extension(end)).expect("a picture")
        });
        assert_eq!((&read, read.pixels()), (&other, tga.pixels.concat().as_slice()));
    }
    folder.run("-input s.txt -size 5 4 -output whole.png").ok();
    assert!(!folder.read("whole.png").windows(4).any(|bytes| bytes == b"tEXt" || bytes == b"oFFs"));
}

#[test]
fn parts_in_any_order_become_the_whole_picture() {
    let folder = folder();
    let flags = "-input s.txt -size 23 17 -shadows -bounces 2 -jittered_samples 4 -gaussian_filter .6";
    for end in ["tga", "png"] {
        folder.run(&format!("{flags} {}", pictures("whole_", end))).ok();
    }
    let parts = [
        ("a", "tga", "0 0 23 5"),
        ("b", "png", "0 5 11 12"),
        // These two overlap, the last overlaps both of the first.
        ("c", "tga", "9 5 14 9"),
        ("d", "png", "11 13 12 4"),
        ("e", "tga", "3 4 5 3"),
    ];
    for (name, end, region) in parts {
        folder.run(&format!("{flags} -region {region} {}", pictures(name, end))).ok();
    }
    for (layer, _) in LAYERS {
        for (order, end) in [([4, 3, 2, 1, 0], "tga"), ([2, 4, 0, 3, 1], "png")] {
            let files = order.map(|index| format!("{}{layer}.{}", parts[index].0, parts[index].1)).join(" ");
            let run = folder.run(&format!("-merge {files} -output merged.{end}")).ok();
            assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
            let whole = folder.read(&format!("whole_{layer}.{end}"));
            assert!(folder.read(&format!("merged.{end}")) == whole, "{layer} {order:?} {end}");
        }
    }
    // They also become a larger part.
    folder.run(&format!("{flags} -region 3 2 6 11 -output part.tga")).ok();
    folder.run("-merge ac.tga bc.png -region 3 2 6 11 -output merged.tga").ok();
    assert!(folder.read("merged.tga") == folder.read("part.tga"));
}

/// What a refused merge says.
fn refused(folder: &Folder, words: &str) -> String {
    folder.write("merged.tga", "an earlier picture");
    let before = folder.names();
    let message = folder.run(&format!("-merge {words} -output merged.tga")).message(1);
    assert_eq!(folder.read("merged.tga"), b"an earlier picture");
    assert_eq!(folder.names(), before);
    message.lines().next().unwrap_or_default().to_owned()
}

#[test]
fn a_gap_is_named_as_the_region_to_render() {
    let folder = folder();
    let flags = "-input s.txt -size 23 17";
    for (name, region) in [("a", "0 0 23 5"), ("b", "0 5 11 12"), ("c", "14 5 9 10"), ("d", "11 5 3 12")] {
        folder.run(&format!("{flags} -region {region} -output {name}.tga")).ok();
    }
    for (files, error) in [
        ("a.tga b.tga c.tga", "a part is missing: `-region 11 5 3 12`"),
        // That is missing then.
        ("a.tga b.tga c.tga d.tga", "a part is missing: `-region 14 15 9 2`"),
        ("c.tga b.tga", "a part is missing: `-region 0 0 23 5`"),
        ("a.tga -region 20 10 5 5", "`-region` reaches beyond the whole picture of 23 x 17 pixels"),
    ] {
        assert_eq!(refused(&folder, files), format!("error: {error}"), "{files}");
    }
}

#[test]
fn parts_of_different_pictures_do_not_mix() {
    let folder = folder();
    let render = |name: &str, rest: &str| folder.run(&format!("-input s.txt {rest} -output {name}.tga")).ok();
    render("a", "-size 9 9 -shadows -region 0 0 9 4");
    render("b", "-size 9 9 -shadows -region 0 4 9 5");
    render("size", "-size 9 10 -shadows -region 0 4 9 5");
    render("flags", "-size 9 9 -region 0 4 9 5");
    render("whole", "-size 9 9");
    folder.run("-input s.txt -size 9 9 -region 0 4 9 5 -normals kind.tga").ok();
    folder.write("one.obj", TRIANGLE.replace("-.2", "-.3"));
    render("mesh", "-size 9 9 -shadows -region 0 4 9 5");
    folder.write("one.obj", format!("{TRIANGLE}# a comment\n"));
    render("comment", "-size 9 9 -shadows -grid auto -threads 1 -region 0 4 9 5");
    folder.write("s.txt", mirrors().replace(".2 .1 0", ".2 .1 .1"));
    render("scene", "-size 9 9 -shadows -region 0 4 9 5");

    folder.run("-merge b.tga a.tga -output ok.tga").ok();
    folder.run("-merge a.tga comment.tga -output ok.tga").ok();
    for (file, difference) in [
        ("size", "of 9 x 10 pixels instead of 9 x 9"),
        ("flags", "of another layer, scene, mesh, flag or version of this program"),
        ("kind", "of another layer"),
        ("mesh", "of another layer"),
        ("scene", "of another layer"),
        ("whole", "9 x 9 pixels, not a part written by `-region`"),
    ] {
        let message = refused(&folder, &format!("a.tga {file}.tga"));
        assert!(message.contains(&format!("`{file}.tga`")) && message.contains(difference), "{message}");
    }
}

#[test]
fn only_flags_that_change_a_layer_tell_its_parts_apart() {
    let folder = folder();
    let fingerprint = |flags: &str| {
        folder.run(&format!("-input s.txt -size 9 9 -region 0 0 9 4 {flags} {}", pictures("", "tga"))).ok();
        LAYERS.map(|(layer, _)| {
            let (.., id) = folder.part(&format!("{layer}.tga"));
            Part::parse(&id).expect("a part").fingerprint
        })
    };
    let plain = fingerprint("");
    assert_eq!(fingerprint("-grid 3 3 3 -threads 1 -stats"), plain);
    for flags in
        ["-shadows", "-random_samples 4", "-gaussian_filter 1", "-visualize_grid -grid 3 3 3", "-bounces 1"]
    {
        let found = fingerprint(flags);
        let changed = [0, 1, 2, 3].map(|k| found[k] != plain[k]);
        assert_eq!(changed, [true, false, false, true], "{flags}");
    }
    let seeded = fingerprint("-random_samples 4 -seed 1");
    assert_ne!(seeded[0], fingerprint("-random_samples 4 -seed 2")[0]);
    assert_ne!(fingerprint("-visualize_grid -grid 3 3 3")[0], fingerprint("-visualize_grid -grid 3 3 4")[0]);
}

#[test]
fn overlaps_must_agree() {
    let folder = folder();
    for (name, region) in [("a", "0 0 6 9"), ("b", "4 0 5 5"), ("c", "3 3 6 6")] {
        folder.run(&format!("-input s.txt -size 9 9 -region {region} -output {name}.tga")).ok();
    }
    folder.run("-merge a.tga b.tga c.tga -output ok.tga").ok();
    // A pixel of `c` that `a` has too: column 1 and row 2 of it.
    let mut bytes = folder.read("c.tga");
    let pixels = 18 + usize::from(bytes[0]);
    bytes[pixels + 3 * (2 * 6 + 1) + 1] ^= 1;
    folder.write("changed.tga", &bytes);
    let message = refused(&folder, "changed.tga b.tga a.tga");
    assert_eq!(message, "error: `a.tga` and `changed.tga` overlap and differ at (4, 5)");
}

#[test]
fn damaged_parts_are_refused() {
    let folder = folder();
    for end in ["tga", "png"] {
        folder.run(&format!("-input s.txt -size 9 9 -region 0 0 9 9 -output a.{end}")).ok();
        let bytes = folder.read(&format!("a.{end}"));
        for length in [0, 17, 40, bytes.len() - 60] {
            folder.write(&format!("cut.{end}"), &bytes[..length]);
            let message = refused(&folder, &format!("cut.{end}"));
            assert!(message.starts_with(&format!("error: cannot read `cut.{end}`: ")), "{message}");
        }
    }
    fs::create_dir(folder.path().join("folder.tga")).unwrap();
    assert_eq!(refused(&folder, "folder.tga"), "error: cannot read `folder.tga`: it is not a regular file");
    assert!(refused(&folder, "no.tga").starts_with("error: cannot read `no.tga`: "));
}

#[test]
fn a_part_in_which_some_byte_is_changed_is_refused() {
    try_bytes(9);
}

#[test]
#[ignore = "slow: half a minute"]
fn a_part_in_which_any_byte_is_changed_is_refused() {
    try_bytes(1);
}

/// Changes every `step`th byte.
fn try_bytes(step: usize) {
    let folder = folder();
    folder.run("-input s.txt -size 5 6 -output whole.tga").ok();
    folder.run("-input s.txt -size 5 6 -region 0 0 5 3 -output top.tga").ok();
    for end in ["tga", "png"] {
        let name = format!("rest.{end}");
        folder.run(&format!("-input s.txt -size 5 6 -region 0 3 5 3 -output {name}")).ok();
        let bytes = folder.read(&name);
        // PNG has checksums of its own, for its pixels too. TGA's origin is for other programs.
        let (checked, flips): (Vec<usize>, &[u8]) = match end {
            "tga" => {
                let head = 0..18 + usize::from(bytes[0]);
                (head.filter(|place| !(8..12).contains(place)).collect(), &[1, 0x20, 0x80])
            }
            _ => ((0..bytes.len()).collect(), &[0x20]),
        };
        let changes =
            checked.into_iter().step_by(step).flat_map(|place| flips.iter().map(move |flip| (place, flip)));
        for (place, flip) in changes {
            let mut changed = bytes.clone();
            changed[place] ^= flip;
            folder.write(&name, changed);
            let message = refused(&folder, &format!("top.tga {name}"));
            assert!(
                message.contains(&name) || message.contains("a part is missing"),
                "byte {place}: {message}"
            );
        }
        folder.write(&name, bytes);
        folder.run(&format!("-merge {name} top.tga -output merged.tga")).ok();
        assert!(folder.read("merged.tga") == folder.read("whole.tga"));
    }
}

#[test]
fn the_statistics_of_a_region_are_its_own() {
    let said = folder().run("-input s.txt -size 9 9 -region 1 2 4 5 -stats").ok().stdout;
    assert!(said.contains("  20 (4x5)\n") && said.contains("  num non-shadow rays        20\n"), "{said}");
}
