//! Surfaces in one place, and surfaces in a boundary of their own checkerboard.

use crate::support::{Folder, Tga};

/// A view from above of an object with a checkerboard whose texture has this transform.
fn board(texture: &str, object: &str) -> String {
    format!(
        "PerspectiveCamera {{ center 0.3 4.1 9.7 direction 0.02 -1.2 -1 up 0 1 0 angle 50 }}
         Lights {{ numLights 1 DirectionalLight {{ direction 0 -1 0 color 1 1 1 }} }}
         Background {{ color 0 1 0 ambientLight 0 0 0 }}
         Materials {{ numMaterials 3 Material {{ diffuseColor 1 0 0 }} Material {{ diffuseColor 0 0 1 }}
           Checkerboard {{ Transform {{ {texture} }} materialIndex 0 materialIndex 1 }} }}
         Group {{ numObjects 1 MaterialIndex 2 {object} }}"
    )
}

fn square(half: u32) -> String {
    format!(
        "v -{half} 0 -{half}\nv -{half} 0 {half}\nv {half} 0 {half}\nv {half} 0 -{half}\nf 1 2 3\nf 1 3 4\n"
    )
}

fn rendered(text: &str, half: u32, flags: &str) -> Tga {
    let folder = Folder::with_scene(text);
    folder.write("flat.obj", square(half));
    folder.render(flags)
}

#[test]
fn a_checkerboard_on_any_surface_is_that_on_the_plane_in_the_same_place() {
    let mesh = "TriangleMesh { obj_file flat.obj }";
    let plane = "Plane { normal 0 1 0 offset 0 }";
    let far = "Translate 900 700 -800 YRotate 20 ZRotate 30";
    let back = "ZRotate -30 YRotate -20 Translate -900 -700 800";
    let disc = "Transform { Scale 50 1e-30 50 Sphere { center 0 0 0 radius 1 } }";
    for (texture, transform, object, plane) in [
        ("UniformScale 5", "", "Box { min -50 -1 -50 max 50 0.6 50 }", "Plane { normal 0 1 0 offset 0.6 }"),
        (
            "UniformScale 5",
            "",
            "Triangle { vertex0 -100 0.6 -100 vertex1 0 0.6 100 vertex2 100 0.6 -100 }",
            "Plane { normal 0 1 0 offset 0.6 }",
        ),
        ("ZRotate -20", "ZRotate 20", mesh, plane),
        ("UniformScale 3 XRotate 11 ZRotate -20", "ZRotate 20 XRotate -11", mesh, plane),
        ("YRotate 33", "", disc, plane),
        (&format!("UniformScale 0.3 {back} {far}"), "", mesh, plane),
        ("UniformScale 7", &format!("{far} {back}"), mesh, plane),
    ] {
        let under = |object: &str| match transform {
            "" => object.to_string(),
            _ => format!("Transform {{ {transform} {object} }}"),
        };
        for half in [50, 500] {
            for flags in ["-size 120 120", "-size 50 50 -jittered_samples 4", "-size 120 120 -grid 5 5 5"] {
                let [found, expected] =
                    [object, plane].map(|object| rendered(&board(texture, &under(object)), half, flags));
                let (red, blue) = (|p: &[u8; 3]| p[0] > 0, |p: &[u8; 3]| p[2] > 0);
                assert!(expected.pixels.iter().any(red) && expected.pixels.iter().any(blue));
                // The brightness of an ellipsoid may be rounded to another byte.
                let differs = |(one, other): (&[u8; 3], &[u8; 3])| {
                    [0, 1, 2].iter().any(|&i| one[i].abs_diff(other[i]) > 1)
                };
                let count = found.pixels.iter().zip(&expected.pixels).filter(|&pair| differs(pair)).count();
                assert_eq!(count, 0, "{texture} {object} {half} {flags}");
            }
        }
    }
}

#[test]
fn a_mesh_in_a_boundary_of_its_checkerboard_is_pointed_out() {
    let mesh = "Transform { ZRotate 20 TriangleMesh { obj_file flat.obj } }";
    let said = |texture: &str| {
        let folder = Folder::with_scene(&board(texture, mesh));
        folder.write("flat.obj", square(500));
        folder.run("-input s.txt -size 99 99 -pixel 40 60").ok().stdout
    };
    let close = "close call: the point lies in a boundary of the checkerboard within roundings\n";
    assert!(said("ZRotate -20").contains(close));
    assert!(!said("Translate 0 0.1 0 ZRotate -20").contains(close));
}

/// A red object and a blue one.
fn pair(red: &str, blue: &str) -> String {
    format!(
        "PerspectiveCamera {{ center 0.3 0.4 5 direction -0.02 -0.03 -1 up 0 1 0 angle 40 }}
         Background {{ color 0 0 0 ambientLight 1 1 1 }}
         Materials {{ numMaterials 2 Material {{ diffuseColor 1 0 0 }} Material {{ diffuseColor 0 0 1 }} }}
         Group {{ numObjects 2 MaterialIndex 0 {red} MaterialIndex 1 {blue} }}"
    )
}

/// Of each pair the lower object is seen, as if the other one were a little farther away.
#[test]
fn of_two_surfaces_in_one_place_one_is_seen_throughout() {
    let triangle = |z: &str| format!("Triangle {{ vertex0 -1 -1 {z} vertex1 1 -1 {z} vertex2 0 1 {z} }}");
    let turned = |z: &str| format!("Triangle {{ vertex0 1 -1 {z} vertex1 0 1 {z} vertex2 -1 -1 {z} }}");
    let other =
        |z: &str| format!("Triangle {{ vertex0 -0.9 -0.7 {z} vertex1 1.3 -0.8 {z} vertex2 0.2 1.1 {z} }}");
    let plane = |z: &str| format!("Plane {{ normal 0 0 1 offset {z} }}");
    let cuboid = |z: &str| format!("Box {{ min -1 -1 -1 max 1 1 {z} }}");
    let turned_cuboid =
        |z: &str| format!("Transform {{ ZRotate 17 Box {{ min -0.5 -0.5 -1 max 1.1 1 {z} }} }}");
    let turned_plane =
        |z: &str| format!("Transform {{ ZRotate 17 Scale 3 1 1 Plane {{ normal 0 0 1 offset {z} }} }}");
    let rotation = "Rotate { 0.6 0.8 0 33 }";
    let far = "Translate 300 200 -100 XRotate 40 XRotate -40 Translate -300 -200 100";
    type Object<'a> = &'a dyn Fn(&str) -> String;
    let pairs: [(Object, Object); 7] = [
        (&cuboid, &plane),
        (&triangle, &plane),
        (&triangle, &turned),
        (&other, &triangle),
        (&plane, &turned_plane),
        (&cuboid, &turned_cuboid),
        (&turned_cuboid, &turned_plane),
    ];
    for (one, another) in pairs {
        for transform in ["Scale 1 1 1", rotation, far, "YRotate 20 Scale 1 0.3 2 UniformScale 0.7"] {
            let under = |object: String| format!("Transform {{ {transform} {object} }}");
            for [red, blue] in [[one, another], [another, one]] {
                let both = pair(&under(red("0.3")), &under(blue("0.3")));
                let found = rendered(&both, 1, "-size 90 90");
                for flags in ["-grid 4 4 4", "-stats", "-grid none"] {
                    let same = rendered(&both, 1, &format!("-size 90 90 {flags}")) == found;
                    assert!(same, "{flags} {both}");
                }
                let behind = pair(&under(red("0.3")), &under(blue("0.299999")));
                // Of boxes the other sides are seen, too, whose edges move by little.
                assert!(differing(&found, &rendered(&behind, 1, "-size 90 90")) < 3, "{both}");
            }
        }
    }
}

fn differing(one: &Tga, other: &Tga) -> usize {
    one.pixels.iter().zip(&other.pixels).filter(|(one, other)| one != other).count()
}

/// However two squares are cut into triangles, the lower one is seen, as if the other one were a little farther away.
#[test]
fn of_two_meshes_in_one_place_the_lower_one_is_seen_throughout() {
    let cuts = ["f 1 2 3\nf 3 4 1\n", "f 1 2 3\nf 1 3 4\n", "f 4 2 3\nf 2 4 1\n", "f 3 4 1 2\n"];
    let square = |half: f64, cut: &str| {
        let corner = |[x, y]: [f64; 2]| format!("v {} {} 0.3\n", half * x, half * y);
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(corner);
        corners.concat() + cut
    };
    for (one, other) in cuts.iter().flat_map(|one| cuts.map(|other| (one, other))) {
        for transform in ["Scale 1 1 1", "Rotate { 0.6 0.8 0 33 }"] {
            let under = |height: f64, mesh: &str| {
                format!(
                    "Transform {{ {transform} Translate 0 0 {height} TriangleMesh {{ obj_file {mesh} }} }}"
                )
            };
            let shown = |height: f64| {
                let folder = Folder::with_scene(&pair(&under(0.0, "a.obj"), &under(height, "b.obj")));
                folder.write("a.obj", square(1.0, one));
                folder.write("b.obj", square(0.9, other));
                folder.render("-size 40 40")
            };
            assert_eq!(shown(0.0), shown(-1e-6), "{one} {other} {transform}");
        }
    }
}

/// Turning a scene does not change which side of a flattened triangle is its front.
#[test]
fn a_flattened_triangle_shows_its_front_however_it_is_turned() {
    for turn in (0..360).step_by(7) {
        for flattening in ["XRotate 25 Scale 1 0 1 ZRotate 20", "Scale 2 0 1 XRotate 40 Rotate { 1 2 3 5 }"] {
            let text = format!(
                "OrthographicCamera {{ center 0 9 0 direction 0 -1 0 up 0 0 -1 size 9 }}
                 Background {{ color 0 1 0 ambientLight 1 1 1 }}
                 Materials {{ numMaterials 1 Material {{ diffuseColor 1 0 0 }} }}
                 Group {{ numObjects 1 MaterialIndex 0 Transform {{ YRotate {turn} {flattening}
                   Triangle {{ vertex0 -2 -1 1 vertex1 2 -1 1 vertex2 0 1 -2 }} }} }}"
            );
            let pixels = Folder::with_scene(&text).render("-size 60 60").pixels;
            let red = pixels.iter().filter(|&&pixel| pixel == [255, 0, 0]).count();
            let empty = pixels.iter().filter(|&&pixel| pixel == [0, 255, 0]).count();
            assert!(red > 60 && red + empty == pixels.len(), "{turn} {flattening}: {red} and {empty}");
        }
    }
}

/// What is nearer is seen, and a checkerboard keeps its squares, however far away a corner of a triangle is.
#[test]
fn a_corner_far_away_changes_nothing_near_the_others() {
    for transform in ["", "ZRotate 20 XRotate 10", "Translate 0.3 0.2 0.1 YRotate 5"] {
        let under = |object: &str| match transform {
            "" => object.to_string(),
            _ => format!("Transform {{ {transform} {object} }}"),
        };
        let pictures = ["1e6", "1e12", "1e16", "1e30"].map(|far| {
            let near = "Triangle { vertex0 -0.9 -0.9 0.5 vertex1 0.9 -0.9 0.5 vertex2 0 0.9 0.5 }";
            let behind =
                format!("Triangle {{ vertex0 1.5 1.2 0 vertex1 -1.5 1.2 0 vertex2 0.3 -{far} -{far} }}");
            let both = pair(&under(near), &under(&behind));
            let floor = format!("Triangle {{ vertex0 -9 0.25 9 vertex1 9 0.25 9 vertex2 0 0.25 -{far} }}");
            ["-size 60 60 -shade_back", "-size 60 60 -shade_back -grid 3 3 3"].map(|flags| {
                [rendered(&both, 1, flags), rendered(&board("Scale 1 2 1", &under(&floor)), 1, flags)]
            })
        });
        let [near, ..] = &pictures;
        let red = near[0][0].pixels.iter().filter(|&&pixel| pixel == [255, 0, 0]).count();
        assert!(red > 100, "{red}");
        for one in pictures.iter().flatten() {
            for (found, expected) in one.iter().zip(&near[0]) {
                let count =
                    found.pixels.iter().zip(&expected.pixels).filter(|(one, other)| one != other).count();
                // The far part of the floor and of the other triangle ends at a horizon.
                assert!(count < 40, "{count} {transform}");
            }
        }
    }
}
