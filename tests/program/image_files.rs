//! The bytes of picture files, and the files on disk after a picture is written.

use crate::support::{Folder, write_picture};
use raytracer::diagnostic::Diagnostic;
use raytracer::image_io::{Content, Format, OutputFile, read_picture};
use raytracer::picture::Picture;

/// Returns a picture of 3 x 2 different pixels. The one at the bottom left is red.
fn sample() -> Picture {
    let mut picture = Picture::new(3, 2).unwrap();
    for j in 0..2 {
        for (i, pixel) in picture.row_mut(j).chunks_exact_mut(3).enumerate() {
            pixel.copy_from_slice(&[255 - 40 * (i as u8 + 3 * j as u8), i as u8, j as u8]);
        }
    }
    picture
}

fn write(folder: &Folder, name: &str) -> Result<(), Diagnostic> {
    write_picture(&folder.path().join(name), &sample())
}

#[test]
fn tga_has_the_course_s_header_and_blue_first_rows_from_the_top() {
    let folder = Folder::new();
    write(&folder, "a.tga").unwrap();
    let top = [1, 0, 135, 1, 1, 95, 1, 2, 55];
    let bottom = [0, 0, 255, 0, 1, 215, 0, 2, 175];
    let header = [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 2, 0, 24, 32];
    assert_eq!(folder.read("a.tga"), [&header[..], &top, &bottom].concat());
}

#[test]
fn bmp_is_24_bits_and_uncompressed_with_padded_blue_first_rows_from_the_bottom() {
    let folder = Folder::new();
    write(&folder, "a.bmp").unwrap();
    let header =
        b"BM\x4e\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x03\0\0\0\x02\0\0\0\x01\0\x18\0\0\0\0\0\x18\0\0\0";
    let top = [1, 0, 135, 1, 1, 95, 1, 2, 55, 0, 0, 0];
    let bottom = [0, 0, 255, 0, 1, 215, 0, 2, 175, 0, 0, 0];
    assert_eq!(folder.read("a.bmp"), [&header[..], &[0; 16], &bottom, &top].concat());
}

#[test]
fn capitals_of_an_ending_do_not_matter() {
    let folder = Folder::new();
    write(&folder, "B.Png").unwrap();
    assert_eq!(read_picture(&folder.path().join("B.Png")).unwrap(), sample());
    assert_eq!(folder.read("B.Png")[..4], *b"\x89PNG");
}

#[test]
fn a_failed_write_leaves_the_old_picture_and_no_other_file() {
    let folder = Folder::new();
    write(&folder, "a.tga").unwrap();
    for format in [Format::Tga, Format::Pfm, Format::Exr] {
        let file = OutputFile::prepare(&folder.path().join("a.tga")).unwrap();
        let begun = file.begin(format, [65536, 1], Content::Colors, None);
        let message = begun.map(drop).unwrap_err().to_string();
        assert!(message.ends_with("65536 x 1 is above 65535 pixels a side"), "{message}");
    }
    assert_eq!(folder.names(), ["a.tga"]);
    assert_eq!(read_picture(&folder.path().join("a.tga")).unwrap(), sample());
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::fs;
    use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};

    #[test]
    fn permissions_are_a_new_file_s_or_the_old_file_s() {
        let folder = Folder::new();
        let mode = |name: &str| fs::metadata(folder.path().join(name)).unwrap().mode() & 0o7777;
        folder.write("plain", "");
        write(&folder, "a.tga").unwrap();
        assert_eq!(mode("a.tga"), mode("plain"));
        fs::set_permissions(folder.path().join("a.tga"), fs::Permissions::from_mode(0o640)).unwrap();
        write(&folder, "a.tga").unwrap();
        assert_eq!(mode("a.tga"), 0o640);
    }

    #[test]
    fn a_link_stays_a_link_and_its_target_gets_the_picture() {
        let (folder, other) = (Folder::new(), Folder::new());
        symlink(other.path().join("b"), folder.path().join("a.tga")).unwrap();
        // The target does not exist the first time.
        for _ in 0..2 {
            write(&folder, "a.tga").unwrap();
            assert!(fs::symlink_metadata(folder.path().join("a.tga")).unwrap().is_symlink());
            assert_eq!(read_picture(&folder.path().join("a.tga")).unwrap(), sample());
        }
        assert_eq!((folder.names(), other.names()), (vec!["a.tga".into()], vec!["b".into()]));
    }

    #[test]
    fn write_protection_is_respected() {
        let folder = Folder::new();
        write(&folder, "a.tga").unwrap();
        let protect = |path: &str, mode: u32| {
            fs::set_permissions(folder.path().join(path), fs::Permissions::from_mode(mode)).unwrap();
        };
        // The superuser may write to any file.
        let is_root = fs::metadata("/proc/self").is_ok_and(|found| found.uid() == 0);
        protect("a.tga", 0o444);
        assert_eq!(write(&folder, "a.tga").is_ok(), is_root);
        protect("", 0o555);
        assert_eq!(write(&folder, "b.tga").is_ok(), is_root);
        protect("", 0o755);
    }
}
