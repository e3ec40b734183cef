//! What the program prints on which stream, how it ends, and which files it leaves.

use crate::support::{CAMERA, Folder, finish, nobody, only_line, scene, sphere};

#[test]
fn a_target_that_cannot_be_written_is_reported_before_anything_is_rendered() {
    // No test waits for this picture.
    let folder = Folder::with_scene(&sphere());
    std::fs::create_dir(folder.path().join("folder.tga")).unwrap();
    for flags in ["-random_samples 1000 -output", "-depth 1 2", "-normals"] {
        let message = folder.run(&format!("-input s.txt -size 60000 60000 {flags} no/such/o.tga")).message(1);
        assert!(only_line(&message).starts_with("error: cannot write `no/such/o.tga`: "), "{message}");
    }
    for flags in ["-render_samples folder.tga 2", "-render_filter folder.tga 2"] {
        let message = folder.run(&format!("-input s.txt -size 30000 30000 {flags}")).message(1);
        assert_eq!(only_line(&message), "error: cannot write `folder.tga`: it is a folder");
    }
    assert_eq!(folder.names(), ["folder.tga", "s.txt"]);
}

#[test]
fn a_failed_run_leaves_an_earlier_picture_alone() {
    let folder = Folder::with_scene("PerspectiveCamera {");
    folder.write("o.tga", "an earlier picture");
    folder.run("-input s.txt -output o.tga -normals n.tga").message(1);
    assert_eq!(folder.read("o.tga"), b"an earlier picture");
    assert_eq!(folder.names(), ["o.tga", "s.txt"]);
}

#[test]
fn a_run_leaves_the_pictures_and_nothing_else() {
    let folder = Folder::with_scene(&sphere());
    folder.write("c.tga", "an earlier picture");
    folder
        .run("-input s.txt -size 5 4 -output c.tga -depth 0 9 d.png -normals n.tga -render_samples s.tga 3 -render_filter f.tga 2")
        .ok();
    assert_eq!(folder.names(), ["c.tga", "d.png", "f.tga", "n.tga", "s.tga", "s.txt"]);
    let size = |name| {
        let tga = folder.tga(name);
        (tga.width, tga.height)
    };
    assert_eq!(["c.tga", "n.tga", "s.tga", "f.tga"].map(size), [(5, 4), (5, 4), (15, 12), (11, 9)]);
}

#[test]
fn silence_is_the_rule() {
    let mirror = "Material { reflectiveColor 1 1 1 } Sphere { center 0 0 0 radius .7 }";
    let folder = Folder::with_scene(&scene(1, mirror));
    let run = folder.run("-input s.txt -output o.tga -shadows -bounces 2 -grid 3 3 3").ok();
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
}

#[test]
fn a_scene_without_lights_warns_on_standard_error_and_is_lit_evenly() {
    let lit = "Group { numObjects 1 Material { diffuseColor 1 .5 0 } Plane { normal 0 0 1 offset 0 } }";
    let folder = Folder::with_scene(&format!("{CAMERA}{lit}"));
    let run = folder.run("-input s.txt -output o.tga -size 2 2").ok();
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", "WARNING:  No lights specified\n"));
    assert_eq!(folder.tga("o.tga").pixels, [[255, 127, 0]; 4]);
}

#[cfg(feature = "gui")]
#[test]
fn what_the_preview_s_flags_do_not_do_is_said_once() {
    let folder = Folder::with_scene(&sphere());
    let plain = folder.render("");
    for (flags, note) in [
        (
            "-gui -tessellation 10 5 -gouraud",
            "`-gui` opens its page on a terminal; elsewhere it needs `-port n`",
        ),
        ("-gui -no_browser", "`-gui` opens its page on a terminal; elsewhere it needs `-port n`"),
        ("-tessellation 10 5", "`-tessellation` and `-gouraud` change nothing"),
    ] {
        let run = folder.run(&format!("-input s.txt -output p.tga {flags}")).ok();
        assert_eq!((only_line(&run.stderr), run.stdout.as_str()), (format!("note: {note}").as_str(), ""));
        assert_eq!(folder.tga("p.tga"), plain);
    }
    let run = folder.run("-compare p.tga -reference o.tga -gui -port 0").ok();
    assert_eq!(only_line(&run.stderr), "note: `-gui` needs a scene in a file");
}

#[test]
fn standard_output_carries_what_was_asked_for() {
    let folder = Folder::with_scene(&sphere());
    let help = folder.run("-help").ok();
    assert!(help.stdout.contains("Usage: raytracer -input scene.txt") && help.stderr.is_empty());
    let version = folder.run("-version").ok();
    assert_eq!(version.stdout, format!("raytracer {}\n", env!("CARGO_PKG_VERSION")));
    let stats = folder.run("-input s.txt -stats").ok();
    assert!(
        stats.stdout.starts_with("********************************************\nRAY TRACING STATISTICS\n")
    );
    assert!(stats.stderr.is_empty());
    assert_eq!(folder.names(), ["s.txt"]);
}

#[test]
fn readers_that_went_away_are_no_reason_to_panic() {
    let folder = Folder::with_scene(&sphere());
    for (line, status) in [("-nonsense", 2), ("-input no-such.txt", 1), ("-input s.txt -gui", 0)] {
        let run = finish(folder.command(line).stderr(nobody()));
        assert_eq!(run.status, Some(status), "{line}");
    }
}

#[test]
fn names_in_other_capitals_are_one_file_where_the_disk_says_so() {
    let folder = Folder::with_scene(&sphere());
    folder.write("probe", "");
    let is_one = folder.path().join("PROBE").exists();
    let cases = [
        ("-output a.tga -normals A.tga", ["a.tga", "A.tga"], "`a.tga` and `A.tga` are the same file"),
        // Both are there, or one of them.
        ("-output a.tga -normals A.tga", ["a.tga", "A.tga"], "`a.tga` and `A.tga` are the same file"),
        ("-output S.TXT tga", ["s.txt", "S.TXT"], "`S.TXT` would overwrite the scene `s.txt`"),
    ];
    for (flags, names, expected) in cases {
        let run = folder.run(&format!("-input s.txt -size 9 9 {flags}"));
        if is_one {
            assert_eq!(only_line(&run.message(2)), format!("error: {expected}"));
            folder.write("a.tga", "an earlier picture");
        } else {
            run.ok();
            let [one, other] = names.map(|name| folder.read(name));
            assert!(one != other, "{names:?}");
        }
        assert_eq!(folder.read("s.txt"), sphere().as_bytes());
    }
}
