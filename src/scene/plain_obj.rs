//! The fast way through an OBJ text that holds nothing but positions and triangles.

use glam::DVec3;
use rayon::prelude::*;
use std::mem;

/// The mesh of a text of `v x y z` and `f i j k` lines, blank ones and comments; none as soon as
/// anything else turns up, which is then for the full reader to understand or to refuse.
///
/// Where it gives a mesh, it is the full reader's to the last bit, but for the order of the vertices: the
/// file's.
pub fn parse(text: &[u8]) -> Option<VerticesAndTriangles> {
    let pieces = chunks(text, chunk_size(text.len())).into_par_iter().map(scan).collect::<Option<_>>()?;
    let Piece { mut vertices, mut faces } = joined(pieces);
    keep_used(&mut vertices, &mut faces)?;
    (!faces.is_empty()).then_some((vertices, faces))
}

/// Positions, and triangles as indices into them.
pub type VerticesAndTriangles = (Vec<DVec3>, Vec<[u32; 3]>);

/// What a run of lines holds; corners count from 1.
struct Piece {
    vertices: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
}

/// How much of a text to scan in one go: all of it where nobody could scan the rest meanwhile, since
/// joining pieces takes time and memory; else enough that a piece's lists fill large pages.
fn chunk_size(length: usize) -> usize {
    let threads = rayon::current_num_threads();
    if threads == 1 { length } else { (length / (2 * threads)).clamp(1 << 18, 1 << 22) }
}

/// Cuts a text at line ends into pieces of about `size` bytes.
fn chunks(mut text: &[u8], size: usize) -> Vec<&[u8]> {
    let mut chunks = vec![];
    while text.len() > size {
        let rest = text[size..].iter().position(|&b| b == b'\n').map_or(text.len(), |end| size + end + 1);
        let (chunk, behind) = text.split_at(rest);
        chunks.push(chunk);
        text = behind;
    }
    chunks.push(text);
    chunks
}

fn scan(mut text: &[u8]) -> Option<Piece> {
    // About twice what a mesh of twice as many faces as vertices has: what stays empty costs nothing, and
    // long lists cost less than short ones.
    let mut piece =
        Piece { vertices: Vec::with_capacity(text.len() / 30), faces: Vec::with_capacity(text.len() / 15) };
    while let Some((&first, rest)) = text.split_first() {
        text = match first {
            b'v' => {
                let (x, rest) = number(rest)?;
                let (y, rest) = number(rest)?;
                let (z, rest) = number(rest)?;
                piece.vertices.push(DVec3::new(x, y, z));
                line_end(rest)?
            }
            b'f' => {
                let (a, rest) = corner(rest)?;
                let (b, rest) = corner(rest)?;
                let (c, rest) = corner(rest)?;
                piece.faces.push([a, b, c]);
                line_end(rest)?
            }
            b'#' => &rest[rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len())..],
            b'\n' | b'\r' => rest,
            _ => return None,
        };
    }
    Some(piece)
}

fn joined(mut pieces: Vec<Piece>) -> Piece {
    if pieces.len() == 1
        && let Some(piece) = pieces.pop()
    {
        return piece;
    }
    let mut all = Piece {
        vertices: Vec::with_capacity(pieces.iter().map(|piece| piece.vertices.len()).sum()),
        faces: Vec::with_capacity(pieces.iter().map(|piece| piece.faces.len()).sum()),
    };
    for piece in pieces {
        all.vertices.extend(piece.vertices);
        all.faces.extend(piece.faces);
    }
    all
}

/// The text behind at least one blank.
#[inline(always)]
fn after_blanks(text: &[u8]) -> Option<&[u8]> {
    let mut rest = text.strip_prefix(b" ")?;
    while let [b' ', behind @ ..] = rest {
        rest = behind;
    }
    Some(rest)
}

/// The text behind the end of its line, if nothing but blanks comes before that.
#[inline(always)]
fn line_end(text: &[u8]) -> Option<&[u8]> {
    let rest = after_blanks(text).unwrap_or(text);
    match rest.strip_prefix(b"\r").unwrap_or(rest) {
        [] => Some(b""),
        [b'\n', behind @ ..] => Some(behind),
        _ => None,
    }
}

/// A run of digits, behind those of `value`, as a number; its length, and the text behind.
#[inline(always)]
fn digits(text: &[u8], value: u64) -> (u64, usize, &[u8]) {
    if let Some(&eight) = text.first_chunk::<8>() {
        let (number, count) = leading_digits(u64::from_le_bytes(eight));
        if count < 8 {
            return (value.wrapping_mul(TEN_TO[count]).wrapping_add(number), count, &text[count..]);
        }
    }
    many_digits(text, value)
}

/// As [`digits`], also for many of them and at the end of the text.
#[inline(never)]
fn many_digits(mut text: &[u8], mut value: u64) -> (u64, usize, &[u8]) {
    let mut length = 0;
    // Eight at a time, since nothing tells the processor when to leave a loop over digits.
    while let Some(&eight) = text.first_chunk::<8>() {
        let (number, count) = leading_digits(u64::from_le_bytes(eight));
        value = value.wrapping_mul(TEN_TO[count]).wrapping_add(number);
        length += count;
        text = &text[count..];
        if count < 8 {
            return (value, length, text);
        }
    }
    while let [digit @ b'0'..=b'9', behind @ ..] = text {
        value = value.wrapping_mul(10).wrapping_add((digit - b'0').into());
        length += 1;
        text = behind;
    }
    (value, length, text)
}

/// The number that eight characters, the first in the lowest byte, begin with, and its length.
#[inline(always)]
fn leading_digits(characters: u64) -> (u64, usize) {
    const ONES: u64 = u64::MAX / 0xff;
    let values = characters ^ (ONES * b'0' as u64);
    // The high bit of each byte above 9; a carry reaches no byte before the first such one.
    let others = (values.wrapping_add(ONES * (0x7f - 9)) | values) & (ONES * 0x80);
    let count = others.trailing_zeros() / 8;
    // As if zeros stood before them. Then neighbours are joined to numbers of two digits, of four
    // and of eight.
    let digits = values.checked_shl(64 - 8 * count).unwrap_or(0);
    let pairs = (digits.wrapping_mul(10) + (digits >> 8)) & (u64::MAX / 0xffff * 0xff);
    let fours = (pairs.wrapping_mul(100) + (pairs >> 16)) & (u64::MAX / 0xffff_ffff * 0xffff);
    let eight = (fours.wrapping_mul(10_000) + (fours >> 32)) & 0xffff_ffff;
    (eight, count as usize)
}

const TEN_TO: [u64; 9] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];

/// A corner's number, which begins behind a blank.
#[inline(always)]
fn corner(text: &[u8]) -> Option<(u32, &[u8])> {
    let (value, length, rest) = digits(after_blanks(text)?, 0);
    (length > 0 && length < 10).then_some((value as u32, rest))
}

/// A decimal number, which begins behind a blank, rounded correctly.
#[inline(always)]
fn number(text: &[u8]) -> Option<(f64, &[u8])> {
    let text = after_blanks(text)?;
    let (sign, unsigned) = match text {
        [b'-', unsigned @ ..] => (-1.0, unsigned),
        _ => (1.0, text),
    };
    let (whole, before, rest) = match unsigned {
        // As most numbers begin.
        [digit @ b'0'..=b'9', b'.', ..] => (u64::from(digit - b'0'), 1, &unsigned[1..]),
        _ => digits(unsigned, 0),
    };
    let (value, after, rest) = match rest {
        [b'.', fraction @ ..] => digits(fraction, whole),
        _ => (whole, 0, rest),
    };
    let plain = matches!(rest.first(), None | Some(b' ' | b'\n' | b'\r'));
    // So many digits fit into the value, and so large a value is exact as a float.
    let exact = before + after <= 19 && value <= 1 << f64::MANTISSA_DIGITS;
    if !plain || before + after == 0 || !exact {
        return other_number(text);
    }
    // Both operands are exact, so that the quotient is the one rounding there is (Clinger, "How to
    // Read Floating Point Numbers Accurately", PLDI 1990).
    Some((sign * (value as f64 / POWERS_OF_TEN[after]), rest))
}

const POWERS_OF_TEN: [f64; 20] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19,
];

/// A number with an exponent or with many digits; words that are no numbers are not for us.
fn other_number(text: &[u8]) -> Option<(f64, &[u8])> {
    let length = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    let value: f64 = str::from_utf8(&text[..length]).ok()?.parse().ok()?;
    value.is_finite().then_some((value, &text[length..]))
}

/// Leaves out the vertices that no face names, and turns the faces' corners into indices of the others;
/// none if a corner names no vertex.
fn keep_used(vertices: &mut Vec<DVec3>, faces: &mut [[u32; 3]]) -> Option<()> {
    let mut used = vec![false; vertices.len()];
    for corner in faces.as_flattened_mut() {
        *corner = corner.checked_sub(1)?;
        *used.get_mut(*corner as usize)? = true;
    }
    if used.contains(&false) {
        let before = used.iter().scan(0, |count, &used| Some(mem::replace(count, *count + u32::from(used))));
        let places: Vec<u32> = before.collect();
        faces.as_flattened_mut().iter_mut().for_each(|corner| *corner = places[*corner as usize]);
        let mut used = used.into_iter();
        vertices.retain(|_| used.next().unwrap_or(false));
    }
    Some(())
}

#[cfg(test)]
mod tests;
