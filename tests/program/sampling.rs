//! Several samples per pixel: pictures of which every pixel can be computed by hand.

use crate::support::{Folder, Tga};

/// A scene of white triangles on black. The orthographic camera shows a square of side 1 with its lower left
/// corner at the origin.
fn white(count: usize, triangles: &str) -> Folder {
    Folder::with_scene(&format!(
        "OrthographicCamera {{ center .5 .5 1 direction 0 0 -1 up 0 1 0 size 1 }}
         Background {{ color 0 0 0 }}
         Group {{ numObjects {count} Material {{ }} {triangles} }}"
    ))
}

/// A scene that is white for x < `edge`.
fn left_of(edge: f64) -> Folder {
    white(1, &format!("Triangle {{ vertex0 {edge} -90 0 vertex1 {edge} 90 0 vertex2 -90 0 0 }}"))
}

/// A scene in which every pixel and sample has its own colour.
fn colorful() -> Folder {
    Folder::with_scene(
        "PerspectiveCamera { center 0 1 6 direction 0 -.1 -1 up 0 1 0 angle 40 }
         Background { color .1 .2 .6 ambientLight .1 .1 .1 }
         Lights { numLights 1 PointLight { position 3 5 4 color 1 1 1 } }
         Materials { numMaterials 4
           Material { diffuseColor 1 .9 .1 } Material { diffuseColor .1 .1 .3 reflectiveColor .4 .4 .4 }
           Checkerboard { materialIndex 0 materialIndex 1 }
           Marble { materialIndex 0 materialIndex 1 octaves 4 frequency 3 amplitude 4 } }
         Group { numObjects 2
           MaterialIndex 2 Plane { normal 0 1 0 offset -1.01 }
           MaterialIndex 3 Sphere { center 0 0 0 radius 1.2 } }",
    )
}

const SAMPLERS: [&str; 3] = ["-random_samples 5", "-uniform_samples 6", "-jittered_samples 8"];
const FILTERS: [&str; 5] =
    ["", "-box_filter 1.2", "-tent_filter 2", "-gaussian_filter .7", "-mitchell_filter 2"];

#[test]
fn one_uniform_sample_is_the_centre() {
    let folder = colorful();
    let plain = folder.render("-size 30 20");
    assert_eq!(folder.render("-size 30 20 -uniform_samples 1"), plain);
    assert_eq!(folder.render("-size 30 20 -uniform_samples 1 -box_filter .5"), plain);
    for moved in ["-random_samples 1", "-jittered_samples 1"] {
        assert_ne!(folder.render(&format!("-size 30 20 {moved}")), plain, "{moved}");
    }
}

#[test]
fn one_random_and_one_jittered_sample_draw_alike_but_for_the_order() {
    // Jittered sampling draws x first, and random sampling y.
    let folder = left_of(1.0);
    let places = |sampler: &str| {
        folder.run(&format!("-input s.txt -size 1 1 {sampler} -seed 3 -render_samples s.tga 64")).ok();
        plotted(&folder.tga("s.tga"))[0]
    };
    let (random, jittered) = (places("-random_samples 1"), places("-jittered_samples 1"));
    assert_eq!(random, (jittered.1, jittered.0));
    assert_ne!(random, jittered);
}

#[test]
fn uniform_samples_measure_what_is_covered() {
    // An edge at 0.25 is right of 16 of the 64 columns of 4096 = 64 x 64 samples, and one at 0.3 is right of
    // one of the two columns of 4 = 2 x 2.
    for (samples, edge, covered) in
        [(4096, 0.25, 0.25), (4096, 0.5, 0.5), (4, 0.3, 0.5), (64, 0.25, 0.25), (65536, 0.75, 0.75)]
    {
        let picture = left_of(edge).render(&format!("-size 1 1 -uniform_samples {samples}"));
        assert_eq!(picture.greys(), [(covered * 255.0) as u8], "{samples} samples, {edge}");
    }
}

#[test]
fn counts_that_are_no_squares_make_the_squarest_grid() {
    // 8 samples are 4 columns by 2 rows, and 7 are 7 by 1. The expected value is the fraction of columns left
    // of the edge.
    for (samples, edge, covered) in
        [(8, 0.3, 0.25), (7, 0.3, 2.0 / 7.0), (12, 0.3, 0.25), (6, 0.4, 1.0 / 3.0)]
    {
        for sampler in ["uniform", "jittered"] {
            // In one column jittered samples may be on either side of the edge.
            let error_bound = if sampler == "uniform" { 0.0 } else { 1.0 / 4.0 };
            let picture = left_of(edge).render(&format!("-size 1 1 -{sampler}_samples {samples}"));
            let error = (f64::from(picture.greys()[0]) / 255.0 - covered).abs();
            assert!(error <= error_bound + 1.0 / 255.0, "{samples} {sampler}: {error}");
        }
    }
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
fn pixels_that_no_sample_counts_for_are_black() {
    let folder = left_of(1.0);
    let greys = |flags: &str| folder.render(&format!("-size 3 2 {flags}")).greys();
    assert_eq!(greys(""), [255; 6]);
    // The four samples are 1/4 pixel from the centre along both axes.
    assert_eq!(greys("-uniform_samples 4 -box_filter .25"), [255; 6]);
    assert_eq!(greys("-uniform_samples 4 -box_filter .2499"), [0; 6]);
    assert_eq!(greys("-uniform_samples 4 -tent_filter .36"), [255; 6], "sqrt(1/8) = .354");
    assert_eq!(greys("-uniform_samples 4 -tent_filter .35"), [0; 6]);
    assert_eq!(greys("-uniform_samples 4 -gaussian_filter .000001"), [0; 6], "the weights vanish");
    assert_eq!(greys("-uniform_samples 9 -box_filter .000001"), [255; 6], "the middle one counts");
}

#[test]
fn at_the_border_the_samples_that_exist_are_averaged() {
    // The white pixel is at the left of a row of four: it is one of two pixels, then one of three, then none.
    let row = |flags: &str| left_of(0.25).render(&format!("-size 4 1 {flags}")).greys();
    let greys = |shares: [f64; 4]| shares.map(|share| (share * 255.0) as u8);
    assert_eq!(row("-box_filter 1"), greys([1.0 / 2.0, 1.0 / 3.0, 0.0, 0.0]));
    assert_eq!(row("-box_filter 2"), greys([1.0 / 3.0, 1.0 / 4.0, 1.0 / 4.0, 0.0]));
    // The weights are 1 at the centre and 1/2 beside it.
    assert_eq!(row("-tent_filter 2"), greys([1.0 / 1.5, 0.5 / 2.0, 0.0, 0.0]));
}

#[test]
fn columns_and_rows_are_filtered_alike() {
    let across = left_of(0.25);
    let along = white(1, "Triangle { vertex0 90 .25 0 vertex1 -90 .25 0 vertex2 0 -90 0 }");
    for filter in FILTERS {
        let row = across.render(&format!("-size 4 1 {filter}")).greys();
        let mut column = along.render(&format!("-size 1 4 {filter}")).greys();
        column.reverse();
        assert_eq!(row, column, "{filter}");
    }
}

#[test]
fn the_seed_chooses_the_random_numbers() {
    let folder = colorful();
    for sampler in ["-random_samples 4", "-jittered_samples 4"] {
        let render = |seed: &str| folder.render(&format!("-size 20 20 {sampler} {seed}"));
        let pictures = ["", "-seed 0", "-seed 1", "-seed 2"].map(render);
        assert!(
            (0..4).all(|i| (0..i).all(|j| pictures[i] != pictures[j])),
            "{sampler}: two seeds agree or a seed is the start without one"
        );
        assert_eq!(render("-seed 1"), pictures[2]);
        assert_eq!(render(""), pictures[0]);
    }
    let uniform = |seed: &str| folder.render(&format!("-size 20 20 -uniform_samples 4 {seed}"));
    assert_eq!(uniform("-seed 1"), uniform(""));
}

#[test]
fn depths_and_normals_show_the_centres() {
    let folder = colorful();
    let measured = |flags: &str| {
        folder.run(&format!("-input s.txt -size 20 15 -depth 4 9 d.tga -normals n.tga {flags}")).ok();
        [folder.tga("d.tga"), folder.tga("n.tga")]
    };
    let plain = measured("");
    for sampler in SAMPLERS {
        assert_eq!(measured(sampler), plain, "{sampler}");
        assert_eq!(measured(&format!("{sampler} -tent_filter 3 -output o.tga")), plain, "{sampler}");
    }
}

/// The positions of the samples in a picture of them, in columns and rows from the bottom left.
fn plotted(plot: &Tga) -> Vec<(usize, usize)> {
    let white = |&at: &usize| plot.pixels[at] == [255; 3];
    (0..plot.pixels.len())
        .filter(white)
        .map(|at| (at % plot.width, plot.height - 1 - at / plot.width))
        .collect()
}
