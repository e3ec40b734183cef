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
