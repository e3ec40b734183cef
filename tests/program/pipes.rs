//! Standard input and output, pipes and devices in place of files.

#[cfg(target_os = "linux")]
use crate::support::only_line;
use crate::support::{Folder, finish, nobody, program, scene, sphere};
use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};

/// What a run writes to standard output, which must succeed.
fn output(command: &mut Command) -> (Vec<u8>, String) {
    let output = command.output().expect("the program starts");
    let errors = String::from_utf8(output.stderr).expect("standard error is text");
    assert_eq!(output.status.code(), Some(0), "{errors}");
    (output.stdout, errors)
}

fn opened(folder: &Folder, name: &str) -> File {
    File::open(folder.path().join(name)).expect("a file in the temporary folder")
}

#[test]
fn a_scene_is_read_from_standard_input() {
    let folder = Folder::with_scene(&sphere());
    let plain = folder.render("");
    finish(folder.command("-input - -output p.tga").stdin(opened(&folder, "s.txt"))).ok();
    assert_eq!(folder.tga("p.tga"), plain);
}

#[test]
fn meshes_of_standard_input_are_in_the_working_directory() {
    let folder = Folder::with_scene(&scene(1, "TriangleMesh { obj_file one.obj }"));
    folder.write("one.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    let input = || opened(&folder, "s.txt");
    finish(folder.command("-input - -output p.tga -size 3 3").stdin(input())).ok();
    assert_eq!(folder.tga("p.tga").at(1, 1), [255; 3]);
    let elsewhere = Folder::new();
    let message = finish(elsewhere.command("-input -").stdin(input())).message(1);
    assert!(message.starts_with("standard input:5:25: error: cannot read the mesh `one.obj`"), "{message}");
}

#[test]
fn a_scene_may_have_any_name() {
    let folder = Folder::new();
    for name in ["scene", "s.scene", "s.TXT", "s.tga"] {
        folder.write(name, sphere());
        folder.run(&format!("-input {name} -output o.png")).ok();
    }
}

#[test]
fn each_picture_is_written_to_standard_output_as_to_a_file() {
    let folder = Folder::with_scene(&sphere());
    for (flags, rest) in [
        ("-output", ""),
        ("-depth 8 10", ""),
        ("-normals", ""),
        ("-cost_map rays", ""),
        ("-render_samples", "3"),
        ("-render_filter", "3"),
    ] {
        for format in ["png", if flags.starts_with("-cost_map") { "tga" } else { "exr" }] {
            folder.run(&format!("-input s.txt -size 9 7 {flags} a.{format} {rest}")).ok();
            let line = format!("-input s.txt -size 9 7 {flags} - {format} {rest}");
            let (bytes, _) = output(&mut folder.command(&line));
            assert!(bytes == folder.read(&format!("a.{format}")), "{line}");
        }
    }
}

#[test]
fn the_text_goes_to_standard_error_if_a_picture_goes_to_standard_output() {
    let folder = Folder::with_scene(&sphere());
    folder.run("-input s.txt -output o.tga").ok();
    let (bytes, errors) =
        output(&mut folder.command("-input s.txt -stats -pixel 50 50 -output - tga -normals n.tga"));
    assert!(bytes == folder.read("o.tga"));
    assert!(errors.starts_with("********************************************\nRAY TRACING STATISTICS\n"));
    assert!(errors.contains("PIXEL (50, 50)"), "{errors}");
    assert_eq!(folder.names(), ["n.tga", "o.tga", "s.txt"]);
}

#[test]
fn parts_become_a_picture_on_standard_output() {
    let folder = Folder::with_scene(&sphere());
    folder.run("-input s.txt -size 9 7 -output o.png").ok();
    folder.run("-input s.txt -size 9 7 -region 0 0 9 3 -output a.tga").ok();
    folder.run("-input s.txt -size 9 7 -region 0 3 9 4 -output b.png").ok();
    let (bytes, _) = output(&mut folder.command("-merge a.tga b.png -output - png"));
    assert!(bytes == folder.read("o.png"));
}

#[test]
fn a_word_tells_the_format_where_the_name_does_not() {
    let folder = Folder::with_scene(&sphere());
    folder.run("-input s.txt -output o.tga -normals n.png").ok();
    folder.run("-input s.txt -output colors tga -normals x.normals png").ok();
    assert!(
        folder.read("colors") == folder.read("o.tga") && folder.read("x.normals") == folder.read("n.png")
    );
}

#[test]
fn a_reader_that_has_seen_enough_ends_nothing_else() {
    let folder = Folder::with_scene(&sphere());
    folder.run("-input s.txt -output expected.tga").ok();
    for picture in ["-depth 8 10 - tga", "-depth 8 10 - png", "-cost_map rays - png"] {
        let line = format!("-input s.txt {picture} -output o.tga -render_samples s.tga 2");
        let run = finish(folder.command(&line).stdout(nobody())).ok();
        assert!(!run.stderr.contains("error"), "{}", run.stderr);
        assert!(folder.read("o.tga") == folder.read("expected.tga"));
        assert_eq!(folder.names(), ["expected.tga", "o.tga", "s.tga", "s.txt"]);
        std::fs::remove_file(folder.path().join("s.tga")).unwrap();
    }
    for line in ["-help", "-version", "-input s.txt -stats", "-input s.txt -json -"] {
        let run = finish(folder.command(line).stdout(nobody())).ok();
        assert_eq!(run.stderr, "", "{line}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_an_error() {
    let folder = Folder::with_scene(&sphere());
    for line in
        ["-help", "-version", "-input s.txt -stats", "-input s.txt -json -", "-input s.txt -output - png"]
    {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let message = finish(folder.command(line).stdout(full)).message(1);
        let parts = ["error: cannot write ", "standard output", "No space left"];
        assert!(parts.iter().all(|part| only_line(&message).contains(part)), "{line}: {message}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn devices_are_written() {
    let folder = Folder::with_scene(&sphere());
    folder.run("-input s.txt -output o.tga").ok();
    folder.run("-input s.txt -output /dev/null png").ok();
    let (bytes, _) = output(&mut folder.command("-input s.txt -output /dev/stdout tga"));
    assert!(bytes == folder.read("o.tga"));
    let file = File::create(folder.path().join("p.tga")).unwrap();
    finish(folder.command("-input s.txt -output /dev/stdout tga -stats").stdout(file)).ok();
    assert!(folder.read("p.tga") == folder.read("o.tga"));
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
}

#[cfg(unix)]
#[test]
fn a_named_pipe_is_written_and_read() {
    let folder = Folder::with_scene(&sphere());
    folder.run("-input s.txt -output o.tga").ok();
    folder.make_pipe("p");
    let path = folder.path().join("p");
    let reader = std::thread::spawn({
        let path = path.clone();
        move || std::fs::read(path).unwrap()
    });
    folder.run("-input s.txt -output p tga").ok();
    assert!(reader.join().unwrap() == folder.read("o.tga"));
    let writer = std::thread::spawn(move || std::fs::write(path, sphere()).unwrap());
    folder.run("-input p -output q.tga").ok();
    writer.join().unwrap();
    assert!(folder.read("q.tga") == folder.read("o.tga"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_scene_without_an_end_is_refused() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path().join("folder")).unwrap();
    let zero = || File::open("/dev/zero").unwrap();
    for (run, name, reason) in [
        (folder.run("-input /dev/zero"), "/dev/zero", "longer than 256 MiB"),
        (finish(folder.command("-input -").stdin(zero())), "standard input", "longer than 256 MiB"),
        (folder.run("-input folder"), "folder", "Is a directory"),
    ] {
        let message = run.message(1);
        assert!(message.starts_with(&format!("{name}: error: ")) && message.contains(reason), "{message}");
    }
}

#[test]
fn a_dash_in_a_folder_is_a_file() {
    let folder = Folder::new();
    folder.write("-", sphere());
    finish(program(folder.path(), ["-input", "./-", "-output", "./-.tga"]).stdin(Stdio::null())).ok();
    assert!(Path::exists(&folder.path().join("-.tga")));
}
