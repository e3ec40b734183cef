//! Mistakes in pictures that are larger than the windows in which causes are searched.

use super::Case;
use crate::picture::Picture;
use crate::render::Request;
use crate::tools::causes::{Finding, Mistake};
use crate::tools::compare::{EdgeMap, colors};
use crate::trace::{Effects, Shadows};

/// Asserts that exactly these mistakes are named.
fn assert_named(found: &Finding, mistakes: &[Mistake]) {
    let Finding::Equal { cause, also, .. } = found else { panic!("{mistakes:?}: {found}") };
    let named: Vec<Mistake> = [cause].into_iter().chain(also).copied().collect();
    let is_named = named.len() == mistakes.len() && mistakes.iter().all(|mistake| named.contains(mistake));
    assert!(is_named, "{mistakes:?}: {found}");
}

#[test]
fn a_mistake_that_makes_only_a_window_right_hides_no_other() {
    // A change of the finished picture can make a flat window right, and leave most of the picture wrong.
    let case = Case::new("scene3_09_exponent_variations.txt", Request::new([150; 2]));
    let original = case.original();
    let wrong = original.picture(Mistake::BlackBackground);
    assert_named(&original.explain(&wrong.unwrap()), &[Mistake::BlackBackground]);
}

#[test]
fn a_learned_mistake_is_the_ground_of_a_second_one_where_edges_differ() {
    let effects = Effects { shadows: Shadows::Opaque, bounces: 2, ..Effects::default() };
    let mistakes = [Mistake::NoAmbient, Mistake::LightsTimesPi];
    for scene in ["scene4_02_colored_shadows.txt", "scene6_02_sphere_triangles.txt"] {
        let case = Case::new(scene, Request { effects, ..Request::new([120; 2]) });
        let original = case.original();
        let right = original.picture(Mistake::Unchanged).unwrap();
        let made = original.made(&mistakes, None).unwrap().to_picture();
        // One of 300 pixels differs, at edges, as in single precision.
        let edges = EdgeMap::new(&made);
        let mut pixels = colors(&made).to_vec();
        let at_edges: Vec<usize> =
            (0..pixels.len()).filter(|at| edges.is_near_edge(at % 120, at / 120)).collect();
        let disturbed = pixels.len() / 300;
        for &at in at_edges.iter().step_by(at_edges.len() / disturbed).take(disturbed) {
            pixels[at] = pixels[at].map(|byte| 255 - byte);
        }
        let wrong = Picture::from_rgb(120, 120, pixels.into_flattened());
        let found = original.explain_all_with(&[wrong], &right, &[Mistake::NoAmbient]);
        assert_named(&found[0], &mistakes);
    }
}
