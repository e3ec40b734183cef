//! The table of common mistakes in ray tracers, in the order in which they are tried.

use super::changes::*;
use super::student::SelfHitting;
use super::transforms::{read_in_radians, reverse_lists, reverse_nesting};
use crate::picture::Color;
use crate::render::Request;
use crate::scene::Scene;
use crate::scene::model::{Depths, MeshNormals, NormalColors, Screen};
use crate::trace::Shadows;
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
    /// Hits nearer than the distance to the start of a secondary ray are ignored.
    Epsilon {
        distance: f64,
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
    /// By changing the colours of the finished picture.
    Colors(fn(Color) -> Color),
    /// By flipping the finished picture: left to right if the first is true, upside down if the second is.
    Flip([bool; 2]),
    /// By another request.
    Request(fn(&mut Request, &Scene)),
    /// By changing the scene.
    Scene(fn(&mut Scene)),
    /// By reading the scene's text differently.
    Text(fn(&mut Scene, &str)),
    /// By a student's tracer with this mistake.
    Student,
}

use Make::{Colors, Flip, Student, Text};
use Mistake::*;

const fn swapped(faces: OppositeFaces) -> Mistake {
    CubeFacesSwapped { faces }
}

const fn shifted(x: i8, y: i8) -> Mistake {
    Shifted { half_pixels: [x, y] }
}

const fn epsilon(distance: f64) -> Mistake {
    Epsilon { distance }
}

/// Every mistake, its description, and how it is made. Cheap ones come first.
#[rustfmt::skip]
const TABLE: &[(Mistake, &str, Make)] = &[
    (Unchanged, "", Flip([false, false])),
    (UpsideDown, "upside down", Flip([false, true])),
    (Mirrored, "mirrored left to right", Flip([true, false])),
    (Turned, "turned by 180 degrees", Flip([true, true])),
    (RedAndBlueSwapped, "with red and blue swapped", Colors(Color::zyx)),
    (Rounded, "with colours rounded to bytes instead of cut", Colors(|color| levels(color, |level| level + 0.5))),
    (RoundedUp, "with colours rounded up to bytes instead of cut", Colors(|color| levels(color, |level| level + (1.0 - 1e-9)))),
    (OneLevelBrighter, "one level brighter everywhere", Colors(|color| levels(color, |level| level.clamp(0.0, 255.0) + 1.0))),
    (OneLevelDarker, "one level darker everywhere", Colors(|color| levels(color, |level| level.clamp(0.0, 255.5) - 1.0))),
    (Wrapped, "with bytes that start again at 0 above 255", Colors(|color| levels(color, |level| level.max(0.0).rem_euclid(256.0)))),
    (Times256, "with colours times 256 instead of 255", Colors(|color| levels(color, |level| 256.0 / 255.0 * level))),
    (GammaEncoded, "with a gamma of 2.2", Colors(|color| levels(color, |level| powered(level, 1.0 / GAMMA)))),
    (BytesGammaEncoded, "with a gamma of 2.2 applied to its bytes",
        Colors(|color| levels(color, |level| powered(level.clamp(0.0, 255.0).trunc(), 1.0 / GAMMA).round() + 0.5))),
    (GammaDecoded, "with an inverse gamma of 2.2", Colors(|color| levels(color, |level| powered(level, GAMMA)))),
    (SrgbEncoded, "with the curve of sRGB", Colors(|color| levels(color, srgb_encoded))),
    (OtherHandedness, "by a camera of the other handedness (turned by 180 degrees)",
        Make::Request(turn_up_vector)),
    (HalfScreen, "with a screen of half the size", Make::Request(|request, scene| zoom(request, scene, 0.5))),
    (DoubleScreen, "with a screen of twice the size", Make::Request(|request, scene| zoom(request, scene, 2.0))),
    (AngleOfShorterSide, "with the camera's angle or size over the shorter side", Make::Request(widen)),
    (AngleNotHalved, "with the tangent of the camera's whole angle instead of half of it",
        Make::Request(|request, scene| set_half_angle(request, scene, f64::to_radians))),
    (AngleInRadians, "with the degrees of the camera's angle taken for radians",
        Make::Request(|request, scene| set_half_angle(request, scene, |angle| angle / 2.0))),
    (NoShadows, "without -shadows", Make::Request(|request, _| request.effects.shadows = Shadows::None)),
    (Mistake::Shadows, "with -shadows",
        Make::Request(|request, _| replace_shadows(request, Shadows::None, Shadows::Opaque))),
    (OpaqueShadows, "with -shadows in place of -transparent_shadows",
        Make::Request(|request, _| replace_shadows(request, Shadows::Transparent, Shadows::Opaque))),
    (TransparentShadows, "with -transparent_shadows", Make::Request(filter_light)),
    (NoShadeBack, "without -shade_back", Make::Request(|request, _| request.effects.shade_back = false)),
    (ShadeBack, "with -shade_back", Make::Request(|request, _| request.effects.shade_back = true)),
    (OneBounceFewer, "with one bounce fewer", Make::Request(|request, _| {
        request.effects.bounces = request.effects.bounces.saturating_sub(1);
    })),
    (OneBounceMore, "with one bounce more", Make::Request(|request, _| {
        request.effects.bounces = request.effects.bounces.saturating_add(1);
    })),
    (WeightIgnored, "without -weight", Make::Request(|request, _| request.effects.min_weight = 0.0)),
    // Without shadows on other objects, reversed lights look the same. They are less common.
    (NoEpsilon { rays: SelfHitting::Shadow }, "where every surface shadows itself, as without an epsilon",
        Student),
    (NoAmbient, "without ambient light", Make::Scene(put_out_ambient)),
    (BlackBackground, "with a black background", Make::Scene(blacken_background)),
    (NotAttenuated, "with lights that are not attenuated",
        Make::Scene(|scene| each_attenuation(scene, |attenuation| *attenuation = [1.0, 0.0, 0.0]))),
    (AttenuatedBySquare, "with lights divided by d^2",
        Make::Scene(|scene| each_attenuation(scene, |attenuation| *attenuation = [0.0, 0.0, 1.0]))),
    (LightsTimesPi, "with lights multiplied by pi", Make::Scene(multiply_lights_by_pi)),
    (LightsReversed, "with directional lights from the other side", Make::Scene(reverse_lights)),
    (NoHighlights, "without highlights",
        Make::Scene(|scene| each_phong(scene, |phong| phong.specular = Color::ZERO))),
    (IndexInverted, "with the index of refraction inverted", Make::Scene(|scene| each_phong(scene, invert_index))),
    (CheckerboardSwapped, "with the other parity of checkerboards", Make::Scene(swap_checkerboards)),
    (BlinnHighlights, "with highlights by the half-way vector", Make::Scene(use_half_way_vectors)),
    (AspectKept, "with the view of 2004, which is not stretched",
        Make::Scene(|scene| scene.screen = Screen::LongerSide)),
    (FlatMeshes, "with the normals of the faces", Make::Scene(|scene| scene.mesh_normals = MeshNormals::Flat)),
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
        Make::Scene(|scene| set_falloff_from(scene, 1.0))),
    (FalloffWithoutOne, "with lights divided by falloff d^2 instead of 1 + falloff d^2",
        Make::Scene(|scene| set_falloff_from(scene, 0.0))),
    (Highlights, "with highlights", Make::Scene(add_highlights)),
    (NearWhite, "with depths that are white where they are near, instead of black",
        Make::Scene(|scene| scene.measure_colors.depths = Depths::NearWhite)),
    (AbsoluteNormals, "with the absolute values of normals instead of (N + 1) / 2",
        Make::Scene(|scene| scene.measure_colors.normals = NormalColors::Absolute)),
    (ShiftedNormals, "with normals as (N + 1) / 2 instead of their absolute values", Make::Scene(shift_normals)),
    (ListsReversed, "with the transformations of a list multiplied in the other order", Text(reverse_lists)),
    (NestingReversed, "with nested transforms multiplied in the other order", Make::Scene(reverse_nesting)),
    (AmbientPerLight, "with the ambient light once for each light", Make::Scene(add_ambient_per_light)),
    (ExponentDoubled, "with the exponents of highlights doubled",
        Make::Scene(|scene| each_phong(scene, |phong| phong.exponent *= 2.0))),
    (ExponentHalved, "with the exponents of highlights halved",
        Make::Scene(|scene| each_phong(scene, |phong| phong.exponent *= 0.5))),
    (RotationsInRadians, "with the degrees of rotations taken for radians", Text(read_in_radians)),
    (epsilon(0.0001), "with an epsilon of 0.0001 for secondary rays",
        Make::Scene(|scene| scene.lighting.epsilon = Some(0.0001))),
    (epsilon(0.001), "with an epsilon of 0.001 for secondary rays",
        Make::Scene(|scene| scene.lighting.epsilon = Some(0.001))),
    (epsilon(0.003), "with an epsilon of 0.003 for secondary rays",
        Make::Scene(|scene| scene.lighting.epsilon = Some(0.003))),
    (epsilon(0.01), "with an epsilon of 0.01 for secondary rays",
        Make::Scene(|scene| scene.lighting.epsilon = Some(0.01))),
    (epsilon(0.03), "with an epsilon of 0.03 for secondary rays",
        Make::Scene(|scene| scene.lighting.epsilon = Some(0.03))),
    (epsilon(0.1), "with an epsilon of 0.1 for secondary rays",
        Make::Scene(|scene| scene.lighting.epsilon = Some(0.1))),
    (epsilon(0.3), "with an epsilon of 0.3 for secondary rays",
        Make::Scene(|scene| scene.lighting.epsilon = Some(0.3))),
    (shifted(-1, -1), "with rays through the lower left corners of the pixels instead of their centres",
        Student),
    (shifted(-1, 1), "with rays through the upper left corners of the pixels instead of their centres",
        Student),
    (shifted(1, 1), "with rays through the upper right corners of the pixels instead of their centres",
        Student),
    (shifted(1, -1), "with rays through the lower right corners of the pixels instead of their centres",
        Student),
    (shifted(-1, 0), "with rays half a pixel further to the left", Student),
    (shifted(1, 0), "with rays half a pixel further to the right", Student),
    (shifted(0, 1), "with rays half a pixel further up", Student),
    (shifted(0, -1), "with rays half a pixel further down", Student),
    (shifted(-2, -2), "with rays one pixel further down and to the left", Student),
    (shifted(-2, 2), "with rays one pixel further up and to the left", Student),
    (shifted(2, 2), "with rays one pixel further up and to the right", Student),
    (shifted(2, -2), "with rays one pixel further down and to the right", Student),
    (shifted(-2, 0), "with rays one pixel further to the left", Student),
    (shifted(2, 0), "with rays one pixel further to the right", Student),
    (shifted(0, 2), "with rays one pixel further up", Student),
    (shifted(0, -2), "with rays one pixel further down", Student),
    (ShadowsFromBehindLight, "with shadows from behind the light", Student),
    (ShadowRaysHalved, "with shadow rays that end halfway to the light", Student),
    (NormalFlippedInReflection, "with reflections from the flipped normal", Student),
    (ReflectionReversed, "with reflected rays reversed", Student),
    (ReflectionFromBelow, "with reflected rays that start below the surface", Student),
    (SamplesClamped, "with the colours of samples clamped before they are summed", Student),
    (RaysClamped, "with the colours of rays clamped before they are summed", Student),
    (LightsClamped, "with the light of each source clamped before it is summed", Student),
    (BackgroundForCameraOnly, "with black where reflected or refracted rays hit nothing", Student),
    (NormalsByMatrix, "with normals transformed by the matrix instead of its inverse transpose", Student),
    (NormalsOfObjectSpace, "with normals that are not transformed", Student),
    (CheckerboardCut, "with checkerboards whose coordinates are cut instead of floored", Student),
    (SchlickSwapped, "with the mirrored and the refracted part of light at glass swapped", Student),
    (NormalsFlipped, "with surfaces lit on the side that is seen instead of on their outside", Student),
    (HighlightsOnlyWhereLit, "without highlights where the surface faces away from the light", Student),
    (NoEpsilon { rays: SelfHitting::Secondary },
        "where reflected and refracted rays hit the surface that they leave, as without an epsilon",
        Student),
    (NoEpsilon { rays: SelfHitting::All },
        "where all rays hit the surface that they leave, as without an epsilon",
        Student),
    (NormalsNotFlipped, "with normals that are not flipped on back faces", Student),
    (HighlightsByReflection, "with highlights by R.V instead of N.H", Student),
    (HighlightsTimesCosine, "with highlights multiplied by N.L", Student),
    (HalfWayNotNormalised, "with half-way vectors that are not normalised", Student),
    (DiffuseOverPi, "with diffuse light divided by pi", Student),
    (DirectionsNotNormalised, "with directions of directional lights that are not normalised", Student),
    (PointDirectionsNotNormalised, "with directions to point lights that are not normalised", Student),
    (AmbientWithoutDiffuse, "with ambient light that is not multiplied by the diffuse colour", Student),
    (AmbientFromAbove, "with ambient light multiplied by (1 + N.y) / 2", Student),
    (NormalNotFlippedInRefraction, "with refraction by the same normal on both sides of a surface", Student),
    (IndexNotInverted, "with the same ratio of indices where rays enter and where they leave", Student),
    (TotalReflectionAdded, "with rays that are mirrored at total internal reflection", Student),
    (GlassWithoutShadows, "without shadows of transparent things", Student),
    (NoiseHalved, "with the noise N as (N + 1) / 2 instead of N + 1/2", Student),
    (ReflectionWithoutColor, "with reflections that are not multiplied by the reflective colour", Student),
    (RefractionWithoutColor, "with refracted light that is not multiplied by the transparent colour",
        Student),
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

    /// Returns true if the mistake is made in the finished picture, without rendering.
    pub(super) fn is_of_pixels(self) -> bool {
        matches!(self.make(), Colors(_) | Flip(_))
    }

    fn entry(self) -> &'static (Self, &'static str, Make) {
        TABLE.iter().find(|(mistake, ..)| *mistake == self).unwrap_or(&TABLE[0])
    }

    /// Returns how the picture is made.
    pub(super) fn make(self) -> Make {
        self.entry().2
    }

    /// Returns the kind of change.
    pub fn kind(self) -> &'static str {
        match self.make() {
            _ if self == Unchanged => "unchanged",
            Colors(_) | Flip(_) => "pixels",
            Make::Request(_) => "request",
            Make::Scene(_) | Text(_) => "scene",
            Student => "rule",
        }
    }

    /// Returns true if both are the same mistake in different degrees.
    pub(super) fn is_akin(self, other: Self) -> bool {
        let kind = |mistake| match mistake {
            BytesGammaEncoded | SrgbEncoded => discriminant(&GammaEncoded),
            DoubleScreen => discriminant(&AngleNotHalved),
            _ => discriminant(&mistake),
        };
        kind(self) == kind(other)
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
        match self.entry().1 {
            "" => Ok(()),
            words => write!(f, " {words}"),
        }
    }
}
