//! Finds the planes in one place, in O(n log n) for n planes.
//!
//! Planes in one place get the same numbers, so that rays hit them at the same t. Parallel planes under the same
//! transforms get the same normal, so that they never cross. Planes under the same transforms are compared in object
//! space, where only the numbers of the text are rounded. So they are told apart however strongly the transforms scale.
//! They are found by the cells of a fine grid in which their numbers lie. Planes under different transforms are compared
//! in world space, by their error bounds, and found in a tree.

use super::coincidence::WRITTEN_ROUNDINGS;
use super::plane::{PlacedPlane, Plane};
use crate::base::patience::{Ended, Steps};
use crate::math::box_tree::{BoxTree, Extents, Node};
use crate::math::robust::UNIT_ROUNDOFF;
use glam::{DAffine3, DVec3};
use std::cell::Cell;
use std::collections::HashMap;

/// The largest sine of the angle between unit normals that may have been written as parallel: [`WRITTEN_ROUNDINGS`] for
/// each normal, and as many for the sine.
const PARALLEL_SINE: f64 = 3.0 * WRITTEN_ROUNDINGS * UNIT_ROUNDOFF;

/// The width of the cells of normals, and the largest difference of a coordinate of normals that may have been written
/// as parallel, with room for the rounding of the sine.
const CELL: f64 = 4.0 * PARALLEL_SINE;
const REACH: f64 = 1.5 * PARALLEL_SINE;

/// The cells of offsets have this power of two of consecutive floats. Offsets that may have been written as equal are
/// closer than `OFFSET_REACH`.
const OFFSET_BITS: u32 = 6;
const OFFSET_REACH: i64 = 16;

/// The planes of a scene as they are written, without their transforms.
#[derive(Default)]
pub struct WrittenPlanes {
    /// The index of each matrix, by the bits of its numbers.
    matrices: HashMap<Option<[u64; 12]>, u32>,
    /// The normals that are not parallel to earlier ones under the same matrix.
    normals: Vec<DVec3>,
    /// The indices of normals, by their matrix and their cell.
    normals_in: HashMap<(u32, [i64; 3]), Vec<u32>>,
    /// The planes that are not in the place of earlier ones, by the index and the cell of their offset.
    offsets_in: HashMap<(u32, i64), Vec<(f64, u32)>>,
    planes: Vec<Written>,
}

/// A plane of the text.
struct Written {
    /// The index of its matrix.
    matrix: u32,
    /// The index of an earlier plane in its place under the same matrix.
    same: Option<u32>,
}

impl WrittenPlanes {
    /// Adds a plane under a matrix. Returns it with the normal of the first plane that is parallel, and with the offset
    /// and the index of the first plane in the same place.
    pub fn add(
        &mut self,
        matrix: Option<DAffine3>,
        written: Plane,
        steps: &mut Steps,
    ) -> Result<(Plane, Option<usize>), Ended> {
        let next = self.matrices.len() as u32;
        // Adding 0 makes both zeros the same.
        let bits = matrix.map(|matrix| matrix.to_cols_array().map(|x| (x + 0.0).to_bits()));
        let matrix = *self.matrices.entry(bits).or_insert(next);
        let normal = match self.parallel(matrix, written.normal, steps)? {
            Some(index) => index,
            None => {
                let index = self.normals.len() as u32;
                self.normals.push(written.normal);
                let cell = written.normal.to_array().map(cell_of);
                self.normals_in.entry((matrix, cell)).or_default().push(index);
                index
            }
        };
        let common = self.normals[normal as usize];
        let is_reversed = common.dot(written.normal) < 0.0;
        let offset = if is_reversed { -written.offset } else { written.offset };
        let same = self.equal(normal, offset, steps)?;
        if same.is_none() {
            let cell = ordered(offset) >> OFFSET_BITS;
            self.offsets_in.entry((normal, cell)).or_default().push((offset, self.planes.len() as u32));
        }
        self.planes.push(Written { matrix, same: same.map(|(_, index)| index) });
        let plane = Plane { normal: common, offset: same.map_or(offset, |(offset, _)| offset) };
        let plane = if is_reversed { plane.reversed() } else { plane };
        Ok((plane, same.map(|(_, index)| index as usize)))
    }

    /// Returns the index of the first normal under this matrix that may have been written as parallel to this one.
    fn parallel(&self, matrix: u32, normal: DVec3, steps: &mut Steps) -> Result<Option<u32>, Ended> {
        let mut first: Option<u32> = None;
        for normal in [normal, -normal] {
            let ends = normal.to_array().map(|x| [cell_of(x - REACH), cell_of(x + REACH)]);
            // The eight corners of the reach, of which most lie in one cell.
            let mut cells: Vec<[i64; 3]> =
                (0..8).map(|corner| [0, 1, 2].map(|axis| ends[axis][corner >> axis & 1])).collect();
            cells.dedup();
            for cell in cells {
                let found = self.normals_in.get(&(matrix, cell)).map_or(&[][..], Vec::as_slice);
                steps.take(1 + found.len())?;
                let parallel = found.iter().find(|&&index| is_parallel(self.normals[index as usize], normal));
                first = first.into_iter().chain(parallel.copied()).min();
            }
        }
        Ok(first)
    }

    /// Returns the offset and the index of the first plane with this normal that may have been written with an equal
    /// offset.
    fn equal(&self, normal: u32, offset: f64, steps: &mut Steps) -> Result<Option<(f64, u32)>, Ended> {
        let mut first: Option<(f64, u32)> = None;
        let key = ordered(offset);
        let [start, end] = [key - OFFSET_REACH, key + OFFSET_REACH].map(|key| key >> OFFSET_BITS);
        for cell in start..=end {
            let found = self.offsets_in.get(&(normal, cell)).map_or(&[][..], Vec::as_slice);
            steps.take(1 + found.len())?;
            let is_equal =
                |other: f64| (offset - other).abs() <= WRITTEN_ROUNDINGS * UNIT_ROUNDOFF * other.abs();
            let equal = found.iter().copied().find(|&(other, _)| is_equal(other));
            first = first.into_iter().chain(equal).min_by_key(|&(_, index)| index);
        }
        Ok(first)
    }

    /// Gives each plane the numbers of the first plane under another matrix that is in its place within the error
    /// bounds of both. `planes` are all planes that were added, placed in world space.
    pub fn unite(self, planes: &mut [PlacedPlane], steps: &mut Steps) -> Result<(), Ended> {
        if self.matrices.len() < 2 {
            return Ok(());
        }
        let boxes: Vec<Extents<4>> = planes.iter().map(|placed| reach(placed, placed.plane)).collect();
        let tree = BoxTree::new(&boxes);
        // The only matrix of the planes below each node; none if there are several.
        let mut matrices: Vec<Option<u32>> = vec![None; tree.nodes().len()];
        let mut has_matrix = vec![false; tree.nodes().len()];
        for (index, written) in (0..).zip(&self.planes) {
            for node in tree.nodes_of(index) {
                let is_other = matrices[node] != Some(written.matrix);
                matrices[node] = if has_matrix[node] && is_other { None } else { Some(written.matrix) };
                has_matrix[node] = true;
            }
        }
        let mut is_first = vec![false; planes.len()];
        for (index, Written { matrix, same }) in self.planes.iter().enumerate() {
            if let Some(same) = *same {
                planes[index].plane = facing(planes[same as usize].plane, planes[index].plane.normal);
                continue;
            }
            let (own, first) = (&planes[index], Cell::new(index as u32));
            for side in [own.plane, own.plane.reversed()] {
                let near = reach(own, side);
                let enters = |id: usize, node: &Node<4>| {
                    node.first < first.get() && matrices[id] != Some(*matrix) && node.bounds.meets(&near)
                };
                let looked = tree.visit(enters, |other| {
                    let is_earlier = other < first.get() && is_first[other as usize];
                    let has_other_matrix = self.planes[other as usize].matrix != *matrix;
                    if is_earlier && has_other_matrix && own.coincides(&planes[other as usize]) {
                        first.set(other);
                    }
                });
                steps.take(looked)?;
            }
            let first = first.get() as usize;
            is_first[index] = first == index;
            planes[index].plane = facing(planes[first].plane, planes[index].plane.normal);
        }
        Ok(())
    }
}

/// Returns a box in the space of normals and offsets. The boxes of planes that coincide meet.
fn reach(placed: &PlacedPlane, Plane { normal, offset }: Plane) -> Extents<4> {
    /// The largest tilt for which the following sums bound the difference of two planes that coincide.
    const SMALL: f64 = 0.01;
    let error = placed.error;
    let rounding = 4.0 * WRITTEN_ROUNDINGS * UNIT_ROUNDOFF;
    let (of_normal, of_offset) = match error.tilt < SMALL {
        true => {
            let of_offset = 1.2 * error.at_origin + (8.0 * error.tilt + rounding) * offset.abs();
            (1.2 * error.tilt + rounding, of_offset)
        }
        false => (f64::INFINITY, f64::INFINITY),
    };
    let (center, half) =
        ([normal.x, normal.y, normal.z, offset], [of_normal, of_normal, of_normal, of_offset]);
    Extents {
        min: std::array::from_fn(|k| center[k] - half[k]),
        max: std::array::from_fn(|k| center[k] + half[k]),
    }
}

/// Returns the cell of a coordinate of a normal.
fn cell_of(x: f64) -> i64 {
    (x / CELL).floor() as i64
}

/// Returns a whole number that is in the order of the floats. Consecutive floats have consecutive numbers.
fn ordered(x: f64) -> i64 {
    let bits = x.to_bits() as i64;
    if bits < 0 { i64::MIN - bits } else { bits }
}

/// Returns true if two unit normals may have been written as parallel.
fn is_parallel(one: DVec3, other: DVec3) -> bool {
    one.cross(other).length() <= PARALLEL_SINE
}

/// Returns the plane with its normal on the side to which `direction` points.
fn facing(plane: Plane, direction: DVec3) -> Plane {
    if plane.normal.dot(direction) < 0.0 { plane.reversed() } else { plane }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::patience::Endless;
    use crate::math::worst_case::Rng;

    /// Moves a number by up to a few roundings.
    fn moved(rng: &mut Rng, x: f64) -> f64 {
        let steps = rng.below(9) as i64 - 4;
        (0..steps.abs()).fold(x, |x, _| if steps < 0 { x.next_down() } else { x.next_up() })
    }

    #[test]
    fn the_first_plane_in_the_same_place_is_found() {
        let rng = &mut Rng(5);
        for _ in 0..60 {
            let directions: Vec<DVec3> = (0..4).map(|_| rng.vector().normalize()).collect();
            let offsets = [0.0, 0.3, 1.0, -1.0, 1e9].map(|offset| offset * rng.signed());
            let (mut all, mut known) = (WrittenPlanes::default(), Vec::<(Option<DAffine3>, Plane)>::new());
            for _ in 0..150 {
                let normal = directions[rng.below(4)];
                let normal = DVec3::from(normal.to_array().map(|x| moved(rng, x)));
                let offset = offsets[rng.below(5)];
                let plane = Plane { normal, offset: moved(rng, offset) };
                let plane = if rng.below(2) == 0 { plane } else { plane.reversed() };
                let matrix = [None, Some(DAffine3::IDENTITY)][rng.below(2)];

                // The rule, by a look at all earlier planes.
                let mut expected = plane;
                let under_same = || known.iter().enumerate().filter(|(_, (other, _))| *other == matrix);
                let parallel = under_same().find(|(_, (_, other))| is_parallel(other.normal, plane.normal));
                expected.normal =
                    parallel.map_or(plane.normal, |(_, (_, p))| facing(*p, plane.normal).normal);
                let same = under_same().find(|(_, (_, other))| {
                    let other = facing(*other, expected.normal);
                    let apart = (expected.offset - other.offset).abs();
                    other.normal == expected.normal
                        && apart <= WRITTEN_ROUNDINGS * UNIT_ROUNDOFF * other.offset.abs()
                });
                expected = same.map_or(expected, |(_, (_, other))| facing(*other, expected.normal));

                let same = same.map(|(index, _)| index);
                let (found, index) = all.add(matrix, plane, &mut Steps::new(&Endless)).unwrap();
                assert_eq!((found, index), (expected, same), "{plane:?} after {known:?}");
                known.push((matrix, found));
            }
        }
    }
}
