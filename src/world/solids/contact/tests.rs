use super::*;

/// The vertices that the tests use, by index.
const POINTS: [[f64; 3]; 20] = [
    [0.0, 0.0, 0.0],   // 0: the shared vertex
    [2.0, 0.0, 0.0],   // 1: with 2, the first triangle
    [0.0, 2.0, 0.0],   // 2
    [-1.0, 0.0, 0.0],  // 3: opposite to 1
    [0.0, -1.0, 0.0],  // 4: opposite to 2
    [1.0, 1.0, 0.0],   // 5: on the edge of 1 and 2
    [0.5, 0.5, 0.0],   // 6: within the triangle
    [3.0, 3.0, 0.0],   // 7: beyond the edge
    [1.0, 0.0, 0.0],   // 8: on the edge of 0 and 1
    [0.5, 0.5, 1.0],   // 9: above the triangle
    [0.5, 0.5, -1.0],  // 10: below it
    [-1.0, -1.0, 1.0], // 11: above, beside it
    [-1.0, -1.0, -1.0],
    [4.0, 4.0, 1.0], // 13: above, beyond the edge
    [4.0, 4.0, -1.0],
    [-1.0, 1.0, 0.0], // 15: beside it in its plane
    [1.0, -1.0, 0.0],
    [0.5, 0.5, 2.0], // 17
    [4.0, 0.0, 0.0], // 18: beyond 1
    [9.0, 9.0, 0.5], // 19
];

/// Turns and mirrors of space that keep the numbers exact, and one that does not.
fn placed(kind: usize, [x, y, z]: [f64; 3]) -> DVec3 {
    match kind {
        0 => DVec3::new(x, y, z),
        1 => DVec3::new(z, x, y),
        2 => DVec3::new(y + 0.5, z - 3.0, -x),
        3 => DVec3::new(x + y, y - z, z + 2.0 * x),
        _ => DVec3::new(-x * 1024.0, y * 0.25, z + y - 7.0),
    }
}

/// Whether the triangle of the first three points and the one of these meet properly, in whatever order and place.
fn meets(ids: [u32; 3]) -> bool {
    let face = |kind, ids: [u32; 3]| MeshFace { ids, corners: ids.map(|i| placed(kind, POINTS[i as usize])) };
    let [a, b, c] = ids;
    let orders = [[a, b, c], [b, c, a], [c, a, b], [c, b, a], [a, c, b], [b, a, c]];
    let base = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1]];
    let mut found = vec![];
    for (kind, one, other) in
        (0..5).flat_map(|k| base.map(|one| (k, one))).flat_map(|(k, one)| orders.map(|o| (k, one, o)))
    {
        let (one, other) = (face(kind, one), face(kind, other));
        found.extend([meet_properly(&one, &other), meet_properly(&other, &one)]);
    }
    assert!(found.iter().all(|&one| one == found[0]), "{ids:?}");
    found[0]
}

#[test]
fn triangles_without_a_shared_vertex_must_be_apart() {
    for (ids, expected) in [
        // In one plane: beside, around, within, across, and touching.
        ([3, 4, 15], true),
        ([3, 4, 16], true),
        ([7, 18, 19], true),
        ([8, 6, 5], false),
        ([3, 4, 7], false),
        ([8, 4, 16], false),
        // In two planes: above, through, beside, and touching with a vertex or with an edge.
        ([9, 13, 17], true),
        ([9, 10, 13], false),
        ([11, 12, 3], true),
        ([13, 14, 7], true),
        ([9, 13, 6], false),
        ([9, 13, 8], false),
        ([9, 13, 7], true),
        ([9, 7, 18], true),
        ([9, 8, 5], false),
        ([9, 3, 4], true),
        ([9, 3, 7], false),
        ([11, 14, 3], false),
        ([11, 14, 7], true),
        ([11, 10, 14], false),
    ] {
        assert_eq!(meets(ids), expected, "{ids:?}");
    }
}

#[test]
fn triangles_with_a_shared_vertex_must_be_apart_beside_it() {
    for (ids, expected) in [
        // In one plane: opposite, beside, touching along an edge, within and around.
        ([0, 3, 4], true),
        ([0, 4, 16], true),
        ([0, 3, 15], true),
        ([0, 15, 7], false),
        ([0, 18, 4], false),
        ([0, 8, 16], false),
        ([0, 6, 4], false),
        ([0, 6, 5], false),
        ([0, 16, 15], false),
        // With the other edge in two planes: above, through both, and only with one vertex in the plane.
        ([0, 9, 13], true),
        ([0, 9, 10], false),
        ([0, 11, 12], true),
        ([0, 13, 14], false),
        ([0, 11, 14], false),
        ([0, 11, 10], true),
        ([0, 9, 12], true),
        ([0, 9, 3], true),
        ([0, 9, 15], true),
        ([0, 9, 6], false),
        ([0, 9, 7], false),
        ([0, 9, 18], false),
        ([0, 9, 8], false),
        ([0, 19, 14], false),
    ] {
        assert_eq!(meets(ids), expected, "{ids:?}");
    }
}

#[test]
fn triangles_with_a_shared_edge_must_not_be_folded_over() {
    for (ids, expected) in [
        ([0, 1, 4], true),
        ([0, 1, 16], true),
        ([0, 1, 9], true),
        ([0, 1, 10], true),
        ([0, 1, 6], false),
        ([0, 1, 15], false),
        ([1, 2, 7], true),
        ([1, 2, 3], false),
        ([0, 1, 2], false),
    ] {
        assert_eq!(meets(ids), expected, "{ids:?}");
    }
}

#[test]
fn a_triangle_has_an_axis_along_which_it_has_an_area() {
    let face = |corners: [[f64; 3]; 3]| MeshFace { ids: [0, 1, 2], corners: corners.map(DVec3::from) };
    let tiny = 2f64.powi(-60);
    for (axis, corners) in [
        (Some(2), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
        (Some(0), [[5.0, 0.0, 0.0], [5.0, 1.0, 0.0], [5.0, 0.0, 1.0]]),
        (Some(1), [[0.0, 5.0, 0.0], [1.0, 5.0, 0.0], [0.0, 5.0, 1.0]]),
        (Some(2), [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0 + 4.0 * f64::EPSILON, 0.0]]),
        (Some(2), [[tiny, tiny, 0.0], [1.0, 1.0, 0.0], [0.1, 0.1, 0.0]]),
        (None, [[0.0; 3], [1.0, 2.0, 3.0], [2.0, 4.0, 6.0]]),
        (None, [[0.1; 3], [0.1; 3], [0.7; 3]]),
    ] {
        let expected = axis.filter(|&axis| turn(axis, face(corners).corners) != 0);
        assert_eq!(face(corners).axis(), expected, "{corners:?}");
    }
}
