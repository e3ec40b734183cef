//! Several samples per pixel.

use crate::pixel_scenes::GLASS;
use crate::support::Folder;

#[test]
fn depths_and_normals_show_the_centres() {
    let folder = Folder::with_scene(GLASS);
    let measured = |flags: &str| {
        folder.run(&format!("-input s.txt -size 20 15 -depth 4 9 d.tga -normals n.tga {flags}")).ok();
        [folder.tga("d.tga"), folder.tga("n.tga")]
    };
    let plain = measured("");
    assert_eq!(measured("-random_samples 5"), plain);
    assert_eq!(measured("-jittered_samples 8 -tent_filter 3 -output o.tga"), plain);
}

/// Returns a scene that is white for x < `edge`. The camera shows a square of side 1 with its lower left corner at the
/// origin.
fn left_of(edge: f64) -> Folder {
    Folder::with_scene(&format!(
        "OrthographicCamera {{ center .5 .5 1 direction 0 0 -1 up 0 1 0 size 1 }}
         Background {{ color 0 0 0 }} Group {{ numObjects 1 Material {{ }}
         Triangle {{ vertex0 {edge} -90 0 vertex1 {edge} 90 0 vertex2 -90 0 0 }} }}"
    ))
}

#[test]
fn a_filter_larger_than_the_picture_averages_all_of_it() {
    let folder = left_of(0.5);
    for filter in ["-box_filter 1000000", "-tent_filter 1000000", "-gaussian_filter 1000000"] {
        for sampler in ["", "-uniform_samples 4"] {
            let greys = folder.render(&format!("-size 6 6 {filter} {sampler}")).greys();
            assert!(greys.iter().all(|grey| (126..=128).contains(grey)), "{filter}: {greys:?}");
        }
    }
    let greys = left_of(1.0).render("-size 6 6 -mitchell_filter 1000000").greys();
    assert!(greys.iter().all(|&grey| grey >= 254), "{greys:?}");
}

#[test]
fn the_seed_chooses_the_random_numbers() {
    let folder = Folder::with_scene(GLASS);
    for sampler in ["-random_samples 4", "-jittered_samples 4"] {
        let render = |seed: &str| folder.render(&format!("-size 20 20 {sampler} {seed}"));
        let [none, zero, one, again] = ["", "-seed 0", "-seed 1", "-seed 1"].map(render);
        assert!(none != zero && none != one && zero != one && one == again, "{sampler}");
    }
}
