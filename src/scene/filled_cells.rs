//! The `Grid` of the 2003 edition: the cells whose centres are in a sphere are filled.

use super::mesh::Mesh;
use crate::base::memory;
use crate::base::patience::{Patience, Steps};
use crate::diagnostic::Diagnostic;
use glam::DVec3;
use std::collections::HashMap;

/// The largest number of cells along an axis.
pub const MOST: u64 = 256;
/// The largest number of cells of all grids of a scene: one grid of the largest size.
pub const MOST_OF_SCENE: u64 = MOST * MOST * MOST;

/// A box divided into cells, and the sphere that fills some of them.
#[derive(Clone, Copy, Debug)]
pub struct FilledCells {
    pub min: DVec3,
    pub max: DVec3,
    /// The number of cells along each axis, 1 to [`MOST`].
    pub counts: [usize; 3],
    pub center: DVec3,
    pub radius: f64,
}

impl FilledCells {
    /// Returns the number of cells.
    pub fn count(&self) -> u64 {
        self.counts.iter().map(|&count| count as u64).product()
    }

    /// Returns the faces between filled and empty cells, two triangles each. Fails if memory is too small, or if the
    /// patience is over.
    pub fn surface(&self, patience: &dyn Patience) -> Result<Mesh, Diagnostic> {
        memory::ask(self.most_bytes())?;
        let mut steps = Steps::new(patience);
        let (mut mesh, mut known) = (Mesh::default(), HashMap::new());
        let [columns, rows, layers] = self.counts;
        let cells = (0..columns).flat_map(|i| (0..rows).map(move |j| [i, j]));
        let cells = cells.flat_map(|[i, j]| (0..layers).map(move |k| [i, j, k]));
        for cell in cells {
            steps.take(1)?;
            if !self.is_filled(cell) {
                continue;
            }
            for (axis, is_upper) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
                if self.neighbor(cell, axis, is_upper).is_some_and(|other| self.is_filled(other)) {
                    continue;
                }
                let mut vertex = |lattice: [usize; 3]| {
                    *known.entry(lattice).or_insert_with(|| {
                        mesh.vertices.push(self.point(lattice, 0.0));
                        mesh.vertices.len() as u32 - 1
                    })
                };
                let [a, b, c, d] = face(cell, axis, is_upper).map(&mut vertex);
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        Ok(mesh)
    }

    /// Returns the lattice point at these indices, moved by `part` of a cell along each axis.
    fn point(&self, lattice: [usize; 3], part: f64) -> DVec3 {
        let [place, count] =
            [lattice, self.counts].map(|numbers| DVec3::from_array(numbers.map(|n| n as f64)));
        self.min + (self.max - self.min) * (place + part) / count
    }

    fn is_filled(&self, cell: [usize; 3]) -> bool {
        (self.point(cell, 0.5) - self.center).length() <= self.radius
    }

    fn neighbor(&self, mut cell: [usize; 3], axis: usize, is_upper: bool) -> Option<[usize; 3]> {
        let place = if is_upper { cell[axis] + 1 } else { cell[axis].checked_sub(1)? };
        cell[axis] = place;
        (place < self.counts[axis]).then_some(cell)
    }

    /// Returns an upper bound on the memory of the surface and its vertex index. A line of cells enters and leaves a
    /// sphere at most once, so it has at most two faces across it.
    fn most_bytes(&self) -> u64 {
        let [x, y, z] = self.counts.map(|count| count as u64);
        let of_face = 2 * size_of::<[u32; 3]>() + size_of::<DVec3>() + 2 * size_of::<([usize; 3], u32)>();
        2 * (x * y + y * z + z * x) * of_face as u64
    }
}

/// Returns the corners of a cell's face across an axis as lattice indices, counter-clockwise seen from outside.
fn face(cell: [usize; 3], axis: usize, is_upper: bool) -> [[usize; 3]; 4] {
    let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| {
        let mut corner = cell;
        corner[axis] += usize::from(is_upper);
        corner[(axis + 1) % 3] += u;
        corner[(axis + 2) % 3] += v;
        corner
    });
    let [a, b, c, d] = corners;
    if is_upper { corners } else { [d, c, b, a] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::patience::Endless;

    fn cells(count: usize, radius: f64) -> FilledCells {
        let corner = DVec3::splat(1.5);
        FilledCells { min: -corner, max: corner, counts: [count; 3], center: DVec3::ZERO, radius }
    }

    #[test]
    fn cells_are_filled_whose_centre_is_in_the_sphere() {
        // With five cells along each axis, the corners and edges are too far away, at 1.2 along two axes.
        let all = cells(5, 1.5);
        let filled = |count: usize, cells: &FilledCells| {
            let axis = || 0..count;
            axis()
                .flat_map(|i| axis().flat_map(move |j| axis().map(move |k| [i, j, k])))
                .filter(|&cell| cells.is_filled(cell))
                .count()
        };
        assert_eq!(filled(5, &all), 27 + 6 * 9);
        // A cell centre on the sphere is filled. With a smaller radius it is not.
        assert_eq!(filled(1, &cells(1, 0.0)), 1);
        assert_eq!(filled(3, &FilledCells { radius: 1.0, ..cells(3, 1.0) }), 7);
        assert_eq!(filled(3, &cells(3, 1.0f64.next_down())), 1);
        assert_eq!(filled(2, &cells(2, 0.1)), 0);
    }

    #[test]
    fn the_surface_is_closed_and_faces_outward() {
        for (cells, faces) in [(cells(1, 1.0), 6), (cells(3, 1.0), 30), (cells(5, 1.5), 54 + 6 * 12)] {
            let Mesh { vertices, triangles } = cells.surface(&Endless).unwrap();
            assert_eq!(triangles.len(), 2 * faces);
            // The volume equals the volume of the filled cells, and every edge is used once in each direction.
            let corners = |&[a, b, c]: &[u32; 3]| [a, b, c].map(|vertex| vertices[vertex as usize]);
            let volume: f64 = triangles.iter().map(corners).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
            let side = 3.0 / cells.counts[0] as f64;
            let count = match faces {
                6 => 1.0,
                30 => 7.0,
                _ => 81.0,
            };
            assert!((volume - count * side.powi(3)).abs() < 1e-12, "{volume}");
            let mut ways = HashMap::new();
            for &[a, b, c] in &triangles {
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    *ways.entry((from, to)).or_insert(0) += 1;
                    *ways.entry((to, from)).or_insert(0) -= 1;
                }
            }
            assert!(ways.values().all(|&balance| balance == 0));
            assert!(cells.surface(&Endless).unwrap().bytes() < cells.most_bytes());
        }
        assert_eq!(cells(2, 0.1).surface(&Endless).unwrap(), Mesh::default());
    }
}
