//! The texture coordinates of an OBJ text's triangles.

use glam::DVec2;

/// The texture coordinates at a triangle's corners, to the right and up.
pub type Corners = [DVec2; 3];

/// The texture coordinates of each triangle, in the order of the faces; none for a triangle without them.
///
/// The text has been read as a mesh of so many triangles. The result is empty if its faces are others: polygons, which
/// the editions of the course with textures do not have.
pub fn read(text: &[u8], triangles: usize) -> Vec<Option<Corners>> {
    let (mut points, mut faces) = (vec![], vec![]);
    for line in text.split(|byte| matches!(byte, b'\n' | b'\r')) {
        let Ok(line) = str::from_utf8(line) else { continue };
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("vt") => {
                let mut number = || words.next().and_then(|word| word.parse().ok()).unwrap_or(0.0);
                points.push(DVec2::new(number(), number()));
            }
            Some("f") => faces.push(words.map(|corner| index(corner, points.len())).collect::<Vec<_>>()),
            _ => {}
        }
    }
    let point = |index: Option<usize>| points.get(index?).copied();
    let corners = |face: &Vec<Option<usize>>| match *face.as_slice() {
        [a, b, c] => Some([point(a)?, point(b)?, point(c)?]),
        _ => None,
    };
    let are_triangles = faces.len() == triangles && faces.iter().all(|face| face.len() == 3);
    if are_triangles { faces.iter().map(corners).collect() } else { vec![] }
}

/// The index of a corner's texture coordinates, from 0. Negative ones count back from the last of those before the face.
fn index(corner: &str, before: usize) -> Option<usize> {
    match corner.split('/').nth(1)?.parse::<isize>().ok()? {
        index if index < 0 => before.checked_add_signed(index),
        index => (index as usize).checked_sub(1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_have_the_coordinates_that_they_name() {
        let text = b"v 0 0 0\nvt 0.25 0.5 # one\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\r\nf 1/-1 2/-2/7 3/-3\nf 1 2 3\nf 1/9 2/1 3/1";
        let [a, b, c] = [DVec2::new(0.25, 0.5), DVec2::X, DVec2::Y];
        assert_eq!(read(text, 4), [Some([a, b, c]), Some([c, b, a]), None, None]);
    }

    #[test]
    fn polygons_have_none() {
        assert_eq!(read(b"vt 0 0\nf 1/1 2/1 3/1 4/1", 2), []);
    }
}
