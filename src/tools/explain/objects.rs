//! Finds the object in the scene's text that a primitive of the world belongs to.

use crate::base::escape::escape;
use crate::diagnostic::Diagnostic;
use crate::math::instructions::Level;
use crate::math::rounded::RoundedPoint;
use crate::render::renderer::Renderer;
use crate::scene::material::{Material, Pattern, Phong};
use crate::scene::{MaterialId, Object, Position, Scene};
use crate::shading::texture::first_weight;
use crate::world::World;
use serde::Serialize;
use std::fmt;

/// A primitive, as a part of an object in the scene's text.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ObjectPart {
    /// The keyword of the object, and the name of its file if it has one.
    pub name: String,
    /// The position of the object.
    #[serde(flatten)]
    pub at: Position,
    /// The index of the triangle in the object. `None` if the object is a single primitive.
    pub triangle: Option<u32>,
}

/// How a texture mixes its two materials at a point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TextureWeight {
    /// The texture's keyword.
    pub name: &'static str,
    /// Its index among the scene's materials.
    pub material: MaterialId,
    /// The position of the texture.
    pub at: Option<Position>,
    /// The indices of its two materials.
    pub children: [MaterialId; 2],
    /// The weight of the first material. The second has the rest.
    pub first: f64,
}

/// A material without parts, as a component of a mixture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MaterialPart {
    /// Its index among the scene's materials.
    pub material: MaterialId,
    /// The position of the material.
    pub at: Option<Position>,
    /// Its share of the mixture. All shares sum to 1.
    pub weight: f64,
    /// The material itself.
    pub phong: Phong,
}

/// How a surface's material is mixed at a point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mixing {
    /// The textures with nonzero weight, outermost first.
    pub textures: Vec<TextureWeight>,
    /// The materials with nonzero weight, in the order of the scene.
    pub parts: Vec<MaterialPart>,
}

/// Looks objects up.
///
/// The numbering of primitives is internal to the world. So a second world is built from a copy of the scene in which
/// the material of every object is the object's own id. Runs without lookups do not pay for it.
#[derive(Debug)]
pub struct Objects<'r> {
    scene: &'r Scene,
    labelled: World,
}

impl<'r> Objects<'r> {
    /// Creates the lookup for a renderer that has kept its meshes.
    pub fn new(renderer: &'r Renderer) -> Result<Self, Diagnostic> {
        let scene = &renderer.scene;
        let mut copy = scene.clone();
        for (id, object) in copy.objects.iter_mut().enumerate() {
            if let Some(material) = object.material_mut() {
                *material = id;
            }
        }
        Ok(Self { scene, labelled: World::new(&copy, renderer.meshes())? })
    }

    /// Returns the object that a primitive belongs to.
    pub fn of(&self, primitive: u32) -> Option<ObjectPart> {
        let (run, id) = self.labelled.material_run(primitive);
        let object = self.scene.objects.get(id)?;
        let name = match object {
            Object::Mesh { mesh, .. } => format!("{} {}", object.name(), self.scene.meshes.get(*mesh)?.name),
            _ => object.name().into(),
        };
        let has_parts = matches!(object, Object::Box { .. } | Object::Grid { .. } | Object::Mesh { .. });
        let triangle = has_parts.then(|| primitive - run.start);
        Some(ObjectPart { name, at: *self.scene.positions.objects.get(id)?, triangle })
    }

    /// Returns the position of a material in the scene's text.
    pub fn material_position(&self, material: MaterialId) -> Option<Position> {
        self.scene.positions.materials.get(material).copied()
    }

    /// Returns the textures and materials with nonzero weight in a material at a point.
    pub fn mixing(&self, material: MaterialId, point: &RoundedPoint) -> Mixing {
        let mut weights = vec![0.0; material + 1];
        weights[material] = 1.0;
        let mut mixing = Mixing::default();
        for id in (0..=material).rev() {
            let (weight, at) = (weights[id], self.material_position(id));
            let texture = match self.scene.materials.get(id) {
                Some(Material::Texture(texture)) if weight != 0.0 => texture,
                Some(&Material::Phong(phong)) if weight != 0.0 => {
                    mixing.parts.push(MaterialPart { material: id, at, weight, phong });
                    continue;
                }
                _ => continue,
            };
            let first = first_weight(texture, point, Level::baseline());
            weights[texture.children[0]] += weights[id] * first;
            weights[texture.children[1]] += weights[id] * (1.0 - first);
            let name = pattern_name(texture.pattern);
            mixing.textures.push(TextureWeight { name, material: id, at, children: texture.children, first });
        }
        mixing.parts.reverse();
        mixing
    }
}

fn pattern_name(pattern: Pattern) -> &'static str {
    match pattern {
        Pattern::Checkerboard => "Checkerboard",
        Pattern::Noise { .. } => "Noise",
        Pattern::Marble { .. } => "Marble",
        Pattern::Wood { .. } => "Wood",
    }
}

impl fmt::Display for ObjectPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, at, triangle } = self;
        if let Some(triangle) = triangle {
            write!(f, "triangle {triangle} of ")?;
        }
        write!(f, "{} in line {}", escape(name), at.line)
    }
}
