//! The table of common mistakes in ray tracers, in the order in which they are tried.
//!
//! A mistake has one row: its name, what distinguishes it from others of this name, a text that completes "this
//! program's picture", and how the picture is made. Rows about a part of the scene are added for each scene.

use super::changes::*;
use super::paint::Move;
use super::rules::Rule::{self, *};
use super::rules::SelfHitting;
use super::transforms::{combine_nested, each_rotation, reverse_lists, transpose_matrices};
use crate::math::rounded::RoundedAffine;
use crate::picture::{Color, Window};
use crate::render::Request;
use crate::scene::Scene;
use crate::scene::model::{Depths, MeshNormals, NormalColors, Screen};
use crate::trace::Shadows;
use glam::{DVec2, Vec3Swizzles};
use serde::{Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// A mistake. `Display` writes its text, which completes "this program's picture".
#[derive(Clone, Debug)]
pub struct Mistake {
    /// The name in JSON documents, which mistakes of one kind in different degrees share.
    pub name: &'static str,
    /// The degree, or an empty string.
    pub detail: Cow<'static, str>,
    text: Cow<'static, str>,
    /// How the picture is made.
    pub(super) make: Make,
}

/// How the picture of a mistake is made.
#[derive(Clone, Copy, Debug)]
pub(super) enum Make {
    /// By changing the colours of the finished picture.
    Colors {
        change: fn(Color) -> Color,
        /// True if bytes alone do not give the changed colours.
        needs_floats: bool,
    },
    /// By flipping the finished picture: left to right if the first is true, upside down if the second is.
    Flip([bool; 2]),
    /// By leaving some pixels of the finished picture as they were before it was rendered.
    Unset(Unset),
    /// By moving the points that rays pass through.
    Points(Move),
    /// By another request.
    Request(fn(&mut Request, &Scene)),
    /// By changing the scene.
    Scene(fn(&mut Scene)),
    /// By leaving out a part of the scene.
    Without(Part),
    /// By a student's tracer that breaks a rule.
    Rule(Rule),
}

use Make::{Flip, Points};

/// Changes colours that may also be read from bytes.
const fn of_bytes(change: fn(Color) -> Color) -> Make {
    Make::Colors { change, needs_floats: false }
}

/// Changes colours before they are cut to bytes.
const fn of_floats(change: fn(Color) -> Color) -> Make {
    Make::Colors { change, needs_floats: true }
}

/// Builds a row of the table.
const fn row(name: &'static str, detail: &'static str, text: &'static str, make: Make) -> Mistake {
    Mistake { name, detail: Cow::Borrowed(detail), text: Cow::Borrowed(text), make }
}

/// Builds a row that breaks a rule.
const fn rule(name: &'static str, detail: &'static str, text: &'static str, rule: Rule) -> Mistake {
    row(name, detail, text, Make::Rule(rule))
}

const fn scene(
    name: &'static str,
    detail: &'static str,
    text: &'static str,
    change: fn(&mut Scene),
) -> Mistake {
    row(name, detail, text, Make::Scene(change))
}

const fn request(
    name: &'static str,
    detail: &'static str,
    text: &'static str,
    change: fn(&mut Request, &Scene),
) -> Mistake {
    row(name, detail, text, Make::Request(change))
}

/// Every mistake that needs no part of a scene. Cheap ones come first.
#[rustfmt::skip]
pub(super) const TABLE: &[Mistake] = &[
    row("upside_down", "", "upside down", Flip([false, true])),
    row("mirrored", "", "mirrored left to right", Flip([true, false])),
    row("turned", "", "turned by 180 degrees", Flip([true, true])),
    row("red_and_blue_swapped", "", "with red and blue swapped", of_bytes(Color::zyx)),
    row("red_and_green_swapped", "", "with red and green swapped", of_bytes(Color::yxz)),
    row("green_and_blue_swapped", "", "with green and blue swapped", of_bytes(Color::xzy)),
    row("rounded", "", "with colours rounded to bytes instead of cut", of_floats(|color| levels(color, |level| level + 0.5))),
    row("rounded_up", "", "with colours rounded up to bytes instead of cut",
        of_floats(|color| levels(color, |level| level + (1.0 - 1e-9)))),
    row("one_level_brighter", "", "one level brighter everywhere",
        of_bytes(|color| levels(color, |level| level.clamp(0.0, 255.0) + 1.0))),
    row("one_level_darker", "", "one level darker everywhere",
        of_bytes(|color| levels(color, |level| level.clamp(0.0, 255.5) - 1.0))),
    row("wrapped", "", "with bytes that start again at 0 above 255",
        of_floats(|color| levels(color, |level| level.max(0.0).rem_euclid(256.0)))),
    row("times256", "", "with colours times 256 instead of 255", of_floats(|color| levels(color, |level| 256.0 / 255.0 * level))),
    row("gamma", "2.2", "with a gamma of 2.2", of_floats(|color| levels(color, |level| powered(level, 1.0 / GAMMA)))),
    row("gamma", "2.2 of bytes", "with a gamma of 2.2 applied to its bytes",
        of_bytes(|color| levels(color, |level| powered(level.clamp(0.0, 255.0).trunc(), 1.0 / GAMMA).round() + 0.5))),
    row("gamma", "2.0", "with a gamma of 2", of_floats(|color| levels(color, |level| powered(level, 0.5)))),
    row("gamma", "sRGB", "with the curve of sRGB", of_floats(|color| levels(color, srgb_encoded))),
    row("gamma_decoded", "", "with an inverse gamma of 2.2", of_bytes(|color| levels(color, |level| powered(level, GAMMA)))),
    row("tone_mapped", "", "with colours x / (1 + x) instead of x", of_floats(|color| color.map(|x| x.max(0.0) / (1.0 + x.max(0.0))))),
    row("grey", "", "without colours, in greys", of_bytes(|color| Color::splat(color.dot(Color::splat(1.0 / 3.0))))),
    request("other_handedness", "", "by a camera of the other handedness (turned by 180 degrees)", turn_up_vector),
    request("screen", "half", "with a screen of half the size", |request, scene| zoom(request, scene, 0.5)),
    request("screen", "double", "with a screen of twice the size", |request, scene| zoom(request, scene, 2.0)),
    request("angle_of_shorter_side", "", "with the camera's angle or size over the shorter side", widen),
    request("angle", "not halved", "with the tangent of the camera's whole angle instead of half of it",
        |request, scene| set_half_tangent(request, scene, libm::tan)),
    request("angle", "quartered", "with the tangent of a quarter of the camera's angle instead of half of it",
        |request, scene| set_half_tangent(request, scene, |angle| libm::tan(0.25 * angle))),
    request("angle", "without tangent", "with half the camera's angle in place of its tangent",
        |request, scene| set_half_tangent(request, scene, |angle| 0.5 * angle)),
    request("angle", "sine", "with the sine of half the camera's angle in place of its tangent",
        |request, scene| set_half_tangent(request, scene, |angle| libm::sin(0.5 * angle))),
    request("angle", "in radians", "with the degrees of the camera's angle taken for radians",
        |request, scene| set_half_tangent(request, scene, |angle| libm::tan(0.5 * angle.to_degrees()))),
    row("stretched", "", "stretched to the picture's shape, as if its width equalled its height", Points(stretched)),
    row("aspect_inverted", "", "with height / width in place of width / height", Points(wrongly_stretched)),
    request("no_shadows", "", "without -shadows", drop_shadows),
    request("shadows", "", "with -shadows", |request, _| replace_shadows(request, Shadows::None, Shadows::Opaque)),
    request("opaque_shadows", "", "with -shadows in place of -transparent_shadows",
        |request, _| replace_shadows(request, Shadows::Transparent, Shadows::Opaque)),
    request("transparent_shadows", "", "with -transparent_shadows", filter_light),
    request("no_shade_back", "", "without -shade_back", |request, _| request.effects.shade_back = false),
    request("shade_back", "", "with -shade_back", |request, _| request.effects.shade_back = true),
    request("one_bounce_fewer", "", "with one bounce fewer",
        |request, _| request.effects.bounces = request.effects.bounces.saturating_sub(1)),
    request("one_bounce_more", "", "with one bounce more",
        |request, _| request.effects.bounces = request.effects.bounces.saturating_add(1)),
    request("no_bounces", "", "without bounces", |request, _| request.effects.bounces = 0),
    request("weight_ignored", "", "without -weight", |request, _| request.effects.min_weight = 0.0),
    // The course's own pictures of four and five bounces in scene4_06 have it.
    request("weight_squared", "", "with -weight compared with the squares of the colours' lengths",
        |request, _| request.effects.min_weight = request.effects.min_weight.sqrt()),
    // Without shadows on other objects, reversed lights look the same. They are less common.
    rule("no_epsilon", "shadow", "where every surface shadows itself, as without an epsilon", NoEpsilon(SelfHitting::Shadow)),
    scene("no_ambient", "", "without ambient light", put_out_ambient),
    scene("black_background", "", "with a black background", blacken_background),
    scene("not_attenuated", "", "with lights that are not attenuated",
        |scene| each_attenuation(scene, |_| [1.0, 0.0, 0.0])),
    scene("attenuation", "d^2 alone", "with lights divided by d^2", |scene| each_attenuation(scene, |_| [0.0, 0.0, 1.0])),
    scene("attenuation", "d for d^2", "with attenuation by d in place of d^2",
        |scene| each_attenuation(scene, |[constant, linear, square]| [constant, linear + square, 0.0])),
    scene("attenuation", "reversed", "with the coefficients of attenuation in the other order",
        |scene| each_attenuation(scene, |[constant, linear, square]| [square, linear, constant])),
    scene("attenuation", "swapped", "with the coefficients of d and d^2 swapped in the attenuation",
        |scene| each_attenuation(scene, |[constant, linear, square]| [constant, square, linear])),
    rule("attenuation", "twice", "with lights that are attenuated twice", AttenuationTwice),
    scene("lights_times_pi", "", "with lights multiplied by pi", multiply_lights_by_pi),
    scene("lights_reversed", "", "with directional lights from the other side", reverse_lights),
    scene("no_highlights", "", "without highlights", drop_highlights),
    scene("no_diffuse", "", "without diffuse light", |scene| each_phong(scene, |phong| phong.diffuse = Color::ZERO)),
    scene("highlights_white", "", "with white highlights in place of coloured ones", |scene| each_phong(scene, whiten_highlight)),
    scene("highlights_white", "everywhere", "with white highlights on all materials", |scene| each_phong(scene, |phong| phong.specular = Color::ONE)),
    scene("index_inverted", "", "with the index of refraction inverted", |scene| each_phong(scene, invert_index)),
    scene("straight_through_glass", "", "with rays that pass straight through glass, without refraction",
        |scene| each_phong(scene, |phong| phong.index_of_refraction = 1.0)),
    scene("materials", "next", "with the next material of the list for each object", |scene| each_material(scene, |id, last| if id == last { 0 } else { id + 1 })),
    scene("materials", "previous", "with the previous material of the list for each object", |scene| each_material(scene, |id, last| if id == 0 { last } else { id - 1 })),
    scene("materials", "first", "with the first material for all objects", |scene| each_material(scene, |_, _| 0)),
    scene("materials", "last", "with the last material for all objects", |scene| each_material(scene, |_, last| last)),
    scene("object_missing", "first of each group", "without the first object of each group", |scene| each_group(scene, |children| {
        children.drain(..children.len().min(1));
    })),
    scene("object_missing", "last of each group", "without the last object of each group", |scene| each_group(scene, |children| {
        children.pop();
    })),
    row("triangles_missing", "last of each mesh", "without the last triangle of each mesh", Make::Without(Part::Triangle { of: None, is_last: true })),
    row("triangles_missing", "first of each mesh", "without the first triangle of each mesh", Make::Without(Part::Triangle { of: None, is_last: false })),
    scene("checkerboard_swapped", "", "with the other parity of checkerboards", |scene| swap_children(scene, true)),
    scene("textures_swapped", "", "with the two materials of textures swapped", |scene| swap_children(scene, false)),
    scene("texture_matrix", "missing", "without the transforms of textures",
        |scene| each_texture(scene, |texture| texture.world_to_texture = RoundedAffine::IDENTITY)),
    scene("texture_matrix", "inverted", "with the inverse transforms of textures", |scene| each_texture(scene, invert_matrix)),
    scene("octaves", "one fewer", "with one octave of noise fewer", |scene| each_octaves(scene, |octaves| octaves.saturating_sub(1))),
    scene("octaves", "one more", "with one octave of noise more", |scene| each_octaves(scene, |octaves| octaves + 1)),
    scene("octaves", "one alone", "with one octave of noise alone", |scene| each_octaves(scene, |octaves| octaves.min(1))),
    scene("blinn_highlights", "", "with highlights by the half-way vector", use_half_way_vectors),
    scene("aspect_kept", "", "with the view of 2004, which is not stretched", |scene| scene.screen = Screen::LongerSide),
    scene("flat_meshes", "", "with the normals of the faces", |scene| scene.mesh_normals = MeshNormals::Flat),
    scene("other_face_weights", "", "with other weights of the faces around a vertex", weigh_faces_otherwise),
    scene("cube_faces_swapped", "front and back", "with the faces front and back of the cube map swapped", |scene| swap_faces(scene, &[2])),
    scene("cube_faces_swapped", "left and right", "with the faces left and right of the cube map swapped", |scene| swap_faces(scene, &[0])),
    scene("cube_faces_swapped", "up and down", "with the faces up and down of the cube map swapped", |scene| swap_faces(scene, &[1])),
    scene("cube_faces_swapped", "all", "with all opposite faces of the cube map swapped", |scene| swap_faces(scene, &[0, 1, 2])),
    scene("falloff_from_one", "", "with lights divided by 1 + falloff d^2 instead of falloff d^2", |scene| set_falloff_from(scene, 1.0)),
    scene("falloff_without_one", "", "with lights divided by falloff d^2 instead of 1 + falloff d^2", |scene| set_falloff_from(scene, 0.0)),
    scene("highlights", "", "with highlights", add_highlights),
    scene("near_white", "", "with depths that are white where they are near, instead of black", |scene| scene.measure_colors.depths = Depths::NearWhite),
    scene("near_black", "", "with depths that are black where they are near, instead of white", |scene| scene.measure_colors.depths = Depths::NearBlack),
    rule("depth_along_axis", "", "with depths along the camera's direction instead of along the rays", DepthAlongAxis),
    rule("depth_inverted", "", "with depths that are black where they are near, and a white background", DepthInverted),
    scene("absolute_normals", "", "with the absolute values of normals instead of (N + 1) / 2",
        |scene| scene.measure_colors.normals = NormalColors::Absolute),
    scene("shifted_normals", "", "with normals as (N + 1) / 2 instead of their absolute values",
        |scene| scene.measure_colors.normals = NormalColors::Shifted),
    rule("shifted_normals", "black background", "with normals as (N + 1) / 2, and a black background", NormalsShifted),
    rule("clamped_normals", "", "with normals whose negative coordinates are black instead of absolute values", NormalsClamped),
    scene("lists_reversed", "", "with the transformations of a list multiplied in the other order", reverse_lists),
    scene("nesting_reversed", "", "with nested transforms multiplied in the other order", |scene| combine_nested(scene, |outer, inner| inner * outer)),
    scene("nesting_ignored", "innermost", "with the innermost of nested transforms alone", |scene| combine_nested(scene, |_, inner| inner)),
    scene("nesting_ignored", "outermost", "with the outermost of nested transforms alone", |scene| combine_nested(scene, |outer, _| outer)),
    scene("matrices_transposed", "", "with the matrices of transforms transposed", transpose_matrices),
    scene("rotations", "reversed", "with rotations in the other direction", |scene| each_rotation(scene, |degrees| -degrees)),
    scene("rotations", "in radians", "with the degrees of rotations taken for radians", |scene| each_rotation(scene, f64::to_degrees)),
    scene("ambient_per_light", "", "with the ambient light once for each light",
        |scene| scene.background.ambient *= scene.lights.len().max(1) as f64),
    scene("exponent", "quartered", "with a quarter of the exponents of highlights", |scene| each_phong(scene, |phong| phong.exponent *= 0.25)),
    scene("exponent", "halved", "with the exponents of highlights halved", |scene| each_phong(scene, |phong| phong.exponent *= 0.5)),
    scene("exponent", "doubled", "with the exponents of highlights doubled", |scene| each_phong(scene, |phong| phong.exponent *= 2.0)),
    scene("exponent", "quadrupled", "with the exponents of highlights times four", |scene| each_phong(scene, |phong| phong.exponent *= 4.0)),
    scene("reflective_color", "squared", "with reflections multiplied by the square of the reflective colour",
        |scene| each_phong(scene, |phong| phong.reflective *= phong.reflective)),
    scene("reflective_color", "doubled", "with reflections that are added twice", |scene| each_phong(scene, |phong| phong.reflective *= 2.0)),
    scene("reflective_color", "negative", "with reflections that are subtracted instead of added",
        |scene| each_phong(scene, |phong| phong.reflective = -phong.reflective)),
    scene("transparent_color", "squared", "with refracted light multiplied by the square of the transparent colour",
        |scene| each_phong(scene, |phong| phong.transparent *= phong.transparent)),
    scene("transparent_color", "doubled", "with refracted light that is added twice", |scene| each_phong(scene, |phong| phong.transparent *= 2.0)),
    scene("transparent_color", "negative", "with refracted light that is subtracted instead of added",
        |scene| each_phong(scene, |phong| phong.transparent = -phong.transparent)),
    scene("no_reflection", "", "without reflections", |scene| each_phong(scene, |phong| phong.reflective = Color::ZERO)),
    scene("no_refraction", "", "without refracted light", |scene| each_phong(scene, |phong| phong.transparent = Color::ZERO)),
    scene("epsilon", "0.003", "with an epsilon of 0.003 for secondary rays", |scene| scene.lighting.epsilon = Some(0.003)),
    scene("epsilon", "0.01", "with an epsilon of 0.01 for secondary rays", |scene| scene.lighting.epsilon = Some(0.01)),
    scene("epsilon", "0.03", "with an epsilon of 0.03 for secondary rays", |scene| scene.lighting.epsilon = Some(0.03)),
    scene("epsilon", "0.1", "with an epsilon of 0.1 for secondary rays", |scene| scene.lighting.epsilon = Some(0.1)),
    scene("epsilon", "0.3", "with an epsilon of 0.3 for secondary rays", |scene| scene.lighting.epsilon = Some(0.3)),
    row("pixel_corners", "lower left", "with rays through the lower left corners of the pixels instead of their centres", Points(|_, _| DVec2::new(-0.5, -0.5))),
    row("pixel_corners", "upper left", "with rays through the upper left corners of the pixels instead of their centres", Points(|_, _| DVec2::new(-0.5, 0.5))),
    row("pixel_corners", "upper right", "with rays through the upper right corners of the pixels instead of their centres", Points(|_, _| DVec2::new(0.5, 0.5))),
    row("pixel_corners", "lower right", "with rays through the lower right corners of the pixels instead of their centres", Points(|_, _| DVec2::new(0.5, -0.5))),
    row("shifted", "half a pixel left", "with rays half a pixel further to the left", Points(|_, _| DVec2::new(-0.5, 0.0))),
    row("shifted", "half a pixel right", "with rays half a pixel further to the right", Points(|_, _| DVec2::new(0.5, 0.0))),
    row("shifted", "half a pixel up", "with rays half a pixel further up", Points(|_, _| DVec2::new(0.0, 0.5))),
    row("shifted", "half a pixel down", "with rays half a pixel further down", Points(|_, _| DVec2::new(0.0, -0.5))),
    row("shifted", "a pixel down and left", "with rays one pixel further down and to the left", Points(|_, _| DVec2::new(-1.0, -1.0))),
    row("shifted", "a pixel up and left", "with rays one pixel further up and to the left", Points(|_, _| DVec2::new(-1.0, 1.0))),
    row("shifted", "a pixel up and right", "with rays one pixel further up and to the right", Points(|_, _| DVec2::new(1.0, 1.0))),
    row("shifted", "a pixel down and right", "with rays one pixel further down and to the right", Points(|_, _| DVec2::new(1.0, -1.0))),
    row("shifted", "a pixel left", "with rays one pixel further to the left", Points(|_, _| DVec2::new(-1.0, 0.0))),
    row("shifted", "a pixel right", "with rays one pixel further to the right", Points(|_, _| DVec2::new(1.0, 0.0))),
    row("shifted", "a pixel up", "with rays one pixel further up", Points(|_, _| DVec2::new(0.0, 1.0))),
    row("shifted", "a pixel down", "with rays one pixel further down", Points(|_, _| DVec2::new(0.0, -1.0))),
    row("pixel_spacing", "", "with pixel i at i / (width - 1) instead of (i + 1/2) / width", Points(spread_to_borders)),
    row("pixel_spacing", "centres", "with pixel i at (i + 1/2) / (width - 1) instead of (i + 1/2) / width", Points(spread_beyond_borders)),
    rule("shadows_from_behind_light", "", "with shadows from behind the light", ShadowsFromBehindLight),
    rule("shadow_rays_halved", "", "with shadow rays that end halfway to the light", ShadowRaysHalved),
    rule("shadows_halve", "", "with shadows that halve the light instead of blocking it", ShadowsHalve),
    rule("shadows_of_first_light", "", "with shadows of the first light alone", ShadowsOfFirstLight),
    rule("shadows_of_any_light", "", "where the shadow of one light blocks all lights", ShadowsOfAnyLight),
    rule("shadows_black", "", "with shadows that block the ambient light, too", ShadowsBlack),
    rule("shadow_bias", "0.001", "with shadow rays that start 0.001 along the normal", ShadowBias(0.001)),
    rule("shadow_bias", "0.01", "with shadow rays that start 0.01 along the normal", ShadowBias(0.01)),
    rule("shadow_bias", "0.1", "with shadow rays that start 0.1 along the normal", ShadowBias(0.1)),
    rule("normal_flipped_in_reflection", "", "with reflections from the flipped normal", NormalFlippedInReflection),
    rule("reflection_reversed", "", "with reflected rays reversed", ReflectionReversed),
    rule("reflection_from_below", "", "with reflected rays that start below the surface", ReflectionFromBelow),
    rule("samples_clamped", "", "with the colours of samples clamped before they are summed", SamplesClamped),
    rule("rays_clamped", "", "with the colours of rays clamped before they are summed", RaysClamped),
    rule("lights_clamped", "", "with the light of each source clamped before it is summed", LightsClamped),
    rule("lights_overwritten", "", "with the light of one source in place of the sum", LightsOverwritten),
    rule("lights_overwritten", "ambient too", "with the light of one source in place of all other light", LightsAndAmbientOverwritten),
    rule("background_for_camera_only", "", "with black where reflected or refracted rays hit nothing", BackgroundForCameraOnly),
    rule("normals_by_matrix", "", "with normals transformed by the matrix instead of its inverse transpose", NormalsByMatrix),
    rule("normals_by_inverse", "", "with normals transformed by the inverse matrix instead of its transpose", NormalsByInverse),
    rule("normals_of_object_space", "", "with normals that are not transformed", NormalsOfObjectSpace),
    rule("normals_not_normalised", "transformed", "with normals that are not normalised after a transform", NormalsNotNormalised),
    rule("normals_not_normalised", "spheres", "with normals of spheres that are not normalised", SphereNormalsNotNormalised),
    rule("normals_not_normalised", "triangles", "with normals of triangles that are not normalised", TriangleNormalsNotNormalised),
    rule("normals_not_normalised", "all", "with normals that are never normalised", NormalsNeverNormalised),
    rule("winding_reversed", "", "with the normals of triangles on the other side", WindingReversed),
    rule("sphere_normals_inward", "", "with the normals of spheres on the other side", SphereNormalsInward),
    rule("back_faces_culled", "", "without the back faces of triangles", BackFacesCulled),
    rule("front_faces_culled", "", "without the front faces of triangles", FrontFacesCulled),
    rule("last_hit", "", "without a depth test: the last object that a ray hits is seen", LastHit),
    rule("first_hit", "", "where the first object of the list that a ray hits is seen, not the nearest", FirstHit),
    rule("far_hit", "", "with the far hits of spheres in place of the near ones", FarHit),
    rule("t_not_rescaled", "", "with distances of transformed objects that are measured in object space", TNotRescaled),
    rule("checkerboard_cut", "", "with checkerboards whose coordinates are cut instead of floored", CheckerboardCut),
    rule("schlick_swapped", "", "with the mirrored and the refracted part of light at glass swapped", SchlickSwapped),
    rule("normals_flipped", "", "with surfaces lit on the side that is seen instead of on their outside", NormalsFlipped),
    rule("highlights_only_where_lit", "", "without highlights where the surface faces away from the light", HighlightsOnlyWhereLit),
    rule("no_epsilon", "secondary", "where reflected and refracted rays hit the surface that they leave, as without an epsilon",
        NoEpsilon(SelfHitting::Secondary)),
    rule("no_epsilon", "all", "where all rays hit the surface that they leave, as without an epsilon", NoEpsilon(SelfHitting::All)),
    rule("normals_not_flipped", "", "with normals that are not flipped on back faces", NormalsNotFlipped),
    rule("highlights_by_reflection", "", "with highlights by R.V instead of N.H", HighlightsByReflection),
    rule("highlights_by_reflection", "wrong formula", "with highlights by R.V with R = 2 (N.L) (N - L)", HighlightsByWrongReflection),
    rule("highlights_ungated", "", "with highlights also where the surface faces away from the light", HighlightsUngated),
    rule("highlights_times_cosine", "", "with highlights multiplied by N.L", HighlightsTimesCosine),
    rule("highlights_times_diffuse", "", "with highlights multiplied by the diffuse colour", HighlightsTimesDiffuse),
    rule("highlights_normalised", "Phong", "with highlights multiplied by (n + 2) / (2 pi)", HighlightsNormalised(2.0)),
    rule("highlights_normalised", "Blinn", "with highlights multiplied by (n + 8) / (8 pi)", HighlightsNormalised(8.0)),
    rule("half_way_not_normalised", "", "with half-way vectors that are not normalised", HalfWayNotNormalised),
    rule("diffuse_over_pi", "", "with diffuse light divided by pi", DiffuseOverPi),
    rule("diffuse", "not clamped", "with diffuse light that is negative where N.L is", DiffuseNotClamped),
    rule("diffuse", "absolute", "with the absolute value of N.L", DiffuseAbsolute),
    rule("diffuse", "cosine absolute", "with the absolute value of N.L, also for highlights", CosineAbsolute),
    rule("directions_not_normalised", "", "with directions of directional lights that are not normalised", DirectionsNotNormalised),
    rule("point_directions_not_normalised", "", "with directions to point lights that are not normalised", PointDirectionsNotNormalised),
    rule("ambient_without_diffuse", "", "with ambient light that is not multiplied by the diffuse colour", AmbientWithoutDiffuse),
    rule("ambient_from_above", "", "with ambient light multiplied by (1 + N.y) / 2", AmbientFromAbove),
    rule("normal_not_flipped_in_refraction", "", "with refraction by the same normal on both sides of a surface", NormalNotFlippedInRefraction),
    rule("index_not_inverted", "", "with the same ratio of indices where rays enter and where they leave", IndexNotInverted),
    rule("total_reflection_added", "", "with rays that are mirrored at total internal reflection", TotalReflectionAdded),
    rule("total_reflection_dropped", "", "without mirrored rays at total internal reflection", TotalReflectionDropped),
    rule("total_reflection_straight", "", "with rays that pass straight on at total internal reflection", TotalReflectionStraight),
    rule("glass_without_shadows", "", "without shadows of transparent things", GlassWithoutShadows),
    rule("noise_halved", "", "with the noise N as (N + 1) / 2 instead of N + 1/2", NoiseHalved),
    rule("noise_smooth_step", "", "with noise that is interpolated by t^2 (3 - 2 t)", NoiseSmoothStep),
    rule("wood", "root missing", "with wood whose radius is x^2 + z^2, without the root", WoodRootMissing),
    rule("wood", "not squared", "with wood whose rings are not squared", WoodNotSquared),
    rule("reflection_without_color", "", "with reflections that are not multiplied by the reflective colour", ReflectionWithoutColor),
    rule("refraction_without_color", "", "with refracted light that is not multiplied by the transparent colour", RefractionWithoutColor),
    rule("reflection_blended", "", "with the surface's own colour times 1 minus the reflective colour", ReflectionBlended),
    rule("refraction_blended", "", "with the surface's own colour times 1 minus the transparent colour", RefractionBlended),
];

impl Mistake {
    /// Returns this program's own picture, without a mistake.
    pub fn unchanged() -> Self {
        Self::unnamed(Flip([false, false]))
    }

    /// Returns every mistake in the table. Cheap ones come first.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.iter().cloned()
    }

    /// Returns the mistake of pixels that were never set, in a picture of this size.
    pub(super) fn unset(unset: Unset, size: [usize; 2]) -> Self {
        let Window { x, y, width, height } = unset.window;
        let shown = match (width == size[0], height == size[1], y, x) {
            (true, _, 0, _) => format!("the top {}", rows(height)),
            (true, ..) if y + height == size[1] => format!("the bottom {}", rows(height)),
            (_, true, _, 0) => format!("the left {}", columns(width)),
            (_, true, ..) if x + width == size[0] => format!("the right {}", columns(width)),
            _ => format!("{width} x {height} pixels at ({x}, {y})"),
        };
        let [red, green, blue] = unset.color;
        let text = format!("with {shown} left at ({red}, {green}, {blue}), as if never set");
        Self { name: "unset", detail: shown.into(), text: text.into(), make: Make::Unset(unset) }
    }

    /// Returns a mistake that leaves out a part of a scene: this thing in this line.
    pub(super) fn without(name: &'static str, thing: &str, line: u32, part: Part) -> Self {
        let (detail, text) = (format!("line {line}"), format!("without {thing} in line {line}"));
        Self { name, detail: detail.into(), text: text.into(), make: Make::Without(part) }
    }

    /// Returns a change that is tried and never named.
    pub(super) fn unnamed(make: Make) -> Self {
        row("", "", "", make)
    }

    /// Returns true if the mistake is made in the finished picture, without rendering.
    pub(super) fn is_of_pixels(&self) -> bool {
        matches!(self.make, Make::Colors { .. } | Flip(_) | Make::Unset(_))
    }

    /// Returns true if the mistake cannot be made in a picture whose bytes alone are known.
    pub(super) fn needs_floats(&self) -> bool {
        matches!(self.make, Make::Colors { needs_floats: true, .. })
    }

    /// Returns the kind of change.
    pub fn kind(&self) -> &'static str {
        match self.make {
            _ if self.is_unchanged() => "unchanged",
            Make::Colors { .. } | Flip(_) | Make::Unset(_) => "pixels",
            Make::Request(_) => "request",
            Make::Scene(_) | Make::Without(_) => "scene",
            Points(_) | Make::Rule(_) => "rule",
        }
    }

    /// Returns true if it is this program's own picture.
    pub fn is_unchanged(&self) -> bool {
        self.name.is_empty()
    }

    /// Returns true if both are the same mistake in different degrees.
    pub(super) fn is_akin(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl PartialEq for Mistake {
    fn eq(&self, other: &Self) -> bool {
        (&self.name, &self.detail) == (&other.name, &other.detail)
    }
}

fn rows(count: usize) -> String {
    if count == 1 { "row".into() } else { format!("{count} rows") }
}

fn columns(count: usize) -> String {
    if count == 1 { "column".into() } else { format!("{count} columns") }
}

/// A mistake as it stands in JSON documents.
impl Serialize for Mistake {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Named<'m> {
            kind: &'static str,
            #[serde(skip_serializing_if = "Option::is_none")]
            name: Option<&'m str>,
            #[serde(skip_serializing_if = "str::is_empty")]
            detail: &'m str,
        }
        let name = (!self.is_unchanged()).then_some(self.name);
        Named { kind: self.kind(), name, detail: &self.detail }.serialize(serializer)
    }
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &*self.text {
            "" => Ok(()),
            words => write!(f, " {words}"),
        }
    }
}
