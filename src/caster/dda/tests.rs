use super::*;
use crate::math::aabb::Aabb;
use glam::DVec3;

fn unit(n: [usize; 3]) -> Lattice {
    Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::ONE }, n)
}

fn cell_coords(lattice: &Lattice, index: usize) -> [i64; 3] {
    lattice.cell_of(index).to_array().map(|i| i as i64)
}

fn is_inside(lattice: &Lattice, index: usize) -> bool {
    cell_coords(lattice, index).iter().zip(lattice.cells()).all(|(&i, n)| i >= 0 && (i as usize) < n)
}

fn cells(ray: &Ray, n: [usize; 3]) -> Vec<[i64; 3]> {
    let lattice = unit(n);
    let Some((mut dda, _)) = Dda::of_ray(&lattice, ray) else { return vec![] };
    let mut list = vec![];
    while is_inside(&lattice, dda.index) {
        list.push(cell_coords(&lattice, dda.index));
        dda.step();
    }
    list
}

#[test]
fn an_axis_parallel_ray_visits_one_line_of_cells() {
    let ray = Ray::new(DVec3::new(-1.0, 0.6, 0.1), DVec3::X);
    assert_eq!(cells(&ray, [3, 2, 1]), [[0, 1, 0], [1, 1, 0], [2, 1, 0]]);
    let reversed = Ray::new(DVec3::new(2.0, 0.6, 0.1), DVec3::NEG_X);
    assert_eq!(cells(&reversed, [3, 2, 1]), [[2, 1, 0], [1, 1, 0], [0, 1, 0]]);
}

#[test]
fn rays_start_inside_the_lattice_outside_it_or_not_at_all() {
    let inside = Ray::new(DVec3::new(0.6, 0.5, 0.5), DVec3::X);
    assert_eq!(cells(&inside, [4, 1, 1]), [[2, 0, 0], [3, 0, 0]]);
    let miss = Ray::new(DVec3::new(0.6, 1.5, 0.5), DVec3::X);
    assert!(cells(&miss, [4, 1, 1]).is_empty());
    let past = Ray::new(DVec3::new(1.6, 0.5, 0.5), DVec3::X);
    assert!(cells(&past, [4, 1, 1]).is_empty());
    let orthographic = Ray { t_min: f64::NEG_INFINITY, ..past };
    assert_eq!(cells(&orthographic, [4, 1, 1]).len(), 4);
    let directionless = Ray::new(DVec3::splat(0.5), DVec3::ZERO);
    assert!(cells(&directionless, [4, 1, 1]).is_empty());
}

/// Compares the positions on the ray at all crossings with the faces.
#[test]
fn face_crossings_are_within_their_error_bound() {
    for n in [[9, 8, 7], [64, 1, 500], [1000, 1000, 1000], [4096, 3, 2]] {
        let lattice = unit(n);
        let bound = face_error_bound(&lattice);
        for k in 0..200u32 {
            let fraction = |k: u32| (k as f64 * 0.618_034) % 1.0;
            let target = DVec3::new(fraction(k), fraction(3 * k + 1), fraction(7 * k + 2));
            let origin = DVec3::new(-1.3 + fraction(11 * k), 2.0 * fraction(5 * k) - 0.5, -0.7);
            let ray = Ray::new(origin, target - origin);
            let Some((mut dda, [entry, _])) = Dda::of_ray(&lattice, &ray) else { continue };
            while is_inside(&lattice, dda.index) {
                let t = entry + dda.exit() as f64 / dda.fixed_per_t;
                let position = lattice.to_cells(ray.at(t));
                let cell = cell_coords(&lattice, dda.index);
                for axis in 0..3 {
                    let min = cell[axis] as f64 - bound;
                    assert!(
                        position[axis] >= min && position[axis] <= min + 1.0 + 2.0 * bound,
                        "{n:?} {position} {cell:?}"
                    );
                }
                dda.step();
            }
        }
    }
}

#[test]
fn the_face_error_bound_is_that_of_the_axis_with_the_most_cells() {
    let of = |cells: f64| (cells + SETUP_ROUNDINGS) * cells * 2f64.powi(-30);
    assert_eq!(face_error_bound(&unit([3, 4096, 500])), of(4096.0));
    assert_eq!(face_error_bound(&unit([3, 2, 1])), of(3.0));
}

#[test]
fn a_fixed_t_is_the_least_that_is_not_before_its_t() {
    let ray = Ray::new(DVec3::new(-1.0, 0.5, 0.5), DVec3::X);
    let lattice = unit([4, 1, 1]);
    let (dda, [entry, _]) = Dda::of_ray(&lattice, &ray).unwrap();
    for k in [0, 1, 5, 1 << 20, (1 << 29) - 1] {
        let t = |part: f64| entry + (f64::from(k) + part) / dda.fixed_per_t;
        assert_eq!([0.25, 0.75].map(|part| dda.fixed_t(t(part))), [k + 1; 2]);
        assert!((k..=k + 1).contains(&dda.fixed_t(t(0.0))));
    }
    assert_eq!(dda.fixed_t(f64::INFINITY), T_NEVER as i32);
}

#[test]
fn a_ray_that_only_touches_the_box_has_finite_steps() {
    let ray = Ray::new(DVec3::new(-1.0, 1.0, 0.5), DVec3::new(1.0, -1.0, 0.0));
    let lattice = unit([4, 4, 4]);
    let (dda, [entry, exit]) = Dda::of_ray(&lattice, &ray).unwrap();
    assert_eq!(entry, exit);
    assert!(dda.fixed_per_t.is_finite(), "{}", dda.fixed_per_t);
}

#[test]
fn the_smallest_of_the_three_step() {
    let t_delta = FixedT::new([10, 20, 30, 0]);
    for ([x, y, z], min3, stepped, next) in [
        ([1, 2, 3], 1, 0b001, 2),
        ([3, 2, 9], 2, 0b010, 3),
        ([5, 4, -7], -7, 0b100, 4),
        ([4, 4, 9], 4, 0b011, 9),
        ([9, 4, 4], 4, 0b110, 9),
        ([4, 9, 4], 4, 0b101, 9),
        ([6, 6, 6], 6, 0b111, 16),
    ] {
        let mut t = FixedT::new([x, y, z, -9]);
        assert_eq!((t.min3(), t.step(t_delta), t.min3()), (min3, 7 - stepped, next), "{x} {y} {z}");
    }
}

#[test]
fn steps_wrap_on_overflow() {
    let mut t = FixedT::new([i32::MAX; 4]);
    assert_eq!(t.step(FixedT::new([1; 4])), 0);
    assert_eq!(t.min3(), i32::MIN);
}
