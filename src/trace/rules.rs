//! The rules by which rays are traced. Those that are provided are the right ones, and the only ones of a caster. Whoever
//! wants to know what a mistake looks like breaks one.

use super::optics::transmittance;
use super::{Secondary, reflected};
use crate::caster::Caster;
use crate::math::double_double::SquaredSine;
use crate::math::instructions::Level;
use crate::math::ray::{Hit, Ray, Visible};
use crate::math::robust::offset_origin;
use crate::picture::Color;
use crate::scene::material::{Material, Paint, Phong};
use crate::scene::model::{MeshNormals, Model};
use crate::shading::light::Incident;
use crate::shading::phong::{Mixture, PointMaterial, View};
use crate::shading::texture::{material_at, mixed_color};
use crate::stats::Probe;
use crate::world::{SurfacePoint, World};
use glam::DVec3;

/// Why a ray leaves a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Departure {
    /// It is reflected or refracted.
    Secondary(Secondary),
    /// It goes to a light.
    Shadow,
    /// It has passed a transparent surface on the way to a light.
    Onwards,
}

/// How rays are traced.
pub trait Rules: Sync {
    /// What rays hit.
    fn world(&self) -> &World;

    /// What the world's scene means. A caster knows only the model of the course, whatever the world says, so that
    /// what others mean takes no time: [`ByModel`] asks the world.
    #[inline(always)]
    fn model(&self) -> Model {
        Model::COURSE
    }

    /// What a ray hits first that leaves the primitive `leaves`. That is not hit again, unless it is round.
    fn nearest<P: Probe>(&self, ray: &Ray, leaves: Option<u32>, probe: &mut P) -> Option<Visible>;

    /// The hit of a ray on what it hits first, with its t.
    #[inline(always)]
    fn hit(&self, ray: &Ray, visible: Visible) -> Hit {
        self.world().hit(ray, visible)
    }

    /// The surface that a ray hits first.
    #[inline(always)]
    fn surface(&self, ray: &Ray, visible: Visible) -> SurfacePoint {
        self.smoothed(self.world().visible_surface(ray, visible))
    }

    /// A surface with the normal by which it is seen, where it has that of the primitive.
    #[inline(always)]
    fn smoothed(&self, surface: SurfacePoint) -> SurfacePoint {
        if self.model().normals == MeshNormals::Flat {
            return surface;
        }
        let normal = self.world().smooth_normal(&surface).unwrap_or(surface.normal);
        SurfacePoint { normal, ..surface }
    }

    /// The level that textures are evaluated with. The bytes are the same with all of them.
    #[inline(always)]
    fn level(&self) -> Level {
        Level::baseline()
    }

    /// The material of a surface, with its textures evaluated at the point.
    #[inline(always)]
    fn material<'m>(&'m self, surface: &SurfacePoint, mixture: &'m mut Mixture) -> PointMaterial<'m> {
        let (world, level) = (self.world(), self.level());
        let material = &world.materials[surface.material];
        if let Material::Phong(phong) = material {
            return phong.into();
        }
        if self.model() != Model::COURSE
            && let Material::Painted(phong, paint) = material
        {
            let diffuse = painted(world, paint, surface, level).unwrap_or(phong.diffuse);
            mixture.start(&Phong { diffuse, ..*phong }, 1.0);
            return mixture.material();
        }
        world.with_rounded_point(surface, |point| {
            material_at(&world.materials, surface.material, point, level, mixture)
        })
    }

    /// The colour of a ray in this direction that hits nothing after so many bounces.
    #[inline(always)]
    fn background(&self, direction: DVec3, _bounces: u32) -> Color {
        if self.model() == Model::COURSE {
            return self.world().background;
        }
        self.world().background_along(direction)
    }

    /// The sine of the angle between a ray and the normal of a surface that it meets, with less rounding than that of the
    /// unit normal where that is known.
    #[inline(always)]
    fn precise_sine(&self, origin: DVec3, direction: DVec3, surface: &SurfacePoint) -> SquaredSine {
        // A smooth normal is not the triangle's.
        let is_smooth = self.model().normals != MeshNormals::Flat && surface.triangle.is_some();
        let primitive = surface.primitive.filter(|_| !is_smooth);
        self.world().precise_sine((origin, direction), primitive, surface.normal)
    }

    /// A ray from a surface, and the primitive that it leaves. It starts a few roundings off the surface, on the side to
    /// which it goes.
    #[inline(always)]
    fn departing(&self, _why: Departure, surface: &SurfacePoint, direction: DVec3) -> (Ray, Option<u32>) {
        if let Some(t_min) = self.model().epsilon {
            return (Ray { t_min, ..Ray::new(surface.position, direction) }, None);
        }
        let origin = offset_origin(surface.position, surface.normal, direction, surface.extent);
        (Ray::new(origin, direction), surface.primitive)
    }

    /// Where a shadow ray to a light at this distance ends.
    #[inline(always)]
    fn shadow_end(&self, distance: f64) -> f64 {
        distance
    }

    /// The direction of a mirrored ray.
    #[inline(always)]
    fn reflected(&self, direction: DVec3, normal: DVec3) -> DVec3 {
        reflected(direction, normal)
    }

    /// The part of the light that is mirrored at a surface, of which Schlick's approximation says `part`.
    #[inline(always)]
    fn mirrored(&self, part: f64) -> f64 {
        part
    }

    /// What a colour of a material makes of the light along a secondary ray.
    #[inline(always)]
    fn filter(&self, _kind: Secondary, color: Color) -> Color {
        color
    }

    /// The indices of refraction in front of a surface and behind it. `around` is that of the medium that the ray comes
    /// from.
    #[inline(always)]
    fn indices(&self, around: f64, material: &Phong, is_entering: bool) -> [f64; 2] {
        [around, if is_entering { material.index_of_refraction } else { 1.0 }]
    }

    /// Where the refracted ray goes at total internal reflection, if there is one.
    #[inline(always)]
    fn totally_reflected(&self, _direction: DVec3, _normal: DVec3) -> Option<DVec3> {
        None
    }

    /// Whether opaque shadows let nothing through along a ray that leaves the primitive `leaves`. The course's program
    /// looks for the nearest hit, even where any hit would do.
    #[inline(always)]
    fn is_blocked<P: Probe>(&self, ray: &Ray, leaves: Option<u32>, probe: &mut P) -> bool {
        self.nearest(ray, leaves, probe).is_some()
    }

    /// The fraction of light that is left after a way through a transparent object.
    #[inline(always)]
    fn transmittance(&self, tint: Color, way: f64) -> Color {
        transmittance(tint, way)
    }

    /// The normal by which a surface is shaded that a ray of this direction meets: that on the viewer's side.
    #[inline(always)]
    fn shading_normal(&self, normal: DVec3, _direction: DVec3, is_inside: bool) -> DVec3 {
        if is_inside { -normal } else { normal }
    }

    /// The ambient light that a surface reflects.
    #[inline(always)]
    fn ambient(&self, surface: &SurfacePoint, material: &Phong) -> Color {
        let diffuse = material.diffuse;
        let is_of_course = self.model() == Model::COURSE;
        self.world().ambient
            * if is_of_course { diffuse } else { self.world().ambient_color(surface, diffuse) }
    }

    /// What a surface reflects of the light with this index; `cosine` is positive.
    #[inline(always)]
    fn reflect(&self, material: &PointMaterial, (light, _): (&Incident, usize), view: &View) -> Color {
        material.reflect(self.model().highlight, light, view)
    }

    /// What the light of one source adds to the colour of a surface.
    #[inline(always)]
    fn light(&self, color: Color) -> Color {
        color
    }

    /// The sum of two colours, in the precision of the computation.
    #[inline(always)]
    fn sum(&self, one: Color, other: Color) -> Color {
        one + other
    }
}

impl Rules for Caster<'_> {
    #[inline(always)]
    fn world(&self) -> &World {
        self.world
    }

    #[inline(always)]
    fn nearest<P: Probe>(&self, ray: &Ray, leaves: Option<u32>, probe: &mut P) -> Option<Visible> {
        Caster::nearest(self, ray, leaves, probe)
    }

    #[inline(always)]
    fn level(&self) -> Level {
        self.level
    }
}

/// The diffuse colour of paint at a surface; none where it has none.
pub(crate) fn painted(world: &World, paint: &Paint, surface: &SurfacePoint, level: Level) -> Option<Color> {
    match *paint {
        Paint::Image { image, .. } => world.image_color(image, surface),
        Paint::Pattern(pattern, colors) => Some(mixed_color(pattern, colors, surface.position, level)),
    }
}

/// A caster by whose rules a scene means what its model says.
#[derive(Clone, Copy, Debug)]
pub struct ByModel<'c, 'w>(pub &'c Caster<'w>);

impl Rules for ByModel<'_, '_> {
    #[inline(always)]
    fn world(&self) -> &World {
        self.0.world
    }

    #[inline(always)]
    fn model(&self) -> Model {
        self.0.world.model
    }

    #[inline(always)]
    fn nearest<P: Probe>(&self, ray: &Ray, leaves: Option<u32>, probe: &mut P) -> Option<Visible> {
        Caster::nearest(self.0, ray, leaves, probe)
    }

    #[inline(always)]
    fn level(&self) -> Level {
        self.0.level
    }
}
