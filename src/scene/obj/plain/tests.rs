//! Compares the fast parser with the full one.

use super::*;
use crate::base::patience::Endless;
use crate::scene::obj::read_any;

fn read(text: &str) -> Option<Mesh> {
    parse(text.as_bytes(), &Endless).map(|(mesh, _)| mesh)
}

fn parse_obj_fully(text: &[u8]) -> Result<Mesh, crate::diagnostic::Diagnostic> {
    read_any(text, false, &Endless).map(|file| file.mesh)
}

/// Asserts that two meshes have bitwise equal triangles and the same number of vertices.
fn assert_same(one: &Mesh, other: &Mesh, text: &str) {
    let bits = |m: &Mesh| {
        let corners = m.triangles.as_flattened().iter().map(|&corner| m.vertices[corner as usize]);
        corners.map(|v| v.to_array().map(f64::to_bits)).collect::<Vec<_>>()
    };
    assert_eq!((bits(one), one.vertices.len()), (bits(other), other.vertices.len()), "{text}");
}

#[test]
fn agrees_with_the_full_parser() {
    let texts = [
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned(),
        "# a comment\r\nv -0.1 .5 1.\r\nv 1e-3 2E5 -1.25e+2 \r\n\r\nv 0 1 0\r\nf 3 2 1\r\nf  1 2 3"
            .to_owned(),
        "v 0.1234567890123456789 12345678901234567890 0.000001\nv 1 -0 3\nv 3 4 5\nf 2 3 1".to_owned(),
        // Numbers around the largest exact value, and with the largest number of digits.
        "v 9007199254740992 9007199254740993 900719925474.0993\nv 0.1234567890123456 0.9007199254740993 -0\n\
         v 0.000000000000000001 0.0000000000000000001 12345678.12345678\nf 1 2 3"
            .to_owned(),
        "f 1 2 3\nv 1 2 3\nv 2 3 4\nv 9 9 9\nv 3 4 5\nf 4 2 1".to_owned(),
        // Some vertices are unused, between others and at both ends.
        "v 9 9 9\nv 1 2 3\nv 8 8 8\nv 2 3 4\nv 3 4 5\nv 7 7 7\nf 5 2 4".to_owned(),
        "v 1 0 0\nv 2 0 0\nv 3 0 0\nv 4 0 0\nv 5 0 0\nf 2 3 1\nf 5 5 2".to_owned(),
        // Lines that end with a carriage return, including a comment.
        "v 1 0 0\r# v 9 9 9\rv 2 0 0\nv 3 0 0 \r\nf 1 2 3\r\rf 3 2 1\r".to_owned(),
    ];
    for text in texts {
        let full = parse_obj_fully(text.as_bytes()).unwrap();
        assert_same(&read(&text).unwrap(), &full, &text);
    }
}

#[test]
fn rejects_what_only_the_full_parser_reads() {
    const GOOD: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    assert!(parse(GOOD.as_bytes(), &Endless).is_some());
    for line in [
        "vn 0 0 1",
        "vt 0 0",
        "o x",
        "g",
        "f 1/1 2/2 3/3",
        "f 1 2 -1",
        "f 1 2 3 1",
        "f 1 2",
        "f 1 2 4",
        "f 1 2 0",
        "f 1 2 99999999999",
        "v 1 2",
        "v 1 2 3 4",
        "v 1 2 x",
        "v 1 2 nan",
        "v 1 2 1e999",
        "v\t1 2 3",
        " v 1 2 3",
        "v 1 2 3 # c",
        "v - 2 3",
        "v . 2 3",
        "v 1..2 2 3",
        "v 1 2 3x",
    ] {
        assert!(parse(format!("{GOOD}{line}\n").as_bytes(), &Endless).is_none(), "{line}");
    }
    assert!([&b""[..], b"v 1 2 3\n"].iter().all(|text| parse(text, &Endless).is_none()));
}

#[test]
fn chunks_end_with_lines_and_are_no_longer_than_needed() {
    let text = b"v 1\nv 22\nv 333\nv 4";
    let cut = |size| chunks(text, size).into_iter().map(<[u8]>::len).collect::<Vec<_>>();
    assert_eq!((cut(3), cut(4), cut(9)), (vec![4, 5, 6, 3], vec![9, 6, 3], vec![15, 3]));
    assert_eq!((cut(18), cut(99)), (vec![18], vec![18]));
}

#[test]
fn the_size_of_chunks_is_proportional_to_the_text_within_bounds() {
    let size = |threads, length| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| chunk_size(length))
    };
    assert_eq!(size(1, 1 << 30), 1 << 30);
    assert_eq!(size(4, 1 << 23), 1 << 20);
    assert_eq!((size(4, 1000), size(4, 1 << 30)), (1 << 18, 1 << 22));
}

#[test]
fn a_text_of_many_chunks_is_read_whole() {
    let mut text: String = (0..40_000).map(|i| format!("v {i} 0.5 -{i}\n")).collect();
    text.extend((1..39_999).map(|i| format!("f {i} {} {}\n", i + 1, i + 2)));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let mesh = pool.install(|| read(&text)).unwrap();
    assert!(text.len() > 4 << 18 && mesh.vertices.len() == 40_000);
    assert!(mesh.triangles.iter().enumerate().all(|(i, t)| *t == [0, 1, 2].map(|k| i as u32 + k)));
    assert!(mesh.vertices.iter().enumerate().all(|(i, v)| v.x == i as f64 && v.z == -v.x));
}

#[test]
fn corners_and_numbers_beyond_their_words_are_not_cut() {
    assert_eq!(corner(b" 123456789\n"), Some((123_456_789, &b"\n"[..])));
    for text in [&b" 4294967297\n"[..], b" \n", b" x", b" 18446744073709551617\n"] {
        assert_eq!(corner(text), None);
    }
    for (text, value) in [
        (&b" 18446744073709551617 "[..], 18446744073709552000.0),
        (b" 18446744073709551617.0 ", 18446744073709552000.0),
        (b" 0.00018446744073709551617 ", "0.00018446744073709551617".parse().unwrap()),
        (b" 9007199254740993 ", 9007199254740992.0),
    ] {
        assert_eq!(number(text), Some((value, &b" "[..])));
    }
}
