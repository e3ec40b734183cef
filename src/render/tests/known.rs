//! Hints by rasterization from the camera and from the lights: pictures with hints are the same as pictures of the
//! tracer without hints, which casts every ray.

use super::*;
use crate::trace::{Effects, Shadows};

/// A wall between the lights and all objects that the camera sees.
const WALL: &str = "Plane { normal 1 0.1 0.3 offset 1.5 }";

const EGG: &str = "Transform { Translate 0.8 0.2 0.6 Scale 1 1 0.5 Sphere { center 0 0 0 radius 0.4 } }";

/// Returns the pictures of a request, with hints and by the tracer alone.
fn both(text: &str, request: &Request) -> [Vec<FloatPicture>; 2] {
    let scene = parse(text).unwrap();
    let world = World::new(&scene, &[]).unwrap();
    [Tracing::Fast, Tracing::Counted].map(|tracing| {
        let caster = &LazyCaster::new(Caster::of_planes(&world), Layout::List);
        let shot = Shot { camera: Camera::new(&scene.camera, request.size), caster, view: View::Scene };
        render_in_memory(&shot, &Request { tracing, ..request.clone() }, &goes_on).unwrap().0
    })
}

#[test]
fn pictures_are_those_of_rays_that_are_cast() {
    let only_a_wall = scene("").replace("Plane { normal 0 1 0.02 offset -0.5 }", WALL);
    assert_eq!(only_a_wall.matches("Plane").count(), 1);
    for (text, sampler, size) in [
        (only_a_wall, Sampler::CENTER, [270, 250]),
        (scene(""), Sampler::CENTER, [270, 250]),
        (scene(""), jittered(9), [91, 90]),
        (scene(WALL), jittered(4), [130, 130]),
        (scene(SPHERE), Sampler::CENTER, [270, 250]),
        (scene(EGG), jittered(9), [90, 91]),
        (scene(""), ADAPTIVE, [130, 130]),
        (scene(WALL), ADAPTIVE, [129, 131]),
    ] {
        let effects = Effects { shadows: Shadows::Opaque, shade_back: true, ..Effects::default() };
        let filter = Filter::Gaussian { sigma: 0.4 };
        let adaptive = further(sampler);
        let request = Request { effects, sampler, adaptive, filter, ..Request::new(size) };
        let [fast, counted] = both(&text, &request);
        assert!(fast == counted, "{text} {sampler:?}");
        let without = Request { effects: Effects { shadows: Shadows::None, ..effects }, ..request };
        assert!(both(&text, &without)[0] != fast, "{text} {sampler:?}");
    }
}

#[test]
fn transparent_shadows_are_cast() {
    let effects = Effects { shadows: Shadows::Transparent, ..Effects::default() };
    let scene =
        scene("").replace("diffuseColor 1 0.5 0.2", "diffuseColor 1 0.5 0.2 transparentColor 0.5 0.5 0.9");
    let [fast, counted] = both(&scene, &Request { effects, ..Request::new([270, 250]) });
    assert!(fast == counted);
}
