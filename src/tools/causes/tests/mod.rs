//! Tests the causes found for pictures with known mistakes.

mod acne;
mod confusion;
mod single;
mod windows;

use super::{Finding, Mistake, Original};
use crate::render::Request;
use crate::render::renderer::{Meshes, Renderer};
use crate::render::test_renderer::renderer_of;
use crate::sampling::drand48::Drand48;
use crate::sampling::sampler::{Pattern, Sampler};
use crate::scene::load::load;
use crate::trace::{Effects, Shadows};
use std::path::Path;

/// A scene with a little of everything, where every mistake shows.
const SCENE: &str = "
    PerspectiveCamera { center 0 2.5 8 direction 0 -.25 -1 up 0 1 0 angle 40 }
    Background { color .10980392 .3 .5 ambientLight .2 .15 .2 }
    Lights { numLights 2
        PointLight { position .5 3 2 color 2.2 2 1.8 attenuation 1 .2 0 }
        DirectionalLight { direction -1 -1 -.5 color .4 .4 .5 } }
    Materials { numMaterials 6
        Material { diffuseColor .8 .4 .2 specularColor .9 .9 .9 exponent 20 }
        Material { diffuseColor .1 .1 .2 reflectiveColor .7 .7 .7 }
        Material { diffuseColor .1 .1 .1 transparentColor .8 .9 .7 indexOfRefraction 1.5 }
        Material { diffuseColor .9 .9 .9 }
        Checkerboard { materialIndex 0 materialIndex 3 }
        Noise { materialIndex 0 materialIndex 3 octaves 3 } }
    Group { numObjects 10
        MaterialIndex 4 Plane { normal 0 1 0 offset -.2 }
        MaterialIndex 1 Sphere { center -1.2 .6 0 radius .8 }
        MaterialIndex 2 Sphere { center .8 .4 1.5 radius .6 }
        MaterialIndex 0 Transform { Translate 1.6 .8 -1 ZRotate 30 Scale 1 .4 .6 Sphere { center 0 0 0 radius 1 } }
        MaterialIndex 0 Sphere { center .6 4.5 2 radius .7 }
        MaterialIndex 3 Triangle { vertex0 -2.5 .2 1.5 vertex1 -2.5 1.2 1.5 vertex2 -1.7 .2 1.5 }
        MaterialIndex 3 Triangle { vertex0 2.2 .2 1.5 vertex1 2.2 1.2 1.5 vertex2 3 .2 1.5 }
        MaterialIndex 5 Sphere { center -.2 .3 2.6 radius .4 }
        MaterialIndex 3 Sphere { center .2 2.5 1.9 radius .15 }
        Transform { Translate -.9 .3 2 Group { numObjects 1 MaterialIndex 0
            Transform { YRotate 30 Scale .3 .5 .3 Box { min -.5 -.5 -.5 max .5 .5 .5 } } } } }";

/// A scene and the request for its picture.
struct Case {
    name: &'static str,
    renderer: Renderer,
    request: Request,
}

impl Case {
    fn new(name: &'static str, request: Request) -> Self {
        let renderer = match name {
            "everything" => renderer_of(SCENE),
            _ => {
                let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
                Renderer::new(load(&path).unwrap(), Meshes::Kept).unwrap()
            }
        };
        Self { name, renderer, request }
    }

    fn original(&self) -> Original<'_> {
        Original::new(&self.renderer, &self.request).unwrap()
    }
}

fn cases() -> Vec<Case> {
    let shadows = Effects { shadows: Shadows::Opaque, bounces: 2, ..Effects::default() };
    let back = Effects { shade_back: true, ..shadows };
    let tinted = Effects { shadows: Shadows::Transparent, ..back };
    let picture = |effects| Request { effects, ..Request::new([64, 48]) };
    let sampler = Sampler::new(Pattern::Jittered, 4, Drand48::UNSEEDED);
    vec![
        Case::new("everything", picture(shadows)),
        Case::new("everything", picture(back)),
        Case::new("everything", picture(Effects { min_weight: 1.3, bounces: 2, ..Effects::default() })),
        Case::new("everything", Request { sampler, ..picture(shadows) }),
        Case::new("everything", picture(tinted)),
        Case::new("scene6_03_sphere_plane.txt", picture(shadows)),
        Case::new("scene4_02_colored_shadows.txt", picture(shadows)),
        Case::new("scene6_05_bunny_mesh_1k.txt", picture(back)),
        Case::new("scene7_05_glass_sphere.txt", picture(tinted)),
        Case::new("scene6_12_faceted_gem.txt", picture(back)),
        Case::new("scene2_05_inside_sphere.txt", picture(back)),
        Case::new("editions/screen_2012a4.txt", picture(shadows)),
        // Rays split at glass, so there are many choices.
        Case::new("editions/glass_2012a5.txt", Request { size: [40, 30], ..picture(shadows) }),
        Case::new("editions/mirrors_2019.txt", picture(shadows)),
    ]
}

/// Returns the mistake that the finding names, if any.
fn named(found: &Finding) -> Option<Mistake> {
    match found {
        Finding::Equal { cause, .. } | Finding::Part { cause, .. } => Some(*cause),
        Finding::Rounding { .. } | Finding::Speckles { .. } | Finding::Unknown { .. } => None,
    }
}
