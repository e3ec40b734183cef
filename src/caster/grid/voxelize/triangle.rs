//! The overlap of triangles with cells: the triangle's plane and its projections along the three axes must
//! overlap the cell (Schwarz and Seidel, "Fast Parallel Surface and Solid Voxelization on GPUs", SIGGRAPH
//! Asia 2010). `proofs/needles.g` proves the error bound of the plane.

use super::CellRange;
use crate::caster::grid::lattice::Lattice;
use crate::caster::grid::touched_cells::TouchedCells;
use crate::math::extremes::{box_corners, max3, min3};
use crate::math::robust::UNIT_ROUNDOFF;
use glam::DVec3;

/// Appends the index of every cell that a triangle touches, where each cell is padded by `padding` cells.
#[inline]
pub fn of_triangle(lattice: &Lattice, corners: [DVec3; 3], padding: f64, out: &mut TouchedCells) {
    let v = corners.map(|p| lattice.to_cells(p));
    let [min, max] = box_corners(v);
    let range = CellRange::new(lattice, min, max, padding);
    let half = 0.5 + padding;
    match range.spans_cells() {
        [true, true, true] => {
            let triangle = TriangleOverlap::new(v, half);
            range.push_if(lattice, out, |cell| triangle.overlaps(cell + 0.5))
        }
        // In a single layer of cells the projection along the layer's axis is sufficient.
        [true, true, false] => push_layer(&range, lattice, &Projection::<0, 1>::new(v, half), out),
        [false, true, true] => push_layer(&range, lattice, &Projection::<1, 2>::new(v, half), out),
        [true, false, true] => push_layer(&range, lattice, &Projection::<2, 0>::new(v, half), out),
        // The triangle touches all cells of a range that extends along one axis only.
        [true, false, false] => range.push_line(lattice, 0, out),
        [false, true, false] => range.push_line(lattice, 1, out),
        [false, false, _] => range.push_line(lattice, 2, out),
    }
}

/// Appends the cells that a projected triangle overlaps, of a range that is one cell thick along the axis of
/// projection.
#[inline(always)]
fn push_layer<const U: usize, const V: usize>(
    range: &CellRange,
    lattice: &Lattice,
    projection: &Projection<U, V>,
    out: &mut TouchedCells,
) {
    let mut start = range.first(lattice);
    for v in range.start[V]..range.end[V] {
        let mut index = start;
        out.reserve(range.end[U] - range.start[U]);
        for u in range.start[U]..range.end[U] {
            if projection.overlaps([u, v].map(|i| f64::from(i) + 0.5)) {
                out.push(index);
            }
            index += lattice.tables.strides[U];
        }
        start += lattice.tables.strides[V];
    }
}

/// A triangle projected along the third axis, for overlap tests with cells. The cell with the centre (u, v)
/// overlaps it if `a u + b v + c >= 0` for each of the three edges, where u and v are the coordinates along
/// the axes `U` and `V`, which follow one another cyclically. The padding of cells is far above the rounding
/// errors of these sums.
struct Projection<const U: usize, const V: usize> {
    edges: [[f64; 3]; 3],
}

impl<const U: usize, const V: usize> Projection<U, V> {
    /// Of a triangle in units of cells. `half` is half the edge length of a padded cell.
    #[inline(always)]
    fn new(v: [DVec3; 3], half: f64) -> Self {
        let [p, q, r] = v.map(|v| [v[U], v[V]]);
        let edge = |from: [f64; 2], to: [f64; 2], opposite: [f64; 2]| {
            let (a, b) = (from[1] - to[1], to[0] - from[0]);
            // The sign makes the interior the positive side of the edge, whatever the orientation is. It may
            // be wrong only where rounding errors hide on which side of this edge the triangle is, and then
            // the whole triangle is as good as on the edge. One sign for all edges would not do: the area of
            // a needle has the rounding errors of its long edges, which hide the side of a short edge.
            let sign = 1f64.copysign(a * (opposite[0] - from[0]) + b * (opposite[1] - from[1]));
            let (a, b) = (a * sign, b * sign);
            [a, b, half * (a.abs() + b.abs()) - (a * from[0] + b * from[1])]
        };
        Self { edges: [edge(p, q, r), edge(q, r, p), edge(r, p, q)] }
    }

    /// Whether the cell with this centre, in units of cells, overlaps the projection.
    #[inline(always)]
    fn overlaps(&self, [u, v]: [f64; 2]) -> bool {
        min3(self.edges.map(|[a, b, c]| a * u + b * v + c)) >= 0.0
    }
}

/// Error bound of the plane of a triangle, in roundings of the cube of its length: see `proofs/needles.g`.
const PLANE_ROUNDINGS: f64 = 32.0;

/// A triangle for overlap tests with cells: its plane and its projections along the three axes.
struct TriangleOverlap {
    normal: DVec3,
    /// The dot product of the normal and any point of the plane.
    offset: f64,
    /// The largest distance of the plane from the centre of a cell that it touches, times the length of the
    /// normal.
    max_distance: f64,
    xy: Projection<0, 1>,
    yz: Projection<1, 2>,
    zx: Projection<2, 0>,
}

impl TriangleOverlap {
    /// As [`Projection::new`].
    #[inline(always)]
    fn new(v: [DVec3; 3], half: f64) -> Self {
        let sides = [v[1] - v[0], v[2] - v[1], v[0] - v[2]];
        let normal = sides[0].cross(v[2] - v[0]);
        // The normal of a needle is mostly rounding error, which is proportional to the square of its length,
        // and may have any direction. The error of the plane is proportional to the cube of the length.
        let length = max3(box_corners(sides.map(DVec3::abs))[1].to_array());
        let plane_error_bound = PLANE_ROUNDINGS * UNIT_ROUNDOFF * length * length * length;
        Self {
            normal,
            offset: normal.dot(v[0]),
            max_distance: half * normal.abs().element_sum() + plane_error_bound,
            xy: Projection::new(v, half),
            yz: Projection::new(v, half),
            zx: Projection::new(v, half),
        }
    }

    /// Whether the cell with this centre, in units of cells, overlaps the triangle.
    #[inline(always)]
    fn overlaps(&self, center: DVec3) -> bool {
        let [x, y, z] = center.to_array();
        (self.normal.dot(center) - self.offset).abs() <= self.max_distance
            && self.xy.overlaps([x, y])
            && self.yz.overlaps([y, z])
            && self.zx.overlaps([z, x])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caster::grid::voxelize::of_box;
    use crate::caster::grid::voxelize::tests::{cells_of, lattice};
    use crate::math::aabb::Aabb;

    /// Points of a triangle, including points of its corners and edges.
    fn points([a, b, c]: [DVec3; 3]) -> impl Iterator<Item = DVec3> {
        (0..=40)
            .flat_map(move |i| (0..=40 - i).map(move |j| (i as f64 / 40.0, j as f64 / 40.0)))
            .map(move |(u, v)| a + u * (b - a) + v * (c - a))
    }

    #[test]
    fn a_triangle_is_inserted_where_it_has_a_point_and_rarely_elsewhere() {
        let l = lattice();
        let mut state = 1u64;
        let mut random = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let (mut by_triangle, mut by_bounds) = (0, 0);
        for _ in 0..200 {
            let corners = [0; 3].map(|_| l.bounds.max * DVec3::new(random(), random(), random()));
            let cells = cells_of(|out| of_triangle(&l, corners, 1e-6, out));
            let by_box = cells_of(|out| of_box(&l, &Aabb::around(corners), 1e-6, out));
            for p in points(corners) {
                let in_cells = l.to_cells(p);
                let cell = [0, 1, 2].map(|axis| l.cell_at(axis, in_cells[axis]));
                assert!(cells.contains(&(l.index(cell) as u32)));
            }
            assert!(cells.iter().all(|c| by_box.contains(c)));
            by_triangle += cells.len();
            by_bounds += by_box.len();
        }
        assert!(2 * by_triangle < by_bounds, "{by_triangle} of {by_bounds}");
    }

    #[test]
    fn a_needle_is_inserted_along_its_whole_length() {
        let l = lattice();
        for k in 1..200 {
            let (a, b) = (DVec3::new(0.1, 0.3, 0.05), DVec3::new(1.9, 3.0, 0.2 + k as f64 * 0.004));
            // The third corner is on the line between the others, except for rounding.
            let c = a + (k as f64 / 200.0) * (b - a);
            let cells = cells_of(|out| of_triangle(&l, [a, b, c], 1e-6, out));
            for p in (0..=1000).map(|i| a + i as f64 / 1000.0 * (b - a)) {
                let in_cells = l.to_cells(p);
                let cell = [0, 1, 2].map(|axis| l.cell_at(axis, in_cells[axis]));
                assert!(cells.contains(&(l.index(cell) as u32)), "{k}");
            }
        }
    }

    #[test]
    fn a_needle_whose_short_side_is_a_few_roundings_is_inserted_along_its_whole_length() {
        let l = lattice();
        for k in 0..343 {
            let (a, b) = (DVec3::new(0.1, 0.3, 0.05), DVec3::new(1.9, 3.0 + 0.002 * f64::from(k), 0.8));
            let ulps = [k % 7, k / 7 % 7, k / 49].map(|i| f64::from(i - 3) * f64::EPSILON);
            let c = b * (1.0 + DVec3::from_array(ulps));
            for corners in [[a, b, c], [b, c, a], [c, a, b], [b, a, c]] {
                let cells = cells_of(|out| of_triangle(&l, corners, 1e-6, out));
                for p in (0..=1000).map(|i| a + f64::from(i) / 1000.0 * (b - a)) {
                    let in_cells = l.to_cells(p);
                    let cell = [0, 1, 2].map(|axis| l.cell_at(axis, in_cells[axis]));
                    assert!(cells.contains(&(l.index(cell) as u32)), "{k} {corners:?}");
                }
            }
        }
    }

    #[test]
    fn a_triangle_is_inserted_into_padded_cells_that_it_only_comes_near() {
        let (l, padding) = (lattice(), 0.25);
        let corners = [[1.1, 0.3, 0.2], [7.3, 6.9, 2.2], [2.7, 4.4, 7.7]].map(DVec3::from);
        let cells = cells_of(|out| of_triangle(&l, corners.map(|cell| cell * l.cell_size), padding, out));
        for at in points(corners) {
            for near in (0..8)
                .map(|i| at + 0.24 * DVec3::from([i & 1, i >> 1 & 1, i >> 2].map(|b| 2.0 * b as f64 - 1.0)))
            {
                let cell = [0, 1, 2].map(|axis| l.cell_at(axis, near[axis]));
                assert!(cells.contains(&(l.index(cell) as u32)), "{near}");
            }
        }
    }

    #[test]
    fn a_triangle_in_a_layer_is_not_inserted_beside_its_outline() {
        let l = lattice();
        let corner = |cells: [f64; 3]| l.cell_size * DVec3::from_array(cells);
        for axis in 0..3 {
            let turned = |mut cells: [f64; 3]| {
                cells.rotate_right(axis);
                corner(cells)
            };
            let corners = [[0.5, 0.5, 2.5], [7.5, 7.5, 2.5], [7.4, 7.5, 2.5]].map(turned);
            let cells = cells_of(|out| of_triangle(&l, corners, 1e-6, out));
            assert!((8..=22).contains(&cells.len()), "{axis} {}", cells.len());
        }
    }
}
