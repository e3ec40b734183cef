//! Shadow rays that start inside a sphere or a small closed mesh, such as a gem. If the light is outside, its surface
//! blocks them.
//!
//! A ray that starts inside a sphere leaves it. A ray that starts inside a closed mesh and ends outside leaves it once
//! more often than it enters it. The triangle test finds these crossings without gaps
//! ([`world::triangle`](crate::world)), so it finds at least one of them. Therefore the ray need not be cast if three
//! things are certain:
//!
//! * It starts inside. The winding number is computed for one point below each triangle. It holds below the whole
//!   triangle without a narrow border, if no other triangle comes near.
//! * It does not leave through its own triangle, which is not tested: its direction points inwards.
//! * The light is outside: it is beyond the mesh's box.

use crate::base::patience::Patience;
use crate::math::aabb::Aabb;
use crate::math::ray::Ray;
use crate::math::robust::unit;
use crate::scene::Light;
use crate::scene::material::Material;
use crate::world::shape::Shape;
use crate::world::{Primitive, SurfacePoint, World};
use glam::DVec3;
use std::ops::Range;

/// The closed meshes of transparent materials.
#[derive(Debug, Default)]
pub struct ClosedMeshes(Vec<ClosedMesh>);

#[derive(Debug)]
struct ClosedMesh {
    /// The id of the first triangle.
    first: u32,
    /// The triangles; `None` for one below which it is not certain that points are inside.
    faces: Vec<Option<Face>>,
    /// For each light, true if it is certainly outside the mesh.
    has_outside: Vec<bool>,
}

#[derive(Clone, Copy, Debug)]
struct Face {
    /// The outward unit normal.
    normal: DVec3,
    /// Each barycentric weight of a point as an affine function: the gradient, and the value at the origin.
    weights: [(DVec3, f64); 3],
}

/// The largest number of triangles of a mesh. All pairs of them are examined.
const MOST_TRIANGLES: usize = 256;

/// The least barycentric weight of the points below which there is certainly the inside.
const LEAST_WEIGHT: f64 = 1.0 / (1 << 10) as f64;

/// The least cosine between a ray and the inward normal. The error of the normal is less than a sixteenth of it, because
/// a triangle with a larger error is not as far from its neighbours as the margin demands.
const LEAST_COSINE: f64 = 1.0 / (1 << 20) as f64;

/// The distance between a triangle and the others, as a part of the largest coordinate. A ray starts at most 2^-45 of it
/// below its triangle: 32 roundings of two coordinates along the normal, or up to four times as much along the ray.
const MARGIN: f64 = 1.0 / (1u64 << 38) as f64;

impl ClosedMeshes {
    /// Returns the meshes that are found while there is patience.
    pub fn new(world: &World, patience: &dyn Patience) -> Self {
        let is_transparent = |id: u32| match world.materials.get(world.material_of(id)) {
            Some(Material::Phong(phong) | Material::Painted(phong, _)) => phong.transparent != DVec3::ZERO,
            _ => false,
        };
        let (mut meshes, mut start, count) = (vec![], 0, world.triangles.len() as u32);
        while start < count && !patience.is_over() {
            let end = (start..count).find(|&id| world.material_of(id) != world.material_of(start));
            let ids = start..end.unwrap_or(count);
            start = ids.end;
            if ids.len() <= MOST_TRIANGLES && is_transparent(ids.start) && is_closed(world, ids.clone()) {
                meshes.push(ClosedMesh::new(world, ids));
            }
        }
        Self(meshes)
    }

    /// Returns true if a mesh certainly blocks the ray from a surface in this direction to the light with this index.
    #[inline(always)]
    pub fn block(&self, light: usize, surface: &SurfacePoint, direction: DVec3) -> bool {
        let Some(triangle) = surface.triangle else { return false };
        for ClosedMesh { first, faces, has_outside } in &self.0 {
            if let Some(&face) = faces.get(triangle.wrapping_sub(*first) as usize) {
                let Some(Face { normal, weights: [a, b, c] }) = face else { return false };
                let p = surface.position;
                let weight = (a.0.dot(p) + a.1).min(b.0.dot(p) + b.1).min(c.0.dot(p) + c.1);
                return has_outside[light]
                    && normal.dot(direction) < -LEAST_COSINE
                    && weight > 2.0 * LEAST_WEIGHT;
            }
        }
        false
    }
}

/// The least radius of a sphere, as a part of its largest coordinate. A ray then starts inside, and not beyond the far
/// side, after its origin was moved off the surface.
const LEAST_RADIUS: f64 = 1.0 / (1 << 20) as f64;

/// The least square of a light's distance from the centre of a sphere, as a part of the squared radius.
const LEAST_SQUARED_DISTANCE: f64 = 1.0 + 1.0 / (1 << 20) as f64;

/// Returns true if this shape is a sphere that certainly blocks the ray from its surface in this direction to the light
/// with this index: the ray starts inside, and the light is outside.
#[inline(always)]
pub fn sphere_blocks(world: &World, id: u32, light: usize, surface: &SurfacePoint, direction: DVec3) -> bool {
    if surface.normal.dot(direction) > -LEAST_COSINE {
        return false;
    }
    let Primitive::Shape(i) = world.primitive(id) else { return false };
    let Shape::Sphere(sphere) = &world.shapes[i] else { return false };
    let is_outside = match world.lights[light] {
        Light::Directional { .. } => true,
        Light::Point { position, .. } => {
            let squared_distance = (position - sphere.center).length_squared();
            squared_distance > LEAST_SQUARED_DISTANCE * sphere.radius * sphere.radius
        }
    };
    is_outside && sphere.radius > LEAST_RADIUS * surface.extent
}

/// Returns true if the triangles are the whole surface of a solid: each edge occurs once in each direction.
fn is_closed(world: &World, ids: Range<u32>) -> bool {
    let corners = ids.clone().map(|id| world.triangles[id as usize]);
    let mut edges: Vec<_> = corners.flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    edges.sort_unstable();
    let is_single = edges.windows(2).all(|pair| pair[0] != pair[1]);
    is_single && edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok())
}

impl ClosedMesh {
    fn new(world: &World, ids: Range<u32>) -> Self {
        let triangles: Vec<[DVec3; 3]> = ids.clone().map(|id| world.corners(id as usize)).collect();
        let bounds = Aabb::around(triangles.iter().flatten().copied());
        let margin = MARGIN * bounds.min.abs().max(bounds.max.abs()).max_element();
        let face = |id: u32| face(world, &triangles, ids.clone(), id, margin);
        let is_beyond = |p: DVec3| (p.cmplt(bounds.min - margin) | p.cmpgt(bounds.max + margin)).any();
        let is_outside = |light: &Light| match *light {
            Light::Directional { .. } => true,
            Light::Point { position, .. } => is_beyond(position),
        };
        let faces = ids.clone().map(face).collect();
        Self { first: ids.start, faces, has_outside: world.lights.iter().map(is_outside).collect() }
    }
}

/// Returns the face of a triangle if points below it are certainly inside the mesh of these triangles.
fn face(world: &World, triangles: &[[DVec3; 3]], ids: Range<u32>, id: u32, margin: f64) -> Option<Face> {
    let own = (id - ids.start) as usize;
    let corners = triangles[own];
    let normal = normal(&corners);
    let inner = [0, 1, 2].map(|k| {
        corners[k].lerp(corners[(k + 1) % 3], LEAST_WEIGHT)
            + LEAST_WEIGHT * (corners[(k + 2) % 3] - corners[k])
    });
    let edge_normals = [0, 1, 2].map(|k| unit(normal.cross(corners[(k + 2) % 3] - corners[(k + 1) % 3])));
    // Other triangles stay away from the triangle within its border.
    let is_apart = |other: &[DVec3; 3]| {
        let axes = edge_normals.into_iter().chain([self::normal(other), normal]);
        axes.into_iter().any(|axis| gap(axis, &inner, other) > margin)
    };
    let mut others = triangles.iter().enumerate().filter(|&(k, _)| k != own);
    if !others.all(|(_, other)| is_apart(other)) {
        return None;
    }
    // Count how often a ray from below the triangle leaves the mesh.
    let below = corners.iter().sum::<DVec3>() / 3.0 - 0.5 * margin * normal;
    let ray = Ray::new(below, -normal);
    let mut exits = 0;
    for (other, corners) in ids.zip(triangles) {
        if other != id && world.crossing(&ray, other).is_some() {
            let cosine = self::normal(corners).dot(ray.direction);
            if cosine.abs() < LEAST_COSINE {
                return None;
            }
            exits += if cosine > 0.0 { 1 } else { -1 };
        }
    }
    let weight = |k: usize| {
        let gradient = edge_normals[k] / edge_normals[k].dot(corners[k] - corners[(k + 1) % 3]);
        (gradient, -gradient.dot(corners[(k + 1) % 3]))
    };
    (exits == 1).then(|| Face { normal, weights: [0, 1, 2].map(weight) })
}

fn normal(&[a, b, c]: &[DVec3; 3]) -> DVec3 {
    unit((b - a).cross(c - a))
}

/// Returns the distance between two triangles along an axis, or a negative number if they overlap there.
fn gap(axis: DVec3, one: &[DVec3; 3], other: &[DVec3; 3]) -> f64 {
    let range = |triangle: &[DVec3; 3]| {
        let [a, b, c] = triangle.map(|corner| axis.dot(corner));
        [a.min(b).min(c), a.max(b).max(c)]
    };
    let ([min, max], [other_min, other_max]) = (range(one), range(other));
    (other_min - max).max(min - other_max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::patience::Endless;
    use crate::caster::{Caster, RayOrigin};
    use crate::math::ray::Hit;
    use crate::math::robust::offset_origin;
    use crate::scene::parser::parse;
    use crate::shading::light::incident;
    use crate::trace::ending_at_light;
    use proptest::prelude::*;

    /// An octahedron of glass with a light inside and two outside.
    const SCENE: &str = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 30 }
        Lights { numLights 3 PointLight { position 0 0 0 color 1 1 1 }
            PointLight { position 3000 4000 5000 color 1 1 1 } DirectionalLight { direction 0.1 -1 0.2 color 1 1 1 } }
        Group { numObjects 1 Material { transparentColor 1 1 1 } Transform { SCALE Rotate { 1 2 3 ANGLE }
            TriangleMesh { obj_file MESH } } }";
    const OCTAHEDRON: &str = "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\nf 1 3 5\nf 3 2 5\nf 2 4 5\n\
                              f 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";

    fn world(scale: &str, angle: f64, mesh: &str) -> World {
        let text =
            SCENE.replace("SCALE", scale).replace("ANGLE", &angle.to_string()).replace("MESH", "m.obj");
        let mesh = crate::scene::obj::parse_obj(mesh.as_bytes()).unwrap();
        World::new(&parse(&text).unwrap(), &[mesh]).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn a_ray_that_a_mesh_blocks_hits_something(
            angle in 0.0..360.0,
            scale in prop::sample::select(vec!["", "Scale { 1 0.001 1 }", "Scale { 1000 1 1 }"]),
            face in 0..8usize,
            weights in prop::array::uniform2(prop_oneof![-20.0..0.0, -3.0..0.0]),
            direction in prop::array::uniform3(-1.0..1.0),
        ) {
            let world = world(scale, angle, OCTAHEDRON);
            let (meshes, caster) = (ClosedMeshes::new(&world, &Endless), Caster::new(&world, None).unwrap());
            prop_assert!(meshes.0[0].faces.iter().all(Option::is_some));
            prop_assert_eq!(&meshes.0[0].has_outside, &[false, true, true]);
            let [u, v] = weights.map(|exponent: f64| 0.5 * 10f64.powf(exponent));
            let corners @ [a, b, c] = world.corners(face);
            let (point, outward) = (a + u * (b - a) + v * (c - a), normal(&corners));
            let camera_ray = Ray::new(point + outward, -outward);
            let Some(hit) = caster.closest(&camera_ray) else { return Ok(()) };
            let surface = world.surface(&camera_ray, &hit);
            let direction = unit(DVec3::from_array(direction));
            if meshes.block(1, &surface, direction) {
                let start = offset_origin(surface.position, surface.normal, direction, surface.extent);
                prop_assert!(caster.any(&Ray::new(start, direction), RayOrigin::on(&world, surface.primitive)));
            }
            prop_assert!(!meshes.block(0, &surface, direction));
        }
    }

    #[test]
    fn most_points_of_a_closed_mesh_are_known_and_none_of_an_open_one() {
        let known = |mesh: &str| {
            let ClosedMeshes(meshes) = ClosedMeshes::new(&world("", 20.0, mesh), &Endless);
            meshes.iter().flat_map(|mesh| &mesh.faces).flatten().count()
        };
        assert_eq!(known(OCTAHEDRON), 8);
        assert_eq!(known(OCTAHEDRON.trim_end_matches("f 1 4 6\n")), 0);
        let inside_out = OCTAHEDRON.replace("f 1 3 5", "f 3 1 5");
        assert_eq!(known(&inside_out), 0);
        let turned: String = OCTAHEDRON
            .lines()
            .map(|line| match line.split(' ').collect::<Vec<_>>()[..] {
                ["f", a, b, c] => format!("f {a} {c} {b}\n"),
                _ => format!("{line}\n"),
            })
            .collect();
        assert_eq!(known(&turned), 0);
    }

    /// Lights: from a side, close to the first sphere, and inside it. The last sphere is smaller than the roundings of
    /// its centre, so a ray from it may start beyond it.
    const SPHERES: &str = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 60 }
         Lights { numLights 3 DirectionalLight { direction -.4 -.7 -.6 color 1 1 1 }
         PointLight { position 0 1.001 0 color 1 1 1 } PointLight { position .2 .9 0 color 1 1 1 } }
         Group { numObjects 3 Material { } Sphere { center 0 0 0 radius 1 } Sphere { center 1e9 2 3 radius 2e3 }
         Sphere { center 1e9 2e9 3 radius 1e-8 } }";

    #[test]
    fn a_sphere_blocks_the_rays_that_start_inside_it_to_lights_outside() {
        let world = World::new(&parse(SPHERES).unwrap(), &[]).unwrap();
        let caster = Caster::new(&world, None).unwrap();
        let mut blocked = [[0; 3]; 3];
        for (id, light, i) in
            (0..3u32).flat_map(|id| (0..3usize).flat_map(move |k| (0..500).map(move |i| (id, k, i))))
        {
            let part = |step: f64| 2.0 * (f64::from(i) * step).fract() - 1.0;
            let outward = DVec3::new(part(0.618), part(0.7548), part(0.5698)).normalize();
            let Shape::Sphere(sphere) = &world.shapes[id as usize] else { panic!("a sphere") };
            let ray = Ray::new(sphere.center, outward);
            let Some(t) = world.crossing(&ray, id) else { continue };
            let surface = world.surface(&ray, &Hit { t, primitive: id });
            let to_light = incident(&world.lights[light], surface.position);
            let direction = to_light.direction;
            if sphere_blocks(&world, id, light, &surface, direction) {
                let origin = offset_origin(surface.position, surface.normal, direction, surface.extent);
                let ray = Ray { t_max: to_light.distance, ..Ray::new(origin, direction) };
                let ray = ending_at_light(&world, light, &surface, ray);
                assert!(caster.any(&ray, RayOrigin::on(&world, Some(id))), "{id} {light} {ray:?}");
                blocked[id as usize][light] += 1;
            }
        }
        let [[from_side, close, inside], far, tiny] = blocked;
        assert!(from_side > 200 && close > 400 && far.iter().all(|&count| count > 200), "{blocked:?}");
        assert_eq!((inside, tiny), (0, [0; 3]));
    }
}
