//! Primitives that no ray sees: triangles without area, and those equal to a primitive that comes before.

use super::{World, triangle};
use crate::math::aabb::Aabb;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// The number of triangles per parallel task.
const PART: usize = 1 << 14;

/// Returns the finite primitives that no ray sees, in ascending order. Of equal ones, a ray sees the first.
pub fn unseen(world: &World) -> Vec<u32> {
    let mut unseen = [without_area(world), equal_triangles(world), equal_shapes(world)].concat();
    unseen.sort_unstable();
    unseen.dedup();
    unseen
}

/// Returns the triangles without area.
fn without_area(world: &World) -> Vec<u32> {
    let in_part = |(part, triangles): (usize, &[[u32; 3]])| {
        let vertex = |id: u32| &world.vertices[id as usize];
        let found = triangles.iter().enumerate().filter(|(_, ids)| !triangle::has_area(ids.map(vertex)));
        found.map(|(i, _)| (part * PART + i) as u32).collect()
    };
    world.triangles.par_chunks(PART).enumerate().map(in_part).collect::<Vec<Vec<u32>>>().concat()
}

/// Returns the triangles that have the corners of an earlier one, in any order.
fn equal_triangles(world: &World) -> Vec<u32> {
    if world.triangles.len() < 2 {
        return vec![];
    }
    let hashes: Vec<u64> = world.vertices.par_iter().with_min_len(PART).map(hash).collect();
    let triangles = || world.triangles.par_iter().with_min_len(PART);
    let hash = |ids: &[u32; 3]| ids.iter().fold(0, |sum: u64, &id| sum.wrapping_add(hashes[id as usize]));
    // Few triangles share a bit with another one by chance. Only those that do are sorted.
    let [once, twice] = [(), ()].map(|()| Bits::new(16 * world.triangles.len()));
    triangles().map(hash).filter(|&hash| !once.set(hash)).for_each(|hash| {
        twice.set(hash);
    });
    let mut ids: Vec<(u64, u32)> = triangles()
        .enumerate()
        .map(|(id, corners)| (hash(corners), id as u32))
        .filter(|(hash, _)| twice.has(*hash))
        .collect();
    ids.sort_unstable();
    let sorted = |id: u32| {
        let mut corners = world.corners(id as usize).map(|corner| corner.to_array());
        corners.sort_by(|one, other| one.partial_cmp(other).unwrap_or(std::cmp::Ordering::Equal));
        corners
    };
    let alike = ids.chunk_by(|one, other| one.0 == other.0).filter(|alike| alike.len() > 1);
    let equal = alike.flat_map(|alike| {
        let first = sorted(alike[0].1);
        alike[1..].iter().map(|&(_, id)| id).filter(move |&id| sorted(id) == first)
    });
    equal.collect()
}

/// Bits that threads set by hashes.
struct Bits {
    words: Vec<AtomicU64>,
    shift: u32,
}

impl Bits {
    /// Returns at least this number of bits, all 0.
    fn new(count: usize) -> Self {
        let words = count.div_ceil(64).next_power_of_two();
        let shift = 64 - words.trailing_zeros() - 6;
        Self { words: (0..words).map(|_| AtomicU64::new(0)).collect(), shift }
    }

    fn place(&self, hash: u64) -> (&AtomicU64, u64) {
        let bit = hash >> self.shift;
        (&self.words[(bit / 64) as usize], 1 << (bit % 64))
    }

    /// Sets a bit. Returns true if it was 0.
    fn set(&self, hash: u64) -> bool {
        let (word, bit) = self.place(hash);
        word.fetch_or(bit, Relaxed) & bit == 0
    }

    fn has(&self, hash: u64) -> bool {
        let (word, bit) = self.place(hash);
        word.load(Relaxed) & bit != 0
    }
}

/// Returns the shapes that are equal to an earlier one.
fn equal_shapes(world: &World) -> Vec<u32> {
    let boxes = world.boxes().zip(world.triangles.len() as u32..);
    let mut ids: Vec<(u64, u32)> =
        boxes.map(|(Aabb { min, max }, id)| (hash(&min) ^ hash(&max), id)).collect();
    ids.sort_unstable();
    let shape = |id: u32| &world.shapes[id as usize - world.triangles.len()];
    let alike = ids.chunk_by(|one, other| one.0 == other.0);
    let equal = alike
        .flat_map(|alike| alike[1..].iter().map(|&(_, id)| id).filter(|&id| shape(id) == shape(alike[0].1)));
    equal.collect()
}

/// Returns a number that equal points share, and others seldom.
fn hash(point: &DVec3) -> u64 {
    // Adding 0 makes -0 equal to 0.
    let [x, y, z] = (*point + 0.0).to_array().map(f64::to_bits);
    let mix = |sum: u64, bits: u64| (sum.rotate_left(23) ^ bits).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let sum = mix(mix(mix(0, x), y), z);
    (sum ^ sum >> 32).wrapping_mul(0x9E37_79B9_7F4A_7C15)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parser::parse;

    #[test]
    fn of_equal_primitives_the_first_is_seen() {
        let triangle =
            |a: &str, b: &str, c: &str| format!("Triangle {{ vertex0 {a} vertex1 {b} vertex2 {c} }}");
        let sphere = |radius: &str| format!("Sphere {{ center 0 0 0 radius {radius} }}");
        let objects = [
            triangle("0 0 0", "1 0 0", "0 1 0"),
            // Turned, moved to its place by a transform, and with a zero of the other sign.
            triangle("0 1 0", "1 0 0", "0 0 0"),
            format!("Transform {{ Translate 1 0 0 {} }}", triangle("-1 0 0", "0 0 0", "-1 1 0")),
            triangle("1 0 -0", "0 1 0", "0 0 0"),
            // Almost equal, and with two corners that are.
            triangle("0 0 0", "1 0 0", "0 1.0000000000000002 0"),
            triangle("0 0 0", "1 0 0", "0 -1 0"),
            // Without an area.
            triangle("0 0 0", "1 0 0", "2 0 0"),
            sphere("1"),
            sphere("2"),
            sphere("1"),
            format!("Transform {{ Scale 1 2 1 {} }}", sphere("1")),
            format!("Transform {{ Scale 1 2 1 {} }}", sphere("1")),
        ];
        let text = format!(
            "OrthographicCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 0 size 3 }}
             Group {{ numObjects {} Material {{ }} {} }}",
            objects.len(),
            objects.join(" ")
        );
        let world = World::new(&parse(&text).unwrap(), &[]).unwrap();
        assert_eq!(world.unseen, [1, 2, 3, 6, 9, 11]);
    }
}
