//! Picture files: their bytes, and the files on disk after writing them succeeds or fails.

use super::support::write_picture;
use raytracer::image_io::{OutputFile, read_picture};
use raytracer::picture::Picture;
use std::fs;
use std::path::Path;
use tempfile::{TempDir, tempdir};

/// A picture of 3 x 2 different pixels. The one at the bottom left is red.
fn sample() -> Picture {
    let mut picture = Picture::new(3, 2).unwrap();
    for j in 0..2 {
        for (i, pixel) in picture.row_mut(j).chunks_exact_mut(3).enumerate() {
            pixel.copy_from_slice(&[255 - 40 * (i as u8 + 3 * j as u8), i as u8, j as u8]);
        }
    }
    picture
}

fn names(folder: &TempDir) -> Vec<String> {
    let entries = fs::read_dir(folder.path()).unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn tga_has_the_course_s_header_and_blue_first_rows_from_the_top() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.tga");
    write_picture(&path, &sample()).unwrap();
    let bytes = fs::read(&path).unwrap();
    assert_eq!(bytes[..18], [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 2, 0, 24, 32]);
    let top = [1, 0, 135, 1, 1, 95, 1, 2, 55];
    let bottom = [0, 0, 255, 0, 1, 215, 0, 2, 175];
    assert_eq!(bytes[18..], [top, bottom].concat());
}

#[test]
fn bmp_is_24_bits_and_uncompressed_with_padded_blue_first_rows_from_the_bottom() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.bmp");
    write_picture(&path, &sample()).unwrap();
    let bytes = fs::read(&path).unwrap();
    let header =
        b"BM\x4e\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\x03\0\0\0\x02\0\0\0\x01\0\x18\0\0\0\0\0\x18\0\0\0";
    assert_eq!(bytes[..54], [&header[..], &[0; 16]].concat());
    let top = [1, 0, 135, 1, 1, 95, 1, 2, 55, 0, 0, 0];
    let bottom = [0, 0, 255, 0, 1, 215, 0, 2, 175, 0, 0, 0];
    assert_eq!(bytes[54..], [bottom, top].concat());
}

#[test]
fn ppm_is_three_lines_and_red_first_rows_from_the_top() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.ppm");
    write_picture(&path, &sample()).unwrap();
    let expected =
        [&b"P6\n3 2\n255\n"[..], &[135, 0, 1, 95, 1, 1, 55, 2, 1, 255, 0, 0, 215, 1, 0, 175, 2, 0]].concat();
    assert_eq!(fs::read(&path).unwrap(), expected);
}

#[test]
fn all_formats_of_bytes_come_back_as_written() {
    let folder = tempdir().unwrap();
    for name in ["a.tga", "a.png", "B.TGA", "b.Png", "a.bmp", "a.ppm"] {
        let path = folder.path().join(name);
        write_picture(&path, &sample()).unwrap();
        assert_eq!(read_picture(&path).unwrap(), sample(), "{name}");
    }
    assert_eq!(read_picture(&folder.path().join("a.png")).unwrap().get(0, 0), Some([255, 0, 0]));
    assert_eq!(fs::read(folder.path().join("a.png")).unwrap()[..4], *b"\x89PNG");
}

#[test]
fn a_failed_write_leaves_the_old_picture_and_no_other_file() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.tga");
    write_picture(&path, &sample()).unwrap();
    let wide = Picture::new(65536, 1).unwrap();
    let error = write_picture(&path, &wide).unwrap_err();
    let expected = format!("cannot write `{}`: 65536 x 1 is above 65535 pixels a side", path.display());
    assert_eq!(error.message, expected);
    assert_eq!(names(&folder), ["a.tga"]);
    assert_eq!(read_picture(&path).unwrap(), sample());
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().mode() & 0o7777
    }

    fn is_root() -> bool {
        fs::metadata("/proc/self").is_ok_and(|found| found.uid() == 0)
    }

    #[test]
    fn permissions_are_a_new_file_s_or_the_old_file_s() {
        let folder = tempdir().unwrap();
        let (path, plain) = (folder.path().join("a.tga"), folder.path().join("plain"));
        fs::write(&plain, "").unwrap();
        write_picture(&path, &sample()).unwrap();
        assert_eq!(mode(&path), mode(&plain));
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        write_picture(&path, &sample()).unwrap();
        assert_eq!(mode(&path), 0o640);
    }

    #[test]
    fn a_link_stays_a_link_and_its_target_gets_the_picture() {
        let folder = tempdir().unwrap();
        let other = tempdir().unwrap();
        let (link, target) = (folder.path().join("a.tga"), other.path().join("b"));
        symlink(&target, &link).unwrap();
        // The target does not exist the first time.
        for _ in 0..2 {
            write_picture(&link, &sample()).unwrap();
            assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
            assert_eq!(read_picture(&link).unwrap(), sample());
        }
        assert_eq!((names(&folder), names(&other)), (vec!["a.tga".into()], vec!["b".into()]));
    }

    #[test]
    fn write_protection_is_respected() {
        let folder = tempdir().unwrap();
        let path = folder.path().join("a.tga");
        write_picture(&path, &sample()).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
        // The superuser may write to any file.
        assert_eq!(OutputFile::prepare(&path).is_ok(), is_root());
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o555)).unwrap();
        assert_eq!(OutputFile::prepare(&folder.path().join("b.tga")).is_ok(), is_root());
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
    }
}
