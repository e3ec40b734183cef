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
