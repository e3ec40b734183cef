//! Case 71: which transforms turn a triangle inside out. Those that flatten it do not, and no plane is placed under them.

use crate::support::exact::{dot, exact3};
use crate::support::measure::{Failures, measure};
use crate::support::placed::{scene_of, world_of};
use crate::support::rays;
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use glam::{DMat3, DVec3};
use num_traits::{Signed, Zero};
use raytracer::scene::Object;
use raytracer::scene::mesh::Mesh;
use raytracer::world::World;

/// A transformation as it is written in a scene's text. Most of them mirror or flatten.
fn transformation(rng: &mut Rng) -> String {
    let numbers = |v: DVec3| format!("{} {} {}", v.x, v.y, v.z);
    match rng.below(6) {
        0 => format!("{}Rotate {}", ["X", "Y", "Z"][rng.below(3)], rng.range(-180.0, 180.0)),
        1 => format!("Rotate {{ {} {} }}", numbers(rng.direction()), rng.range(-180.0, 180.0)),
        2 => format!("Translate {}", numbers(9.0 * rng.in_cube())),
        3 => {
            let mut factor = || [0.0, 1.0, -1.0, rng.range(-2.0, 2.0)][rng.below(4)];
            format!("Scale {}", numbers(DVec3::new(factor(), factor(), factor())))
        }
        4 => format!("Scale {}", numbers(DVec3::from_array([0; 3].map(|_| rng.range(0.1, 3.0))))),
        _ => {
            // The third row is a combination of the others, exactly or but for a rounding.
            let [p, q] = [0, 1].map(|_| DVec3::from_array([0; 3].map(|_| rng.integer(99))));
            let sum = rng.integer(9) * p + rng.integer(9) * q;
            let sum = if rng.below(2) == 0 { sum } else { sum.with_x(sum.x.next_up()) };
            format!("Matrix {{ {} 0 {} 0 {} 0 0 0 0 1 }}", numbers(p), numbers(q), numbers(sum))
        }
    }
}

/// The linear part of the matrix of one transform around an object.
fn matrix_of(text: &str) -> DMat3 {
    let object = format!("Transform {{ {text} Sphere {{ center 0 0 0 radius 1 }} }}");
    let scene = scene_of(&[object], "");
    let matrices = scene.objects.iter().find_map(|object| match object {
        Object::Transform { matrix, .. } => Some(matrix.map.matrix3),
        _ => None,
    });
    matrices.expect("a transform")
}

/// The sign of a determinant in rational arithmetic.
fn exact_sign(m: DMat3) -> i32 {
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(exact3);
    let minor = |i: usize, j: usize| &x[i] * &y[j] - &x[j] * &y[i];
    let determinant = dot(&z, &[minor(1, 2), minor(2, 0), minor(0, 1)]);
    i32::from(determinant.is_positive()) - i32::from(determinant.is_negative())
}

/// Counts for one list of transformations: triangles turned the wrong way, planes that are placed although they are
/// flattened, triangles that the rounded product turns the wrong way, and lists that flatten.
fn one(rng: &mut Rng, failures: &Failures, index: u64) -> [u64; 4] {
    let list: Vec<String> = (0..2 + rng.below(4)).map(|_| transformation(rng)).collect();
    let is_nested = rng.below(2) == 0;
    let under = |object: &str| match is_nested {
        true => {
            list.iter().rev().fold(object.to_string(), |inner, one| format!("Transform {{ {one} {inner} }}"))
        }
        false => format!("Transform {{ {} {object} }}", list.join(" ")),
    };
    // A matrix is multiplied from the left, which changes no determinant.
    let sign: i32 = list.iter().map(|text| exact_sign(matrix_of(text))).product();
    let triangle = under("Triangle { vertex0 0 0 0 vertex1 1 0 0 vertex2 0 1 0 }");
    let no_mesh = Mesh { vertices: vec![], triangles: vec![] };
    let world = world_of(&scene_of(&[triangle], ""), &no_mesh);
    let expected = if sign < 0 { [0, 2, 1] } else { [0, 1, 2] };
    let wrong = world.triangles != [expected];
    let plane = scene_of(&[under("Plane { normal 1 2 3 offset 0.5 }")], "");
    let refused = World::new(&plane, &[]).is_err_and(|error| error.message.contains("singular"));
    let placed = sign.is_zero() && !refused;
    failures.note(wrong || placed, || format!("list {index}: {list:?} has the sign {sign}"));
    let textbook = (matrix_of(&list.join(" ")).determinant() < 0.0) != (sign < 0);
    [wrong, placed, textbook, sign.is_zero()].map(u64::from)
}

#[test]
fn case_68_transforms_that_mirror_or_flatten() {
    const SEED: u64 = 1068;
    let lists = rays(20_000, 1_000_000);
    let failures = Failures::default();
    let ([wrong, placed, textbook, flat], []) =
        measure(lists, |index| (one(&mut Rng::at(SEED, index), &failures, index), []));
    Record {
        case: 71,
        basis: Basis::Sampled,
        name: "triangles and planes under transforms that mirror or flatten",
        inputs: format!("{lists} lists of 2 to 5 transformations, {flat} of which flatten"),
        measure: "triangles turned the wrong way by the product of exact determinants, planes that are placed although flattened",
        textbook: format!("the sign of the determinant of the product in f64: {textbook} triangles"),
        ours: format!("{wrong}, {placed}"),
        target: "0, 0",
    }
    .write();
    assert!(textbook > 100 && flat > lists / 10 && flat < lists, "the case tests nothing");
    assert_eq!([wrong, placed], [0, 0]);
}
