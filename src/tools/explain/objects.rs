//! Finds the object in the scene's text that a primitive of the world belongs to.

use super::tree::Surface;
use crate::base::escape::escape;
use crate::diagnostic::Diagnostic;
use crate::math::instructions::Level;
use crate::math::rounded::RoundedPoint;
use crate::render::renderer::Renderer;
use crate::scene::material::{Material, Paint, Pattern, Phong};
use crate::scene::{MaterialId, Object, Position, Scene};
use crate::shading::texture::{first_weight, is_in_boundary};
use crate::world::{SurfacePoint, World};
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

    /// Returns the textures with nonzero weight in a material at a point, outermost first, and the materials, in the
    /// order of the scene.
    pub fn mixing(
        &self,
        material: MaterialId,
        point: &RoundedPoint,
    ) -> (Vec<TextureWeight>, Vec<MaterialPart>) {
        let mut weights = vec![0.0; material + 1];
        weights[material] = 1.0;
        let (mut textures, mut parts) = (vec![], vec![]);
        for id in (0..=material).rev() {
            let (weight, at) = (weights[id], self.material_position(id));
            let texture = match self.scene.materials.get(id) {
                Some(Material::Texture(texture)) if weight != 0.0 => texture,
                Some(&Material::Phong(phong)) if weight != 0.0 => {
                    parts.push(MaterialPart { material: id, at, weight, phong });
                    continue;
                }
                _ => continue,
            };
            let first = first_weight(texture, point, Level::baseline());
            weights[texture.children[0]] += weights[id] * first;
            weights[texture.children[1]] += weights[id] * (1.0 - first);
            let name = pattern_name(texture.pattern);
            textures.push(TextureWeight { name, material: id, at, children: texture.children, first });
        }
        parts.reverse();
        (textures, parts)
    }

    /// Returns the source of the diffuse colour at a point, if it is not the material itself.
    pub fn paint(&self, point: &SurfacePoint, world: &World) -> Option<String> {
        match self.scene.materials.get(point.material)? {
            &Material::Painted(_, Paint::Image { image, .. }) => {
                world.image_color(image, point)?;
                Some(format!("the texture {}", escape(&self.scene.images.get(image)?.name)))
            }
            Material::Painted(_, Paint::Pattern(..)) => Some("the noise".into()),
            Material::Phong(_) | Material::Texture(_) => None,
        }
    }

    /// Returns true if rounding decides which material of a checkerboard the surface has.
    pub fn is_in_boundary(&self, Surface { textures, point, .. }: &Surface, world: &World) -> bool {
        textures.iter().any(|texture| match self.scene.materials.get(texture.material) {
            Some(Material::Texture(texture)) => {
                world.with_rounded_point(point, |point| is_in_boundary(texture, point))
            }
            _ => false,
        })
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
