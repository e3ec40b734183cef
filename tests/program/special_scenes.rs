//! Scenes and pictures at the limits: singular transforms, deep nesting, no finite object, endless
//! reflection, few rows.

use crate::support::{CAMERA, Folder, scene};

#[test]
fn a_triangle_under_a_singular_transform_is_still_a_triangle() {
    let flattened = "Transform { Scale 1 1 0 Triangle { vertex0 -1 -1 5 vertex1 1 -1 -3 vertex2 0 1 2 } }";
    let plain = "Triangle { vertex0 -1 -1 0 vertex1 1 -1 0 vertex2 0 1 0 }";
    let pictures = [flattened, plain].map(|o| Folder::with_scene(&scene(1, o)).render("-size 20 20"));
    assert_eq!(pictures[0], pictures[1]);
    assert_eq!(pictures[0].at(10, 10), [255; 3]);
}

#[test]
fn planes_alone_render_with_a_grid() {
    let folder = Folder::with_scene(&scene(1, "Plane { normal 0 1 1 offset 0 }"));
    let plain = folder.render("-size 8 8");
    assert!(plain.pixels.iter().all(|&pixel| pixel == [180; 3]), "255 cos 45 degrees");
    assert_eq!(folder.render("-size 8 8 -grid 4 4 4"), plain);
    let cells = folder.render("-size 8 8 -grid 4 4 4 -visualize_grid");
    assert!(cells.pixels.iter().all(|&pixel| pixel == [127; 3]), "no cell, only background");
}

#[test]
fn an_empty_scene_is_all_background() {
    let text = format!("{CAMERA}Background {{ color .2 .4 1 }} Group {{ numObjects 0 }}");
    let folder = Folder::with_scene(&text);
    for flags in ["", "-grid 2 2 2", "-grid 2 2 2 -visualize_grid", "-uniform_samples 4 -shadows"] {
        let picture = folder.render(&format!("-size 3 2 {flags}"));
        assert_eq!(picture.pixels, [[51, 102, 255]; 6], "{flags}");
    }
    folder.run("-input s.txt -size 3 2 -depth 0 1 d.tga -normals n.tga").ok();
    assert_eq!([folder.tga("d.tga"), folder.tga("n.tga")].map(|p| p.pixels), [[[0; 3]; 6], [[0; 3]; 6]]);
}

/// A camera inside a mirroring sphere.
fn hall_of_mirrors(reflective: &str) -> String {
    format!(
        "PerspectiveCamera {{ center .1 .2 .3 direction 0 0 -1 up 0 1 0 angle 90 }}
         Background {{ color 0 0 0 ambientLight 1 1 1 }}
         Lights {{ numLights 1 PointLight {{ position 0 0 0 color 0 0 0 }} }}
         Group {{ numObjects 1 Material {{ diffuseColor .5 .5 .5 reflectiveColor {reflective} }}
           Sphere {{ center 0 0 0 radius 1 }} }}"
    )
}

#[test]
fn a_hall_of_mirrors_ends_by_weight() {
    // Each bounce has .5 times the light of the one before, and .5 sqrt(3) times its weight.
    let folder = Folder::with_scene(&hall_of_mirrors(".5 .5 .5"));
    let line = "-input s.txt -output o.tga -size 4 4 -shade_back -bounces 2147483647 -weight 1e-6 -stats";
    let run = folder.run(line).ok();
    let bounces = (0..).take_while(|&n| 0.75f64.sqrt().powi(n) > 1e-6).count();
    let rays = format!("\n  num non-shadow rays        {}\n", 16 * bounces);
    assert!(run.stdout.contains(&rays), "{}\nexpected{rays}", run.stdout);
    assert!(folder.tga("o.tga").greys().iter().all(|&grey| grey >= 254), "1/2 + 1/4 + ... = 1");
}

#[test]
fn a_hall_of_perfect_mirrors_ends_by_bounces() {
    let folder = Folder::with_scene(&hall_of_mirrors("1 1 1"));
    let run = folder.run("-input s.txt -size 2 2 -shade_back -bounces 100000 -stats").ok();
    assert!(run.stdout.contains("\n  num non-shadow rays        400004\n"), "{}", run.stdout);
}

/// Rays that split at each of a million bounces are refused while those that wait still fit into memory.
#[test]
fn rays_that_split_without_end_are_an_error() {
    let folder = Folder::with_scene(
        "PerspectiveCamera { center .1 .2 .3 direction 3 2 1 up 0 1 0 angle 40 }
         Lights { numLights 0 } Materials { numMaterials 1
         Material { reflectiveColor 1 1 1 transparentColor 1 1 1 } }
         Group { numObjects 2 MaterialIndex 0 Box { min -1 -1 -1 max 1 1 1 } Box { min -2 -2 -2 max 2 2 2 } }",
    );
    folder.write("o.tga", "old");
    let message = folder.run("-input s.txt -size 2 2 -shade_back -bounces 1000000 -output o.tga").message(1);
    assert!(message.contains("the rays of one pixel split without end"), "{message}");
    assert_eq!(folder.names(), ["o.tga", "s.txt"]);
    assert_eq!(folder.read("o.tga"), b"old");
}
