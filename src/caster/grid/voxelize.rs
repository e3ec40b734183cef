//! Insertion: which cells of a lattice a box, a sphere or a triangle touches. Cells are padded, so that the
//! cell that the DDA visits at the t of a hit always lists the primitive.

mod triangle;

use crate::caster::grid::lattice::Lattice;
use crate::caster::grid::touched_cells::TouchedCells;
use crate::math::aabb::Aabb;
use crate::math::robust::UNIT_ROUNDOFF;
use glam::DVec3;
pub use triangle::of_triangle;

/// Appends the index of every cell that a box touches, where each cell is padded by `padding` cells.
pub fn of_box(lattice: &Lattice, bounds: &Aabb, padding: f64, out: &mut TouchedCells) {
    let range = CellRange::new(lattice, lattice.to_cells(bounds.min), lattice.to_cells(bounds.max), padding);
    range.push_if(lattice, out, |_| true)
}

/// The same cells, as runs of indices along x.
pub fn runs_of_box(
    lattice: &Lattice,
    bounds: &Aabb,
    padding: f64,
) -> impl Iterator<Item = std::ops::Range<usize>> {
    let range = CellRange::new(lattice, lattice.to_cells(bounds.min), lattice.to_cells(bounds.max), padding);
    let CellRange { start: [x0, y0, z0], end: [x1, y1, z1] } = range;
    let run = move |y: u32, z: u32| {
        let first = lattice.index([x0, y, z].map(|i| i as usize));
        first..first + (x1 - x0) as usize
    };
    (z0..z1).flat_map(move |z| (y0..y1).map(move |y| run(y, z)))
}

/// The number of cells that a box touches, where each cell is padded by `padding` cells.
pub fn count_of_box(lattice: &Lattice, bounds: &Aabb, padding: f64) -> u64 {
    let range = CellRange::new(lattice, lattice.to_cells(bounds.min), lattice.to_cells(bounds.max), padding);
    (0..3).map(|axis| u64::from(range.end[axis] - range.start[axis])).product()
}

/// Appends the index of every cell whose centre is at most the radius plus half the cell's diagonal away from
/// the centre of the ball, where each cell is padded by `padding` cells. This is the course's rule for
/// spheres. It includes every cell that the ball touches.
pub fn of_ball_by_centers(
    lattice: &Lattice,
    center: DVec3,
    radius: f64,
    padding: f64,
    out: &mut TouchedCells,
) {
    let size = lattice.cell_size;
    let max_distance = radius + (0.5 + padding) * size.length();
    let range = CellRange::new(
        lattice,
        lattice.to_cells(center - max_distance),
        lattice.to_cells(center + max_distance),
        0.0,
    );
    range.push_if(lattice, out, |cell| {
        let cell_center = lattice.bounds.min + (cell + 0.5) * size;
        cell_center.distance(center) <= max_distance
    })
}

/// Appends the index of every cell that the surface of a sphere touches, where each cell is padded by
/// `padding` cells. Cells in the interior of the sphere are left out, since no ray hits the sphere there.
pub fn of_sphere(lattice: &Lattice, center: DVec3, radius: f64, padding: f64, out: &mut TouchedCells) {
    let (center_in_cells, size) = (lattice.to_cells(center), lattice.cell_size);
    let range = CellRange::new(
        lattice,
        lattice.to_cells(center - radius),
        lattice.to_cells(center + radius),
        padding,
    );
    let square = radius * radius;
    range.push_if(lattice, out, |cell| {
        let (min, max) = (cell - padding, cell + (1.0 + padding));
        let nearest = (center_in_cells - center_in_cells.clamp(min, max)) * size;
        let farthest = (center_in_cells - min).abs().max((max - center_in_cells).abs()) * size;
        // For a radius of very many cells the padding is lost in rounding.
        let touches_ball = nearest.length_squared() <= square * (1.0 + SPHERE_ROUNDINGS * UNIT_ROUNDOFF);
        touches_ball && farthest.length_squared() >= square * (1.0 - SPHERE_ROUNDINGS * UNIT_ROUNDOFF)
    })
}

/// Error bound of a squared distance from a sphere's centre and of the points that a ray finds on the sphere, in
/// roundings of the squared radius: see `proofs/spheres.g`.
const SPHERE_ROUNDINGS: f64 = 128.0;

/// A box of cells, as a half-open range of coordinates along each axis; never empty.
struct CellRange {
    start: [u32; 3],
    end: [u32; 3],
}

impl CellRange {
    /// The cells between two points in units of cells, padded by `padding` cells. Points outside the lattice
    /// count as in the nearest cell.
    #[inline(always)]
    fn new(lattice: &Lattice, min: DVec3, max: DVec3, padding: f64) -> Self {
        // The conversion saturates at 0, and maps NaN to 0.
        let cell = |x: f64, axis: usize| (x as u32).min(lattice.cells()[axis] as u32 - 1);
        let (min, max) = ((min - padding).to_array(), (max + padding).to_array());
        Self {
            start: [0, 1, 2].map(|axis| cell(min[axis], axis)),
            end: [0, 1, 2].map(|axis| cell(max[axis], axis) + 1),
        }
    }

    /// Whether there is more than one cell along each axis.
    #[inline(always)]
    fn spans_cells(&self) -> [bool; 3] {
        [0, 1, 2].map(|axis| self.end[axis] > self.start[axis] + 1)
    }

    /// The index of the first cell.
    #[inline(always)]
    fn first(&self, lattice: &Lattice) -> u32 {
        let [sx, sy, sz] = lattice.tables.strides;
        (self.start[0] + 1) * sx + (self.start[1] + 1) * sy + (self.start[2] + 1) * sz
    }

    /// Appends all cells of a range that extends along one axis only.
    #[inline(always)]
    fn push_line(&self, lattice: &Lattice, axis: usize, out: &mut TouchedCells) {
        let mut index = self.first(lattice);
        out.reserve(self.end[axis] - self.start[axis]);
        for _ in self.start[axis]..self.end[axis] {
            out.push(index);
            index += lattice.tables.strides[axis];
        }
    }

    /// Appends the cells for which `is_touched` holds; its argument is the cell's lower corner in units of
    /// cells.
    #[inline(always)]
    fn push_if(&self, lattice: &Lattice, out: &mut TouchedCells, is_touched: impl Fn(DVec3) -> bool) {
        let [x0, y0, z0] = self.start;
        for z in z0..self.end[2] {
            for y in y0..self.end[1] {
                let start = lattice.index([x0, y, z].map(|i| i as usize)) as u32;
                out.reserve(self.end[0] - x0);
                for (x, index) in (x0..self.end[0]).zip(start..) {
                    if is_touched(DVec3::new(x.into(), y.into(), z.into())) {
                        out.push(index);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::ray::Ray;
    use crate::primitive::shape::Form;
    use crate::primitive::sphere::Sphere;

    pub fn lattice() -> Lattice {
        Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::new(2.0, 4.0, 1.0) }, [8, 8, 8])
    }

    /// The cells that `insert` appends to an empty list.
    pub fn cells_of(insert: impl Fn(&mut TouchedCells)) -> Vec<u32> {
        let mut out = TouchedCells::default();
        insert(&mut out);
        out.indices
    }

    /// The cells of the lattice, each with its box.
    fn cell_boxes(l: &Lattice) -> impl Iterator<Item = (u32, Aabb)> + '_ {
        (0..512).map(|i| [i % 8, i / 8 % 8, i / 64]).map(|c| {
            let min = l.bounds.min + l.cell_size * DVec3::from_array(c.map(|x| x as f64));
            (l.index(c) as u32, Aabb { min, max: min + l.cell_size })
        })
    }

    #[test]
    fn a_sphere_is_inserted_exactly_where_its_surface_is() {
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

    /// The sphere's surface is all but a plane, close to the faces of cells.
    #[test]
    fn a_sphere_of_very_many_cells_is_listed_where_a_ray_finds_it() {
        let l = Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::new(1.1, 1.3, 0.7) }, [11, 13, 7]);
        for radius in [1e9, 1e11, 1e13, 1e15].map(|cells| cells * l.cell_size.x) {
            for k in 1..200 {
                let (y, z) = ((0.618 * k as f64) % 1.0, (0.414 * k as f64) % 1.0);
                let aside = DVec3::new(0.3 * y, 0.9 * z, 0.5);
                let direction = DVec3::new(1.0, y - 0.5, z - 0.5) * if k % 2 == 0 { 1.0 } else { -1.0 };
                // The surface passes the point at a corner of cells.
                let corner = DVec3::new(5.0, (k % 13) as f64, (k % 7) as f64) * l.cell_size;
                let outward = (DVec3::X + 1e-3 * aside).normalize();
                let sphere = Sphere { center: corner - radius * outward, radius };
                let target = corner + 1e-9 * aside;
                let ray = Ray::new(target - 2.0 * direction, direction);
                let Some(t) = sphere.intersect(&ray) else { continue };
                let found = l.to_cells(ray.at(t));
                let cell = [0, 1, 2].map(|axis| l.cell_at(axis, found[axis]));
                if found.clamp(DVec3::ZERO, DVec3::from_array(l.cells().map(|n| n as f64))) == found {
                    let cells = cells_of(|out| of_sphere(&l, sphere.center, radius, 1e-5, out));
                    assert!(cells.contains(&(l.index(cell) as u32)), "{radius:e} {k}: {found}");
                }
            }
        }
    }

    #[test]
    fn shapes_outside_are_inserted_into_the_nearest_cells() {
        let l = lattice();
        let far = DVec3::splat(100.0);
        let cells = cells_of(|out| {
            of_box(&l, &Aabb { min: far, max: far }, 0.0, out);
            of_triangle(&l, [-far; 3], 0.0, out);
        });
        assert_eq!(cells, [l.index([7, 7, 7]) as u32, l.index([0, 0, 0]) as u32]);
    }

    #[test]
    fn padded_cells_are_touched_from_farther_away() {
        let (l, padding) = (lattice(), 0.25);
        let (center, radius) = (DVec3::new(0.9, 1.7, 0.4), 0.55);
        let cells = cells_of(|out| of_sphere(&l, center, radius, padding, out));
        let by_centers = cells_of(|out| of_ball_by_centers(&l, center, radius, padding, out));
        for (index, b) in cell_boxes(&l) {
            let b = Aabb { min: b.min - padding * l.cell_size, max: b.max + padding * l.cell_size };
            let nearest = center.distance(center.clamp(b.min, b.max));
            let farthest = b.corners().map(|p| center.distance(p)).into_iter().fold(0.0, f64::max);
            assert_eq!(cells.contains(&index), nearest <= radius && farthest >= radius, "{index}");
            assert!(by_centers.contains(&index) || nearest > radius, "{index}");
        }
    }

    /// The error bound must count the rounding of the radius, which is more than the padding here.
    #[test]
    fn the_surface_of_a_huge_sphere_is_inserted_where_it_passes_through_cells() {
        let l = lattice();
        for (far, wall) in [(1e13, 3), (-1e13, 4)] {
            // Its surface is as good as the plane x = 1, which is where cells 3 and 4 meet.
            let cells = cells_of(|out| of_sphere(&l, DVec3::new(1.0 + far, 2.0, 0.5), 1e13, 1e-6, out));
            for (y, z) in (0..8).flat_map(|y| (0..8).map(move |z| (y, z))) {
                assert!([wall, 7 - wall].iter().all(|&x| cells.contains(&(l.index([x, y, z]) as u32))));
            }
        }
    }

    #[test]
    fn the_cells_of_a_box_are_counted() {
        let l = lattice();
        let corner = |cells: [f64; 3]| l.cell_size * DVec3::from_array(cells);
        for (high, tested) in [
            ([7.5, 4.5, 3.5], 3),
            ([5.5, 6.5, 3.5], 3),
            ([5.5, 4.5, 6.5], 4),
            ([7.5, 5.5, 3.5], 6),
            ([5.5, 6.5, 4.5], 6),
            ([7.5, 4.5, 4.5], 6),
            ([7.5, 5.5, 4.5], 12),
        ] {
            let (low, high) = (corner([5.5, 4.5, 3.5]), corner(high));
            let [mut triangle, mut all] = [0; 2].map(|_| TouchedCells::default());
            of_triangle(&l, [low, high, low.midpoint(high)], 1e-6, &mut triangle);
            of_box(&l, &Aabb { min: low, max: high }, 1e-6, &mut all);
            let counted = count_of_box(&l, &Aabb { min: low, max: high }, 1e-6);
            assert_eq!((all.indices.len(), counted), (tested, tested as u64), "{high}");
            let bounds = Aabb { min: low, max: high };
            let in_runs = runs_of_box(&l, &bounds, 1e-6).flatten();
            assert!(in_runs.eq(all.indices.iter().map(|&index| index as usize)), "{high}");
            if tested < 6 {
                assert_eq!(triangle.indices, all.indices, "{high}");
            }
        }
    }
}
