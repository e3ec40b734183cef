//! The table of common mistakes in ray tracers, in the order in which they are tried.

use super::changes::*;
use super::student::SelfHitting;
use super::transforms::{in_radians, with_lists_reversed, with_nesting_reversed};
use crate::picture::Color;
use crate::render::{Layer, Request};
use crate::scene::material::{Material, Pattern};
use crate::scene::model::{Depths, Highlight, NormalColors, Screen, Split};
use crate::scene::{Camera, Light, Object, Scene};
use crate::trace::{Effects, Shadows};
use glam::Vec3Swizzles;
use serde::{Serialize, Serializer};
use std::fmt;
use std::mem::discriminant;

/// A mistake. `Display` writes the table's words for it, which complete "this program's picture".
#[allow(missing_docs)]
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "name", rename_all = "snake_case")]
pub enum Mistake {
    Unchanged,
    UpsideDown,
    Mirrored,
    Turned,
    RedAndBlueSwapped,
    Rounded,
    RoundedUp,
    OneLevelBrighter,
    OneLevelDarker,
    Wrapped,
    Times256,
    GammaEncoded,
    BytesGammaEncoded,
    GammaDecoded,
    SrgbEncoded,
    OtherHandedness,
    HalfScreen,
    DoubleScreen,
    AngleOfShorterSide,
    AngleNotHalved,
    AngleInRadians,
    NoShadows,
    Shadows,
    OpaqueShadows,
    TransparentShadows,
    NoShadeBack,
    ShadeBack,
    OneBounceFewer,
    OneBounceMore,
    WeightIgnored,
    NoAmbient,
    BlackBackground,
    NotAttenuated,
    AttenuatedBySquare,
    LightsTimesPi,
    LightsReversed,
    NoHighlights,
    IndexInverted,
    CheckerboardSwapped,
    BlinnHighlights,
    AspectKept,
    FlatMeshes,
    OtherFaceWeights,
    CubeFacesSwapped {
        faces: OppositeFaces,
    },
    FalloffFromOne,
    FalloffWithoutOne,
    Highlights,
    NearWhite,
    AbsoluteNormals,
    ShiftedNormals,
    ListsReversed,
    NestingReversed,
    AmbientPerLight,
    ExponentDoubled,
    ExponentHalved,
    RotationsInRadians,
    /// Rays pass through points shifted by this many half pixels to the right and up.
    Shifted {
        half_pixels: [i8; 2],
    },
    ShadowsFromBehindLight,
    ShadowRaysHalved,
    NormalFlippedInReflection,
    NormalNotFlippedInRefraction,
    ReflectionReversed,
    ReflectionFromBelow,
    SamplesClamped,
    RaysClamped,
    LightsClamped,
    BackgroundForCameraOnly,
    NormalsByMatrix,
    NormalsOfObjectSpace,
    CheckerboardCut,
    SchlickSwapped,
    NormalsFlipped,
    HighlightsOnlyWhereLit,
    /// Hits nearer than the distance to the start of a secondary ray are ignored.
    Epsilon {
        distance: f64,
    },
    /// The distance is smaller than in the edition's program.
    SmallerEpsilon {
        distance: f64,
    },
    NoEpsilon {
        rays: SelfHitting,
    },
    NormalsNotFlipped,
    HighlightsByReflection,
    HighlightsTimesCosine,
    HalfWayNotNormalised,
    DiffuseOverPi,
    DirectionsNotNormalised,
    PointDirectionsNotNormalised,
    AmbientWithoutDiffuse,
    AmbientFromAbove,
    IndexNotInverted,
    TotalReflectionAdded,
    GlassWithoutShadows,
    NoiseHalved,
    ReflectionWithoutColor,
    RefractionWithoutColor,
}

/// Pairs of opposite faces of a cube map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum OppositeFaces {
    /// Left and right.
    LeftAndRight,
    /// Up and down.
    UpAndDown,
    /// Front and back.
    FrontAndBack,
    /// All three pairs.
    All,
}

/// How the picture of a mistake is made.
#[derive(Clone, Copy, Debug)]
pub(super) enum Make {
    /// By changing the levels of the finished picture, 255 times its colours.
    Levels(fn(f64) -> f64),
    /// By changing the finished picture, of this width.
    Pixels(fn(&mut [Color], usize)),
    /// By another camera. `None` if it shows the same.
    Camera(fn(Camera, Screen, [usize; 2]) -> Option<Camera>),
    /// By other effects. They are unchanged if the mistake cannot show.
    Effects(fn(&mut Effects, &Scene)),
    /// By changing the scene. Returns true if the change can show.
    Scene(fn(&mut Scene) -> bool),
    /// By reading the scene's text differently. `None` if that gives the same scene.
    Text(fn(&Scene, &str) -> Option<Scene>),
    /// By a student's tracer with this mistake. Returns true if the mistake can show.
    Student(fn(&Setting) -> bool),
}

use Make::{Levels, Pixels, Student, Text};
use Mistake::*;

const fn swapped(faces: OppositeFaces) -> Mistake {
    CubeFacesSwapped { faces }
}

const fn shifted(x: i8, y: i8) -> Mistake {
    Shifted { half_pixels: [x, y] }
}

/// Every mistake, its description, and how it is made. Cheap ones come first.
#[rustfmt::skip]
const TABLE: &[(Mistake, &str, Make)] = &[
    (Unchanged, "", Pixels(|_, _| {})),
    (UpsideDown, "upside down", Pixels(upside_down)),
    (Mirrored, "mirrored left to right", Pixels(mirrored)),
    (Turned, "turned by 180 degrees", Pixels(|pixels, _| pixels.reverse())),
    (RedAndBlueSwapped, "with red and blue swapped",
        Pixels(|pixels, _| pixels.iter_mut().for_each(|color| *color = color.zyx()))),
    (Rounded, "with colours rounded to bytes instead of cut", Levels(|level| level + 0.5)),
    (RoundedUp, "with colours rounded up to bytes instead of cut", Levels(|level| level + (1.0 - 1e-9))),
    (OneLevelBrighter, "one level brighter everywhere", Levels(|level| level.clamp(0.0, 255.0) + 1.0)),
    (OneLevelDarker, "one level darker everywhere", Levels(|level| level.clamp(0.0, 255.5) - 1.0)),
    (Wrapped, "with bytes that start again at 0 above 255", Levels(|level| level.max(0.0).rem_euclid(256.0))),
    (Times256, "with colours times 256 instead of 255", Levels(|level| 256.0 / 255.0 * level)),
    (GammaEncoded, "with a gamma of 2.2", Levels(|level| powered(level, 1.0 / GAMMA))),
    (BytesGammaEncoded, "with a gamma of 2.2 applied to its bytes",
        Levels(|level| powered(level.clamp(0.0, 255.0).trunc(), 1.0 / GAMMA).round() + 0.5)),
    (GammaDecoded, "with an inverse gamma of 2.2", Levels(|level| powered(level, GAMMA))),
    (SrgbEncoded, "with the curve of sRGB", Levels(srgb_encoded)),
    (OtherHandedness, "by a camera of the other handedness (turned by 180 degrees)",
        Make::Camera(|camera, _, _| Some(of_other_handedness(camera)))),
    (HalfScreen, "with a screen of half the size", Make::Camera(|camera, _, _| Some(zoomed(camera, 0.5)))),
    (DoubleScreen, "with a screen of twice the size", Make::Camera(|camera, _, _| Some(zoomed(camera, 2.0)))),
    (AngleOfShorterSide, "with the camera's angle or size over the shorter side", Make::Camera(widened)),
    (AngleNotHalved, "with the tangent of the camera's whole angle instead of half of it",
        Make::Camera(|camera, _, _| with_half_angle(camera, f64::to_radians))),
    (AngleInRadians, "with the degrees of the camera's angle taken for radians",
        Make::Camera(|camera, _, _| with_half_angle(camera, |angle| angle / 2.0))),
    (NoShadows, "without -shadows", Make::Effects(|effects, _| effects.shadows = Shadows::None)),
    (Mistake::Shadows, "with -shadows",
        Make::Effects(|effects, _| replace(&mut effects.shadows, Shadows::None, Shadows::Opaque))),
    (OpaqueShadows, "with -shadows in place of -transparent_shadows",
        Make::Effects(|effects, _| replace(&mut effects.shadows, Shadows::Transparent, Shadows::Opaque))),
    (TransparentShadows, "with -transparent_shadows", Make::Effects(filter_light)),
    (NoShadeBack, "without -shade_back", Make::Effects(|effects, _| effects.shade_back = false)),
    (ShadeBack, "with -shade_back", Make::Effects(|effects, _| effects.shade_back = true)),
    (OneBounceFewer, "with one bounce fewer",
        Make::Effects(|effects, scene| change_bounces(effects, scene, u32::saturating_sub))),
    (OneBounceMore, "with one bounce more",
        Make::Effects(|effects, scene| change_bounces(effects, scene, u32::saturating_add))),
    (WeightIgnored, "without -weight", Make::Effects(|effects, _| effects.min_weight = 0.0)),
    // Without shadows on other objects, reversed lights look the same. They are less common.
    (NoEpsilon { rays: SelfHitting::Shadow }, "where every surface shadows itself, as without an epsilon",
        Student(|setting| setting.has_shadows())),
    (NoAmbient, "without ambient light", Make::Scene(put_out_ambient)),
    (BlackBackground, "with a black background", Make::Scene(blacken_background)),
    (NotAttenuated, "with lights that are not attenuated",
        Make::Scene(|scene| any_attenuation(scene, |attenuation| replaced(attenuation, [1.0, 0.0, 0.0])))),
    (AttenuatedBySquare, "with lights divided by d^2",
        Make::Scene(|scene| any_attenuation(scene, |attenuation| replaced(attenuation, [0.0, 0.0, 1.0])))),
    (LightsTimesPi, "with lights multiplied by pi", Make::Scene(multiply_lights_by_pi)),
    (LightsReversed, "with directional lights from the other side", Make::Scene(reverse_lights)),
    (NoHighlights, "without highlights",
        Make::Scene(|scene| any_phong(scene, |phong| replaced(&mut phong.specular, Color::ZERO)))),
    (IndexInverted, "with the index of refraction inverted",
        Make::Scene(|scene| any_phong(scene, invert_index))),
    (CheckerboardSwapped, "with the other parity of checkerboards",
        Make::Scene(|scene| any(&mut scene.materials, swap_checkerboard))),
    (BlinnHighlights, "with highlights by the half-way vector",
        Make::Scene(use_half_way_vectors)),
    (AspectKept, "with the view of 2004, which is not stretched",
        Make::Scene(|scene| replaced(&mut scene.screen, Screen::LongerSide))),
    (FlatMeshes, "with the normals of the faces", Make::Scene(flatten_meshes)),
    (OtherFaceWeights, "with other weights of the faces around a vertex", Make::Scene(weigh_faces_otherwise)),
    (swapped(OppositeFaces::FrontAndBack), "with the faces front and back of the cube map swapped",
        Make::Scene(|scene| swap_faces(scene, &[2]))),
    (swapped(OppositeFaces::LeftAndRight), "with the faces left and right of the cube map swapped",
        Make::Scene(|scene| swap_faces(scene, &[0]))),
    (swapped(OppositeFaces::UpAndDown), "with the faces up and down of the cube map swapped",
        Make::Scene(|scene| swap_faces(scene, &[1]))),
    (swapped(OppositeFaces::All), "with all opposite faces of the cube map swapped",
        Make::Scene(|scene| swap_faces(scene, &[0, 1, 2]))),
    (FalloffFromOne, "with lights divided by 1 + falloff d^2 instead of falloff d^2",
        Make::Scene(|scene| falls_off_from(scene, 1.0))),
    (FalloffWithoutOne, "with lights divided by falloff d^2 instead of 1 + falloff d^2",
        Make::Scene(|scene| falls_off_from(scene, 0.0))),
    (Highlights, "with highlights", Make::Scene(add_highlights)),
    (NearWhite, "with depths that are white where they are near, instead of black",
        Make::Scene(|scene| replaced(&mut scene.measure_colors.depths, Depths::NearWhite))),
    (AbsoluteNormals, "with the absolute values of normals instead of (N + 1) / 2",
        Make::Scene(|scene| replaced(&mut scene.measure_colors.normals, NormalColors::Absolute))),
    (ShiftedNormals, "with normals as (N + 1) / 2 instead of their absolute values",
        Make::Scene(shift_normals)),
    (ListsReversed, "with the transformations of a list multiplied in the other order",
        Text(with_lists_reversed)),
    (NestingReversed, "with nested transforms multiplied in the other order",
        Text(|scene, _| with_nesting_reversed(scene))),
    (AmbientPerLight, "with the ambient light once for each light", Make::Scene(add_ambient_per_light)),
    (ExponentDoubled, "with the exponents of highlights doubled",
        Make::Scene(|scene| any_phong(scene, |phong| scale_exponent(phong, 2.0)))),
    (ExponentHalved, "with the exponents of highlights halved",
        Make::Scene(|scene| any_phong(scene, |phong| scale_exponent(phong, 0.5)))),
    (RotationsInRadians, "with the degrees of rotations taken for radians", Text(in_radians)),
    (shifted(-1, -1), "with rays through the lower left corners of the pixels instead of their centres",
        Student(always)),
    (shifted(-1, 1), "with rays through the upper left corners of the pixels instead of their centres",
        Student(always)),
    (shifted(1, 1), "with rays through the upper right corners of the pixels instead of their centres",
        Student(always)),
    (shifted(1, -1), "with rays through the lower right corners of the pixels instead of their centres",
        Student(always)),
    (shifted(-1, 0), "with rays half a pixel further to the left", Student(always)),
    (shifted(1, 0), "with rays half a pixel further to the right", Student(always)),
    (shifted(0, 1), "with rays half a pixel further up", Student(always)),
    (shifted(0, -1), "with rays half a pixel further down", Student(always)),
    (shifted(-2, -2), "with rays one pixel further down and to the left", Student(always)),
    (shifted(-2, 2), "with rays one pixel further up and to the left", Student(always)),
    (shifted(2, 2), "with rays one pixel further up and to the right", Student(always)),
    (shifted(2, -2), "with rays one pixel further down and to the right", Student(always)),
    (shifted(-2, 0), "with rays one pixel further to the left", Student(always)),
    (shifted(2, 0), "with rays one pixel further to the right", Student(always)),
    (shifted(0, 2), "with rays one pixel further up", Student(always)),
    (shifted(0, -2), "with rays one pixel further down", Student(always)),
    (ShadowsFromBehindLight, "with shadows from behind the light",
        Student(|setting| setting.has_shadows() && setting.has_point_light())),
    (ShadowRaysHalved, "with shadow rays that end halfway to the light",
        Student(|setting| setting.has_shadows() && setting.has_point_light())),
    (NormalFlippedInReflection, "with reflections from the flipped normal",
        Student(|setting| setting.has_mirrors())),
    (ReflectionReversed, "with reflected rays reversed", Student(|setting| setting.has_mirrors())),
    (ReflectionFromBelow, "with reflected rays that start below the surface",
        Student(|setting| setting.has_mirrors())),
    (SamplesClamped, "with the colours of samples clamped before they are summed",
        Student(|setting| setting.request.sampler.count() > 1 || setting.request.filter.support() > 0)),
    (RaysClamped, "with the colours of rays clamped before they are summed",
        Student(|setting| setting.bounces() > 0)),
    (LightsClamped, "with the light of each source clamped before it is summed",
        Student(|setting| setting.is_lit())),
    (BackgroundForCameraOnly, "with black where reflected or refracted rays hit nothing",
        Student(|setting| setting.bounces() > 0 && setting.has_background())),
    (NormalsByMatrix, "with normals transformed by the matrix instead of its inverse transpose",
        Student(|setting| setting.has_transforms())),
    (NormalsOfObjectSpace, "with normals that are not transformed",
        Student(|setting| setting.has_transforms())),
    (CheckerboardCut, "with checkerboards whose coordinates are cut instead of floored",
        Student(|setting| setting.has_pattern(|pattern| pattern == Pattern::Checkerboard))),
    (SchlickSwapped, "with the mirrored and the refracted part of light at glass swapped",
        Student(|setting| setting.scene.lighting.split == Split::Schlick && setting.has_glass())),
    (NormalsFlipped, "with surfaces lit on the side that is seen instead of on their outside",
        Student(|setting| setting.is_lit() && !setting.is_blinn())),
    (HighlightsOnlyWhereLit, "without highlights where the surface faces away from the light",
        Student(|setting| setting.has_highlights() && !setting.is_blinn())),
    (Epsilon { distance: 0.001 }, "with an epsilon of 0.001 for secondary rays, which is too large",
        Student(|setting| setting.overlooks_less_than(0.001))),
    (Epsilon { distance: 0.003 }, "with an epsilon of 0.003 for secondary rays, which is too large",
        Student(|setting| setting.overlooks_less_than(0.003))),
    (Epsilon { distance: 0.01 }, "with an epsilon of 0.01 for secondary rays, which is too large",
        Student(|setting| setting.overlooks_less_than(0.01))),
    (Epsilon { distance: 0.03 }, "with an epsilon of 0.03 for secondary rays, which is too large",
        Student(|setting| setting.overlooks_less_than(0.03))),
    (Epsilon { distance: 0.1 }, "with an epsilon of 0.1 for secondary rays, which is too large",
        Student(|setting| setting.overlooks_less_than(0.1))),
    (Epsilon { distance: 0.3 }, "with an epsilon of 0.3 for secondary rays, which is too large",
        Student(|setting| setting.overlooks_less_than(0.3))),
    (SmallerEpsilon { distance: 0.0001 },
        "with an epsilon of 0.0001 for secondary rays, less than the course's",
        Student(|setting| setting.overlooks_more_than(0.0001))),
    (SmallerEpsilon { distance: 0.001 },
        "with an epsilon of 0.001 for secondary rays, less than the course's",
        Student(|setting| setting.overlooks_more_than(0.001))),
    (NoEpsilon { rays: SelfHitting::Secondary },
        "where reflected and refracted rays hit the surface that they leave, as without an epsilon",
        Student(|setting| setting.bounces() > 0)),
    (NoEpsilon { rays: SelfHitting::All },
        "where all rays hit the surface that they leave, as without an epsilon",
        Student(|setting| setting.has_shadows() && setting.bounces() > 0)),
    (NormalsNotFlipped, "with normals that are not flipped on back faces",
        Student(|setting| setting.request.effects.shade_back && setting.is_lit() && setting.is_blinn())),
    (HighlightsByReflection, "with highlights by R.V instead of N.H",
        Student(|setting| setting.has_highlights() && setting.is_blinn())),
    (HighlightsTimesCosine, "with highlights multiplied by N.L", Student(|setting| setting.has_highlights())),
    (HalfWayNotNormalised, "with half-way vectors that are not normalised",
        Student(|setting| setting.has_highlights() && setting.is_blinn())),
    (DiffuseOverPi, "with diffuse light divided by pi", Student(|setting| setting.is_lit())),
    (DirectionsNotNormalised, "with directions of directional lights that are not normalised",
        Student(|setting| setting.has_long_direction())),
    (PointDirectionsNotNormalised, "with directions to point lights that are not normalised",
        Student(|setting| setting.has_point_light())),
    (AmbientWithoutDiffuse, "with ambient light that is not multiplied by the diffuse colour",
        Student(|setting| setting.scene.background.ambient != Color::ZERO)),
    (AmbientFromAbove, "with ambient light multiplied by (1 + N.y) / 2",
        Student(|setting| setting.scene.background.ambient != Color::ZERO)),
    (NormalNotFlippedInRefraction, "with refraction by the same normal on both sides of a surface",
        Student(|setting| setting.has_glass())),
    (IndexNotInverted, "with the same ratio of indices where rays enter and where they leave",
        Student(|setting| setting.has_glass())),
    (TotalReflectionAdded, "with rays that are mirrored at total internal reflection",
        Student(|setting| setting.has_glass())),
    (GlassWithoutShadows, "without shadows of transparent things",
        Student(|setting| setting.has_shadows() && has(setting.scene, |phong| phong.transparent))),
    (NoiseHalved, "with the noise N as (N + 1) / 2 instead of N + 1/2",
        Student(|setting| setting.has_pattern(|pattern| matches!(pattern, Pattern::Noise { .. })))),
    (ReflectionWithoutColor, "with reflections that are not multiplied by the reflective colour",
        Student(|setting| setting.has_mirrors())),
    (RefractionWithoutColor, "with refracted light that is not multiplied by the transparent colour",
        Student(|setting| setting.has_glass())),
];

impl Mistake {
    /// Returns every mistake tried on the picture of a scene. Cheap ones come first.
    pub fn all() -> impl Iterator<Item = Self> {
        // A camera of the other handedness rotates the picture, too.
        TABLE.iter().map(|&(mistake, ..)| mistake).filter(|&mistake| mistake != Turned)
    }

    /// Returns every mistake tried on a finished picture. `has_colors` is true if more than the bytes is known.
    pub(super) fn of_pixels(has_colors: bool) -> impl Iterator<Item = Self> {
        let needs_colors = |mistake| {
            matches!(mistake, Rounded | RoundedUp | Wrapped | Times256 | GammaEncoded | SrgbEncoded)
        };
        let of_pixels = TABLE
            .iter()
            .map(|&(mistake, ..)| mistake)
            .filter(|&mistake| mistake != Unchanged && mistake.is_of_pixels());
        of_pixels.filter(move |&mistake| has_colors || !needs_colors(mistake))
    }

    /// Returns true if the finished picture is changed, if anything.
    pub(super) fn is_of_pixels(self) -> bool {
        matches!(self.make(), Some(Levels(_) | Pixels(_)))
    }

    fn entry(self) -> Option<&'static (Self, &'static str, Make)> {
        TABLE.iter().find(|(mistake, ..)| *mistake == self)
    }

    /// Returns how the picture is made.
    pub(super) fn make(self) -> Option<Make> {
        self.entry().map(|&(.., make)| make)
    }

    /// Returns the kind of change.
    pub fn kind(self) -> &'static str {
        match self.make() {
            _ if self == Unchanged => "unchanged",
            Some(Levels(_) | Pixels(_)) => "pixels",
            Some(Make::Camera(_) | Make::Effects(_)) => "request",
            Some(Make::Scene(_) | Text(_)) => "scene",
            Some(Student(_)) | None => "rule",
        }
    }

    /// Returns true if both are the same mistake in different degrees.
    pub(super) fn is_akin(self, other: Self) -> bool {
        let kind = |mistake| match mistake {
            BytesGammaEncoded | SrgbEncoded => discriminant(&GammaEncoded),
            DoubleScreen => discriminant(&AngleNotHalved),
            SmallerEpsilon { distance } => discriminant(&Epsilon { distance }),
            _ => discriminant(&mistake),
        };
        kind(self) == kind(other)
    }

    /// Returns true if the mistake can show in a layer.
    pub(super) fn shows_in(self, layer: Layer) -> bool {
        match (self, layer) {
            (NearWhite, _) => matches!(layer, Layer::Depth { .. }),
            (AbsoluteNormals | ShiftedNormals, _) => layer == Layer::Normals,
            (_, Layer::Color) | (Shifted { .. }, _) => true,
            (NormalsByMatrix | NormalsOfObjectSpace, _) => layer == Layer::Normals,
            _ => !matches!(self.make(), Some(Make::Effects(_) | Student(_))),
        }
    }
}

/// A mistake in JSON, with its name if it has one.
#[derive(Serialize)]
struct Kinded {
    kind: &'static str,
    #[serde(flatten)]
    mistake: Option<Mistake>,
}

fn kinded(mistake: &Mistake) -> Kinded {
    Kinded { kind: mistake.kind(), mistake: Some(*mistake).filter(|mistake| *mistake != Unchanged) }
}

/// Writes a mistake with its kind.
pub(super) fn with_kind<S: Serializer>(mistake: &Mistake, serializer: S) -> Result<S::Ok, S::Error> {
    kinded(mistake).serialize(serializer)
}

/// Writes mistakes with their kinds.
pub(super) fn with_kinds<S: Serializer>(mistakes: &[Mistake], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(mistakes.iter().map(kinded))
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.entry() {
            None | Some((Unchanged, ..)) => Ok(()),
            Some((_, words, _)) => write!(f, " {words}"),
        }
    }
}

/// The scene and the request in which a student's mistake is made.
pub struct Setting<'a> {
    pub scene: &'a Scene,
    pub request: &'a Request,
}

impl Setting<'_> {
    /// Returns the number of bounces that secondary rays can make.
    pub fn bounces(&self) -> u32 {
        if has_secondary_rays(self.scene) { self.request.effects.bounces } else { 0 }
    }

    fn is_lit(&self) -> bool {
        !self.scene.lights.is_empty()
    }

    fn is_blinn(&self) -> bool {
        self.scene.lighting.highlight == Highlight::Blinn
    }

    fn has_shadows(&self) -> bool {
        self.request.effects.shadows != Shadows::None && self.is_lit()
    }

    fn has_mirrors(&self) -> bool {
        self.bounces() > 0 && has(self.scene, |phong| phong.reflective)
    }

    fn has_glass(&self) -> bool {
        self.bounces() > 0 && has(self.scene, |phong| phong.transparent)
    }

    fn has_highlights(&self) -> bool {
        self.is_lit() && has(self.scene, |phong| phong.specular)
    }

    fn has_point_light(&self) -> bool {
        self.scene.lights.iter().any(|light| matches!(light, Light::Point { .. }))
    }

    fn has_long_direction(&self) -> bool {
        self.scene.lights.iter().any(|light| match light {
            Light::Directional { direction, .. } => !direction.is_normalized(),
            Light::Point { .. } => false,
        })
    }

    fn has_background(&self) -> bool {
        self.scene.background.color != Color::ZERO || self.scene.cube_map.is_some()
    }

    fn has_transforms(&self) -> bool {
        self.scene.objects.iter().any(|object| matches!(object, Object::Transform { .. }))
    }

    fn has_pattern(&self, is_meant: fn(Pattern) -> bool) -> bool {
        let is_meant =
            |material: &Material| matches!(material, Material::Texture(texture) if is_meant(texture.pattern));
        self.scene.materials.iter().any(is_meant)
    }

    /// Returns true if secondary rays ignore hits up to less than this distance.
    fn overlooks_less_than(&self, distance: f64) -> bool {
        let epsilon = self.scene.lighting.epsilon;
        (self.has_shadows() || self.bounces() > 0) && epsilon.is_none_or(|epsilon| epsilon < distance)
    }

    /// Returns true if secondary rays ignore hits up to more than this distance.
    fn overlooks_more_than(&self, distance: f64) -> bool {
        let epsilon = self.scene.lighting.epsilon;
        (self.has_shadows() || self.bounces() > 0) && epsilon.is_some_and(|epsilon| epsilon > distance)
    }
}

fn always(_: &Setting) -> bool {
    true
}
