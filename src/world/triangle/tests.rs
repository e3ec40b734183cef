//! Tests the exact test with rays through edges and vertices, and with triangles without area.

use super::*;
use crate::world::edge_functions::edge_error_bound;

fn test(origin: DVec3, direction: DVec3, triangle: [DVec3; 3]) -> Option<f64> {
    Shear::new(&Ray::new(origin, direction)).intersect(triangle.each_ref())
}

#[test]
fn normals_are_right_at_every_size() {
    for size in [1e-300, 1e-150, 1e-72, 1e-68, 1.0, 1e68, 1e72, 1e150, 1e300] {
        let t = [DVec3::ZERO, size * DVec3::X, size * DVec3::Y];
        for (t, expected) in [(t, DVec3::Z), ([t[0], t[2], t[1]], -DVec3::Z)] {
            assert!((normal(t) - expected).length() < f64::EPSILON, "{size:e}");
        }
    }
}

#[test]
fn a_triangle_on_one_line_is_missed_and_leaves_no_gap() {
    // Two small triangles share the long side of another, and a triangle without area fills the seam. Its
    // third corner lies exactly on that side.
    let (p, q) = (DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.7, -0.4, 0.9));
    let [p, q] = [p, q].map(|v| v.as_vec3().as_dvec3());
    let m = 0.5 * (p + q);
    let (left, right) = (DVec3::new(-1.0, 2.0, 0.5), DVec3::new(1.5, 1.0, -2.0));
    for i in 0..2000 {
        let origin = DVec3::new(3.0, libm::sin(i as f64), 4.0);
        let direction = p.lerp(q, i as f64 / 2000.0) - origin;
        assert_eq!(test(origin, direction, [p, m, q]), None);
        let around = [[p, q, left], [q, m, right], [m, p, right]];
        assert_eq!(around.into_iter().filter(|&t| test(origin, direction, t).is_some()).count(), 1);
    }
}

/// Rays and two points as bit patterns: direction, origin, p and q. The computed edge function of p and q has the wrong
/// sign. Hill climbing made it as large as possible: 0.77, 0.84, 0.73 and 0.86 of the error bound.
#[rustfmt::skip]
const WORST: [[u64; 12]; 4] = [
    // The points are close to the ray compared with their distance along it,
    [0x3ff462c58f4473e3, 0xbff462c3841b646e, 0x3ff462c58f44750b, 0xbf9b3fd515406c23, 0xbf7f07473e70177b, 0x3fa5aadbc27c8810,
     0x3ff214a44971a339, 0xbff2a0a9036de5f1, 0x3ff32efa75fa281b, 0x3fefc2872847eff0, 0xbff06d4893ecf834, 0x3ff0fb99cc6d40e1],
    [0x3ff45ed4a899c19f, 0xbff45ed4335adb09, 0x3ff45ed4a899c2c6, 0x3f41c9cd9afe4c11, 0xbfa84c83c5eb512e, 0x3f8761b2bd743c40,
     0x3ff0b268385069c3, 0xbff17285bcb7a993, 0x3ff0def37c1dca1e, 0x3ff0135ce8b24de6, 0xbff0d39470bbc60d, 0x3ff03fe5fc7400ba],
    // about as far from it as along it,
    [0x3ff371ef42ed53df, 0xbff3ee97e4517352, 0x3ff3ee97e4519fe5, 0xbfee4ca3c40e83d8, 0x3fde46a795de4ee7, 0xbfcc3017a5b4ed30,
     0x3fc2e4a518224cb4, 0xbfe213ee9afceda3, 0x3fecd576874e7d3b, 0x3fc2bd5bf9fc151b, 0xbfe767fedf6a0f8d, 0x3fecd512b61cfb1f],
    // and no farther from it than the rounding errors.
    [0x3ff07312bf37470e, 0x3ff06b597f3fef5c, 0x3ff07313ffa0c5bb, 0x3fe3c84e95f06e43, 0x3feedf2b40d8ffd9, 0xbfd1ca6b47eec18a,
     0x3ffb2201614a5234, 0x400052aba04015ce, 0x3fe99681285b7b8a, 0x3ffb195c6b31c49c, 0x40004e5b2cc6698f, 0x3fe985373ad99da2],
];

/// Returns the rays, each with its p and q.
fn worst() -> [(Ray, [DVec3; 2]); 4] {
    WORST.map(|bits| {
        let vector = |i: usize| DVec3::from_array([0, 1, 2].map(|k| f64::from_bits(bits[3 * i + k])));
        (Ray::new(vector(1), vector(0)), [vector(2), vector(3)])
    })
}

#[test]
fn the_worst_error_of_an_edge_function_is_between_two_thirds_and_all_of_the_bound() {
    for (ray, [p, q]) in worst() {
        let sheared = [p, q, p].map(|v| Shear::new(&ray).apply(&v));
        let [_, _, found] = edge_functions(sheared);
        let exact = projected_area(ray.direction, [ray.origin, p, q]).sign();
        assert!(exact as f64 * found < 0.0, "the case tests nothing: {exact} {found}");
        let ratio = found.abs() / edge_error_bound(sheared);
        assert!((2.0 / 3.0..1.0).contains(&ratio), "{ratio}");
    }
}

#[test]
fn a_ray_beside_an_edge_where_rounding_is_worst_hits_one_triangle() {
    for (ray, [p, q]) in worst() {
        let shear = Shear::new(&ray);
        let [x, y, z] = shear.axes;
        // Returns a point beside the edge, `times` as far from the ray as p is.
        let beside = |times: f64| {
            let seen = shear.apply(&p);
            let mut point = p;
            point[x] = ray.origin[x] + shear.slopes[0] * seen.z - times * seen.y;
            point[y] = ray.origin[y] + shear.slopes[1] * seen.z + times * seen.x;
            point[z] = p[z];
            point
        };
        let triangles = [[p, q, beside(0.9)], [q, p, beside(-1e5)]];
        let hits = triangles.iter().filter(|t| shear.intersect(t.each_ref()).is_some()).count();
        assert_eq!(hits, 1, "{ray:?}");
    }
}
