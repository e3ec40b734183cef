//! Every variant of the formats, and invalid files.

use super::test_files::*;
use super::*;
use crate::image_io::{Content, OutputFile, Rows};
use crate::picture::Color;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use std::fs;

/// Files with and without run-length encoding, with the first pixel in each of the four corners.
fn variants(image_type: u8, bits: u8, alpha_bits: u8) -> impl Iterator<Item = Tga> {
    [image_type, image_type + 8].into_iter().flat_map(move |image_type| {
        [0, 0x10, 0x20, 0x30].map(|corner| Tga {
            image_type,
            bits,
            descriptor: corner | alpha_bits,
            map: (0, 0, 0),
        })
    })
}

fn assert_tga(tga: Tga, file: &[u8], expected: &[Rgb; 6]) {
    let read = Folder::new().read("a.tga", file).unwrap();
    let Tga { image_type, bits, descriptor, map } = tga;
    assert_eq!(read, picture(expected), "type {image_type}, {bits} bits, {descriptor:#x}, map {map:?}");
}

#[test]
fn true_colour_tga_of_every_size_encoding_and_corner() {
    type Encode = fn(Rgb) -> Vec<u8>;
    let rows: [(u8, u8, Encode); 9] = [
        (15, 0, packed),
        (16, 0, packed),
        (16, 1, packed),
        (24, 0, bgr),
        // Some programs store a number of alpha bits that does not match the size of a pixel.
        (24, 8, bgr),
        (16, 8, packed),
        (32, 0, bgra),
        (32, 8, bgra),
        (32, 1, bgra),
    ];
    for (bits, alpha_bits, encode) in rows {
        for tga in variants(2, bits, alpha_bits) {
            assert_tga(tga, &tga.file(&[], &COLORS.map(encode)), &COLORS);
        }
    }
}

#[test]
fn grey_tga_with_and_without_alpha() {
    for (bits, alpha_bits) in [(8, 0), (8, 8), (16, 8), (16, 0)] {
        for tga in variants(3, bits, alpha_bits) {
            let pixels = GREYS.map(|level| [level, 17][..usize::from(bits) / 8].to_vec());
            assert_tga(tga, &tga.file(&[], &pixels), &GREYS.map(|level| [level; 3]));
        }
    }
}

#[test]
fn colour_mapped_tga_with_entries_of_every_size_and_a_first_index() {
    type Encode = fn(Rgb) -> Vec<u8>;
    let entries: [(u8, Encode); 4] = [(15, packed), (16, packed), (24, bgr), (32, bgra)];
    for (first, index_bits, (map_bits, encode)) in [0, 5]
        .into_iter()
        .flat_map(|first| entries.map(|entry| [(first, 8, entry), (first, 16, entry)]))
        .flatten()
    {
        if index_bits > map_bits {
            continue;
        }
        for tga in variants(1, index_bits, 0) {
            let tga = Tga { map: (first, map_bits, 6), ..tga };
            let indices = [0, 1, 2, 3, 4, 5]
                .map(|i: u16| (first + i).to_le_bytes()[..usize::from(index_bits) / 8].to_vec());
            assert_tga(tga, &tga.file(&COLORS.map(encode).concat(), &indices), &COLORS);
        }
    }
}

#[test]
fn five_bits_are_scaled_and_rounded() {
    for value in 0..32_u16 {
        let tga = Tga { image_type: 2, bits: 16, descriptor: 0, map: (0, 0, 0) };
        let file = [tga.header(1, 1), (value * 0x421).to_le_bytes().to_vec()].concat();
        let level = (f64::from(value) * 255.0 / 31.0).round() as u8;
        assert_eq!(Folder::new().read("a.tga", &file).unwrap().pixels(), [level; 3]);
    }
}

#[test]
fn a_packet_of_different_pixels_crosses_into_the_next_row() {
    let tga = Tga { image_type: 10, bits: 24, descriptor: 0x20, map: (0, 0, 0) };
    let file = [tga.header(WIDTH, HEIGHT), vec![5], COLORS.map(bgr).concat()].concat();
    assert_tga(tga, &file, &COLORS);
}

#[test]
fn png_of_every_colour_type_and_depth() {
    let palette: Chunk = (b"PLTE", &[1, 2, 3, 40, 50, 60]);
    let transparent: Chunk = (b"tRNS", &[0, 128]);
    // 7 * 256 + 255 is nearer to level 8 than to 7, and 0xC880 of 0xFFFF is 199.72 of 255.
    type Row<'a> = (u8, u8, &'a [Chunk], &'a [u8], [Rgb; 2]);
    let rows: [Row; 13] = [
        (1, 0, &[], &[0b0100_0000], [[0; 3], [255; 3]]),
        (4, 0, &[], &[0x3F], [[51; 3], [255; 3]]),
        (8, 0, &[], &[7, 200], [[7; 3], [200; 3]]),
        (16, 0, &[], &[7, 255, 200, 128], [[8; 3], [200; 3]]),
        (8, 4, &[], &[7, 0, 200, 128], [[7; 3], [200; 3]]),
        (16, 4, &[], &[7, 255, 0, 0, 200, 128, 1, 1], [[8; 3], [200; 3]]),
        (8, 2, &[], &[1, 2, 3, 4, 5, 6], [[1, 2, 3], [4, 5, 6]]),
        (16, 2, &[], &[1, 255, 2, 255, 3, 255, 4, 0, 5, 0, 6, 0], [[2, 3, 4], [4, 5, 6]]),
        (8, 6, &[], &[1, 2, 3, 0, 4, 5, 6, 128], [[1, 2, 3], [4, 5, 6]]),
        (16, 6, &[], &[1, 255, 2, 255, 3, 255, 0, 0, 4, 0, 5, 0, 6, 0, 9, 9], [[2, 3, 4], [4, 5, 6]]),
        (1, 3, &[palette], &[0b0100_0000], [[1, 2, 3], [40, 50, 60]]),
        (8, 3, &[palette], &[1, 0], [[40, 50, 60], [1, 2, 3]]),
        (8, 3, &[palette, transparent], &[1, 0], [[40, 50, 60], [1, 2, 3]]),
    ];
    for (bits, color_type, chunks, row, expected) in rows {
        let read = Folder::new().read("a.png", &png([2, 1], bits, color_type, chunks, &[row])).unwrap();
        assert_eq!(read.pixels(), expected.as_flattened(), "{bits} bits, type {color_type}");
    }
}

#[test]
fn bmp_from_the_bottom_and_the_top_with_a_map_and_in_runs() {
    let folder = Folder::new();
    for is_from_top in [false, true] {
        assert_eq!(folder.read("a.bmp", &bmp(is_from_top)).unwrap(), picture(&COLORS), "{is_from_top}");
    }
    let map: Vec<u8> = COLORS.iter().flat_map(|&color| [bgr(color), vec![0]].concat()).collect();
    let rows = [3, 4, 5, 0, 0, 1, 2, 0];
    let mapped = bmp_file([3, 2], 8, 0, &map, &rows);
    assert_eq!(folder.read("a.bmp", &mapped).unwrap(), picture(&COLORS));
    // A run of three, the end of the row, three pixels as they are, and the end of the picture.
    let runs = bmp_file([3, 2], 8, 1, &map, &[3, 4, 0, 0, 0, 3, 0, 1, 2, 0, 0, 1]);
    let [red, green, blue] = [COLORS[0], COLORS[1], COLORS[2]];
    assert_eq!(
        folder.read("a.bmp", &runs).unwrap(),
        picture(&[red, green, blue, COLORS[4], COLORS[4], COLORS[4]])
    );
}

#[test]
fn sizes_that_do_not_fit_the_file_are_rejected_before_memory_is_allocated() {
    let folder = Folder::new();
    let expected = |name: &str| format!("cannot read `F/{name}`: it is too short for 65535 x 65535 pixels");
    for image_type in [2, 10] {
        let tga = Tga { image_type, bits: 32, descriptor: 8, map: (0, 0, 0) };
        assert_eq!(folder.complaint("a.tga", &tga.header(u16::MAX, u16::MAX)), expected("a.tga"));
    }
    let file = png([65535, 65535], 8, 2, &[], &[&[0; 100]]);
    assert_eq!(folder.complaint("a.png", &file), expected("a.png"));
    assert_eq!(folder.complaint("a.bmp", &bmp_file([65535; 2], 24, 0, &[], &[0; 99])), expected("a.bmp"));
    assert_eq!(folder.complaint("a.ppm", b"P6 65535 65535 255\n abc"), expected("a.ppm"));
    let wide = folder.complaint("a.png", &png([i32::MAX as u32, 1], 16, 6, &[], &[]));
    assert!(wide.ends_with("it is too short for 2147483647 x 1 pixels"), "{wide}");
    let padded = [png([1 << 30, 1], 1, 0, &[], &[]), vec![0; 1 << 18]].concat();
    assert!(folder.complaint("a.png", &padded).contains("above the limit"));
    let padded = [png([100_000_000, 1], 8, 2, &[], &[]), vec![0; 1 << 18]].concat();
    assert!(folder.complaint("a.png", &padded).contains("a row of its pixels or its metadata take more"));
}

#[test]
fn a_flat_picture_is_read_however_small_its_file_is() {
    let folder = Folder::new();
    let tga = Tga { image_type: 11, bits: 8, descriptor: 0, map: (0, 0, 0) };
    let file = [tga.header(512, 3), [255, 9].repeat(512 * 3 / 128)].concat();
    assert_eq!(folder.read("a.tga", &file).unwrap().pixels(), [9; 512 * 3 * 3]);
    let mut file = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut file, CompressionType::Best, FilterType::Up);
    encoder.write_image(&[9; 2000 * 2000], 2000, 2000, ExtendedColorType::L8).unwrap();
    assert!(file.len() * 400 < 2000 * 2000);
    assert!(folder.read("a.png", &file).unwrap().pixels().iter().all(|&level| level == 9));
}

#[test]
fn a_picture_that_takes_more_than_the_limit_is_an_error() {
    let tga = Tga { image_type: 10, bits: 32, descriptor: 8, map: (0, 0, 0) };
    let file = [tga.header(11_600, 11_600), vec![0; 11_600 * 11_600 / 128 * 5 + 5]].concat();
    let expected =
        "cannot read `F/a.tga`: its 11600 x 11600 pixels take 538.2 MB, above the limit of 536.9 MB";
    assert_eq!(Folder::new().complaint("a.tga", &file), expected);
}

#[test]
fn files_that_end_early_are_errors_wherever_they_end() {
    let folder = Folder::new();
    let tga = |image_type, bits, map| Tga { image_type, bits, descriptor: 0, map };
    let mapped = tga(1, 8, (0, 24, 6));
    let files = [
        ("raw.tga", tga(2, 24, (0, 0, 0)).file(&[], &COLORS.map(bgr))),
        ("packets.tga", tga(10, 24, (0, 0, 0)).file(&[], &COLORS.map(bgr))),
        ("a.bmp", bmp(false)),
        ("a.ppm", [b"P6 3 2 255\n", COLORS.concat().as_slice()].concat()),
        ("mapped.tga", mapped.file(&COLORS.map(bgr).concat(), &[0, 1, 2, 3, 4, 5].map(|i| vec![i]))),
        // The picture is complete without the checksum at the end of its data.
        ("a.png", png([2, 1], 8, 2, &[], &[&[1, 2, 3, 4, 5, 6]])),
    ];
    for (name, file) in &files {
        assert!(folder.read(name, file).is_ok(), "{name}");
        let picture_end = if name.ends_with("png") { file.len() - 24 } else { file.len() };
        for end in 0..picture_end {
            let complaint = folder.complaint(name, &file[..end]);
            assert!(complaint.starts_with(&format!("cannot read `F/{name}`: ")), "{complaint}");
        }
    }
    let complaint = folder.complaint("raw.tga", &files[0].1[..17]);
    assert_eq!(complaint, "cannot read `F/raw.tga`: it ends within its header");
    let complaint = folder.complaint("raw.tga", &files[0].1[..38]);
    assert_eq!(complaint, "cannot read `F/raw.tga`: it is too short for 3 x 2 pixels");
}

/// A file of OpenEXR with runs in place of its last row.
fn exr(folder: &Folder) -> Vec<u8> {
    let path = folder.0.path().join("whole.exr");
    let file = OutputFile::prepare(&path).unwrap();
    let mut writer = file.begin(Format::Exr, [3, 2], Content::Colors, None).unwrap();
    [0.5, 0.5].iter().for_each(|&level| writer.row(&[Color::splat(level); 3]).unwrap());
    writer.complete().unwrap().put_in_place().unwrap();
    let mut bytes = fs::read(path).unwrap();
    let compression = bytes.windows(16).position(|part| part == b"compression\0\x01\0\0\0").map(|at| at + 16);
    compression.into_iter().for_each(|at| bytes[at] = 1);
    let row = bytes.len() - 36;
    bytes.truncate(row);
    bytes[row - 4] = 4;
    bytes.extend([17, 9, 17, 8]);
    bytes
}

#[test]
fn a_damaged_byte_leads_to_a_picture_or_an_error() {
    let folder = Folder::new();
    let mapped = Tga { image_type: 9, bits: 8, descriptor: 0x10, map: (2, 16, 6) };
    let packets = Tga { image_type: 10, bits: 32, descriptor: 8, map: (0, 0, 0) };
    let files = [
        ("a.tga", mapped.file(&COLORS.map(packed).concat(), &[2, 3, 4, 5, 6, 7].map(|i| vec![i]))),
        ("b.tga", packets.file(&[], &COLORS.map(bgra))),
        ("d.bmp", bmp(true)),
        ("e.ppm", [b"P6 3 2 255\n", COLORS.concat().as_slice()].concat()),
        ("c.png", png([2, 1], 8, 3, &[(b"PLTE", &[1, 2, 3, 40, 50, 60])], &[&[1, 0]])),
        ("f.ppm", b"P3 # plain\n3 1 255\n1 2 3\n4 5 6 7 8 9\n".to_vec()),
        ("g.pbm", b"P4\r\n9 2\r\n\x55\x80\xaa\0".to_vec()),
        (
            "h.pam",
            b"P7\nWIDTH 2\nHEIGHT 1\nDEPTH 4\nMAXVAL 999\nENDHDR\n\0\x09\x01\x02\0\0\0\0\0\0\0\0\0\0\0\x07"
                .to_vec(),
        ),
        ("i.pfm", [b"PF\n1 2\n-1\n".as_slice(), &[0x3e; 24]].concat()),
        ("j.exr", exr(&folder)),
    ];
    for (name, file) in files {
        assert!(folder.read(name, &file).is_ok(), "{name}");
        for (at, change) in
            (0..file.len()).flat_map(|at| [1, 2, 0x10, 0x20, 0x80, 0xFF].map(|change| (at, change)))
        {
            let mut damaged = file.clone();
            damaged[at] ^= change;
            if let Err(error) = folder.read(name, &damaged) {
                let message = error.in_one_line();
                assert_eq!(message.lines().count(), 1, "{error}");
            }
        }
    }
}

#[test]
fn an_index_outside_the_colour_map_is_an_error() {
    let folder = Folder::new();
    for index in [1, 8] {
        let tga = Tga { image_type: 1, bits: 8, descriptor: 0, map: (2, 24, 6) };
        let file = tga.file(&COLORS.map(bgr).concat(), &[2, 3, index, 5, 6, 7].map(|i| vec![i]));
        assert!(folder.complaint("a.tga", &file).contains("its decoder says"));
    }
}

#[test]
fn a_file_that_its_decoder_refuses_is_an_error_with_its_reason() {
    let folder = Folder::new();
    let mut png = png([2, 1], 8, 2, &[], &[&[1, 2, 3, 4, 5, 6]]);
    png[60] = 99;
    let mut bmp = bmp(false);
    bmp[30] = 4;
    let tga =
        Tga { image_type: 2, bits: 8, descriptor: 0, map: (0, 0, 0) }.file(&[], &[0; 6].map(|_| vec![0]));
    for (name, file, reason) in
        [("a.png", &png, "CRC error"), ("a.bmp", &bmp, "compression"), ("a.tga", &tga, "")]
    {
        let complaint = folder.complaint(name, file);
        let start =
            format!("cannot read `F/{name}`: it is damaged, or of a rare variant: its decoder says `");
        assert!(complaint.starts_with(&start) && complaint.contains(reason), "{complaint}");
    }
    // The row by row reader says the same.
    folder.complaint("a.png", &png);
    let mut rows = Rows::open(&folder.0.path().join("a.png")).unwrap();
    let error = rows.next(&mut vec![]).unwrap_err();
    assert!(error.message.contains("CRC error"), "{error}");
}
