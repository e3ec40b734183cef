use super::*;
use crate::scene::mesh;
use crate::world::solids::tests::{MESH, SUN, glass, prism, world as world_of};

type File = mesh::Mesh;

const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
const HOOK: [[f64; 2]; 6] = [[0.0, 0.0], [4.0, 0.0], [4.0, 0.5], [0.5, 0.5], [0.5, 4.0], [0.0, 4.0]];

/// Whether a mesh is embedded and around its inside, under a transform.
fn is_embedded_under(transform: &str, file: &File) -> bool {
    let object = format!("Transform {{ {transform} {MESH} }}");
    let world = world_of(&[], &[&glass(&object)], file);
    let solid = embedded(&world, &(0..world.triangles.len() as u32));
    solid.inspect(|solid| assert_eq!(solid.bounds, world.bounds)).is_some()
}

/// The same in several places.
fn is_embedded(file: &File) -> bool {
    let places = ["", "XRotate 40 ZRotate 9", "Scale 1 -2 .3 YRotate 33", "Translate 3 -2 7 XRotate 90"];
    let found = places.map(|place| is_embedded_under(place, file));
    assert!(found.iter().all(|&one| one == found[0]), "{found:?}");
    found[0]
}

/// The mesh of two, of which the second one is scaled and moved.
fn both(one: &File, other: &File, scale: f64, to: [f64; 3]) -> File {
    let first = one.vertices.len() as u32;
    let moved = other.vertices.iter().map(|&v| scale * v + DVec3::from(to));
    let faces = other.triangles.iter().map(|face| face.map(|i| i + first));
    File {
        vertices: one.vertices.iter().copied().chain(moved).collect(),
        triangles: one.triangles.iter().copied().chain(faces).collect(),
    }
}

fn inside_out(file: &File) -> File {
    let turned = |&[a, b, c]: &[u32; 3]| [a, c, b];
    File { vertices: file.vertices.clone(), triangles: file.triangles.iter().map(turned).collect() }
}

/// A torus of this many cells around, and half as many across.
fn torus(around: u32, thickness: f64) -> File {
    let across = around / 2;
    let vertex = |i: u32, j: u32| {
        let [u, v] = [f64::from(i) / f64::from(around), f64::from(j) / f64::from(across)]
            .map(|turns| turns * std::f64::consts::TAU);
        let radius = 2.0 + thickness * libm::cos(v);
        DVec3::new(radius * libm::cos(u), radius * libm::sin(u), thickness * libm::sin(v))
    };
    let cells = || (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let id = |i: u32, j: u32| (i % around) * across + j % across;
    let faces = |(i, j)| {
        let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    File {
        vertices: cells().map(|(i, j)| vertex(i, j)).collect(),
        triangles: cells().flat_map(faces).collect(),
    }
}

#[test]
fn closed_meshes_that_do_not_touch_themselves_are_embedded() {
    let square = prism(&SQUARE, false);
    assert!(is_embedded(&square) && is_embedded(&prism(&HOOK, false)));
    assert!(is_embedded(&torus(24, 0.7)) && is_embedded(&torus(8, 1.5)));
    assert!(is_embedded(&both(&square, &square, 2.0, [1.5, 0.25, 0.0])));
    assert!(!is_embedded(&prism(&SQUARE, true)) && !is_embedded(&File::default()));
}

#[test]
fn meshes_that_are_turned_inside_out_are_not_solids() {
    let (square, torus) = (prism(&SQUARE, false), torus(24, 0.7));
    assert!(!is_embedded(&inside_out(&square)) && !is_embedded(&inside_out(&torus)));
    // One of two apart is turned.
    assert!(!is_embedded(&both(&square, &inside_out(&square), 1.0, [3.0, 0.0, 0.0])));
    // A hollow is around the outside, and a cube within a cube is twice inside.
    let within = [0.25, 0.3, 0.2];
    assert!(is_embedded(&both(&square, &inside_out(&square), 0.5, within)));
    assert!(!is_embedded(&both(&square, &square, 0.5, within)));
    // Also if the two are so close that a point before the inner one is outside of both.
    assert!(!is_embedded(&both(&square, &square, 1.0 - 2e-8, [1e-8; 3])));
    let filled = both(&square, &inside_out(&square), 0.5, within);
    assert!(is_embedded(&both(&filled, &square, 0.25, [0.35, 0.4, 0.3])));
}

#[test]
fn meshes_that_touch_themselves_are_not_embedded() {
    let square = prism(&SQUARE, false);
    for (is_apart, to) in [
        (false, [0.5, 0.25, 0.2]),
        (false, [1.0, 0.0, 0.0]),
        (false, [1.0, 0.5, 0.25]),
        (false, [1.0, 1.0, 0.0]),
        (false, [1.0, 1.0, 1.0]),
        (false, [0.0, 0.0, 0.0]),
        (true, [1.0 + 1e-15, 0.0, 0.0]),
        (true, [1.25, 0.0, 0.0]),
    ] {
        let object = both(&square, &square, 1.0, to);
        assert_eq!(is_embedded_under("", &object), is_apart, "{to:?}");
    }
    // A handle that passes through itself, and corners that are not the same points but in the same place.
    assert!(!is_embedded(&torus(24, 2.5)));
    let mut split = square.clone();
    split.vertices.extend_from_within(..);
    split.triangles[0] = split.triangles[0].map(|i| i + 8);
    assert!(!is_embedded(&split));
}

#[test]
fn a_face_that_is_folded_or_without_area_is_not_embedded() {
    let mut folded = prism(&SQUARE, false);
    let n = folded.vertices.len() as u32;
    folded.vertices.push(DVec3::new(0.5, 0.5, 0.0));
    assert!(is_embedded(&folded));
    // The same two faces, seen from both sides, upon the base: all edges are balanced.
    folded.triangles.extend([[0, 1, n], [0, n, 1]]);
    assert!(!is_embedded(&folded));
    // A face without area fills the gap where one of two faces at an edge is split.
    let mut split = folded.clone();
    split.triangles.truncate(12);
    split.vertices[n as usize] = DVec3::new(0.5, 0.0, 0.0);
    split.triangles.retain(|&face| face != [0, 2, 1]);
    split.triangles.extend([[0, 2, n], [n, 2, 1], [0, n, 1]]);
    assert!(!is_embedded_under("", &split));
    let mut flat = prism(&SQUARE, false);
    flat.vertices.extend([DVec3::new(0.5, 0.0, 9.0), DVec3::new(0.5, 0.0, 9.5), DVec3::new(0.5, 0.0, 9.75)]);
    flat.triangles.extend([[n, n + 1, n + 2], [n, n + 2, n + 1]]);
    assert!(!is_embedded(&flat));
}

/// Cubes that share a vertex or an edge do not touch otherwise. Two that share an edge are two components.
#[test]
fn components_are_joined_by_edges_of_two_faces() {
    let square = prism(&SQUARE, false);
    let sharing = |to: [f64; 3], other: &File| {
        let mut mesh = both(&square, other, 1.0, to);
        for i in 8..16 {
            let same = mesh.vertices[..8].iter().position(|&v| v == mesh.vertices[i]);
            let Some(same) = same else { continue };
            let renamed = |id: &mut u32| *id = if *id == i as u32 { same as u32 } else { *id };
            mesh.triangles.iter_mut().flatten().for_each(renamed);
        }
        mesh
    };
    let count = |mesh: &File| {
        let edges = sorted_edges(&mesh.triangles);
        components(mesh.triangles.len(), &edges).len()
    };
    for to in [[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]] {
        let mesh = sharing(to, &square);
        assert_eq!((count(&mesh), is_embedded(&mesh)), (2, true), "{to:?}");
        assert!(!is_embedded(&sharing(to, &inside_out(&square))), "{to:?}");
    }
    // The two faces between cubes side by side are the same.
    assert!(!is_embedded(&sharing([1.0, 0.0, 0.0], &square)));
    assert_eq!((count(&torus(8, 0.5)), count(&both(&square, &square, 1.0, [3.0; 3]))), (1, 2));
}

#[test]
fn too_many_components_are_not_looked_at() {
    let square = prism(&SQUARE, false);
    let row = |count: u32| {
        (1..count).fold(square.clone(), |all, i| both(&all, &square, 1.0, [2.0 * f64::from(i), 0.0, 0.0]))
    };
    let edge = (MAX_VISITS as f64 / 12.0).sqrt() as u32;
    assert!(is_embedded_under("", &row(edge)) && !is_embedded_under("", &row(edge + 1)));
}

/// Every mesh that is found becomes a solid, in the order of ids.
#[test]
fn solids_with_embedded_meshes_know_more() {
    let hook = prism(&HOOK, false);
    let place = |x: u32| glass(&format!("Transform {{ Translate {x} 0 0 {MESH} }}"));
    let cube = glass("Box { min 20 0 0 max 21 1 1 }");
    let ball = glass("Sphere { center 30 0 0 radius 1 }");
    let bead = glass("Sphere { center 40.25 3 .5 radius .1 }");
    let world = world_of(&[SUN], &[&place(0), &cube, &place(40), &ball, &bead], &hook);
    assert_eq!((world.triangles.len(), world.solids.undecided_triangles()), (52, 40));
    let solids = world.solids.with_embedded(&world).unwrap();
    for id in 0..54 {
        let is_old = (20..32).contains(&id) || id >= 52;
        assert_eq!((world.solids.are_dark_within(id), solids.are_dark_within(id)), (is_old, true), "{id}");
        let is_empty = !(32..52).contains(&id);
        assert_eq!(world.solids.are_empty_within(id), is_old, "{id}");
        assert_eq!(solids.are_empty_within(id), is_empty, "{id}");
        assert_eq!(world.solids.stands_alone(id), solids.stands_alone(id), "{id}");
    }
    assert_eq!(solids.undecided_triangles(), 0);
}
