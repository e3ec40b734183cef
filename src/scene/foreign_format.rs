//! Recognizes files of other formats that are given as OBJ, so that the error names the true reason.

use std::fmt;

/// A format that is not OBJ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForeignFormat {
    /// Text in UTF-16 or UTF-32.
    WideText,
    /// Any other file that is no text.
    Binary,
    /// A compressed file.
    Compressed,
    /// The program's output of a compiler, whose files are called `.obj` too.
    ObjectCode,
    /// What stands for a large file where Git LFS did not fetch it.
    LfsPointer,
    /// A page of the web, or another file in XML.
    Markup,
    /// A material library, which belongs to an OBJ file.
    Materials,
    /// A 3D model in another format.
    Model(&'static str),
}

/// How files of a 3D model begin.
const MODELS: [(&[u8], &str); 15] = [
    (b"ply\n", "PLY"),
    (b"ply\r", "PLY"),
    (b"glTF", "binary glTF"),
    (b"OFF", "OFF"),
    (b"COFF", "OFF"),
    (b"NOFF", "OFF"),
    (b"Kaydara FBX Binary", "FBX"),
    (b"; FBX", "FBX"),
    (b"BLENDER", "a Blender file"),
    (b"#VRML", "VRML"),
    (b"#X3D", "X3D"),
    (b"xof ", "DirectX"),
    (b"DRACO", "Draco"),
    (b"#USDA", "USD"),
    (b"PXR-USDC", "USD"),
];

impl ForeignFormat {
    /// The format of a file that is certainly not OBJ, by how it begins.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let starts_with =
            |start: &[u8]| bytes.len() >= start.len() && bytes[..start.len()].eq_ignore_ascii_case(start);
        let text = bytes.trim_ascii_start();
        if is_wide_text(bytes) {
            return Some(Self::WideText);
        }
        if is_binary_stl(bytes) {
            return Some(Self::Model("binary STL"));
        }
        if bytes.starts_with(b"solid") && contains(bytes, b"facet") {
            return Some(Self::Model("STL"));
        }
        if let Some((_, name)) = MODELS.iter().find(|(start, _)| starts_with(start)) {
            return Some(Self::Model(name));
        }
        if bytes.starts_with(b"MM") && has_length(bytes, 2, 0) {
            return Some(Self::Model("3DS"));
        }
        match text {
            [b'<', b'!' | b'?' | b'a'..=b'z' | b'A'..=b'Z', ..] => return Some(Self::Markup),
            [b'{', ..] => return Some(Self::Model("JSON, as in glTF")),
            _ => {}
        }
        const COMPRESSED: [&[u8]; 6] =
            [b"PK\x03\x04", b"\x1f\x8b", b"BZh", b"\xfd7zXZ", b"\x28\xb5\x2f\xfd", b"7z\xbc\xaf"];
        // Executables of Unix and Windows, and object files of Windows for three kinds of processor.
        const CODE: [&[u8]; 5] = [b"\x7fELF", b"MZ\x90", b"\x64\x86", b"\x4c\x01", b"\x64\xaa"];
        if COMPRESSED.iter().any(|start| bytes.starts_with(start)) {
            Some(Self::Compressed)
        } else if CODE.iter().any(|start| bytes.starts_with(start)) {
            Some(Self::ObjectCode)
        } else if bytes.starts_with(b"version https://git-lfs") {
            Some(Self::LfsPointer)
        } else {
            None
        }
    }

    /// What a text without faces probably is, if it is not OBJ.
    pub fn of_no_mesh(bytes: &[u8]) -> Option<Self> {
        if bytes.contains(&0) {
            return Some(Self::Binary);
        }
        let mut lines = bytes.split(|byte| matches!(byte, b'\n' | b'\r'));
        lines.any(|line| line.trim_ascii_start().starts_with(b"newmtl")).then_some(Self::Materials)
    }

    /// Advice in one line.
    pub fn hint(self) -> &'static str {
        match self {
            Self::WideText => "save the file as UTF-8",
            Self::Compressed => "unpack it",
            Self::LfsPointer => "fetch it with `git lfs pull`",
            Self::Markup => "it may be a page that was downloaded in place of the mesh",
            Self::Materials => "name the `.obj` file that it belongs to",
            Self::Binary | Self::ObjectCode | Self::Model(_) => "export the mesh as OBJ",
        }
    }
}

impl fmt::Display for ForeignFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::WideText => write!(f, "UTF-16 or UTF-32 text"),
            Self::Binary => write!(f, "binary"),
            Self::Compressed => write!(f, "compressed"),
            Self::ObjectCode => write!(f, "a program or the output of a compiler"),
            Self::LfsPointer => write!(f, "a pointer of Git LFS"),
            Self::Markup => write!(f, "HTML or XML"),
            Self::Materials => write!(f, "a material library"),
            Self::Model(name) => write!(f, "{name}"),
        }
    }
}

/// Whether a text has a byte order mark of UTF-16 or UTF-32, or zero bytes where these have them in the words of OBJ.
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

/// Whether the number of triangles, after a header of 80 bytes, is right for the file's length.
fn is_binary_stl(bytes: &[u8]) -> bool {
    const HEADER: usize = 80;
    const TRIANGLE: u64 = 50;
    let count = bytes.get(HEADER..).and_then(|rest| rest.first_chunk());
    count.is_some_and(|&count| bytes.len() as u64 == 84 + TRIANGLE * u64::from(u32::from_le_bytes(count)))
}

/// Whether the file's length stands at `offset`, after which it is `less` than the whole.
fn has_length(bytes: &[u8], offset: usize, less: usize) -> bool {
    let length = bytes.get(offset..).and_then(|rest| rest.first_chunk());
    length.is_some_and(|&length| u32::from_le_bytes(length) as usize + less == bytes.len())
}

fn contains(bytes: &[u8], word: &[u8]) -> bool {
    bytes.windows(word.len()).any(|window| window == word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_known_by_how_they_begin() {
        let stl = [&[b's'; 80][..], &1_u32.to_le_bytes(), &[0; 50]].concat();
        for (bytes, expected) in [
            (&b"\xff\xfev\0 \0"[..], ForeignFormat::WideText),
            (b"\xfe\xff\0v\0 ", ForeignFormat::WideText),
            (b"v\0 \0x\0", ForeignFormat::WideText),
            (b"\0#\0 ", ForeignFormat::WideText),
            (&stl, ForeignFormat::Model("binary STL")),
            (b"solid cube\n facet normal 0 0 1\n", ForeignFormat::Model("STL")),
            (b"ply\r\nformat ascii 1.0\n", ForeignFormat::Model("PLY")),
            (b"glTF\x02\0\0\0", ForeignFormat::Model("binary glTF")),
            (b"\n { \"asset\": { } }", ForeignFormat::Model("JSON, as in glTF")),
            (b"OFF\n8 6 12\n", ForeignFormat::Model("OFF")),
            (b"MM\x0a\0\0\0\0\0\0\0", ForeignFormat::Model("3DS")),
            (b"<!DOCTYPE html>", ForeignFormat::Markup),
            (b"\x1f\x8b\x08", ForeignFormat::Compressed),
            (b"\x64\x86\x02\0", ForeignFormat::ObjectCode),
            (b"version https://git-lfs.github.com/spec/v1\n", ForeignFormat::LfsPointer),
        ] {
            assert_eq!(ForeignFormat::of(bytes), Some(expected), "{bytes:?}");
        }
        assert_eq!(ForeignFormat::of_no_mesh(b"# m\nnewmtl red\nKd 1 0 0\n"), Some(ForeignFormat::Materials));
        assert_eq!(ForeignFormat::of_no_mesh(b"a\0b"), Some(ForeignFormat::Binary));
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
                (ForeignFormat::of(text.as_bytes()), ForeignFormat::of_no_mesh(text.as_bytes())),
                (None, None),
                "{text}"
            );
        }
    }
}
