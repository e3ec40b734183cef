use super::*;
use crate::base::patience::tests::Counted;
use crate::diagnostic::Position;
use glam::{DVec2, DVec3};
use std::path::Path;

fn read(text: &str) -> Mesh {
    parse_obj(text.as_bytes()).unwrap()
}

fn refuse(text: &str) -> Diagnostic {
    parse_obj(text.as_bytes()).unwrap_err()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn faces_may_name_more_than_positions() {
    let plain = read(&format!("{SQUARE}f 1 2 3"));
    for face in ["1/1 2/2 3/3", "1//9 2//9 3//9", "1/7/7 2/8/8 3/9/9", "1/-99999999/6148914691236517206 2 3"]
    {
        let text = format!("vn 0 0 1\nvt 0 0\n{SQUARE}f {face}");
        assert_eq!(read(&text), plain, "{face}");
    }
}

#[test]
fn negative_indices_count_backwards_from_the_face() {
    let mesh = read(&format!("{SQUARE}f -4 -3 -2\nv 9 9 9\nf -1 -2 -3"));
    let corners = mesh.triangles[1].map(|corner| mesh.vertices[corner as usize]);
    assert_eq!(corners, [DVec3::splat(9.0), DVec3::Y, DVec3::new(1.0, 1.0, 0.0)]);
    assert_eq!((mesh.triangles[0], mesh.vertices.len()), ([0, 1, 2], 5));
}

#[test]
fn comments_colours_weights_and_byte_order_marks() {
    let bytes =
        b"\xef\xbb\xbfv 0 0 0 # \xe9\r\n# \xff\r\n v 2 0 0 2\r\nv\t0 1 0 .1 .2 .3\r\nf 1 2 3 # f 9\r\n";
    let mesh = parse_obj(bytes).unwrap();
    assert_eq!(mesh.vertices, [DVec3::ZERO, DVec3::X, DVec3::Y]);
}

#[test]
fn meshes_without_faces() {
    for (text, why) in [
        ("", ": the file is empty"),
        ("\n", ""),
        ("# nothing", ""),
        (SQUARE, ""),
        ("v 0 0 0\nv 1 0 0\nl 1 2\n", ", only points, lines or curves"),
        ("surf 0 1 0 1 1 2 3 4", ": a curved surface is ignored"),
        ("call all.obj", ": `call` is ignored, and so is the file that it names"),
        ("csh ls", ": `csh` is ignored: no command of a file is run"),
        ("nothing", ": `nothing` is not a keyword of OBJ; its line is ignored"),
    ] {
        assert_eq!(refuse(text).message, format!("the mesh has no faces{why}"), "{text}");
    }
    assert_eq!(refuse("binary \0 rubbish").message, "the file is binary, not OBJ");
    let library = refuse("newmtl red\nKd 1 0 0\n");
    assert_eq!(
        (library.position(), library.message.as_str()),
        (None, "the file is a material library, not OBJ")
    );
}

/// Faulty statements: `@` marks the caret, `2/@x` a part of a word. With the start of the hint.
const FAULTS: &[(&str, &str)] = &[
    ("@v", ""),
    ("v 1 @2", ""),
    ("v 1 @2 # 3", ""),
    ("v 1 2 @x", ""),
    ("v 1 @x", ""),
    ("v @1,5 2,5 3,5", "a decimal point"),
    ("v @1,2,3", "numbers are separated by blanks"),
    ("v @1, 2, 3", "numbers are separated by blanks"),
    ("v @1d-5 2 3", "an exponent is written with `e`"),
    ("v 1 \\ @2 \\ 3", "a backslash continues"),
    ("v 1 2 @3\0", "the word has a zero byte"),
    ("v 1 2 3 4 @5", ""),
    ("v 1 2 3 4 5 6 7 @8", ""),
    ("f 1 2 @x", ""),
    ("f 1 2 @3.0", "indices are whole numbers"),
    ("f @1,2,3", "indices are separated by blanks"),
    ("f 1 2 @1/2/3/4", "a corner has at most three indices"),
    ("f @/ / /", "the index of the position comes first"),
    ("f 1 2/@x 3", ""),
    ("@f", "a line between two vertices is written"),
    ("f 1 @2", "a line between"),
    ("f 1 @2 # two", "a line between"),
    ("  f 1 @0 2", "indices start with 1"),
    ("fo 1 @9 2", ""),
    ("f 1 2 @-5", "a negative index counts back"),
    ("f 1 2 @9223372036854775807", ""),
    ("f 1 2 @99999999999999999999", ""),
    ("f 1 2 @4294967297", ""),
    ("f 1 2 @-9223372036854775808", "a negative index counts back"),
];

#[test]
fn an_error_has_its_place_and_a_hint() {
    for end in ["\n", "\r", "\r\n"] {
        for (marked, hint) in FAULTS {
            // The position of a part of a word is the position of the word.
            let marked = marked.replace("2/@x", "@2/x").replace("\\ @2", "@\\ 2");
            let (before, after) = marked.split_once('@').unwrap();
            let text = format!("{SQUARE}{before}{after}\n\nf 1 2 3\n").replace('\n', end);
            let error = refuse(&text);
            let at = Position { line: 5, column: before.len() as u32 + 1 };
            assert_eq!(error.position(), Some(at), "{marked}");
            let found = error.hint.clone().unwrap_or_default();
            assert!(found.starts_with(hint) && found.is_empty() == hint.is_empty(), "{marked}: {found}");
            let line = format!("{before}{after}").replace('\0', "\u{fffd}");
            let shown = error.in_text(Path::new("m"), &super::text(text.as_bytes())).to_string();
            assert!(shown.contains(&format!("\n    5 | {line}\n")), "{marked}");
        }
    }
}

#[test]
fn vertices_that_faces_use_must_be_finite() {
    let hint = Some("leave it out, or make it 1".to_owned());
    let not_finite = "a vertex has a coordinate that is not finite";
    let zero_weight = "a vertex has the weight 0: it is at infinity";
    for (marked, message) in [
        ("@nan 0 0", not_finite),
        ("0 @inf 0", not_finite),
        ("0 0 @-1e999", not_finite),
        ("0 0 0 @nan", not_finite),
        ("0 0 0 @inf", not_finite),
        ("@1e300 0 0 1e-300", not_finite),
        ("0 @1 0 1e-320", not_finite),
        ("@-nan(ind) 0 0", not_finite),
        ("0 @1.#IND 0", not_finite),
        ("0 0 @-1.#QNAN", not_finite),
        ("0 0 0 @0", zero_weight),
        ("1 2 3 @-0", zero_weight),
    ] {
        let vertex = marked.replace('@', "");
        let at = Some(Position { line: 5, column: 3 + marked.find('@').unwrap() as u32 });
        // The error names the first such vertex that a face uses.
        let error = refuse(&format!("{SQUARE}v {vertex}\nv 0 0 inf\nv nan 0 0\nf 1 2 7\nf 1 2 5\n"));
        assert_eq!((error.position(), error.message.as_str()), (at, message), "{vertex}");
        assert_eq!(error.hint, hint.clone().filter(|_| message == zero_weight), "{vertex}");
        assert_eq!(read(&format!("{SQUARE}v {vertex}\nf 1 2 3\n")).vertices.len(), 3, "{vertex}");
    }
}

#[test]
fn what_other_programs_write_is_read() {
    let plain = read(&format!("{SQUARE}f 1 2 3\nf 1 3 4\n"));
    let utf8 = |text: &str| parse_obj(format!("\u{feff}{text}").as_bytes()).unwrap();
    let faces = "f 1 2 3\nf 1 3 4\n";
    for text in [
        "v 0 0 0 1 0 0 1\nv 1 0 0 .1 .2 .3 0\nv 1 1 0 1 1 1 1\nv 0 1 0 0 0 0 0\nf 1 2 3\nf 1 3 4\n"
            .to_owned(),
        "v 0 0 0 1 0 0\nv 1. +0 -0\nv +1 1e0 0\nv 0. 10.0E-1 0 0 1 0\nf 1 2 3\nf 1 3 4\n".to_owned(),
        format!("{SQUARE}fo 1 2 3\nfo 1 3 4\n"),
        format!("{SQUARE}f 1/ 2/ 3/\nf 1// 3//9 4//9\n"),
        format!("{SQUARE}f -4 +2 -2\nf 1\t3\x0b-1\n"),
        format!("{SQUARE}usemtl C:\\wood\\\nf 1 2 3\ng a \\\nb\nmtllib x \\ \nf 1 3 4\n"),
        format!("{SQUARE}vt 0 \\\n0\nf 1 2 \\ \n 3\nf \\\n1 3\\\n4 # \\\n"),
        format!("g\no a b\ns off\ns 1\nvp 0 1\ncurv 0 1 1 2\np 1\nl 1 2\nl x\nvn nan\n{SQUARE}{faces}end\n"),
        format!("{SQUARE}{faces}\0\0\x1a"),
        format!("{SQUARE}# {}\n{faces}", "x".repeat(1 << 16)),
        format!("{faces}{SQUARE}"),
    ] {
        for end in ["\n", "\r", "\r\n"] {
            let text = text.replace('\n', end);
            let file = read_obj(text.as_bytes(), true, &Endless).unwrap();
            assert_eq!((&file.mesh, file.warnings), (&plain, vec![]), "{text:.200}");
            assert_eq!(utf8(&text), plain, "{text:.200}");
        }
    }
    let mixed = format!("{SQUARE}{faces}").replacen('\n', "\r", 2).replacen('\n', "\r\n", 1);
    assert_eq!(read(&mixed), plain);
    assert_eq!(read(&format!("# one\r{mixed}")), plain);
}

#[test]
fn what_is_left_out_has_a_warning() {
    let text = format!(
        "{SQUARE}F 1 2 3\nf 1 2 3\nface 1 2 3\n surf 0 1 0 1 1 2 3 4\nf 1 3 2 4\nf 4 2 3 1\n{}",
        "f 1 2 3 2\n".repeat(3)
    );
    let ObjFile { mesh, warnings, .. } = read_obj(text.as_bytes(), false, &Endless).unwrap();
    assert_eq!(mesh.triangles.len(), 1 + 1 + 1);
    let said: Vec<_> = warnings.iter().map(Diagnostic::headline).collect();
    assert_eq!(
        said,
        [
            "line 5, column 1: warning: `F` is not a keyword of OBJ; its line is ignored (and 1 more)",
            "line 8, column 2: warning: a curved surface is ignored",
            "line 9, column 1: warning: the outline of the polygon crosses itself (and 1 more)",
            "line 11, column 1: warning: the outline of the polygon encloses nothing (and 2 more)",
        ]
    );
    let hints: Vec<_> = warnings.iter().map(|warning| warning.hint.clone().unwrap_or_default()).collect();
    assert_eq!(hints[0], "did you mean `f`?");
}

#[test]
fn a_face_has_up_to_a_thousand_corners() {
    let face = |count: usize| format!("{SQUARE}f{}\n", " 1 2".repeat(count / 2));
    assert_eq!(read_obj(face(1000).as_bytes(), false, &Endless).unwrap().warnings.len(), 0);
    let error = refuse(&face(1002));
    assert_eq!(error.message, "a face has 1002 corners: 1000 are the most");
    assert_eq!(error.position(), Some(Position { line: 5, column: 1 }));
}

#[test]
fn reading_ends_at_any_question() {
    let plain = format!("{SQUARE}{}", "f 1 2 3\n".repeat(40_000));
    let quads = format!("{SQUARE}{}", "f 1 2 3 4\n".repeat(10_000));
    for text in [plain, quads] {
        let mut read =
            (0..).map(|most| read_obj(text.as_bytes(), false, &Counted::up_to(most)).map(|file| file.mesh));
        let ended = read.by_ref().take_while(Result::is_err).count();
        assert!(ended > 3, "{ended}");
    }
}

#[test]
fn the_error_names_the_first_face_with_a_missing_vertex() {
    for (corner, line) in [("6", 7), ("0", 7), ("-6", 7), ("-5", 9), ("5", 9), ("1", 9)] {
        let text = format!("{SQUARE}v 0 2 0\nf 1/1 -5 5//1\nf 2 3 {corner}\n#\nf 1 2 7\nf 1 2 8\n");
        let error = refuse(&text);
        assert!(error.message.ends_with("does not exist; the mesh has 5"), "{corner}");
        assert_eq!(error.position().map(|at| at.line), Some(line), "{corner}");
    }
    // Vertices after a later fault are counted.
    let error = refuse(&format!("{SQUARE}f 1 2 9\nv x\nv 0 0 0\n"));
    assert_eq!(error.message, "a face names a vertex that does not exist; the mesh has 6");
    assert_eq!(error.position(), Some(Position { line: 5, column: 7 }));
    // A negative index counts back from its face, even if more vertices follow.
    let text = format!("{SQUARE}f -1 -2 -4\nf -1 -2 -5\nv 0 2 0\n");
    assert_eq!(refuse(&text).position(), Some(Position { line: 6, column: 9 }));
}

#[test]
fn triangles_have_the_texture_coordinates_that_their_corners_name() {
    let [a, b, c] = [DVec2::new(0.25, 0.5), DVec2::X, DVec2::Y];
    let places = "vt 0.25 0.5 # one\nvt 1\nvt 0 1 7\n";
    let faces = "f 1/1 2/2/9 3/3/-9\nf 1/-1 2/-2/7 3/-3\nf 1 2 3\nf 1/ 2/1 3/1\nf 1//1 2/1 3/1\n";
    let expected = [Some([a, b, c]), Some([c, b, a]), None, None, None];
    let read = |text: &str| read_obj(text.as_bytes(), true, &Endless).unwrap();
    for text in [
        format!("{SQUARE}{places}{faces}"),
        format!("\u{feff}{places}{SQUARE}{faces}"),
        format!("{SQUARE}{places}{faces}").replace("f 1", "fo 1").replace(" 2/", " \\\n2/"),
        format!("{SQUARE}{places}{faces}").replace('\n', "\r\n").replace("vt 1", "vt \\\r\n1 \\\r\n0 "),
    ] {
        assert_eq!(read(&text).texture_coordinates, expected, "{text}");
        assert_eq!(read_obj(text.as_bytes(), false, &Endless).unwrap().texture_coordinates, []);
    }
    // Coordinates may come after the faces if no index is negative.
    let later = format!("{SQUARE}f 1/1 2/2 3/3\n{places}");
    assert_eq!(read(&later).texture_coordinates, [Some([a, b, c])]);
    // The triangles of a quad and of a cut polygon keep the coordinates of their corners.
    let quad = format!("{SQUARE}{places}f 1/1 2/2 3/3 4/1\nf 1/3 2/2 3/1\n");
    assert_eq!(read(&quad).texture_coordinates, [Some([a, b, c]), Some([a, c, a]), Some([c, b, a])]);
    let dart = "v 0 0 0\nv 4 2 0\nv 0 4 0\nv 1.5 2 0\nvt 0 0\nvt 4 2\nvt 0 4\nvt 1.5 2\nf 1/1 2/2 3/3 4/4\n";
    let ObjFile { mesh, texture_coordinates, .. } = read(dart);
    for (corners, places) in mesh.triangles.iter().zip(texture_coordinates) {
        assert_eq!(corners.map(|corner| mesh.vertices[corner as usize].truncate()), places.unwrap());
    }
    // A file without coordinates has an empty list.
    assert_eq!(read(&format!("{SQUARE}f 1 2 3\n")).texture_coordinates, []);
}

#[test]
fn a_texture_coordinate_that_a_face_names_must_exist_and_be_finite() {
    const PLACES: &str = "vt 0 0\nvt 1 0\nvt 0 1\n";
    let missing = "a face names a texture coordinate that does not exist; the mesh has";
    let not_finite = "a texture coordinate is not finite";
    let hint = "a negative index counts back from the face: -1 is the texture coordinate before it";
    for (marked, message, hint) in [
        ("f 1/1 2/2 @3/4\n", format!("{missing} 3"), None),
        ("f 1/1 @2/0 3/3\n", format!("{missing} 3"), Some("indices start with 1")),
        ("f @1/-4 2/2 3/3\n", format!("{missing} 3"), Some(hint)),
        ("f 1/1 2/2 @3/4000000000/1\n", format!("{missing} 3"), None),
        ("f 1/1 2/2 @3/9223372036854775807\n", format!("{missing} 3"), None),
        ("vt @nan 0\nf 1/1 2/2 3/4\n", not_finite.into(), None),
        ("vt 0 @-nan(ind)\nvt inf 0\nf 1/1 2/5 3/4\n", not_finite.into(), None),
        ("vt @1e999\nf 1/1 2/2 3/-1\n", not_finite.into(), None),
        ("vt 0 @x\nf 1 2 3\n", "a texture coordinate needs numbers, found `x`".into(), None),
    ] {
        let (before, _) = marked.split_once('@').unwrap();
        let text = format!("{SQUARE}{PLACES}{}", marked.replace('@', ""));
        let error = read_obj(text.as_bytes(), true, &Endless).unwrap_err();
        let at = Position { line: 8, column: before.chars().count() as u32 + 1 };
        assert_eq!((error.position(), error.message), (Some(at), message), "{marked}");
        assert_eq!(error.hint.as_deref(), hint, "{marked}");
        assert!(read_obj(text.as_bytes(), false, &Endless).is_ok(), "{marked}");
    }
    let missing = read_obj(format!("{SQUARE}f 1/1 2/2 3/3\n").as_bytes(), true, &Endless).unwrap_err();
    assert!(missing.message.ends_with("the mesh has 0"), "{}", missing.message);
    // One that no face uses may be anything.
    for unused in ["vt nan 0", "vt 0 inf", "vt 7 0"] {
        let text = format!("{SQUARE}{unused}\n{PLACES}f 1 2 3\nf 1/2 2/3 3/4\n");
        assert_eq!(read_obj(text.as_bytes(), true, &Endless).unwrap().warnings, [], "{unused}");
    }
}

#[test]
fn texture_coordinates_beyond_the_picture_have_a_warning() {
    let said = |places: &str| {
        let text = format!("{SQUARE}{places}f 1/1 2/2 3/3 4/4\n");
        let warnings = read_obj(text.as_bytes(), true, &Endless).unwrap().warnings;
        warnings.iter().map(Diagnostic::headline).collect::<Vec<_>>()
    };
    // Exporters round.
    assert_eq!(said("vt 0 0\nvt 1 0\nvt 1.0000002 1\nvt -1e-7 1\n"), [""; 0]);
    let outside = "warning: a texture coordinate is outside 0 to 1: there the picture's edge continues";
    assert_eq!(said("vt 0 0\nvt 1 -.25\nvt 1 1\nvt 0 1\n"), [format!("line 6, column 1: {outside}")]);
    assert_eq!(
        said("vt 0 0\nvt 2 0\nvt 2 2\nvt 0 2\n"),
        [format!("line 6, column 1: {outside} (and 2 more)")]
    );
}

#[test]
fn white_space_beyond_ascii_is_an_error_in_its_line() {
    let blanks = ["\u{a0}", "\u{2003}", "\u{202f}", "\u{3000}", "\u{200b}", "\u{feff}", "\u{85}", "\u{2028}"];
    for blank in blanks.map(str::as_bytes).into_iter().chain([&b"\xa0"[..]]) {
        for marked in [
            "v@0 0 0",
            "@v 0 0 0",
            "v 0@0 0",
            "v 0 0@0",
            "v 0 0 0@1 1 1 1",
            "f@1 2 3",
            "@f 1 2 3",
            "f 1 2@3 4",
            "fo@1 2 3",
            "vt 0@0 0",
        ] {
            let line: Vec<u8> = marked
                .bytes()
                .flat_map(|byte| if byte == b'@' { blank.to_vec() } else { vec![byte] })
                .collect();
            let text = [SQUARE.as_bytes(), &line, b"\nf 1 2 3\nf 1 2 5\n"].concat();
            let error = read_obj(&text, true, &Endless).unwrap_err();
            assert_eq!(error.position().unwrap().line, 5, "{marked} {blank:?}");
            let hint = error.hint.unwrap_or_default();
            assert!(hint.starts_with("it contains a blank that is not ASCII"), "{marked} {blank:?}: {hint}");
        }
    }
    // A comment, a name and a word that is no keyword may have them.
    let text = format!("{SQUARE}# a\u{a0}b\ng a\u{a0}b\nf 1 2 3 # f\u{a0}4\n");
    assert_eq!(read_obj(text.as_bytes(), true, &Endless).unwrap().warnings, []);
}

#[test]
fn vertices_that_no_face_uses_are_counted() {
    for extra in ["", "vn 0 0 1\n", "v 1 1 1 1\n"] {
        let text = format!("v 9 9 9\n{SQUARE}{extra}f 2 3 4\nv nan 0 0\n");
        let count = text.lines().filter(|line| line.starts_with("v ")).count();
        let file = read_obj(text.replace("nan", "5").as_bytes(), false, &Endless).unwrap();
        assert_eq!((file.vertices, file.mesh.vertices.len()), (count, 3));
        assert_eq!(read_obj(text.as_bytes(), false, &Endless).unwrap().vertices, count);
    }
}
