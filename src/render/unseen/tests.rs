use super::*;
use crate::scene::parser::parse;

const ABOVE: &str = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 8 }";
/// With the same view of the plane z = 0.
const AHEAD: &str = "PerspectiveCamera { center 0 0 4 direction 0 0 -1 up 0 1 0 angle 90 }";
const SIZE: [usize; 2] = [8, 8];

/// What is known of the pixels of a scene with these objects, from the bottom.
fn variances(camera: &str, materials: &str, objects: &[&str]) -> Vec<[f64; 8]> {
    let text = format!("{camera} {materials} Group {{ numObjects {} {} }}", objects.len(), objects.join(" "));
    let scene = parse(&text).unwrap();
    let world = World::new(&scene, &[]).unwrap();
    let request = Request::new(SIZE);
    let unseen = Unseen::new(&Camera::new(&scene.camera, SIZE), &world, &request).unwrap();
    let rows = |rows: Range<usize>| {
        let known = unseen.rows(rows.clone()).unwrap();
        rows.map(|row| std::array::from_fn(|column| known.variance([column, row]))).collect::<Vec<[f64; 8]>>()
    };
    let all = rows(0..8);
    // Some rows know what all of them know.
    assert_eq!([rows(0..3), rows(3..4), rows(4..8)].concat(), all);
    all
}

const ONE: &str = "Materials { numMaterials 1 Material { } }";

fn marked(variances: &[[f64; 8]]) -> Vec<[usize; 2]> {
    let places = (0..8).flat_map(|row| (0..8).map(move |column| [column, row]));
    places.filter(|[column, row]| variances[*row][*column] > 0.0).collect()
}

#[test]
fn a_small_thing_has_the_variance_of_what_it_covers() {
    for camera in [ABOVE, AHEAD] {
        // A sphere and an ellipsoid in the middle of the pixels (5, 2) and (1, 6), and a triangle in (6, 6).
        let found = variances(
            camera,
            ONE,
            &[
                "MaterialIndex 0 Sphere { center 1.5 -1.5 0 radius 0.1 }",
                "Transform { Translate -2.5 2.5 0 Scale 0.2 0.1 0.3 Sphere { center 0 0 0 radius 1 } }",
                "Triangle { vertex0 2.4 2.4 0 vertex1 2.6 2.4 0 vertex2 2.4 2.6 0 }",
            ],
        );
        assert_eq!(marked(&found), [[5, 2], [1, 6], [6, 6]], "{camera}");
        for ([column, row], part) in [([5, 2], 0.01 * PI), ([1, 6], 0.02 * PI)] {
            let expected = part * (1.0 - part);
            assert!((found[row][column] / expected - 1.0).abs() < 0.05, "{camera} {column} {row}");
        }
        let expected = 0.02 * 0.98;
        assert!((found[6][6] / expected - 1.0).abs() < 0.3, "{camera} {}", found[6][6] / expected);
    }
}

#[test]
fn the_outlines_of_large_things_are_marked_and_their_inside_is_not() {
    let rim: Vec<[usize; 2]> = (0..8)
        .flat_map(|row| (0..8).map(move |column| [column, row]))
        .filter(|place| {
            // Pixels that a circle of radius 2.5 around the middle passes through.
            let distance = |x: usize, y: usize| (x as f64 - 4.0).hypot(y as f64 - 4.0);
            let [x, y] = *place;
            let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].map(|(x, y)| distance(x, y));
            corners.iter().any(|d| *d < 2.45) && corners.iter().any(|d| *d > 2.55)
        })
        .collect();
    let found = marked(&variances(ABOVE, ONE, &["MaterialIndex 0 Sphere { center 0 0 0 radius 2.5 }"]));
    assert!(rim.len() > 16 && rim.iter().all(|place| found.contains(place)), "{rim:?} {found:?}");
    assert!(![[3, 3], [4, 4], [0, 0], [7, 0]].iter().any(|place| found.contains(place)));
}

#[test]
fn edges_inside_a_surface_are_not_marked() {
    let obj = "v -2.5 -2.5 0\nv 2.5 -2.5 0\nv 2.5 2.5 0\nv -2.5 2.5 0\nf 1 2 3\nf 1 3 4\n";
    let mesh = crate::scene::mesh::read_obj(obj.as_bytes()).unwrap().0;
    let text = format!("{ABOVE} {ONE} Group {{ numObjects 1 MaterialIndex 0 TriangleMesh {{ obj_file m.obj }} }}");
    let scene = parse(&text).unwrap();
    let world = World::new(&scene, &[mesh]).unwrap();
    let unseen = Unseen::new(&Camera::new(&scene.camera, SIZE), &world, &Request::new(SIZE)).unwrap();
    let known = unseen.rows(0..8).unwrap();
    let is_marked = |place| known.variance(place) > 0.0;
    // The diagonal runs through the pixels in the middle.
    assert!(![[3, 3], [4, 4], [2, 2]].into_iter().any(is_marked));
    assert!([[1, 1], [4, 1], [6, 6], [1, 4], [6, 3]].into_iter().all(is_marked));
}

#[test]
fn what_is_partly_behind_the_eye_is_marked_where_it_is_seen() {
    let wide = "Triangle { vertex0 -100 -1 100 vertex1 100 -1 100 vertex2 0 -1 -4 }";
    let found = variances(AHEAD, ONE, &[&format!("MaterialIndex 0 {wide}")]);
    // Its tip is at depth 8, an eighth of the picture's height below the middle.
    assert!(found[3][3] > 0.0 || found[3][4] > 0.0, "{:?}", marked(&found));
    assert!(marked(&found).iter().all(|[_, row]| *row < 4));
    let behind = "MaterialIndex 0 Triangle { vertex0 -1 0 9 vertex1 1 0 9 vertex2 0 1 9 }";
    assert_eq!(marked(&variances(AHEAD, ONE, &[behind, "Sphere { center 0 0 9 radius 1 }"])), [[0; 2]; 0]);
    // The eye is inside of it.
    let around = "MaterialIndex 0 Sphere { center 0 0 4 radius 1 }";
    assert_eq!(marked(&variances(AHEAD, ONE, &[around])), [[0; 2]; 0]);
}

#[test]
fn materials_hide_what_they_may_show() {
    let of = |material: &str, bounces: u32| {
        let text = format!(
            "{ABOVE} Materials {{ numMaterials 2 Material {{ }} {material} }} Group {{ numObjects 0 }}"
        );
        let effects = Effects { bounces, ..Effects::default() };
        hidden(&parse(&text).unwrap().materials, &effects).unwrap()[1]
    };
    assert_eq!(of("Material { diffuseColor 1 1 1 }", 9), 0.0);
    let mirror = "Material { reflectiveColor 0.5 0.5 0.5 }";
    assert_eq!([0, 1].map(|bounces| of(mirror, bounces)), [0.0, 0.25 * IN_MIRROR]);
    assert_eq!(of("Material { transparentColor 1 0 0 }", 1), IN_GLASS);
    assert_eq!(of("Material { specularColor 1 1 1 exponent 5 }", 0), 0.0);
    assert_eq!(of("Material { specularColor 2 1 1 exponent 500 }", 0), IN_HIGHLIGHT);
    assert_eq!(of("Checkerboard { materialIndex 0 materialIndex 0 }", 0), IN_TEXTURE);
}
