//! Recognizes other file formats given as OBJ, so that the error names the true reason.

use crate::diagnostic::Diagnostic;

const EXPORT: &str = "export the mesh as OBJ";

/// Formats, advice, and the bytes that such files begin with. Case is ignored.
const FORMATS: [(&str, &str, &[&[u8]]); 13] = [
    ("PLY", EXPORT, &[b"ply\n", b"ply\r"]),
    ("binary glTF", EXPORT, &[b"glTF"]),
    ("OFF", EXPORT, &[b"OFF", b"COFF", b"NOFF"]),
    ("FBX", EXPORT, &[b"Kaydara FBX Binary", b"; FBX"]),
    ("a Blender file", EXPORT, &[b"BLENDER"]),
    ("VRML", EXPORT, &[b"#VRML"]),
    ("X3D", EXPORT, &[b"#X3D"]),
    ("DirectX", EXPORT, &[b"xof "]),
    ("Draco", EXPORT, &[b"DRACO"]),
    ("USD", EXPORT, &[b"#USDA", b"PXR-USDC"]),
    (
        "compressed",
        "unpack it",
        &[b"PK\x03\x04", b"\x1f\x8b", b"BZh", b"\xfd7zXZ", b"\x28\xb5\x2f\xfd", b"7z\xbc\xaf"],
    ),
    // Executables of Unix and Windows, and Windows object files for three processors.
    (
        "a program or the output of a compiler",
        EXPORT,
        &[b"\x7fELF", b"MZ\x90", b"\x64\x86", b"\x4c\x01", b"\x64\xaa"],
    ),
    ("a pointer of Git LFS", "fetch it with `git lfs pull`", &[b"version https://git-lfs"]),
];

/// Returns the error for a file that is certainly not OBJ, judged by its first bytes.
pub fn foreign(bytes: &[u8]) -> Option<Diagnostic> {
    let starts_with =
        |start: &&[u8]| bytes.len() >= start.len() && bytes[..start.len()].eq_ignore_ascii_case(start);
    let length = bytes.get(2..).and_then(|rest| rest.first_chunk()).map(|&length| u32::from_le_bytes(length));
    let (format, hint) = match bytes.trim_ascii_start() {
        _ if is_wide_text(bytes) => ("UTF-16 or UTF-32 text", "save the file as UTF-8"),
        _ if is_binary_stl(bytes) => ("binary STL", EXPORT),
        _ if bytes.starts_with(b"solid") && bytes.windows(5).any(|word| word == b"facet") => ("STL", EXPORT),
        _ if bytes.starts_with(b"MM") && length == Some(bytes.len() as u32) => ("3DS", EXPORT),
        [b'<', b'!' | b'?' | b'a'..=b'z' | b'A'..=b'Z', ..] => {
            ("HTML or XML", "it may be a page that was downloaded in place of the mesh")
        }
        [b'{', ..] => ("JSON, as in glTF", EXPORT),
        _ => {
            let (format, hint, _) = FORMATS.iter().find(|(_, _, starts)| starts.iter().any(starts_with))?;
            (*format, *hint)
        }
    };
    Some(refused(format, hint))
}

/// Returns the error for a text without faces if it is probably not OBJ.
pub fn foreign_without_faces(bytes: &[u8]) -> Option<Diagnostic> {
    let mut lines = bytes.split(|byte| matches!(byte, b'\n' | b'\r'));
    if bytes.contains(&0) {
        return Some(refused("binary", EXPORT));
    }
    let is_library = lines.any(|line| line.trim_ascii_start().starts_with(b"newmtl"));
    is_library.then(|| refused("a material library", "name the `.obj` file that it belongs to"))
}

fn refused(format: &str, hint: &str) -> Diagnostic {
    Diagnostic::error(format!("the file is {format}, not OBJ")).with_hint(hint)
}

/// Returns true if a text has a UTF-16 or UTF-32 byte order mark, or zero bytes where those encodings have them in OBJ
/// keywords.
pub(crate) fn is_wide_text(bytes: &[u8]) -> bool {
    let is_text = |byte: &u8| matches!(byte, b'\t' | b'\n' | b'\r' | b' '..=b'~');
    let of_words = match bytes {
        [a, 0, 0, 0, ..] | [0, 0, 0, a, ..] => is_text(a),
        [a, 0, b, 0, ..] | [0, a, 0, b, ..] => is_text(a) && is_text(b),
        _ => false,
    };
    of_words
        || bytes.starts_with(b"\xff\xfe")
        || bytes.starts_with(b"\xfe\xff")
        || bytes.starts_with(b"\0\0\xfe\xff")
}

/// Returns true if the number of triangles after the 80-byte header matches the file's length.
fn is_binary_stl(bytes: &[u8]) -> bool {
    const HEADER: usize = 80;
    const TRIANGLE: u64 = 50;
    let count = bytes.get(HEADER..).and_then(|rest| rest.first_chunk());
    count.is_some_and(|&count| bytes.len() as u64 == 84 + TRIANGLE * u64::from(u32::from_le_bytes(count)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_known_by_how_they_begin() {
        let stl = [&[b's'; 80][..], &1_u32.to_le_bytes(), &[0; 50]].concat();
        for (bytes, expected) in [
            (&b"\xff\xfev\0 \0"[..], "UTF-16 or UTF-32 text"),
            (b"\xfe\xff\0v\0 ", "UTF-16 or UTF-32 text"),
            (b"v\0 \0x\0", "UTF-16 or UTF-32 text"),
            (b"\0#\0 ", "UTF-16 or UTF-32 text"),
            (&stl, "binary STL"),
            (b"solid cube\n facet normal 0 0 1\n", "STL"),
            (b"ply\r\nformat ascii 1.0\n", "PLY"),
            (b"glTF\x02\0\0\0", "binary glTF"),
            (b"\n { \"asset\": { } }", "JSON, as in glTF"),
            (b"OFF\n8 6 12\n", "OFF"),
            (b"MM\x0a\0\0\0\0\0\0\0", "3DS"),
            (b"<!DOCTYPE html>", "HTML or XML"),
            (b"\x1f\x8b\x08", "compressed"),
            (b"\x64\x86\x02\0", "a program or the output of a compiler"),
            (b"version https://git-lfs.github.com/spec/v1\n", "a pointer of Git LFS"),
        ] {
            let message = foreign(bytes).unwrap().message;
            assert_eq!(message, format!("the file is {expected}, not OBJ"), "{bytes:?}");
        }
        let message = |bytes: &[u8]| foreign_without_faces(bytes).unwrap().message;
        assert_eq!(message(b"# m\nnewmtl red\nKd 1 0 0\n"), "the file is a material library, not OBJ");
        assert_eq!(message(b"a\0b"), "the file is binary, not OBJ");
    }

    #[test]
    fn obj_is_no_other_format() {
        for text in [
            "",
            "v",
            "# c\nv 0 0 0",
            "o solid\n",
            "solid",
            "\n\nv 1 2 3",
            "mtllib ply\n",
            "MM",
            "g off\nf 1 2 3",
        ] {
            assert_eq!(
                (foreign(text.as_bytes()), foreign_without_faces(text.as_bytes())),
                (None, None),
                "{text}"
            );
        }
    }
}
