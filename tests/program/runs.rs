//! What the program prints on which stream, how it ends, and which files it leaves.

use crate::support::{Folder, only_line, sphere};

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
