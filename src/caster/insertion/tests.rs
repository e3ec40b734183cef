use super::*;
use crate::caster::block::Frame;
use crate::math::double_double::Dd;
use crate::math::ray::Ray;
use crate::math::worst_case::Rng;
use crate::world::shape::Form;

fn lattice() -> Lattice {
    Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::new(2.0, 4.0, 1.0) }, [8, 8, 8])
}

/// Returns the cells that `insert` appends to an empty list.
fn cells_of(insert: impl Fn(&mut Vec<u32>)) -> Vec<u32> {
    let mut out = vec![];
    insert(&mut out);
    out
}

/// Returns the cells of the lattice, each with its box.
fn cell_boxes(l: &Lattice) -> impl Iterator<Item = (u32, Aabb)> + '_ {
    (0..512).map(|i| [i % 8, i / 8 % 8, i / 64]).map(|c| {
        let min = l.bounds.min + l.cell_size * DVec3::from_array(c.map(|x| x as f64));
        (l.index(c) as u32, Aabb { min, max: min + l.cell_size })
    })
}

#[test]
fn a_ball_is_inserted_wherever_it_is_within_padded_cells() {
    let l = lattice();
    let (center, radius) = (DVec3::new(0.9, 1.7, 0.4), 0.55);
    for padding in [0.0, 0.25] {
        let cells = cells_of(|out| of_ball(&l, center, radius, padding, out));
        for (index, b) in cell_boxes(&l) {
            let b = Aabb { min: b.min - padding * l.cell_size, max: b.max + padding * l.cell_size };
            let nearest = center.distance(center.clamp(b.min, b.max));
            assert!(cells.contains(&index) || nearest > radius, "{index}");
        }
        assert!(cells.len() < 200, "{}", cells.len());
    }
}

/// The sphere's surface is almost a plane, close to the faces of cells.
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
            let cell = l.cell_at(found).map(|i| i as usize);
            if found.clamp(DVec3::ZERO, DVec3::from_array(l.cells().map(|n| n as f64))) == found {
                let cells = cells_of(|out| of_ball(&l, sphere.center, radius, 1e-5, out));
                assert!(cells.contains(&(l.index(cell) as u32)), "{radius:e} {k}: {found}");
            }
        }
    }
}

/// The error bound must count the rounding of the radius, which is more than the padding here.
#[test]
fn the_surface_of_a_huge_sphere_is_inserted_where_it_passes_through_cells() {
    let l = lattice();
    for (far, wall) in [(1e13, 3), (-1e13, 4)] {
        // The surface is practically the plane x = 1, where cells 3 and 4 meet.
        let cells = cells_of(|out| of_ball(&l, DVec3::new(1.0 + far, 2.0, 0.5), 1e13, 1e-6, out));
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
        let bounds = Aabb { min: low, max: high };
        let all: usize = runs_of_box(&l, &bounds, 1e-6).map(|run| run.len()).sum();
        assert_eq!((all, count_of_box(&l, &bounds, 1e-6)), (tested, tested as u64), "{high}");
    }
    // A box outside counts as in the nearest cell.
    for (at, cell) in [(100.0, [7; 3]), (-100.0, [0; 3])] {
        let bounds = Aabb { min: DVec3::splat(at), max: DVec3::splat(at) };
        let cells: Vec<usize> = runs_of_box(&l, &bounds, 0.0).flatten().collect();
        assert_eq!(cells, [l.index(cell)]);
    }
}

/// The plane of the triangle passes through about a fifth of the cells that its box touches.
#[test]
fn a_triangle_is_inserted_where_it_has_a_point_and_not_beside_its_plane() {
    let (l, corners) =
        (lattice(), [DVec3::new(0.1, 0.2, 0.1), DVec3::new(1.9, 0.7, 0.2), DVec3::new(0.3, 3.8, 0.9)]);
    let cells = cells_of(|out| of_triangle(&l, corners, 1e-6, out));
    for (i, j) in (0..=100).flat_map(|i| (0..=100 - i).map(move |j| (i, j))) {
        let [u, v] = [i, j].map(|k| f64::from(k) / 100.0);
        let point = corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]);
        let cell = l.cell_at(l.to_cells(point)).map(|i| i as usize);
        assert!(cells.contains(&(l.index(cell) as u32)), "{point}");
    }
    let in_box = count_of_box(&l, &Aabb::around(corners), 1e-6) as usize;
    assert!(3 * cells.len() < in_box, "{} of {in_box}", cells.len());
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
            let cell = l.cell_at(in_cells).map(|i| i as usize);
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
                let cell = l.cell_at(in_cells).map(|i| i as usize);
                assert!(cells.contains(&(l.index(cell) as u32)), "{k} {corners:?}");
            }
        }
    }
}

#[test]
fn cells_are_padded_by_the_face_error_bound_and_that_of_positions() {
    let lattice = Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::ONE }, [4096, 2, 3]);
    let more = padding(&lattice) - face_error_bound(&lattice);
    assert!((0.9 * POSITION_ERROR_BOUND..1.1 * POSITION_ERROR_BOUND).contains(&more), "{more}");
}

/// `proofs/box8.g` assumes this for the boxes of trees, which end at the corners of padded cells. Cells far from the
/// origin are not smaller than `widened` makes them.
#[test]
fn the_corners_of_cells_are_off_by_at_most_two_roundings_of_single_precision() {
    let (rng, mut largest) = (&mut Rng(1), 0.0f64);
    for _ in 0..20_000 {
        let (min, extent) = (rng.vector(), libm::exp2(-60.0 * rng.unit()) * rng.vector().abs());
        let bounds = widened(Aabb { min, max: min + extent });
        let counts = [0, 1, 2].map(|_| 1 + rng.below(50));
        let lattice = Lattice::new(bounds, counts);
        let (scale, padding) = (Frame::new(&bounds).scale, padding(&lattice));
        let cell = counts.map(|count| rng.below(count as u64));
        let corner = |cells: DVec3| lattice.bounds.min + cells * lattice.cell_size;
        let low = DVec3::from_array(cell.map(|i| i as f64));
        let padded = Aabb { min: corner(low - padding), max: corner(low + (1.0 + padding)) };
        for axis in 0..3 {
            let (first, count) = (bounds.min[axis], Dd::from(counts[axis] as f64));
            let whole = Dd::difference(bounds.max[axis], first);
            let off = |corner: f64, cells: Dd| {
                (Dd::difference(corner, first) * count - cells * whole).value() / count.value() * scale
            };
            let cells = [cell[axis], cell[axis] + 1].map(|cells| Dd::from(cells as f64));
            let below = off(padded.min[axis], cells[0] - padding.into());
            let above = off(padded.max[axis], cells[1] + padding.into());
            largest = largest.max(below.abs()).max(above.abs());
        }
    }
    let roundings = largest * libm::exp2(24.0);
    assert!((0.5..=2.0).contains(&roundings), "{roundings}");
}
