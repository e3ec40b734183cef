//! A fast parser for OBJ texts that contain only positions and triangles, which scans parts of the text in
//! parallel.

use super::mesh::Mesh;
use glam::DVec3;
use rayon::prelude::*;

/// Parses a text that consists of `v x y z` and `f i j k` lines, blank lines and comments. None if it
/// contains anything else, so that the full parser has to accept or reject it.
///
/// The result is identical to that of the full parser, except that the vertices are in the order of the file. With it comes
/// the number of `v` lines.
pub fn parse(text: &[u8]) -> Option<(Mesh, usize)> {
    let chunks = chunks(text, chunk_size(text.len()));
    let parts = chunks.into_par_iter().map(scan).collect::<Option<_>>()?;
    let Part { mut vertices, mut faces } = joined(parts);
    let count = vertices.len();
    let is_mesh = !faces.is_empty() && keep_used(&mut vertices, &mut faces);
    is_mesh.then_some((Mesh { vertices, triangles: faces }, count))
}

/// The memory that reading a mesh takes at least, for a file of this many bytes: its text, and the lists into which it
/// is scanned. In bytes.
pub fn memory_for(length: u64) -> u64 {
    let vertices = length / BYTES_PER_VERTEX as u64 * size_of::<DVec3>() as u64;
    length + vertices + length / BYTES_PER_FACE as u64 * size_of::<[u32; 3]>() as u64
}

/// The bytes of a text for each vertex and each face for which its lists have room. The lists are about twice as long
/// as those of a mesh with two faces per vertex, so that they do not grow. Memory that is reserved but not touched costs
/// nothing.
const BYTES_PER_VERTEX: usize = 30;
const BYTES_PER_FACE: usize = 15;

/// The contents of some lines. The corners of faces count vertices from 1.
struct Part {
    vertices: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
}

/// The size in bytes of the chunks that are scanned in parallel. With one thread it is the whole text, since
/// joining the parts takes time and memory. Otherwise it is large enough for a part's lists to fill large
/// pages.
fn chunk_size(length: usize) -> usize {
    let threads = rayon::current_num_threads();
    if threads == 1 { length } else { (length / (2 * threads)).clamp(1 << 18, 1 << 22) }
}

/// Splits a text at line ends into chunks of about `size` bytes.
fn chunks(mut text: &[u8], size: usize) -> Vec<&[u8]> {
    let mut chunks = vec![];
    while text.len() > size {
        let rest = text[size..].iter().position(|&b| b == b'\n').map_or(text.len(), |end| size + end + 1);
        let (chunk, after) = text.split_at(rest);
        chunks.push(chunk);
        text = after;
    }
    chunks.push(text);
    chunks
}

/// The contents of some lines. None if there is something else than plain positions and triangles.
fn scan(mut text: &[u8]) -> Option<Part> {
    let mut part = Part {
        vertices: Vec::with_capacity(text.len() / BYTES_PER_VERTEX),
        faces: Vec::with_capacity(text.len() / BYTES_PER_FACE),
    };
    while let Some((&first, rest)) = text.split_first() {
        text = match first {
            b'v' => {
                let (vertex, rest) = vertex(rest)?;
                part.vertices.push(vertex);
                rest
            }
            b'f' => {
                let (face, rest) = face(rest)?;
                part.faces.push(face);
                rest
            }
            b'#' => &rest[rest.iter().position(|&b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len())..],
            b'\n' | b'\r' => rest,
            _ => return None,
        };
    }
    Some(part)
}

fn joined(mut parts: Vec<Part>) -> Part {
    if parts.len() == 1
        && let Some(part) = parts.pop()
    {
        return part;
    }
    let mut all = Part {
        vertices: Vec::with_capacity(parts.iter().map(|part| part.vertices.len()).sum()),
        faces: Vec::with_capacity(parts.iter().map(|part| part.faces.len()).sum()),
    };
    for part in parts {
        all.vertices.extend(part.vertices);
        all.faces.extend(part.faces);
    }
    all
}

/// The position on the rest of a line that starts with `v`.
#[inline(always)]
fn vertex(rest: &[u8]) -> Option<(DVec3, &[u8])> {
    let (x, rest) = number(rest)?;
    let (y, rest) = number(rest)?;
    let (z, rest) = number(rest)?;
    Some((DVec3::new(x, y, z), line_end(rest)?))
}

/// The corners on the rest of a line that starts with `f`.
#[inline(always)]
fn face(rest: &[u8]) -> Option<([u32; 3], &[u8])> {
    let (a, rest) = corner(rest)?;
    let (b, rest) = corner(rest)?;
    let (c, rest) = corner(rest)?;
    Some(([a, b, c], line_end(rest)?))
}

/// The text after one or more leading blanks; none if there is no blank.
#[inline(always)]
fn after_blanks(text: &[u8]) -> Option<&[u8]> {
    let mut rest = text.strip_prefix(b" ")?;
    while let [b' ', after @ ..] = rest {
        rest = after;
    }
    Some(rest)
}

/// The text after the end of the line; none unless only blanks precede the line end.
#[inline(always)]
fn line_end(text: &[u8]) -> Option<&[u8]> {
    let rest = after_blanks(text).unwrap_or(text);
    match rest {
        [] => Some(b""),
        [b'\n', after @ ..] | [b'\r', b'\n', after @ ..] | [b'\r', after @ ..] => Some(after),
        _ => None,
    }
}

/// Appends a run of digits to the decimal digits of `value`. Returns the resulting number, the length of the
/// run and the text after it.
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

/// As [`digits`], but for any number of digits, and also near the end of the text.
#[inline(never)]
fn many_digits(mut text: &[u8], mut value: u64) -> (u64, usize, &[u8]) {
    let mut length = 0;
    // Eight digits at a time, because the exit of a loop over single digits is hard to predict.
    while let Some(&eight) = text.first_chunk::<8>() {
        let (number, count) = leading_digits(u64::from_le_bytes(eight));
        value = value.wrapping_mul(TEN_TO[count]).wrapping_add(number);
        length += count;
        text = &text[count..];
        if count < 8 {
            return (value, length, text);
        }
    }
    while let [digit @ b'0'..=b'9', after @ ..] = text {
        value = value.wrapping_mul(10).wrapping_add((digit - b'0').into());
        length += 1;
        text = after;
    }
    (value, length, text)
}

/// The number formed by the leading digits of eight characters, the first in the lowest byte, and its length.
/// The bytes are processed in parallel within a 64-bit integer.
#[inline(always)]
fn leading_digits(characters: u64) -> (u64, usize) {
    const ONES: u64 = u64::MAX / 0xff;
    let values = characters ^ (ONES * b'0' as u64);
    // The high bit is set in each byte above 9. A carry can only reach bytes after the first such one.
    let others = (values.wrapping_add(ONES * (0x7f - 9)) | values) & (ONES * 0x80);
    let count = others.trailing_zeros() / 8;
    // The digits are shifted as if zeros preceded them. Then neighbours are combined to numbers of two, four
    // and eight digits.
    let digits = values.checked_shl(64 - 8 * count).unwrap_or(0);
    let pairs = (digits.wrapping_mul(10) + (digits >> 8)) & (u64::MAX / 0xffff * 0xff);
    let fours = (pairs.wrapping_mul(100) + (pairs >> 16)) & (u64::MAX / 0xffff_ffff * 0xffff);
    let eight = (fours.wrapping_mul(10_000) + (fours >> 32)) & 0xffff_ffff;
    (eight, count as usize)
}

const TEN_TO: [u64; 9] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];

/// The vertex number of a face's corner, after one or more blanks.
#[inline(always)]
fn corner(text: &[u8]) -> Option<(u32, &[u8])> {
    let (value, length, rest) = digits(after_blanks(text)?, 0);
    (length > 0 && length < 10).then_some((value as u32, rest))
}

/// A correctly rounded decimal number, after one or more blanks.
#[inline(always)]
fn number(text: &[u8]) -> Option<(f64, &[u8])> {
    let text = after_blanks(text)?;
    let (sign, unsigned) = match text {
        [b'-', unsigned @ ..] => (-1.0, unsigned),
        _ => (1.0, text),
    };
    let (whole, before, rest) = match unsigned {
        // Most numbers begin with a single digit and a decimal point.
        [digit @ b'0'..=b'9', b'.', ..] => (u64::from(digit - b'0'), 1, &unsigned[1..]),
        _ => digits(unsigned, 0),
    };
    let (value, after, rest) = match rest {
        [b'.', fraction @ ..] => digits(fraction, whole),
        _ => (whole, 0, rest),
    };
    let is_plain = matches!(rest.first(), None | Some(b' ' | b'\n' | b'\r'));
    // 19 digits fit into a u64, and an integer up to 2^53 is exact as an f64.
    let is_exact = before + after <= 19 && value <= 1 << f64::MANTISSA_DIGITS;
    if !is_plain || before + after == 0 || !is_exact {
        return other_number(text);
    }
    // Both operands are exact, so the quotient is rounded only once (Clinger, "How to Read Floating Point
    // Numbers Accurately", PLDI 1990).
    Some((sign * (value as f64 / POWERS_OF_TEN[after]), rest))
}

const POWERS_OF_TEN: [f64; 20] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19,
];

/// A number with an exponent or with many digits; none for a word that is not a finite number.
fn other_number(text: &[u8]) -> Option<(f64, &[u8])> {
    let length = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    let value: f64 = str::from_utf8(&text[..length]).ok()?.parse().ok()?;
    value.is_finite().then_some((value, &text[length..]))
}

/// Removes the vertices that no face uses, and converts the corners of faces, which count from 1, to indices of the
/// remaining ones. False, with the lists in no particular state, if a corner names a vertex that does not exist.
pub fn keep_used(vertices: &mut Vec<DVec3>, faces: &mut [[u32; 3]]) -> bool {
    let mut used = vec![false; vertices.len()];
    for corner in faces.as_flattened_mut() {
        // No vertex has the largest index.
        *corner = corner.wrapping_sub(1);
        let Some(used) = used.get_mut(*corner as usize) else { return false };
        *used = true;
    }
    if used.contains(&false) {
        let mut next = 0;
        let indices = used.iter().map(|&used| {
            next += u32::from(used);
            next - u32::from(used)
        });
        let new_indices: Vec<u32> = indices.collect();
        faces.as_flattened_mut().iter_mut().for_each(|corner| *corner = new_indices[*corner as usize]);
        let mut used = used.into_iter();
        vertices.retain(|_| used.next().unwrap_or(false));
    }
    true
}

#[cfg(test)]
mod tests;
