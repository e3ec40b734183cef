//! Mistakes in what a scene means: its lights, its materials, its transformations.

use super::requests::has;
use super::{rotations, transform_order};
use crate::picture::Color;
use crate::render::Layer;
use crate::scene::material::{Material, Pattern, Phong};
use crate::scene::model::{Depths, FaceWeights, Highlight, MeshNormals, Model, NormalColors, Screen, Split};
use crate::scene::texels::CubeFaces;
use crate::scene::{Light, Scene};
use serde::Serialize;
use std::fmt;

/// A change of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "name", rename_all = "snake_case")]
pub enum SceneChange {
    /// There is no ambient light.
    NoAmbient,
    /// Rays that hit nothing are black.
    BlackBackground,
    /// A point light is as bright at any distance.
    NotAttenuated,
    /// The direction of a directional light is taken for the one towards it.
    LightsReversed,
    /// The ambient light is added once for each light.
    AmbientPerLight,
    /// Exponents of highlights are twice as large.
    ExponentDoubled,
    /// Exponents of highlights are half as large.
    ExponentHalved,
    /// The angles of rotations are taken for radians.
    RotationsInRadians,
    /// There are no highlights.
    NoHighlights,
    /// One over the index of refraction is taken for it.
    IndexInverted,
    /// The two materials of a checkerboard are swapped.
    CheckerboardSwapped,
    /// Highlights by the half-way vector in place of the mirrored direction.
    BlinnHighlights,
    /// The view is not stretched: its angle spans the longer side, to the edges of the pixels.
    AspectKept,
    /// Meshes have the normals of their faces.
    FlatMeshes,
    /// The faces around a vertex count alike in place of by their areas, or the other way round.
    OtherFaceWeights,
    /// Faces of the cube map on opposite sides are swapped.
    CubeFacesSwapped {
        /// Which ones.
        faces: OppositeFaces,
    },
    /// Point lights are 1 / (1 + falloff d²) times as bright in place of 1 / (falloff d²).
    FalloffFromOne,
    /// The other way round.
    FalloffWithoutOne,
    /// There are highlights where there are to be none.
    Highlights,
    /// What is near is white in depths, in place of black.
    NearWhite,
    /// Normals have the colours of their absolute coordinates in place of (N + 1) / 2.
    AbsoluteNormals,
    /// The other way round.
    ShiftedNormals,
    /// The transformations in a list are multiplied in the opposite order.
    ListsReversed,
    /// The matrices of nested transforms are multiplied in the opposite order.
    NestingReversed,
}

/// Faces of a cube map on opposite sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum OppositeFaces {
    /// Left and right.
    LeftAndRight,
    /// Up and down.
    UpAndDown,
    /// Front and back.
    FrontAndBack,
    /// All of these.
    All,
}

impl OppositeFaces {
    /// The pairs of neighbours in the order of the map's files.
    fn pairs(self) -> &'static [usize] {
        match self {
            Self::LeftAndRight => &[0],
            Self::UpAndDown => &[1],
            Self::FrontAndBack => &[2],
            Self::All => &[0, 1, 2],
        }
    }
}

impl SceneChange {
    /// Whether it shows in a layer at all.
    pub(super) fn shows_in(self, layer: Layer) -> bool {
        match self {
            Self::NearWhite => matches!(layer, Layer::Depth { .. }),
            Self::AbsoluteNormals | Self::ShiftedNormals => layer == Layer::Normals,
            _ => true,
        }
    }

    pub(super) const ALL: [Self; 27] = [
        Self::NoAmbient,
        Self::BlackBackground,
        Self::NotAttenuated,
        Self::LightsReversed,
        Self::NoHighlights,
        Self::IndexInverted,
        Self::CheckerboardSwapped,
        Self::BlinnHighlights,
        Self::AspectKept,
        Self::FlatMeshes,
        Self::OtherFaceWeights,
        Self::CubeFacesSwapped { faces: OppositeFaces::FrontAndBack },
        Self::CubeFacesSwapped { faces: OppositeFaces::LeftAndRight },
        Self::CubeFacesSwapped { faces: OppositeFaces::UpAndDown },
        Self::CubeFacesSwapped { faces: OppositeFaces::All },
        Self::FalloffFromOne,
        Self::FalloffWithoutOne,
        Self::Highlights,
        Self::NearWhite,
        Self::AbsoluteNormals,
        Self::ShiftedNormals,
        Self::ListsReversed,
        Self::NestingReversed,
        Self::AmbientPerLight,
        Self::ExponentDoubled,
        Self::ExponentHalved,
        Self::RotationsInRadians,
    ];

    /// The changed scene, whose text this is; none where the change cannot show.
    pub(super) fn apply(self, scene: &Scene, text: &str) -> Option<Scene> {
        let mut changed = scene.clone();
        let changes = match self {
            Self::NoAmbient => put_out_ambient(&mut changed),
            Self::BlackBackground => {
                replaced(&mut changed.background.color, Color::ZERO) | changed.cube_map.take().is_some()
            }
            Self::NotAttenuated => any(&mut changed.lights, not_attenuated),
            Self::LightsReversed => any(&mut changed.lights, reversed),
            Self::NoHighlights => any_phong(&mut changed, |phong| replaced(&mut phong.specular, Color::ZERO)),
            Self::IndexInverted => any_phong(&mut changed, |phong| {
                let index = phong.index_of_refraction;
                phong.transparent != Color::ZERO && replaced(&mut phong.index_of_refraction, 1.0 / index)
            }),
            Self::CheckerboardSwapped => any(&mut changed.materials, swapped),
            // In the editions of 2003 and 2004 nothing else is usual.
            Self::BlinnHighlights
            | Self::AspectKept
            | Self::FlatMeshes
            | Self::OtherFaceWeights
            | Self::FalloffFromOne
            | Self::FalloffWithoutOne
            | Self::NearWhite
            | Self::AbsoluteNormals
            | Self::ShiftedNormals
                if scene.model == Model::COURSE =>
            {
                false
            }
            Self::BlinnHighlights => {
                has(scene, |phong| phong.specular) && replaced(&mut changed.model.highlight, Highlight::Blinn)
            }
            Self::AspectKept => replaced(&mut changed.model.screen, Screen::LongerSide),
            Self::FlatMeshes => {
                !scene.meshes.is_empty() && replaced(&mut changed.model.normals, MeshNormals::Flat)
            }
            Self::OtherFaceWeights => !scene.meshes.is_empty() && other_weights(&mut changed.model.normals),
            Self::CubeFacesSwapped { faces } => {
                let swap = |map: &mut CubeFaces| {
                    faces.pairs().iter().for_each(|pair| map.swap(2 * pair, 2 * pair + 1));
                };
                changed.cube_map.as_mut().map(swap).is_some()
            }
            Self::FalloffFromOne => any(&mut changed.lights, |light| with_constant(light, 1.0)),
            Self::FalloffWithoutOne => any(&mut changed.lights, |light| with_constant(light, 0.0)),
            Self::Highlights => {
                scene.model.split == Split::Schlick
                    && any_phong(&mut changed, |phong| {
                        let color = phong.reflective;
                        replaced(&mut phong.specular, color)
                    })
            }
            Self::NearWhite => replaced(&mut changed.model.depths, Depths::NearWhite),
            Self::AbsoluteNormals => replaced(&mut changed.model.normal_colors, NormalColors::Absolute),
            Self::ShiftedNormals => replaced(&mut changed.model.normal_colors, NormalColors::Shifted),
            Self::AmbientPerLight => {
                let count = changed.lights.len().max(1) as f64;
                let ambient = count * changed.background.ambient;
                replaced(&mut changed.background.ambient, ambient)
            }
            Self::ExponentDoubled => any_phong(&mut changed, |phong| scale_exponent(phong, 2.0)),
            Self::ExponentHalved => any_phong(&mut changed, |phong| scale_exponent(phong, 0.5)),
            Self::RotationsInRadians => return rotations::in_radians(scene, text),
            Self::ListsReversed => return transform_order::with_lists_reversed(scene, text),
            Self::NestingReversed => return transform_order::with_nesting_reversed(scene),
        };
        changes.then_some(changed)
    }
}

/// A scene without lights is lit evenly by a rule of its own, which this breaks, too.
fn put_out_ambient(scene: &mut Scene) -> bool {
    if scene.lights.is_empty() {
        scene.lights.push(Light::Directional { direction: Color::X, color: Color::ZERO });
        scene.background.ambient = Color::ZERO;
        return true;
    }
    replaced(&mut scene.background.ambient, Color::ZERO)
}

fn scale_exponent(phong: &mut Phong, factor: f64) -> bool {
    let exponent = factor * phong.exponent;
    phong.specular != Color::ZERO && replaced(&mut phong.exponent, exponent)
}

fn any_phong(scene: &mut Scene, change: impl Fn(&mut Phong) -> bool) -> bool {
    any(&mut scene.materials, |material| match material {
        Material::Phong(phong) | Material::Painted(phong, _) => change(phong),
        Material::Texture(_) => false,
    })
}

/// Replaces a value; says whether the new one is another.
fn replaced<T: PartialEq>(place: &mut T, value: T) -> bool {
    let changes = *place != value;
    *place = value;
    changes
}

/// Changes all of them; says whether any is changed.
fn any<T>(all: &mut [T], change: impl Fn(&mut T) -> bool) -> bool {
    all.iter_mut().fold(false, |changes, one| change(one) | changes)
}

fn not_attenuated(light: &mut Light) -> bool {
    match light {
        Light::Point { attenuation, .. } => replaced(attenuation, [1.0, 0.0, 0.0]),
        Light::Directional { .. } => false,
    }
}

/// Replaces the constant part of what a light that falls off is divided by.
fn with_constant(light: &mut Light, constant: f64) -> bool {
    match light {
        Light::Point { attenuation: [first, _, square], .. } if *square > 0.0 => replaced(first, constant),
        _ => false,
    }
}

fn reversed(light: &mut Light) -> bool {
    match light {
        Light::Directional { direction, .. } => replaced(direction, -*direction),
        Light::Point { .. } => false,
    }
}

fn other_weights(normals: &mut MeshNormals) -> bool {
    let MeshNormals::Smooth { weights, .. } = normals else { return false };
    *weights = match weights {
        FaceWeights::Area => FaceWeights::Equal,
        FaceWeights::Equal => FaceWeights::Area,
    };
    true
}

fn swapped(material: &mut Material) -> bool {
    match material {
        Material::Texture(texture) if texture.pattern == Pattern::Checkerboard => {
            texture.children.swap(0, 1);
            true
        }
        _ => false,
    }
}

impl fmt::Display for SceneChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoAmbient => "without ambient light",
            Self::BlackBackground => "with a black background",
            Self::NotAttenuated => "with lights that are not attenuated",
            Self::LightsReversed => "with directional lights from the other side",
            Self::NoHighlights => "without highlights",
            Self::IndexInverted => "with the index of refraction inverted",
            Self::CheckerboardSwapped => "with the other parity of checkerboards",
            Self::BlinnHighlights => "with highlights by the half-way vector",
            Self::AspectKept => "with the view of 2004, which is not stretched",
            Self::FlatMeshes => "with the normals of the faces",
            Self::OtherFaceWeights => "with other weights of the faces around a vertex",
            Self::CubeFacesSwapped { faces } => match faces {
                OppositeFaces::LeftAndRight => "with the faces left and right of the cube map swapped",
                OppositeFaces::UpAndDown => "with the faces up and down of the cube map swapped",
                OppositeFaces::FrontAndBack => "with the faces front and back of the cube map swapped",
                OppositeFaces::All => "with all opposite faces of the cube map swapped",
            },
            Self::FalloffFromOne => "with lights divided by 1 + falloff d^2 instead of falloff d^2",
            Self::FalloffWithoutOne => "with lights divided by falloff d^2 instead of 1 + falloff d^2",
            Self::Highlights => "with highlights",
            Self::NearWhite => "with depths that are white where they are near, instead of black",
            Self::AbsoluteNormals => "with the absolute values of normals instead of (N + 1) / 2",
            Self::ShiftedNormals => "with normals as (N + 1) / 2 instead of their absolute values",
            Self::ListsReversed => "with the transformations of a list multiplied in the other order",
            Self::AmbientPerLight => "with the ambient light once for each light",
            Self::ExponentDoubled => "with the exponents of highlights doubled",
            Self::ExponentHalved => "with the exponents of highlights halved",
            Self::RotationsInRadians => "with the degrees of rotations taken for radians",
            Self::NestingReversed => "with nested transforms multiplied in the other order",
        })
    }
}
