//! Looks up what a hit means in the scene's text: the object, its materials, what blocks a light, and close calls.

use super::close_call::close_primitives;
use super::tree::{CloseCall, LightBlocker, MaterialPart, ObjectPart, Shadow, Surface, TextureWeight};
use crate::base::escape::escape;
use crate::caster::RayOrigin;
use crate::diagnostic::Diagnostic;
use crate::math::instructions::Level;
use crate::math::ray::{Hit, Ray};
use crate::math::rounded::RoundedPoint;
use crate::render::renderer::Prepared;
use crate::scene::material::{Material, Paint, Pattern, Phong};
use crate::scene::{MaterialId, Object, Position, Scene};
use crate::shading::texture::{first_weight, is_in_boundary};
use crate::stats::Counts;
use crate::world::{SurfacePoint, World};

/// Looks up what a scene's text says about hits.
///
/// The numbering of primitives is internal to the world. So a second world is built from a copy of the scene in which
/// the material of every object is the object's own id. Runs without lookups do not pay for it.
#[derive(Debug)]
pub struct Explainer<'p, 'r> {
    pub(super) prepared: &'p Prepared<'r>,
    scene: &'p Scene,
    labelled: World,
}

impl<'p, 'r> Explainer<'p, 'r> {
    /// Creates an explainer for a scene whose renderer has kept its meshes.
    pub fn new(prepared: &'p Prepared<'r>) -> Result<Self, Diagnostic> {
        let (renderer, scene) = (prepared.renderer(), &prepared.renderer().scene);
        let is_lost =
            |object: &Object| matches!(object, Object::Mesh { mesh, .. } if *mesh >= renderer.meshes().len());
        if scene.objects.iter().any(is_lost) {
            return Err(Diagnostic::error("the meshes were not kept"));
        }
        let mut copy = scene.clone();
        for (id, object) in copy.objects.iter_mut().enumerate() {
            if let Some(material) = object.material_mut() {
                *material = id;
            }
        }
        Ok(Self { prepared, scene, labelled: World::new(&copy, renderer.meshes())? })
    }

    /// Returns the object that a primitive belongs to.
    pub fn object(&self, primitive: u32) -> Option<ObjectPart> {
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
    fn material_position(&self, material: MaterialId) -> Option<Position> {
        self.scene.positions.materials.get(material).copied()
    }

    /// Returns the textures with nonzero weight in a material at a point, outermost first, and the materials, in the
    /// order of the scene.
    fn mixing(&self, material: MaterialId, point: &RoundedPoint) -> (Vec<TextureWeight>, Vec<MaterialPart>) {
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
    fn paint(&self, point: &SurfacePoint, world: &World) -> Option<String> {
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
    pub fn is_in_boundary(&self, Surface { textures, point, .. }: &Surface) -> bool {
        let world = self.prepared.caster().world;
        textures.iter().any(|texture| match self.scene.materials.get(texture.material) {
            Some(Material::Texture(texture)) => {
                world.with_rounded_point(point, |point| is_in_boundary(texture, point))
            }
            _ => false,
        })
    }

    /// Returns a surface that a ray hits, without its lighting.
    pub fn surface(&self, point: &SurfacePoint, material: &Phong, hit: Hit) -> Surface {
        let world = self.prepared.caster().world;
        let (textures, parts) =
            world.with_rounded_point(point, |rounded| self.mixing(point.material, rounded));
        let mut surface = Surface {
            object: self.object(hit.primitive),
            t: hit.t,
            point: *point,
            material_at: self.material_position(point.material),
            material: *material,
            paint: self.paint(point, world),
            textures,
            parts: vec![],
            ambient: None,
            lights: vec![],
        };
        if parts.len() > 1 {
            // The tracer keeps highlights separate, because they have their own exponents.
            surface.material.specular = parts.iter().map(|part| part.weight * part.phong.specular).sum();
            surface.parts = parts;
        }
        surface
    }

    /// Completes a ray towards the light of this index, which leaves this primitive.
    pub fn finish_shadow(&self, shadow: &mut Shadow, light: usize, leaves: u32) {
        let caster = self.prepared.caster();
        let world = caster.world;
        let nearest = || {
            let visible =
                caster.nearest(&shadow.ray, RayOrigin::on(world, Some(leaves)), &mut Counts::default())?;
            Some(world.hit(&shadow.ray, visible))
        };
        let sees = shadow.crossed.first().map(|crossing| crossing.hit).or_else(nearest);
        shadow.close_calls = self.close_calls(&shadow.ray, Some(leaves), sees);
        if shadow.crossed.is_empty() {
            // A light on a surface is behind it, even if rounding lets the ray miss the surface.
            let at_light = || {
                let place = world.primitives_at_light(light).first()?;
                Some(Hit { primitive: place.primitive, t: shadow.ray.t_max })
            };
            let blocker = |Hit { primitive, t }| LightBlocker { object: self.object(primitive), t };
            shadow.blocker = sees.or_else(at_light).map(blocker);
        }
    }

    /// Returns the close calls of a ray that leaves a primitive and first hits another one.
    pub fn close_calls(&self, ray: &Ray, leaves: Option<u32>, sees: Option<Hit>) -> Vec<CloseCall> {
        let close = close_primitives(self.prepared.caster().world, ray, leaves, sees);
        close.into_iter().map(|(kind, id)| CloseCall { kind, object: self.object(id) }).collect()
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
