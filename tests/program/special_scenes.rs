//! Scenes and pictures at the limits: singular transforms, deep nesting, no finite object, endless
//! reflection, few rows.

use crate::support::{CAMERA, Folder, Tga, scene, sphere};
use std::ops::Range;

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
    let run = folder.run("-input s.txt -output g.tga -size 8 8 -grid 4 4 4 -stats").ok();
    assert!(run.stdout.contains("\n  scene bounds               NULL\n"), "{}", run.stdout);
    assert_eq!(folder.tga("g.tga"), plain);
    assert!(plain.pixels.iter().all(|&pixel| pixel == [180; 3]), "255 cos 45 degrees");
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

#[test]
fn rays_that_split_without_end_are_an_error() {
    split_without_end(&[""]);
}

#[test]
#[ignore = "slow: ten seconds"]
fn rays_that_split_without_end_are_an_error_with_any_flags() {
    split_without_end(&["-stats", "-random_samples 4 -shadows"]);
}

/// Rays that split at each of a million bounces are refused while those that wait still fit into memory.
fn split_without_end(all_flags: &[&str]) {
    let folder = Folder::with_scene(
        "PerspectiveCamera { center .1 .2 .3 direction 3 2 1 up 0 1 0 angle 40 }
         Lights { numLights 0 } Materials { numMaterials 1
         Material { reflectiveColor 1 1 1 transparentColor 1 1 1 } }
         Group { numObjects 2 MaterialIndex 0 Box { min -1 -1 -1 max 1 1 1 } Box { min -2 -2 -2 max 2 2 2 } }",
    );
    folder.write("o.tga", "old");
    for flags in all_flags {
        let line = format!("-input s.txt -size 2 2 -shade_back -bounces 1000000 -output o.tga {flags}");
        let message = folder.run(&line).message(1);
        assert!(message.contains("the rays of one pixel split without end"), "{line}: {message}");
        assert_eq!(folder.names(), ["o.tga", "s.txt"]);
        assert_eq!(folder.read("o.tga"), b"old");
    }
}

/// The pixels of a picture in these columns and rows, counted from the top left.
fn cut(picture: &Tga, columns: Range<usize>, rows: Range<usize>) -> Vec<[u8; 3]> {
    rows.flat_map(|y| columns.clone().map(move |x| picture.at(x, y))).collect()
}

#[test]
fn the_longer_side_spans_the_view_and_the_shorter_is_cropped() {
    let perspective =
        sphere().replace(CAMERA, "PerspectiveCamera { center .2 .1 3 direction 0 0 -1 up 0 1 0 angle 30 }");
    for text in [sphere(), perspective] {
        let folder = Folder::with_scene(&text);
        let square = folder.render("-size 20 20");
        let (tall, wide) = (folder.render("-size 8 20"), folder.render("-size 20 8"));
        assert_eq!((tall.width, tall.height, wide.width, wide.height), (8, 20, 20, 8));
        assert_eq!(tall.pixels, cut(&square, 6..14, 0..20));
        assert_eq!(wide.pixels, cut(&square, 0..20, 6..14));
    }
}

/// A wall lit through a sphere of radius 1 along its axis.
fn lit_through_glass() -> Folder {
    Folder::with_scene(
        "PerspectiveCamera { center 3 0 0 direction 1 0 0 up 0 1 0 angle 10 }
         Lights { numLights 1 DirectionalLight { direction 1 0 0 color 1 1 1 } }
         Materials { numMaterials 2 Material { } Material { transparentColor .5 .25 1 } }
         Group { numObjects 2
           MaterialIndex 0 Plane { normal -1 0 0 offset -5 }
           MaterialIndex 1 Sphere { center 0 0 0 radius 1 } }",
    )
}

#[test]
fn transparent_shadows_are_tinted_by_the_way_through() {
    let folder = lit_through_glass();
    assert_eq!(folder.render("-size 1 1").pixels, [[255; 3]]);
    assert_eq!(folder.render("-size 1 1 -no_shadows").pixels, [[255; 3]]);
    assert_eq!(folder.render("-size 1 1 -shadows").pixels, [[0; 3]]);
    // The colour to the power of 2, which is the length of the path inside.
    let tinted = [[63, 15, 255]];
    assert_eq!(folder.render("-size 1 1 -transparent_shadows").pixels, tinted);
    assert_eq!(folder.render("-size 1 1 -transparent_shadows -shadows -grid 3 3 3").pixels, tinted);
}
