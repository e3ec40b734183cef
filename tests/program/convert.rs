//! Pictures in other formats, with and without a scene.

#[cfg(unix)]
use crate::support::finish;
use crate::support::{Folder, sphere};
#[cfg(unix)]
use std::fs::File;

const RENDER: &str = "-input s.txt -size 21 15 -shadows";

#[test]
fn a_picture_becomes_one_of_another_format_as_if_it_had_been_rendered() {
    let folder = Folder::with_scene(&sphere());
    let endings = ["tga", "png", "bmp", "ppm"];
    for end in endings {
        folder.run(&format!("{RENDER} -output o.{end} -normals n.{end}")).ok();
    }
    for (from, to) in endings.iter().flat_map(|from| endings.map(|to| (from, to))) {
        let run = folder.run(&format!("-convert o.{from} -output c.{to}")).ok();
        assert_eq!((run.stdout, run.stderr), (String::new(), String::new()));
        assert!(folder.read(&format!("c.{to}")) == folder.read(&format!("o.{to}")), "{from} to {to}");
    }
    folder.run("-compare o.bmp -reference o.ppm -tolerance 0 0 -difference d.bmp").ok();
    assert!(folder.names().contains(&"d.bmp".into()));
    let written = folder.command("-convert o.png -output - ppm").output().unwrap();
    assert!(written.stdout == folder.read("o.ppm"));
}

#[cfg(unix)]
#[test]
fn a_picture_of_this_program_is_converted_in_the_memory_of_a_row() {
    let folder = Folder::new();
    let header = [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xa0, 0x0f, 0xe0, 0x2e, 24, 32];
    folder.write("vast.tga", header);
    // A hole of 4000 x 12000 black pixels.
    let file = File::options().append(true).open(folder.path().join("vast.tga")).unwrap();
    file.set_len(18 + 4000 * 12000 * 3).unwrap();
    finish(&mut folder.command_within("-v 120000", "-convert vast.tga -output o.png")).ok();
    let png = folder.read("o.png");
    assert_eq!(png[16..24], [0, 0, 0x0f, 0xa0, 0, 0, 0x2e, 0xe0]);
}

#[test]
fn numbers_become_bytes_and_clamped_ones_are_counted() {
    let folder = Folder::with_scene(&sphere().replace("color 1 1 1", "color 2 2 2"));
    folder.run(&format!("{RENDER} -output o.tga -depth 8 9 o.exr")).ok();
    folder.run(&format!("{RENDER} -output o.pfm")).ok();
    let run = folder.run("-convert o.pfm -output c.tga").ok();
    assert!(
        run.stderr.starts_with("note: ") && run.stderr.ends_with("and are converted clamped\n"),
        "{}",
        run.stderr
    );
    assert!(folder.read("c.tga") == folder.read("o.tga"));
    assert!(folder.run("-convert o.tga -output c.exr").message(2).contains("'c.exr' for '-output'"));
}

#[test]
fn the_picture_that_is_read_is_not_written_and_nothing_else_is_understood() {
    let folder = Folder::with_scene(&sphere());
    folder.run(&format!("{RENDER} -output o.png")).ok();
    let before = folder.read("o.png");
    for (line, status) in [
        ("-convert o.png -output o.png", 2),
        ("-convert o.png -output ./o.png", 2),
        ("-convert o.png", 2),
        ("-convert o.png -output a.bmp -size 3 3", 2),
        ("-convert o.png -merge o.png -output a.bmp", 2),
        ("-convert gone.png -output a.bmp", 1),
        ("-convert s.txt -output a.bmp", 2),
        ("-merge o.png -output a.bmp", 1),
        ("-merge o.bmp -output a.png", 2),
    ] {
        folder.run(line).message(status);
    }
    assert!(folder.names() == ["o.png", "s.txt"] && folder.read("o.png") == before);
}

#[test]
fn parts_make_a_picture_of_any_format_of_bytes() {
    let folder = Folder::with_scene(&sphere());
    folder.run(&format!("{RENDER} -region 0 0 21 8 -output a.png")).ok();
    folder.run(&format!("{RENDER} -region 0 8 21 7 -output b.tga")).ok();
    folder.run(&format!("{RENDER} -output o.bmp")).ok();
    folder.run("-merge a.png b.tga -output m.bmp").ok();
    assert!(folder.read("m.bmp") == folder.read("o.bmp"));
}
