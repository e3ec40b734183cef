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
use crate::scene::{MaterialId, Object, ObjectId, Position, Scene, TRIANGLES_OF_BOX};
use crate::shading::texture::{first_weight, is_in_boundary};
use crate::stats::Counts;
use crate::world::{SurfacePoint, World};

/// Looks up what a scene's text says about hits.
#[derive(Debug)]
pub struct Explainer<'p, 'r> {
    pub(super) prepared: &'p Prepared<'r>,
    scene: &'p Scene,
    /// The first primitive of each object.
    objects: Vec<(u32, ObjectId)>,
}

impl<'p, 'r> Explainer<'p, 'r> {
    /// Creates an explainer for a scene whose renderer has kept its meshes.
    pub fn new(prepared: &'p Prepared<'r>) -> Result<Self, Diagnostic> {
        let (renderer, scene) = (prepared.renderer(), &prepared.renderer().scene);
        // The ids count triangles, shapes and planes, each in the order of the text, as the objects are.
        let mut next = [0, renderer.world().triangles.len(), renderer.world().finite_count()];
        let mut objects = [const { vec![] }; 3];
        for (id, object) in scene.objects.iter().enumerate() {
            let (kind, count) = match object {
                Object::Group(_) | Object::Transform { .. } => continue,
                Object::Triangle { .. } => (0, 1),
                Object::Box { .. } => (0, TRIANGLES_OF_BOX),
                Object::Grid { surface, .. } => (0, surface.triangles.len()),
                Object::Mesh { mesh, .. } => match renderer.meshes().get(*mesh) {
                    Some(mesh) => (0, mesh.triangles.len()),
                    None => return Err(Diagnostic::error("the meshes were not kept")),
                },
                Object::Sphere { .. } => (1, 1),
                Object::Plane { .. } => (2, 1),
            };
            objects[kind].push((next[kind] as u32, id));
            next[kind] += count;
        }
        Ok(Self { prepared, scene, objects: objects.concat() })
    }

    /// Returns the object that a primitive belongs to.
    pub fn object(&self, primitive: u32) -> Option<ObjectPart> {
        let next = self.objects.partition_point(|&(first, _)| first <= primitive);
        let (first, id) = *self.objects.get(next.checked_sub(1)?)?;
        let object = self.scene.objects.get(id)?;
        let name = match object {
            Object::Mesh { mesh, .. } => format!("{} {}", object.name(), self.scene.meshes.get(*mesh)?.name),
            _ => object.name().into(),
        };
        let has_parts = matches!(object, Object::Box { .. } | Object::Grid { .. } | Object::Mesh { .. });
        let triangle = has_parts.then(|| primitive - first);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Request;
    use crate::render::renderer::{Meshes, Renderer};
    use crate::scene::MeshFile;
    use crate::scene::load::{Hints, Readers, Source, load_text};
    use crate::scene::texels::ImageFile;

    #[test]
    fn a_primitive_belongs_to_the_object_whose_material_it_has() {
        // Each object has a line and a material of its own.
        let text = "OrthographicCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 size 2 }
            Materials { numMaterials 7 Material {} Material {} Material {} Material {} Material {} Material {} Material {} }
            Group { numObjects 6
            MaterialIndex 0 Plane { normal 0 0 1 offset -5 }
            MaterialIndex 1 Transform { Translate 1 0 0 Box { min 0 0 0 max 1 1 1 } }
            MaterialIndex 2 Sphere { center 0 0 0 radius 1 }
            MaterialIndex 3 Triangle { vertex0 0 0 0 vertex1 1 0 0 vertex2 0 1 0 }
            Group { numObjects 2
            MaterialIndex 4 Transform { Scale 1 2 3 Sphere { center 0 0 0 radius 1 } }
            MaterialIndex 5 Box { min 3 3 3 max 4 4 4 } }
            MaterialIndex 6 Plane { normal 0 1 0 offset -5 } }";
        let source = Source { path: "s.txt".into(), text: text.into() };
        let no_mesh = |_: &MeshFile, _, _| Err(Diagnostic::error("no mesh"));
        let no_image = |_: &ImageFile, _| Err(Diagnostic::error("no picture"));
        let readers = Readers { mesh: &no_mesh, image: &no_image };
        let loaded = load_text(source, &Hints::default(), readers).unwrap();
        let renderer = Renderer::new(loaded, Meshes::Kept).unwrap();
        let prepared = renderer.prepare(&Request::new([2, 2])).unwrap();
        let (explainer, world) = (Explainer::new(&prepared).unwrap(), renderer.world());
        const LINES: [u32; 7] = [4, 5, 6, 7, 9, 10, 11];
        assert_eq!(world.ids().len(), 12 + 1 + 12 + 2 + 2);
        for id in world.ids() {
            let found = explainer.object(id).unwrap();
            assert_eq!(found.at.line, LINES[world.material_of(id)], "{id}: {found}");
            assert!(found.triangle.is_none_or(|triangle| triangle < 12));
        }
    }
}
