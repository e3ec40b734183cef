//! Looks up what a hit means in the scene's text: the object, its materials, and what blocks a light.

use super::close_call::is_about_zero;
use super::tree::{CloseCall, CloseCallKind, LightBlocker, MaterialPart, ObjectPart, RayNode};
use super::tree::{Shadow, Surface, TextureWeight};
use crate::base::escape::escape;
use crate::caster::{Caster, RayOrigin};
use crate::diagnostic::Diagnostic;
use crate::math::instructions::Level;
use crate::math::ray::Hit;
use crate::render::renderer::Prepared;
use crate::scene::material::{Material, Paint, Phong, Texture};
use crate::scene::{MaterialId, Object, ObjectId, Scene};
use crate::shading::texture::{each_part, first_weight, is_in_boundary};
use crate::world::{Objects, SurfacePoint, World};

/// Looks up what a scene's text says about hits.
#[derive(Debug)]
pub struct Explainer<'p, 'r> {
    pub(super) prepared: &'p Prepared<'r>,
    pub(super) world: &'p World,
    pub(super) scene: &'p Scene,
    objects: Objects,
}

impl<'p, 'r> Explainer<'p, 'r> {
    /// Creates an explainer for a scene whose renderer has kept its meshes.
    pub fn new(prepared: &'p Prepared<'r>) -> Result<Self, Diagnostic> {
        let (renderer, world) = (prepared.renderer(), prepared.world());
        let objects = Objects::new(&renderer.scene, renderer.meshes(), world);
        let objects = objects.ok_or_else(|| Diagnostic::error("the meshes were not kept"))?;
        Ok(Self { prepared, world, scene: &renderer.scene, objects })
    }

    /// Returns the index of a primitive's object in the scene.
    pub fn object_id(&self, primitive: u32) -> ObjectId {
        self.objects.of(primitive).id
    }

    /// Returns the object that a primitive belongs to.
    pub fn object(&self, primitive: u32) -> ObjectPart {
        let placed = self.objects.of(primitive);
        let (id, first) = (placed.id, placed.primitives.start);
        let object = &self.scene.objects[id];
        let name = match object {
            Object::Mesh { mesh, .. } => format!("{} {}", object.name(), self.scene.meshes[*mesh].name),
            _ => object.name().into(),
        };
        let has_parts = matches!(object, Object::Box { .. } | Object::Grid { .. } | Object::Mesh { .. });
        let at = self.scene.positions.object(id);
        ObjectPart { name, at, triangle: has_parts.then(|| primitive - first) }
    }

    /// Adds the surface that a ray hits to its node, without the lighting.
    pub fn add_surface(&self, node: &mut RayNode, point: &SurfacePoint, material: &Phong) {
        let Some(Hit { t, primitive }) = node.hit else { return };

        let material_at = |id: MaterialId| self.scene.positions.material(id);
        // Textures mix materials that come before them.
        let mut weights = vec![0.0; point.material + 1];
        weights[point.material] = 1.0;
        let (mut textures, mut parts, mut is_on_boundary) = (vec![], vec![], false);
        self.world.with_rounded_point(point, |rounded| {
            let first = |id, texture: &Texture| {
                let (name, children) = (texture.pattern.name(), texture.children);
                let first = first_weight(texture, rounded, Level::baseline());
                textures.push(TextureWeight { name, material: id, at: material_at(id), children, first });
                is_on_boundary |= is_in_boundary(texture, rounded);
                first
            };
            each_part(&self.scene.materials[..=point.material], &mut weights, first, |id, &phong, weight| {
                parts.push(MaterialPart { material: id, at: material_at(id), weight, phong });
            });
        });
        parts.reverse();
        let mut material = *material;
        if parts.len() > 1 {
            // The tracer keeps highlights separate, because they have their own exponents.
            material.specular = parts.iter().map(|part| part.weight * part.phong.specular).sum();
        } else {
            parts.clear();
        }
        let (object, material_at) = (self.object(primitive), material_at(point.material));
        let (point, paint, ambient, lights) = (*point, self.paint(point), None, vec![]);
        let surface =
            Surface { object, t, point, material_at, material, paint, textures, parts, ambient, lights };
        node.surface = Some(surface);
        let is_grazing = is_about_zero(point.normal.dot(node.ray.direction));
        let close = [(is_grazing, CloseCallKind::Cosine), (is_on_boundary, CloseCallKind::Boundary)];
        let close = close.into_iter().filter(|(is_close, _)| *is_close);
        node.close_calls.extend(close.map(|(_, kind)| CloseCall { kind, object: None }));
    }

    /// Returns the source of the diffuse colour at a point, as in " of the noise". Empty if it is the material itself.
    fn paint(&self, point: &SurfacePoint) -> String {
        match self.scene.materials[point.material] {
            Material::Painted(_, Paint::Image { image, .. })
                if self.world.image_color(image, point).is_some() =>
            {
                format!(" of the texture {}", escape(&self.scene.images[image].name))
            }
            Material::Painted(_, Paint::Pattern(..)) => " of the noise".into(),
            _ => String::new(),
        }
    }

    /// Completes a ray towards the light of this index, which leaves this primitive.
    pub fn finish_shadow(&self, shadow: &mut Shadow, light: usize, origin_primitive: u32, caster: &Caster) {
        let nearest = || {
            let origin = RayOrigin::on(self.world, Some(origin_primitive));
            let visible = caster.nearest(&shadow.ray, origin)?;
            Some(self.world.hit(&shadow.ray, visible))
        };
        let sees = shadow.crossed.first().map(|crossing| crossing.hit).or_else(nearest);
        shadow.close_calls = self.close_calls(&shadow.ray, Some(origin_primitive), sees);
        if shadow.crossed.is_empty() {
            // A light on a surface is behind it, even if rounding lets the ray miss the surface.
            let at_light = self.world.primitives_at_light(light).first();
            let at_light = at_light.map(|place| Hit { primitive: place.primitive, t: shadow.ray.t_max });
            let blocker = |Hit { primitive, t }| LightBlocker { object: self.object(primitive), t };
            shadow.blocker = sees.or(at_light).map(blocker);
        }
    }
}
