//! The header of a BMP file.

/// The length of the file's header and of the BITMAPINFOHEADER after it, in bytes.
pub(super) const BMP_HEADER: usize = 14 + INFO_HEADER;
const INFO_HEADER: usize = 40;

/// The length of a row in bytes: a pixel has three, and a row is filled up to a multiple of four.
pub(super) fn row_length(width: usize) -> usize {
    (width * 3).next_multiple_of(4)
}

/// The header of an uncompressed picture of 24 bits per pixel, whose rows follow from the bottom. None if its fields
/// cannot hold the size of the picture or of the file.
pub(super) fn header([width, height]: [usize; 2]) -> Option<Vec<u8>> {
    let rows = row_length(width).checked_mul(height)?;
    let file = u32::try_from(rows.checked_add(BMP_HEADER)?).ok()?;
    let [width, height] = [i32::try_from(width).ok()?, i32::try_from(height).ok()?];
    let mut header = b"BM".to_vec();
    header.extend(file.to_le_bytes());
    // Two reserved fields.
    header.extend([0; 4]);
    header.extend((BMP_HEADER as u32).to_le_bytes());
    header.extend((INFO_HEADER as u32).to_le_bytes());
    header.extend(width.to_le_bytes());
    header.extend(height.to_le_bytes());
    // One plane of 24 bits.
    header.extend([1, 0, 24, 0]);
    // No compression.
    header.extend([0; 4]);
    header.extend((rows as u32).to_le_bytes());
    // Neither a resolution nor a table of colours.
    header.extend([0; 16]);
    Some(header)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_has_the_sizes() {
        let header = header([3, 2]).unwrap();
        let field = |at: usize| u32::from_le_bytes(header[at..at + 4].try_into().unwrap());
        assert_eq!((header.len(), &header[..2]), (54, &b"BM"[..]));
        assert_eq!([2, 10, 14, 18, 22, 26, 30, 34].map(field), [54 + 24, 54, 40, 3, 2, 1 | 24 << 16, 0, 24]);
    }

    #[test]
    fn a_file_of_more_than_four_gigabytes_has_none() {
        assert_eq!([1, 2, 3, 4].map(row_length), [4, 8, 12, 12]);
        assert!(header([65535, 21845]).is_some() && header([65535, 21846]).is_none());
    }
}
