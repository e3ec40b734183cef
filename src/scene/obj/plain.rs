//! A fast parser for OBJ texts that contain only positions and triangles. It scans chunks of the text in parallel.

use crate::base::patience::Patience;
use crate::scene::mesh::Mesh;
use glam::DVec3;
use rayon::prelude::*;

/// Parses a text of `v x y z` and `f i j k` lines, blank lines and comments. `None` if it contains anything else: the
/// full parser then has to accept or reject it. Also `None` if the patience is over.
///
/// Returns the mesh and the number of `v` lines. The mesh is identical to the full parser's, except that the vertices
/// are in the order of the file.
pub fn parse(text: &[u8], patience: &dyn Patience) -> Option<(Mesh, usize)> {
    let chunks = chunks(text, chunk_size(text.len()));
    let parts: Option<Vec<_>> = chunks.into_par_iter().map(|chunk| scan(chunk, patience)).collect();
    let (vertices, triangles) = parts?.into_iter().unzip();
    let mut mesh = Mesh { vertices: joined(vertices), triangles: joined(triangles) };
    let count = mesh.vertices.len();
    let is_mesh = !mesh.triangles.is_empty() && keep_used(&mut mesh.vertices, &mut mesh.triangles);
    is_mesh.then_some((mesh, count))
}

/// Returns the minimum memory in bytes for reading a mesh of this length: its text and the scanned lists.
pub fn memory_for(length: u64) -> u64 {
    let vertices = length / BYTES_PER_VERTEX as u64 * size_of::<DVec3>() as u64;
    length + vertices + length / BYTES_PER_FACE as u64 * size_of::<[u32; 3]>() as u64
}

/// The bytes of text per vertex and per face assumed when the lists are allocated. The lists are about twice as long as
/// needed for two faces per vertex, so they do not grow. Untouched memory costs nothing.
const BYTES_PER_VERTEX: usize = 30;
const BYTES_PER_FACE: usize = 15;

/// Returns the size in bytes of the chunks scanned in parallel. With one thread it is the whole text, since joining
/// chunks takes time and memory.
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

/// Returns the vertices and the faces in some lines. Corners count vertices from 1. `None` if there is anything else, or
/// if the patience is over.
fn scan(mut text: &[u8], patience: &dyn Patience) -> Option<(Vec<DVec3>, Vec<[u32; 3]>)> {
    /// The bytes between two questions.
    const PART: usize = 1 << 16;
    let mut next_question = text.len();
    let mut vertices = Vec::with_capacity(text.len() / BYTES_PER_VERTEX);
    let mut faces = Vec::with_capacity(text.len() / BYTES_PER_FACE);
    while let Some((&first, rest)) = text.split_first() {
        if text.len() <= next_question {
            patience.check().ok()?;
            next_question = text.len().saturating_sub(PART);
        }
        text = match first {
            b'v' => {
                let (vertex, rest) = three(rest, number)?;
                vertices.push(DVec3::from_array(vertex));
                rest
            }
            b'f' => {
                let (face, rest) = three(rest, corner)?;
                faces.push(face);
                rest
            }
            b'#' => &rest[rest.iter().position(|&b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len())..],
            b'\n' | b'\r' => rest,
            _ => return None,
        };
    }
    Some((vertices, faces))
}

fn joined<T: Clone>(mut lists: Vec<Vec<T>>) -> Vec<T> {
    if lists.len() == 1 { lists.remove(0) } else { lists.concat() }
}

/// Parses the three words on the rest of a line.
#[inline(always)]
fn three<T>(rest: &[u8], word: impl Fn(&[u8]) -> Option<(T, &[u8])>) -> Option<([T; 3], &[u8])> {
    let (a, rest) = word(rest)?;
    let (b, rest) = word(rest)?;
    let (c, rest) = word(rest)?;
    Some(([a, b, c], line_end(rest)?))
}

/// Returns the text after one or more leading blanks. `None` if there is no blank.
#[inline(always)]
fn after_blanks(text: &[u8]) -> Option<&[u8]> {
    let mut rest = text.strip_prefix(b" ")?;
    while let [b' ', after @ ..] = rest {
        rest = after;
    }
    Some(rest)
}

/// Returns the text from the end of the line on. `None` unless only blanks precede it.
#[inline(always)]
fn line_end(text: &[u8]) -> Option<&[u8]> {
    let rest = after_blanks(text).unwrap_or(text);
    matches!(rest, [] | [b'\n' | b'\r', ..]).then_some(rest)
}

/// Appends a run of digits to the decimal digits of `value`. Returns the resulting number, the length of the run and
/// the text after it.
#[inline(always)]
pub fn digits(text: &[u8], mut value: u64) -> (u64, usize, &[u8]) {
    let mut rest = text;
    while let [digit @ b'0'..=b'9', after @ ..] = rest {
        value = value.wrapping_mul(10).wrapping_add((digit - b'0').into());
        rest = after;
    }
    (value, text.len() - rest.len(), rest)
}

/// Parses the vertex number of a face's corner, after one or more blanks.
#[inline(always)]
fn corner(text: &[u8]) -> Option<(u32, &[u8])> {
    let (value, length, rest) = digits(after_blanks(text)?, 0);
    (length > 0 && length < 10).then_some((value as u32, rest))
}

/// Parses a correctly rounded decimal number, after one or more blanks.
#[inline(always)]
fn number(text: &[u8]) -> Option<(f64, &[u8])> {
    let text = after_blanks(text)?;
    let unsigned = text.strip_prefix(b"-").unwrap_or(text);
    let sign = if unsigned.len() < text.len() { -1.0 } else { 1.0 };
    let (whole, before, rest) = digits(unsigned, 0);
    let (value, after, rest) = match rest {
        [b'.', fraction @ ..] => digits(fraction, whole),
        _ => (whole, 0, rest),
    };
    let is_plain = matches!(rest.first(), None | Some(b' ' | b'\n' | b'\r'));
    // 19 digits fit into a u64, and an integer up to 2^53 is exact as an f64.
    let is_exact = before + after <= 19 && value <= 1 << f64::MANTISSA_DIGITS;
    if !is_plain || before + after == 0 || !is_exact {
        let length = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
        let value: f64 = str::from_utf8(&text[..length]).ok()?.parse().ok()?;
        return value.is_finite().then_some((value, &text[length..]));
    }
    // Both operands are exact, so the quotient is rounded only once (Clinger, "How to Read Floating Point
    // Numbers Accurately", PLDI 1990).
    Some((sign * (value as f64 / POWERS_OF_TEN[after]), rest))
}

const POWERS_OF_TEN: [f64; 20] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19,
];

/// Removes unused vertices, and converts the corners of faces from numbers that count from 1 to indices of the
/// remaining vertices. Returns false, with the lists in an unspecified state, if a corner refers to a vertex that does
/// not exist.
pub fn keep_used(vertices: &mut Vec<DVec3>, faces: &mut [[u32; 3]]) -> bool {
    let mut used = vec![false; vertices.len()];
    for corner in faces.as_flattened_mut() {
        // No vertex has the largest index.
        *corner = corner.wrapping_sub(1);
        let Some(used) = used.get_mut(*corner as usize) else { return false };
        *used = true;
    }
    if used.contains(&false) {
        let after = |next: &mut u32, used: &bool| Some(std::mem::replace(next, *next + u32::from(*used)));
        let new_indices: Vec<u32> = used.iter().scan(0, after).collect();
        faces.as_flattened_mut().iter_mut().for_each(|corner| *corner = new_indices[*corner as usize]);
        let mut used = used.into_iter();
        vertices.retain(|_| used.next().unwrap_or(false));
    }
    true
}

#[cfg(test)]
mod tests;
