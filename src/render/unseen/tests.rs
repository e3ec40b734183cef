use super::*;
use crate::scene::parser::parse;

const ABOVE: &str = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 8 }";
/// With the same view of the plane z = 0.
const AHEAD: &str = "PerspectiveCamera { center 0 0 4 direction 0 0 -1 up 0 1 0 angle 90 }";
const SIZE: [usize; 2] = [8, 8];

/// A corner that shows a material at some depth, or nothing.
fn corner(seen: Option<(u32, f32)>) -> Corner {
    let depth = seen.map_or(f32::INFINITY, |(_, depth)| depth);
    Corner { color: glam::Vec3A::ZERO, hidden: 0.0, material: seen.map(|(material, _)| material), depth }
}

/// What is known of the pixels of a scene with these objects, from the bottom, if all corners show the same.
fn variances(camera: &str, objects: &[&str], seen: Option<(u32, f32)>) -> Vec<[f32; 8]> {
    let text = format!(
        "{camera} Materials {{ numMaterials 2 Material {{ }} Material {{ }} }}
         Group {{ numObjects {} MaterialIndex 0 {} }}",
        objects.len(),
        objects.join(" ")
    );
    let scene = parse(&text).unwrap();
    let world = World::new(&scene, &[]).unwrap();
    let request = Request::new(SIZE);
    let unseen = Unseen::new(&Camera::new(&scene.camera, SIZE), &world, &request);
    let rows = |rows: Range<usize>| {
        let known = unseen.rows(rows.clone());
        let variance =
            |row| std::array::from_fn(|column| known.variance(&unseen, [column, row], &[corner(seen); 4]));
        rows.map(variance).collect::<Vec<[f32; 8]>>()
    };
    let all = rows(0..8);
    // Some rows know what all of them know.
    assert_eq!([rows(0..3), rows(3..4), rows(4..8)].concat(), all);
    all
}

fn marked(variances: &[[f32; 8]]) -> Vec<[usize; 2]> {
    let places = (0..8).flat_map(|row| (0..8).map(move |column| [column, row]));
    places.filter(|[column, row]| variances[*row][*column] > 0.0).collect()
}

/// A sphere, an ellipsoid and a triangle in the middle of pixels.
const SMALL_THINGS: [&str; 3] = [
    "Sphere { center 1.5 -1.5 0 radius 0.1 }",
    "Transform { Translate -2.5 2.5 0 Scale 0.2 0.1 0.01 Sphere { center 0 0 0 radius 1 } }",
    "Triangle { vertex0 2.4 2.4 0 vertex1 2.6 2.4 0 vertex2 2.4 2.6 0 }",
];

#[test]
fn a_small_thing_has_the_variance_of_what_it_covers() {
    for camera in [ABOVE, AHEAD] {
        let found = variances(camera, &SMALL_THINGS, None);
        assert_eq!(marked(&found), [[5, 2], [1, 6], [6, 6]], "{camera}");
        let parts =
            [([5, 2], std::f32::consts::PI * 0.01), ([1, 6], std::f32::consts::PI * 0.02), ([6, 6], 0.02)];
        for ([column, row], part) in parts {
            let ratio = found[row][column] / (part * (1.0 - part));
            // In perspective the box of a solid is larger than what it covers.
            let most = if camera == ABOVE { 1.1 } else { 2.0 };
            assert!((0.9..most).contains(&ratio), "{camera} {column} {row} {ratio}");
        }
    }
}

#[test]
fn what_corners_show_in_front_hides_small_things() {
    assert_eq!(marked(&variances(ABOVE, &SMALL_THINGS, Some((1, 3.0)))), [[0; 2]; 0]);
    let before = variances(ABOVE, &SMALL_THINGS, Some((1, 6.0)));
    assert_eq!(before, variances(ABOVE, &SMALL_THINGS, None));
    // What is of the same material is likely to have the same colour.
    let same = variances(ABOVE, &SMALL_THINGS, Some((0, 6.0)));
    assert!(
        same.iter().flatten().zip(before.iter().flatten()).all(|(a, b)| a <= b && (*a > 0.0) == (*b > 0.0))
    );
}

#[test]
fn a_needle_is_in_the_pixels_that_it_touches() {
    for camera in [ABOVE, AHEAD] {
        let needle = "Triangle { vertex0 -3.7 -2.73 0 vertex1 -3.7 -2.69 0 vertex2 3.6 2.2 0 }";
        let found = variances(camera, &[needle], None);
        for k in 0..1000 {
            let along = f64::from(k) / 1000.0;
            let place = [-3.7 + along * 7.3 + 4.0, -2.71 + along * 4.91 + 4.0].map(|x| x as usize);
            assert!(found[place[1]][place[0]] > 0.0, "{camera} {place:?}");
        }
        assert!(marked(&found).len() < 20);
        let area: f32 = found.iter().flatten().sum();
        assert!((0.1..0.2).contains(&area), "{area}");
    }
}

#[test]
fn of_large_things_only_the_ends_are_marked() {
    let triangle = "Triangle { vertex0 -3.5 -3.5 0 vertex1 3.5 -3.5 0 vertex2 -3.5 3.5 0 }";
    let found = variances(ABOVE, &[triangle], None);
    assert_eq!(marked(&found), [[0, 0], [7, 0], [0, 7]]);
    let found = variances(ABOVE, &["Sphere { center 0.5 0.5 0 radius 2.2 }"], None);
    assert_eq!(marked(&found), [[4, 2], [2, 4], [6, 4], [4, 6]]);
}

#[test]
fn what_is_behind_the_eye_is_not_marked() {
    let behind =
        ["Triangle { vertex0 -1 0 9 vertex1 1 0 9 vertex2 0 0.01 9 }", "Sphere { center 0 0 9 radius 0.01 }"];
    assert_eq!(marked(&variances(AHEAD, &behind, None)), [[0; 2]; 0]);
    let partly = "Triangle { vertex0 -100 -1 100 vertex1 100 -1 100 vertex2 0 -1 -4.1 }";
    // Its tip is at depth 8.1, an eighth of the picture's height below the middle.
    assert_eq!(marked(&variances(AHEAD, &[partly], None)), [[4, 3]]);
}

#[test]
fn materials_hide_what_they_may_show() {
    let of = |material: &str, bounces: u32| {
        let text = format!(
            "{ABOVE} Materials {{ numMaterials 2 Material {{ }} {material} }} Group {{ numObjects 0 }}"
        );
        let effects = Effects { bounces, ..Effects::default() };
        materials(&World::new(&parse(&text).unwrap(), &[]).unwrap(), &effects)[1].0
    };
    assert_eq!(of("Material { diffuseColor 1 1 1 }", 9), 0.0);
    let mirror = "Material { reflectiveColor 0.5 0.5 0.5 }";
    assert_eq!([0, 1].map(|bounces| of(mirror, bounces)), [0.0, 0.25 * IN_MIRROR]);
    assert_eq!(of("Material { transparentColor 1 0 0 }", 1), IN_GLASS);
    // It may show something as bright as itself.
    assert_eq!(of("Material { diffuseColor 3 0 0 reflectiveColor 1 1 1 }", 1), 9.0 * IN_MIRROR);
    assert_eq!(of("Material { specularColor 1 1 1 exponent 5 }", 0), 0.0);
    assert_eq!(of("Material { specularColor 2 1 1 exponent 500 }", 0), IN_HIGHLIGHT);
    assert_eq!(of("Checkerboard { materialIndex 0 materialIndex 0 }", 0), IN_TEXTURE);
}
