//! Which cells a shape touches.

use super::Lattice;
use super::budget::TouchedCells;
use super::cell_lists::GridTooLarge;
use crate::math::aabb::Aabb;
use crate::math::extremes::{box_corners, max3, min3};
use crate::math::robust::UNIT_ROUNDOFF;
use glam::DVec3;

/// Appends the index of every cell that the box, widened by `padding` cells, touches.
pub fn of_box(
    lattice: &Lattice,
    bounds: &Aabb,
    padding: f64,
    out: &mut TouchedCells,
) -> Result<(), GridTooLarge> {
    let range = Range::new(lattice, lattice.to_cells(bounds.min), lattice.to_cells(bounds.max), padding);
    range.enter_met(lattice, out, |_| true)
}

/// Appends the index of every cell whose centre lies within the radius and half the cell's diagonal
/// of the centre, each cell widened by `padding` cells: the course's rule for spheres. Every cell that
/// the ball touches is among them.
pub fn of_ball_by_centers(
    lattice: &Lattice,
    center: DVec3,
    radius: f64,
    padding: f64,
    out: &mut TouchedCells,
) -> Result<(), GridTooLarge> {
    let size = lattice.cell_size;
    let radius_bound = radius + (0.5 + padding) * size.length();
    let range = Range::new(
        lattice,
        lattice.to_cells(center - radius_bound),
        lattice.to_cells(center + radius_bound),
        0.0,
    );
    range.enter_met(lattice, out, |cell| {
        let middle = lattice.bounds.min + (cell + 0.5) * size;
        middle.distance(center) <= radius_bound
    })
}

/// Appends the index of every cell that the sphere's surface touches, each cell widened by `padding`
/// cells. Cells within the sphere are left out: no ray hits it there.
pub fn of_sphere(
    lattice: &Lattice,
    center: DVec3,
    radius: f64,
    padding: f64,
    out: &mut TouchedCells,
) -> Result<(), GridTooLarge> {
    let (middle, size) = (lattice.to_cells(center), lattice.cell_size);
    let range =
        Range::new(lattice, lattice.to_cells(center - radius), lattice.to_cells(center + radius), padding);
    let square = radius * radius;
    range.enter_met(lattice, out, |cell| {
        let (low, high) = (cell - padding, cell + (1.0 + padding));
        let nearest = (middle - middle.clamp(low, high)) * size;
        let farthest = (middle - low).abs().max((high - middle).abs()) * size;
        // The slack may vanish in the rounding of a radius that is large in cells.
        let reaches = nearest.length_squared() <= square * (1.0 + 1e-12);
        reaches && farthest.length_squared() >= square * (1.0 - 1e-12)
    })
}

/// Appends the index of every cell that the triangle touches, each cell widened by `padding` cells:
/// the triangle's plane and its outline along each axis must meet the cell (Schwarz, Seidel, "Fast
/// Parallel Surface and Solid Voxelization on GPUs", SIGGRAPH Asia 2010).
#[inline]
pub fn of_triangle(
    lattice: &Lattice,
    corners: [DVec3; 3],
    padding: f64,
    out: &mut TouchedCells,
) -> Result<(), GridTooLarge> {
    let v = corners.map(|p| lattice.to_cells(p));
    let [low, high] = box_corners(v);
    let range = Range::new(lattice, low, high, padding);
    let half = 0.5 + padding;
    match range.spanned() {
        [true, true, true] => {
            let solid = Solid::new(v, half);
            range.enter_met(lattice, out, |cell| solid.meets(cell + 0.5))
        }
        // In a layer of cells the outline along the layer's axis decides alone.
        [true, true, false] => range.enter_layer(lattice, &Flat::<0, 1>::new(v, half), out),
        [false, true, true] => range.enter_layer(lattice, &Flat::<1, 2>::new(v, half), out),
        [true, false, true] => range.enter_layer(lattice, &Flat::<2, 0>::new(v, half), out),
        // A row of cells along one axis is touched as a whole.
        [true, false, false] => range.enter_x_run(lattice, 0, out),
        [false, true, false] => range.enter_x_run(lattice, 1, out),
        [false, false, _] => range.enter_x_run(lattice, 2, out),
    }
}

/// A block of cells, as ranges along the axes; never empty.
struct Range {
    low: [u32; 3],
    end: [u32; 3],
}

impl Range {
    /// Between two points in units of cells, widened by `padding` cells. Points outside the lattice
    /// count as in its nearest cell.
    #[inline(always)]
    fn new(lattice: &Lattice, low: DVec3, high: DVec3, padding: f64) -> Self {
        // The conversion cuts below at 0, and gives 0 for a NaN.
        let cell = |x: f64, axis: usize| (x as u32).min(lattice.cells()[axis] as u32 - 1);
        let (low, high) = ((low - padding).to_array(), (high + padding).to_array());
        Self {
            low: [0, 1, 2].map(|axis| cell(low[axis], axis)),
            end: [0, 1, 2].map(|axis| cell(high[axis], axis) + 1),
        }
    }

    /// Whether there is more than one cell, along each axis.
    #[inline(always)]
    fn spanned(&self) -> [bool; 3] {
        [0, 1, 2].map(|axis| self.end[axis] > self.low[axis] + 1)
    }

    /// The index of the first cell.
    #[inline(always)]
    fn first(&self, lattice: &Lattice) -> u32 {
        let [sx, sy, sz] = lattice.tables.strides;
        (self.low[0] + 1) * sx + (self.low[1] + 1) * sy + (self.low[2] + 1) * sz
    }

    /// Appends all cells, which stand in a row along one axis.
    #[inline(always)]
    fn enter_x_run(
        &self,
        lattice: &Lattice,
        axis: usize,
        out: &mut TouchedCells,
    ) -> Result<(), GridTooLarge> {
        let mut index = self.first(lattice);
        out.look_at(self.end[axis] - self.low[axis])?;
        for _ in self.low[axis]..self.end[axis] {
            out.push(index);
            index += lattice.tables.strides[axis];
        }
        Ok(())
    }

    /// Appends the cells that an outline meets, of those in one layer across the third axis.
    #[inline(always)]
    fn enter_layer<const U: usize, const V: usize>(
        &self,
        lattice: &Lattice,
        outline: &Flat<U, V>,
        out: &mut TouchedCells,
    ) -> Result<(), GridTooLarge> {
        let mut start = self.first(lattice);
        for v in self.low[V]..self.end[V] {
            let mut index = start;
            out.look_at(self.end[U] - self.low[U])?;
            for u in self.low[U]..self.end[U] {
                if outline.meets([u, v].map(|i| f64::from(i) + 0.5)) {
                    out.push(index);
                }
                index += lattice.tables.strides[U];
            }
            start += lattice.tables.strides[V];
        }
        Ok(())
    }

    /// Appends the cells that are met, as `is_met` says of a cell's lower corner in units of cells.
    #[inline(always)]
    fn enter_met(
        &self,
        lattice: &Lattice,
        out: &mut TouchedCells,
        is_met: impl Fn(DVec3) -> bool,
    ) -> Result<(), GridTooLarge> {
        let [x0, y0, z0] = self.low;
        for z in z0..self.end[2] {
            for y in y0..self.end[1] {
                let start = lattice.index([x0, y, z].map(|i| i as usize)) as u32;
                out.look_at(self.end[0] - x0)?;
                for (x, index) in (x0..self.end[0]).zip(start..) {
                    if is_met(DVec3::new(x.into(), y.into(), z.into())) {
                        out.push(index);
                    }
                }
            }
        }
        Ok(())
    }
}

/// A triangle's outline projected along the third axis: its three edges as `a u + b v + c >= 0`,
/// where u and v are the coordinates of axes `U` and `V`, which follow one another. The slack by which
/// cells are widened is far above the rounding of these sums.
struct Flat<const U: usize, const V: usize> {
    edges: [[f64; 3]; 3],
}

impl<const U: usize, const V: usize> Flat<U, V> {
    /// Of a triangle in units of cells. `half` is half a cell's edge length, its slack included.
    #[inline(always)]
    fn new(v: [DVec3; 3], half: f64) -> Self {
        let [p, q, r] = v.map(|v| [v[U], v[V]]);
        let area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        // Seen from the side from which it runs counter-clockwise.
        let sign = 1f64.copysign(area);
        let edge = |from: [f64; 2], to: [f64; 2]| {
            let (a, b) = ((from[1] - to[1]) * sign, (to[0] - from[0]) * sign);
            [a, b, half * (a.abs() + b.abs()) - (a * from[0] + b * from[1])]
        };
        Self { edges: [edge(p, q), edge(q, r), edge(r, p)] }
    }

    /// Whether the cell around a centre, in units of cells, is met.
    #[inline(always)]
    fn meets(&self, [u, v]: [f64; 2]) -> bool {
        min3(self.edges.map(|[a, b, c]| a * u + b * v + c)) >= 0.0
    }
}

/// So many roundings of its length cubed a triangle's plane may be off its points: see `proofs/needles.g`.
const PLANE_ROUNDINGS: f64 = 32.0;
/// A triangle's plane and its three outlines.
struct Solid {
    normal: DVec3,
    offset: f64,
    /// How far the plane may be from a cell's centre, scaled by the normal.
    radius_bound: f64,
    xy: Flat<0, 1>,
    yz: Flat<1, 2>,
    zx: Flat<2, 0>,
}

impl Solid {
    /// As [`Flat::new`].
    #[inline(always)]
    fn new(v: [DVec3; 3], half: f64) -> Self {
        let sides = [v[1] - v[0], v[2] - v[1], v[0] - v[2]];
        let normal = sides[0].cross(v[2] - v[0]);
        // A needle's normal is little but rounding, in proportion to its squared length, and may point
        // anywhere; over that length its plane is off by as much again times the length.
        let length = max3(box_corners(sides.map(DVec3::abs))[1].to_array());
        let rounding = PLANE_ROUNDINGS * UNIT_ROUNDOFF * length * length * length;
        Self {
            normal,
            offset: normal.dot(v[0]),
            radius_bound: half * normal.abs().element_sum() + rounding,
            xy: Flat::new(v, half),
            yz: Flat::new(v, half),
            zx: Flat::new(v, half),
        }
    }

    /// Whether the cell around `center`, in units of cells, is met.
    #[inline(always)]
    fn meets(&self, center: DVec3) -> bool {
        let [x, y, z] = center.to_array();
        (self.normal.dot(center) - self.offset).abs() <= self.radius_bound
            && self.xy.meets([x, y])
            && self.yz.meets([y, z])
            && self.zx.meets([z, x])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice() -> Lattice {
        Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::new(2.0, 4.0, 1.0) }, [8, 8, 8])
    }

    fn cells_of(enter: impl Fn(&mut TouchedCells) -> Result<(), GridTooLarge>) -> Vec<u32> {
        let budget = crate::grid::budget::Budget::unlimited();
        let mut out = TouchedCells::new(&budget);
        enter(&mut out).unwrap();
        out.indices
    }

    fn cell_boxes(l: &Lattice) -> impl Iterator<Item = (u32, Aabb)> + '_ {
        (0..512).map(|i| [i % 8, i / 8 % 8, i / 64]).map(|c| {
            let min = l.bounds.min + l.cell_size * DVec3::from_array(c.map(|x| x as f64));
            (l.index(c) as u32, Aabb { min, max: min + l.cell_size })
        })
    }

    /// Points spread over a triangle, its corners and edges among them.
    fn points([a, b, c]: [DVec3; 3]) -> impl Iterator<Item = DVec3> {
        (0..=40)
            .flat_map(move |i| (0..=40 - i).map(move |j| (i as f64 / 40.0, j as f64 / 40.0)))
            .map(move |(u, v)| a + u * (b - a) + v * (c - a))
    }

    #[test]
    fn a_triangle_is_entered_wherever_it_has_a_point_and_hardly_elsewhere() {
        let l = lattice();
        let mut state = 1u64;
        let mut random = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let (mut entered, mut boxed) = (0, 0);
        for _ in 0..200 {
            let corners = [0; 3].map(|_| l.bounds.max * DVec3::new(random(), random(), random()));
            let cells = cells_of(|out| of_triangle(&l, corners, 1e-6, out));
            let by_box = cells_of(|out| of_box(&l, &Aabb::around(corners), 1e-6, out));
            for p in points(corners) {
                let at = l.to_cells(p);
                let cell = [0, 1, 2].map(|axis| l.cell_at(axis, at[axis]));
                assert!(cells.contains(&(l.index(cell) as u32)));
            }
            assert!(cells.iter().all(|c| by_box.contains(c)));
            entered += cells.len();
            boxed += by_box.len();
        }
        assert!(2 * entered < boxed, "{entered} of {boxed}");
    }

    #[test]
    fn a_needle_is_entered_along_its_whole_length() {
        let l = lattice();
        for k in 1..200 {
            let (a, b) = (DVec3::new(0.1, 0.3, 0.05), DVec3::new(1.9, 3.0, 0.2 + k as f64 * 0.004));
            // Between them but for rounding.
            let c = a + (k as f64 / 200.0) * (b - a);
            let cells = cells_of(|out| of_triangle(&l, [a, b, c], 1e-6, out));
            for p in (0..=1000).map(|i| a + i as f64 / 1000.0 * (b - a)) {
                let at = l.to_cells(p);
                let cell = [0, 1, 2].map(|axis| l.cell_at(axis, at[axis]));
                assert!(cells.contains(&(l.index(cell) as u32)), "{k}");
            }
        }
    }

    #[test]
    fn a_sphere_is_entered_just_where_its_surface_is() {
        let l = lattice();
        let (center, radius) = (DVec3::new(0.9, 1.7, 0.4), 0.55);
        let cells = cells_of(|out| of_sphere(&l, center, radius, 1e-6, out));
        let by_centers = cells_of(|out| of_ball_by_centers(&l, center, radius, 0.0, out));
        for (index, b) in cell_boxes(&l) {
            let nearest = center.distance(center.clamp(b.min, b.max));
            let farthest = b.corners().map(|p| center.distance(p)).into_iter().fold(0.0, f64::max);
            assert_eq!(cells.contains(&index), nearest <= radius && farthest >= radius, "{index}");
            assert!(by_centers.contains(&index) || nearest > radius);
        }
    }

    #[test]
    fn shapes_outside_go_to_the_nearest_cells() {
        let l = lattice();
        let far = DVec3::splat(100.0);
        let cells = cells_of(|out| {
            of_box(&l, &Aabb { min: far, max: far }, 0.0, out)
                .and_then(|()| of_triangle(&l, [-far; 3], 0.0, out))
        });
        assert_eq!(cells, [l.index([7, 7, 7]) as u32, l.index([0, 0, 0]) as u32]);
    }
}
