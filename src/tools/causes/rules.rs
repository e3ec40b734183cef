//! Mistakes in how rays are generated, traced and shaded.

use super::Original;
use super::object_space::ObjectSpaces;
use super::paint::paint;
use super::requests::{has, has_secondary_rays};
use super::student::{Departure, Hits, Student};
use crate::math::ray::Ray;
use crate::picture::{BadSize, CHANNELS, Color, FloatPicture, Picture};
use crate::render::renderer::Renderer;
use crate::render::{Layer, Request};
use crate::sampling::filter::Filter;
use crate::sampling::sampler::Sampler;
use crate::scene::material::{Material, Pattern};
use crate::scene::model::{Highlight, Split};
use crate::scene::{Light, Object, Scene};
use crate::trace::Shadows;
use glam::{DVec2, DVec3};
use serde::Serialize;
use std::fmt;

/// A rule of the tracer that is broken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "name", rename_all = "snake_case")]
pub enum Rule {
    /// Rays run through other points than the samples.
    Shifted {
        /// So many half pixels to the right and up.
        half_pixels: [i8; 2],
    },
    /// What lies behind a point light casts shadows, too.
    ShadowsFromBehindLight,
    /// d + 2 (d.n) n is taken for the mirrored direction: the normal is flipped in one of its two places.
    NormalFlippedInReflection,
    /// Mirrored rays run in the opposite direction.
    ReflectionReversed,
    /// Mirrored rays start below the surface.
    ReflectionFromBelow,
    /// Colours along camera rays are clamped to 1 before a pixel's samples are summed.
    SamplesClamped,
    /// Colours along all rays are clamped to 1 before they are summed.
    RaysClamped,
    /// The light of each source is clamped to 1 before it is added.
    LightsClamped,
    /// Reflected and refracted rays that hit nothing are black.
    BackgroundForCameraOnly,
    /// Normals are transformed like directions, by the matrix itself.
    NormalsByMatrix,
    /// Normals are left as they are in the object's own space.
    NormalsOfObjectSpace,
    /// The cell of a checkerboard is found by cutting coordinates off, so that those around zero are twice as wide.
    CheckerboardCut,
    /// Everything nearer than some distance to the start of a secondary ray is overlooked.
    Epsilon {
        /// The distance that is overlooked.
        distance: f64,
    },
    /// Less is overlooked than in the program of the edition.
    SmallerEpsilon {
        /// The distance that is overlooked.
        distance: f64,
    },
    /// Rays hit the surface that they leave.
    NoEpsilon {
        /// Which rays.
        rays: SelfHitting,
    },
    /// Surfaces seen from behind are lit by their outward normal.
    NormalsNotFlipped,
    /// Surfaces are lit on the side that is seen, where the outside is to be lit.
    NormalsFlipped,
    /// The cosine of a highlight is that between the mirrored light and the viewer, R.V, instead of N.H.
    HighlightsByReflection,
    /// Highlights are multiplied by the cosine of the light, N.L.
    HighlightsTimesCosine,
    /// There are no highlights where a surface faces away from the light.
    HighlightsOnlyWhereLit,
    /// The vector to a directional light keeps its length.
    DirectionsNotNormalised,
    /// The vector to a point light keeps its length.
    PointDirectionsNotNormalised,
    /// The ambient light is added without the surface's colour.
    AmbientWithoutDiffuse,
    /// The ratio of the indices of refraction is the same where a ray enters and where it leaves.
    IndexNotInverted,
    /// At total internal reflection the refracted ray is mirrored.
    TotalReflectionAdded,
    /// Transparent things cast no shadow.
    GlassWithoutShadows,
    /// The weight of noise N is (N + 1) / 2.
    NoiseHalved,
    /// Reflected rays are added without the material's reflective colour.
    ReflectionWithoutColor,
    /// Refracted rays are added without the material's transparent colour.
    RefractionWithoutColor,
    /// The parts of the light that are mirrored at glass and that go through it are swapped.
    SchlickSwapped,
    /// Colours are computed in single precision.
    SinglePrecision,
}

/// Which rays hit the surface that they leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SelfHitting {
    /// Those to the lights.
    Shadow,
    /// Reflected and refracted ones.
    Secondary,
    /// All.
    All,
}

impl SelfHitting {
    /// Whether a ray that leaves a surface for this reason is one of them.
    pub(super) fn includes(self, why: Departure) -> bool {
        match why {
            Departure::Shadow => self != Self::Secondary,
            Departure::Reflected | Departure::Refracted => self != Self::Shadow,
            Departure::Onwards => false,
        }
    }
}

/// Deeper recursion is not tried, for the sake of the stack.
pub(crate) const MAX_BOUNCES: u32 = 100;

/// Distances that are overlooked, from the smallest.
const EPSILONS: [f64; 7] = [0.0001, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3];
/// Those that are less than what some editions overlook.
const SMALL_EPSILONS: [f64; 2] = [0.0001, 0.001];

impl Rule {
    /// All but that of shadow rays without an epsilon.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        let shifts = [1, 2].into_iter().flat_map(|n| {
            let sides = [[-1, -1], [-1, 1], [1, 1], [1, -1], [-1, 0], [1, 0], [0, 1], [0, -1]];
            sides.map(|side: [i8; 2]| Self::Shifted { half_pixels: side.map(|side| n * side) })
        });
        shifts
            .chain([
                Self::ShadowsFromBehindLight,
                Self::NormalFlippedInReflection,
                Self::ReflectionReversed,
                Self::ReflectionFromBelow,
                Self::SamplesClamped,
                Self::RaysClamped,
                Self::LightsClamped,
                Self::BackgroundForCameraOnly,
                Self::NormalsByMatrix,
                Self::NormalsOfObjectSpace,
                Self::CheckerboardCut,
                Self::SchlickSwapped,
                Self::NormalsFlipped,
                Self::HighlightsOnlyWhereLit,
            ])
            .chain(EPSILONS.map(|distance| Self::Epsilon { distance }))
            .chain(SMALL_EPSILONS.map(|distance| Self::SmallerEpsilon { distance }))
            .chain([
                Self::NoEpsilon { rays: SelfHitting::Secondary },
                Self::NoEpsilon { rays: SelfHitting::All },
                Self::NormalsNotFlipped,
                Self::HighlightsByReflection,
                Self::HighlightsTimesCosine,
                Self::DirectionsNotNormalised,
                Self::PointDirectionsNotNormalised,
                Self::AmbientWithoutDiffuse,
                Self::IndexNotInverted,
                Self::TotalReflectionAdded,
                Self::GlassWithoutShadows,
                Self::NoiseHalved,
                Self::ReflectionWithoutColor,
                Self::RefractionWithoutColor,
                Self::SinglePrecision,
            ])
    }

    /// Whether the scene and the request can show that the rule is broken.
    pub(super) fn applies(self, scene: &Scene, request: &Request) -> bool {
        let effects = request.effects;
        let bounces = if has_secondary_rays(scene) { effects.bounces } else { 0 };
        let (is_lit, is_blinn) = (!scene.lights.is_empty(), scene.model.highlight == Highlight::Blinn);
        let has_shadows = effects.shadows != Shadows::None && is_lit;
        bounces <= MAX_BOUNCES && match self {
            Self::Shifted { .. } | Self::SinglePrecision => true,
            Self::ShadowsFromBehindLight => has_shadows && scene.lights.iter().any(is_point),
            Self::NormalFlippedInReflection | Self::ReflectionReversed | Self::ReflectionFromBelow => {
                bounces > 0 && has(scene, |phong| phong.reflective)
            }
            Self::SamplesClamped => request.sampler.count() > 1 || request.filter.support() > 0,
            Self::RaysClamped => bounces > 0,
            Self::LightsClamped => is_lit,
            Self::BackgroundForCameraOnly => {
                bounces > 0 && (scene.background.color != Color::ZERO || scene.cube_map.is_some())
            }
            Self::NormalsByMatrix | Self::NormalsOfObjectSpace => {
                scene.objects.iter().any(|object| matches!(object, Object::Transform { .. }))
            }
            Self::SchlickSwapped => {
                bounces > 0 && scene.model.split == Split::Schlick && has(scene, |phong| phong.transparent)
            }
            Self::CheckerboardCut => has_pattern(scene, |pattern| pattern == Pattern::Checkerboard),
            Self::Epsilon { distance } => {
                (has_shadows || bounces > 0) && scene.model.epsilon.is_none_or(|right| distance > right)
            }
            Self::SmallerEpsilon { distance } => {
                (has_shadows || bounces > 0) && scene.model.epsilon.is_some_and(|right| distance < right)
            }
            Self::NoEpsilon { rays: SelfHitting::Shadow } => has_shadows,
            Self::NoEpsilon { rays: SelfHitting::Secondary } => bounces > 0,
            Self::NoEpsilon { rays: SelfHitting::All } => has_shadows && bounces > 0,
            Self::NormalsNotFlipped => effects.shade_back && is_lit && is_blinn,
            Self::NormalsFlipped => is_lit && !is_blinn,
            Self::HighlightsByReflection => is_lit && is_blinn && has(scene, |phong| phong.specular),
            Self::HighlightsOnlyWhereLit => is_lit && !is_blinn && has(scene, |phong| phong.specular),
            Self::HighlightsTimesCosine => is_lit && has(scene, |phong| phong.specular),
            Self::DirectionsNotNormalised => scene.lights.iter().any(
                |light| matches!(light, Light::Directional { direction, .. } if !direction.is_normalized()),
            ),
            Self::PointDirectionsNotNormalised => scene.lights.iter().any(is_point),
            Self::AmbientWithoutDiffuse => scene.background.ambient != Color::ZERO,
            Self::IndexNotInverted | Self::TotalReflectionAdded | Self::RefractionWithoutColor => {
                bounces > 0 && has(scene, |phong| phong.transparent)
            }
            Self::GlassWithoutShadows => has_shadows && has(scene, |phong| phong.transparent),
            Self::NoiseHalved => has_pattern(scene, |pattern| matches!(pattern, Pattern::Noise { .. })),
            Self::ReflectionWithoutColor => bounces > 0 && has(scene, |phong| phong.reflective),
        }
    }

    /// Whether what it changes shows in a layer at all.
    pub(super) fn shows_in(self, layer: Layer) -> bool {
        matches!(
            (layer, self),
            (Layer::Color, _)
                | (Layer::Depth { .. } | Layer::Normals, Self::Shifted { .. })
                | (Layer::Normals, Self::NormalsByMatrix | Self::NormalsOfObjectSpace)
        )
    }

    fn shift(self) -> DVec2 {
        match self {
            Self::Shifted { half_pixels: [x, y] } => 0.5 * DVec2::new(x.into(), y.into()),
            _ => DVec2::ZERO,
        }
    }
}

fn is_point(light: &Light) -> bool {
    matches!(light, Light::Point { .. })
}

fn has_pattern(scene: &Scene, is_meant: impl Fn(Pattern) -> bool) -> bool {
    let is_meant =
        |material: &Material| matches!(material, Material::Texture(texture) if is_meant(texture.pattern));
    scene.materials.iter().any(is_meant)
}

/// The colours of the first layer by a student with this mistake, or none. The renderer must have kept the meshes. The
/// rest is black as soon as `is_over` says so.
pub fn colors(
    renderer: &Renderer,
    request: &Request,
    hits: &dyn Hits,
    mistake: Option<Rule>,
    is_over: &(dyn Fn() -> bool + Sync),
) -> Result<FloatPicture, BadSize> {
    let spaces = &ObjectSpaces::new(&renderer.scene, renderer.meshes(), renderer.world());
    let (effects, lights) = (request.effects, &renderer.scene.lights);
    let student = Student { hits, effects, mistake, spaces, lights, starts: None };
    let shift = mistake.map_or(DVec2::ZERO, Rule::shift);
    let camera = renderer.camera(request);
    let model = renderer.scene.model;
    let centers = || Request { sampler: Sampler::CENTER, filter: Filter::PIXEL, ..request.clone() };
    match request.layers.first() {
        Some(&Layer::Depth { near, far }) => {
            let grey = |(t, _)| Color::splat(model.depths.grey(t, [near, far]));
            let depth = |ray: &Ray| student.seen(ray).map_or(Color::ZERO, grey);
            paint(&camera, &centers(), shift, &depth, is_over)
        }
        Some(Layer::Normals) => {
            let normal = |ray: &Ray| student.seen(ray).map_or(DVec3::ZERO, |(_, surface)| surface.normal);
            paint(&camera, &centers(), shift, &|ray| model.normal_colors.color(normal(ray)), is_over)
        }
        _ => paint(&camera, request, shift, &|ray| student.color(ray), is_over),
    }
}

/// The picture by a tracer that breaks the rule, or none; none where there is no memory for it.
pub fn picture(original: &Original, rule: Option<Rule>) -> Option<Picture> {
    let Original { prepared, request, .. } = original;
    let renderer = prepared.renderer();
    let is_over = || original.is_cancelled();
    let colors = renderer.on_own_threads(|| colors(renderer, request, prepared.caster(), rule, &is_over));
    let colors = colors.ok()?;
    Some(if rule == Some(Rule::SinglePrecision) { cut_singles(&colors) } else { colors.to_picture() })
}

/// The bytes of colours whose product with 255 is rounded to single precision.
fn cut_singles(colors: &FloatPicture) -> Picture {
    let mut bytes = Vec::with_capacity(colors.colors.len() * CHANNELS);
    let cut = |color: &Color| color.as_vec3().to_array().map(|channel| (255.0 * channel) as u8);
    bytes.extend(colors.colors.iter().flat_map(cut));
    let [width, height] = colors.size.map(|n| n as u32);
    Picture::from_rgb(width, height, bytes)
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NormalsFlipped => "with surfaces lit on the side that is seen instead of on their outside",
            Self::HighlightsOnlyWhereLit => "without highlights where the surface faces away from the light",
            Self::SchlickSwapped => "with the mirrored and the refracted part of light at glass swapped",
            Self::Shifted { half_pixels } => return shifted(*half_pixels, f),
            Self::Epsilon { distance } => {
                return write!(f, "with an epsilon of {distance} for secondary rays, which is too large");
            }
            Self::SmallerEpsilon { distance } => {
                return write!(f, "with an epsilon of {distance} for secondary rays, less than the course's");
            }
            Self::ShadowsFromBehindLight => "with shadows from behind the light",
            Self::NormalFlippedInReflection => "with reflections from the flipped normal",
            Self::ReflectionReversed => "with reflected rays reversed",
            Self::ReflectionFromBelow => "with reflected rays that start below the surface",
            Self::SamplesClamped => "with the colours of samples clamped before they are summed",
            Self::RaysClamped => "with the colours of rays clamped before they are summed",
            Self::LightsClamped => "with the light of each source clamped before it is summed",
            Self::BackgroundForCameraOnly => "with black where reflected or refracted rays hit nothing",
            Self::NormalsByMatrix => {
                "with normals transformed by the matrix instead of its inverse transpose"
            }
            Self::NormalsOfObjectSpace => "with normals that are not transformed",
            Self::CheckerboardCut => "with checkerboards whose coordinates are cut instead of floored",
            Self::NoEpsilon { rays } => match rays {
                SelfHitting::Shadow => "where every surface shadows itself, as without an epsilon",
                SelfHitting::Secondary => {
                    "where reflected and refracted rays hit the surface that they leave, as without an epsilon"
                }
                SelfHitting::All => "where all rays hit the surface that they leave, as without an epsilon",
            },
            Self::NormalsNotFlipped => "with normals that are not flipped on back faces",
            Self::HighlightsByReflection => "with highlights by R.V instead of N.H",
            Self::HighlightsTimesCosine => "with highlights multiplied by N.L",
            Self::DirectionsNotNormalised => "with directions of directional lights that are not normalised",
            Self::PointDirectionsNotNormalised => "with directions to point lights that are not normalised",
            Self::AmbientWithoutDiffuse => "with ambient light that is not multiplied by the diffuse colour",
            Self::IndexNotInverted => "with the same ratio of indices where rays enter and where they leave",
            Self::TotalReflectionAdded => "with rays that are mirrored at total internal reflection",
            Self::GlassWithoutShadows => "without shadows of transparent things",
            Self::NoiseHalved => "with the noise N as (N + 1) / 2 instead of N + 1/2",
            Self::ReflectionWithoutColor => "with reflections that are not multiplied by the reflective colour",
            Self::RefractionWithoutColor => "with refracted light that is not multiplied by the transparent colour",
            Self::SinglePrecision => "seen through single precision (f32)",
        })
    }
}

fn shifted([x, y]: [i8; 2], f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let side = |n: i8, names: [&'static str; 2]| match n {
        0 => None,
        n => Some(names[usize::from(n > 0)]),
    };
    let vertical = side(y, ["lower", "upper"]);
    let horizontal = side(x, ["left", "right"]);
    match (vertical, horizontal, x.abs().max(y.abs())) {
        (Some(vertical), Some(horizontal), 1) => {
            write!(
                f,
                "with rays through the {vertical} {horizontal} corners of the pixels instead of their centres"
            )
        }
        (_, _, halves) => {
            let amount = if halves == 1 { "half a pixel" } else { "one pixel" };
            let directions = [side(y, ["down", "up"]), side(x, ["to the left", "to the right"])];
            let directions: Vec<&str> = directions.into_iter().flatten().collect();
            write!(f, "with rays {amount} further {}", directions.join(" and "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caster::choose::Structure;
    use crate::render::renderer::{Meshes, Renderer};
    use crate::render::{Request, Window};
    use crate::sampling::{drand48::Drand48, filter::Filter, sampler};
    use crate::scene::load;
    use crate::tools::causes::Cause;
    use crate::tools::causes::window::part;
    use crate::trace::Effects;
    use std::path::Path;

    /// The picture of one of this project's scenes by the renderer, and by the textbook's tracer without a mistake.
    fn both(scene: &str, request: &Request) -> [Picture; 2] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
        let renderer = Renderer::new(load::load(&path).unwrap(), Meshes::Kept).unwrap();
        let original = Original::new(&renderer, Structure::Any, request).unwrap();
        [original.colors.to_picture(), picture(&original, None).unwrap()]
    }

    #[test]
    fn without_a_mistake_the_picture_is_the_real_one() {
        let shadows = Effects { shadows: Shadows::Opaque, bounces: 3, min_weight: 0.1, shade_back: false };
        let transparent = Effects { shadows: Shadows::Transparent, shade_back: true, ..shadows };
        let sampler = sampler::Sampler::new(sampler::Pattern::Jittered, 4, Drand48::UNSEEDED);
        let one = Request { effects: shadows, ..Request::new([50, 40]) };
        let many =
            Request { sampler, filter: Filter::Gaussian { sigma: 0.7 }, effects: transparent, ..one.clone() };
        for scene in [
            "scene6_02_sphere_triangles.txt",
            "scene6_10_nested_transformations.txt",
            "scene6_11_mirrored_floor.txt",
            "scene6_13_checkerboard.txt",
            "scene7_05_glass_sphere.txt",
        ] {
            for request in [&one, &many] {
                let [real, textbook] = both(scene, request);
                assert!(real == textbook, "{scene}");
            }
        }
    }

    #[test]
    fn a_window_is_a_part_of_the_picture() {
        let sampler = sampler::Sampler::new(sampler::Pattern::Jittered, 4, Drand48::UNSEEDED);
        let window = Window { x: 30, y: 7, width: 20, height: 9 };
        for filter in [Filter::PIXEL, Filter::Gaussian { sigma: 0.7 }] {
            let request = Request { sampler, filter, ..Request::new([50, 40]) };
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/scene6_02_sphere_triangles.txt");
            let renderer = Renderer::new(load::load(&path).unwrap(), Meshes::Kept).unwrap();
            let mut original = Original::new(&renderer, Structure::Any, &request).unwrap();
            let causes: Vec<Cause> = Cause::all().collect();
            let whole: Vec<_> = causes.iter().map(|&cause| original.picture(cause)).collect();
            original.request.window = Some(window);
            for (cause, whole) in causes.into_iter().zip(whole) {
                let expected = whole.map(|whole| part(&whole, window));
                assert!(original.picture(cause) == expected, "{cause:?} {filter:?}");
            }
        }
    }

    #[test]
    fn a_picture_taller_than_a_batch_of_rows_is_in_order() {
        let request = Request { filter: Filter::Tent { radius: 2.0 }, ..Request::new([20, 150]) };
        let [real, textbook] = both("scene6_02_sphere_triangles.txt", &request);
        assert!(real == textbook);
    }
}
