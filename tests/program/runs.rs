//! What the program prints on which stream, how it ends, and which files it leaves.

use crate::support::{Folder, only_line, sphere};

#[test]
fn a_target_that_cannot_be_written_is_reported_before_anything_is_rendered() {
    // No test waits for this picture.
    let folder = Folder::with_scene(&sphere());
    std::fs::create_dir(folder.path().join("folder.tga")).unwrap();
    for flags in ["-random_samples 1000 -output", "-depth 1 2", "-normals"] {
        let message = folder.run(&format!("-input s.txt -size 60000 60000 {flags} no/o.tga")).message(1);
        assert!(message.contains("`no/o.tga`: there is no folder `no`"), "{message}");
    }
    for flags in ["-render_samples folder.tga 2", "-render_filter folder.tga 2"] {
        let message = folder.run(&format!("-input s.txt -size 30000 30000 {flags}")).message(1);
        assert!(message.contains("`folder.tga`: it is a folder"), "{message}");
    }
    assert_eq!(folder.names(), ["folder.tga", "s.txt"]);
}

#[cfg(feature = "gui")]
#[test]
fn what_the_preview_s_flags_do_not_do_is_said_once() {
    let folder = Folder::with_scene(&sphere());
    let plain = folder.render("");
    for (flags, note) in [
        ("-gui -tessellation 10 5 -gouraud", "note: `-gui` opens its page on a terminal"),
        ("-tessellation 10 5", "note: `-tessellation` and `-gouraud` change nothing"),
    ] {
        let run = folder.run(&format!("-input s.txt -output p.tga {flags}")).ok();
        assert!(only_line(&run.stderr).starts_with(note) && run.stdout.is_empty(), "{}", run.stderr);
        assert_eq!(folder.tga("p.tga"), plain);
    }
    let run = folder.run("-compare p.tga -reference o.tga -gui -port 0").ok();
    assert!(only_line(&run.stderr).starts_with("note: `-gui` needs a scene"), "{}", run.stderr);
}

#[test]
fn names_in_other_capitals_are_one_file_where_the_disk_says_so() {
    let folder = Folder::with_scene(&sphere());
    folder.write("probe", "");
    let is_one = folder.path().join("PROBE").exists();
    let same = ("-output a.tga -normals A.tga", ["a.tga", "A.tga"], "`a.tga` and `A.tga` are the same file");
    let cases = [
        same,
        // Both are there, or one of them.
        same,
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
