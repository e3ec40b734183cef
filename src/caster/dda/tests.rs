use super::*;
use crate::math::aabb::Aabb;
use glam::DVec3;

fn unit(n: [usize; 3]) -> Lattice {
    Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::ONE }, n)
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
fn steps_wrap_on_overflow() {
    let mut t = FixedT::new([i32::MAX; 4]);
    assert_eq!(t.step(FixedT::new([1; 4])), 0);
    assert_eq!(t.min3(), i32::MIN);
}
