//! Flattening: the object tree times its matrices becomes lists of world-space primitives.
//!
//! After this only true ellipsoids keep a matrix. Primitives are numbered through the lists in one
//! order: triangles, spheres, ellipsoids, planes.

use crate::math::aabb::Aabb;
use crate::math::ray::{Hit, Ray};
use crate::math::robust;
use crate::primitive::{ellipsoid::Ellipsoid, plane::Plane, sphere::Sphere, triangle};
use crate::scene::error::{Problem, SceneError};
use crate::scene::mesh::Mesh;
use crate::scene::{Color, Light, MaterialId, Object, ObjectId, Position, Scene, material::Material};
use glam::{DAffine3, DVec3};
use std::cmp::Ordering;

/// What the tracer works on.
#[derive(Clone, Debug)]
pub struct World {
    pub vertices: Vec<DVec3>,
    /// Indices into `vertices`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    pub spheres: Vec<Sphere>,
    pub ellipsoids: Vec<Ellipsoid>,
    pub planes: Vec<Plane>,
    pub materials: Vec<Material>,
    /// Directions are unit vectors.
    pub lights: Vec<Light>,
    pub background: Color,
    pub ambient: Color,
    /// The box of the finite primitives by the course's rule, which is not tight around a rotated
    /// sphere; empty where there are none.
    pub bounds: Aabb,
    /// The largest absolute coordinate of a finite primitive: the scale of its rounding.
    pub reach: f64,
    /// The material from each primitive's number on, up to the next entry's.
    material_runs: Vec<(u32, u32)>,
}

/// A primitive by its kind and its index in the world's list of that kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Primitive {
    Triangle(usize),
    Sphere(usize),
    Ellipsoid(usize),
    Plane(usize),
}

/// The surface at a hit.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// On the surface within a few roundings of its coordinates and the primitive's.
    pub position: DVec3,
    /// Outward unit normal, not turned towards the ray.
    pub normal: DVec3,
    pub material: MaterialId,
}

/// A leaf of the object tree with the matrix that takes it to the world.
#[derive(Clone, Copy, Debug)]
pub struct Placement<'s> {
    pub object: &'s Object,
    pub matrix: DAffine3,
    /// The innermost transform around the object; None at the top.
    pub transform: Option<Position>,
}

impl Placement<'_> {
    /// An error at the transform, or at the start of the text where there is none.
    fn error(&self, problem: Problem) -> SceneError {
        SceneError::new(self.transform.unwrap_or(Position { line: 1, column: 1 }), problem)
    }
}

/// The leaves of a scene's tree in the order of its text. Walks with a stack of its own, so that
/// depth costs memory and nothing else.
pub fn placements(scene: &Scene) -> impl Iterator<Item = Placement<'_>> {
    let mut stack: Vec<(ObjectId, DAffine3, Option<Position>)> = vec![(scene.root, DAffine3::IDENTITY, None)];
    std::iter::from_fn(move || {
        loop {
            let (id, matrix, transform) = stack.pop()?;
            match &scene.objects[id] {
                Object::Group(children) => {
                    stack.extend(children.iter().rev().map(|&c| (c, matrix, transform)))
                }
                Object::Transform { matrix: m, child, at } => stack.push((*child, matrix * *m, Some(*at))),
                object => return Some(Placement { object, matrix, transform }),
            }
        }
    })
}

/// The box by which the course's program bounds a placed sphere: tight where it stands untransformed,
/// else around the transformed corners of its box.
pub fn course_sphere_box(center: DVec3, radius: f64, placement: &Placement) -> Aabb {
    let tight = Sphere { center, radius }.bounds();
    match placement.transform {
        None => tight,
        Some(_) => Aabb::around(tight.corners().map(|p| placement.matrix.transform_point3(p))),
    }
}

impl World {
    /// `meshes` are those that the scene names, in its order.
    pub fn new(scene: &Scene, meshes: &[Mesh]) -> Result<Self, SceneError> {
        let mut builder =
            Builder { meshes, world: World::without_objects(scene), materials: Default::default() };
        for placement in placements(scene) {
            builder.place(&placement)?;
        }
        builder.finish()
    }

    fn without_objects(scene: &Scene) -> Self {
        Self {
            vertices: vec![],
            triangles: vec![],
            spheres: vec![],
            ellipsoids: vec![],
            planes: vec![],
            materials: scene.materials.clone(),
            lights: scene.lights.iter().map(|&l| with_unit_direction(l)).collect(),
            background: scene.background.color,
            // The course's rule: a scene without lights is lit evenly, which shows flat colours.
            ambient: if scene.lights.is_empty() { Color::ONE } else { scene.background.ambient },
            bounds: Aabb::EMPTY,
            reach: 0.0,
            material_runs: vec![],
        }
    }

    /// How many primitives have a box: all but the planes.
    pub fn finite_count(&self) -> usize {
        self.triangles.len() + self.spheres.len() + self.ellipsoids.len()
    }

    /// The primitive of a number.
    pub fn primitive(&self, number: u32) -> Primitive {
        let i = number as usize;
        let first_ellipsoid = self.triangles.len() + self.spheres.len();
        if i < self.triangles.len() {
            Primitive::Triangle(i)
        } else if i < first_ellipsoid {
            Primitive::Sphere(i - self.triangles.len())
        } else if i < self.finite_count() {
            Primitive::Ellipsoid(i - first_ellipsoid)
        } else {
            Primitive::Plane(i - self.finite_count())
        }
    }

    /// The number of the first plane; planes come last.
    pub fn first_plane(&self) -> u32 {
        self.finite_count() as u32
    }

    /// The tight boxes of the finite primitives, in the order of their numbers.
    pub fn boxes(&self) -> impl Iterator<Item = Aabb> + '_ {
        let triangles = (0..self.triangles.len()).map(|i| Aabb::around(self.corners(i)));
        triangles
            .chain(self.spheres.iter().map(Sphere::bounds))
            .chain(self.ellipsoids.iter().map(Ellipsoid::bounds))
    }

    /// The corners of a triangle.
    #[inline(always)]
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|v| self.vertices[v as usize])
    }

    /// Whether `hit` is seen and not `other`: the nearer. Of two at the same t it is the one that the
    /// primitives' own places put first, so that the answer depends neither on the grid, nor on the
    /// order of tests, nor on that of a mesh's faces.
    #[inline]
    pub fn precedes(&self, hit: Hit, other: Hit) -> bool {
        hit.t < other.t || (hit.t == other.t && self.comes_first(hit.primitive, other.primitive))
    }

    /// Triangles by their corners, and all else, or two triangles at one place, by their numbers.
    #[cold]
    fn comes_first(&self, one: u32, other: u32) -> bool {
        let by_place = match (self.primitive(one), self.primitive(other)) {
            (Primitive::Triangle(i), Primitive::Triangle(j)) => {
                let coordinates = |k| self.corners(k).into_iter().flat_map(|v| v.to_array());
                coordinates(i).partial_cmp(coordinates(j)).unwrap_or(Ordering::Equal)
            }
            _ => Ordering::Equal,
        };
        by_place.then(one.cmp(&other)).is_lt()
    }

    /// The surface where `ray` meets a primitive.
    pub fn surface(&self, ray: &Ray, hit: Hit) -> SurfacePoint {
        let along = ray.at(hit.t);
        let (normal, position) = match self.primitive(hit.primitive) {
            Primitive::Triangle(i) => self.triangle_surface(ray, i, along),
            Primitive::Sphere(i) => self.spheres[i].surface(along),
            Primitive::Ellipsoid(i) => self.ellipsoids[i].surface(ray, hit.t),
            Primitive::Plane(i) => (self.planes[i].normal, self.planes[i].project(along)),
        };
        SurfacePoint { position, normal, material: self.material_of(hit.primitive) }
    }

    fn triangle_surface(&self, ray: &Ray, i: usize, along: DVec3) -> (DVec3, DVec3) {
        let corners = self.corners(i);
        let crossing = triangle::Shear::new(ray).intersect(corners);
        (triangle::normal(corners), crossing.map_or(along, |c| c.point(corners)))
    }

    fn material_of(&self, primitive: u32) -> MaterialId {
        let run = self.material_runs.partition_point(|&(start, _)| start <= primitive);
        self.material_runs[run - 1].1 as MaterialId
    }
}

/// A world in the making: materials per list until the numbers are known.
struct Builder<'a> {
    meshes: &'a [Mesh],
    world: World,
    /// Runs as in `material_runs`, but each list counted from 0: triangles, spheres, ellipsoids, planes.
    materials: [Vec<(u32, u32)>; 4],
}

impl Builder<'_> {
    fn place(&mut self, placement: &Placement) -> Result<(), SceneError> {
        let map = |p: DVec3| placement.matrix.transform_point3(p);
        match *placement.object {
            Object::Triangle { vertices, material } => {
                self.triangles(vertices.map(map), &[[0, 1, 2]], placement, material)
            }
            Object::Box { min, max, material } => {
                let corners = Aabb { min, max }.corners().map(map);
                self.triangles(corners, &BOX_FACES, placement, material)
            }
            Object::Mesh { mesh, material } => {
                let Mesh { vertices, triangles } = &self.meshes[mesh];
                self.triangles(vertices.iter().map(|&v| map(v)), triangles, placement, material)
            }
            Object::Sphere { center, radius, material } => self.sphere(center, radius, placement, material),
            Object::Plane { normal, offset, material } => self.plane(normal, offset, placement, material),
            Object::Group(_) | Object::Transform { .. } => Ok(()),
        }?;
        if self.fits() { Ok(()) } else { Err(placement.error(Problem::TooManyPrimitives)) }
    }

    fn fits(&self) -> bool {
        let w = &self.world;
        w.vertices.len() < u32::MAX as usize && w.finite_count() + w.planes.len() < u32::MAX as usize
    }

    fn triangles(
        &mut self,
        vertices: impl IntoIterator<Item = DVec3>,
        faces: &[[u32; 3]],
        placement: &Placement,
        material: MaterialId,
    ) -> Result<(), SceneError> {
        let world = &mut self.world;
        let first = world.vertices.len();
        world.vertices.extend(vertices);
        let new = &world.vertices[first..];
        let bounds =
            if new.iter().all(|v| v.is_finite()) { Aabb::around(new.iter().copied()) } else { BROKEN };
        note_run(&mut self.materials[0], world.triangles.len(), material);
        // A mirroring matrix turns the winding; two swapped vertices turn it back.
        let mirrored = placement.matrix.matrix3.determinant() < 0.0;
        world.triangles.extend(faces.iter().map(|f| {
            let [a, b, c] = f.map(|v| v + first as u32);
            if mirrored { [a, c, b] } else { [a, b, c] }
        }));
        self.grow(bounds, placement)
    }

    fn sphere(
        &mut self,
        center: DVec3,
        radius: f64,
        placement: &Placement,
        material: MaterialId,
    ) -> Result<(), SceneError> {
        let matrix = placement.matrix;
        let linear = matrix.matrix3;
        let (middle, reach) = (matrix.transform_point3(center), linear * radius);
        if robust::is_singular(linear) {
            return Err(placement.error(Problem::SingularTransform));
        }
        if let Some(scale) = similarity_scale(linear) {
            note_run(&mut self.materials[1], self.world.spheres.len(), material);
            self.world.spheres.push(Sphere { center: middle, radius: scale * radius });
        } else {
            note_run(&mut self.materials[2], self.world.ellipsoids.len(), material);
            self.world.ellipsoids.push(Ellipsoid::new(middle, reach));
        }
        self.grow(course_sphere_box(center, radius, placement), placement)
    }

    fn plane(
        &mut self,
        normal: DVec3,
        offset: f64,
        placement: &Placement,
        material: MaterialId,
    ) -> Result<(), SceneError> {
        let normal = robust::unit(normal);
        note_run(&mut self.materials[3], self.world.planes.len(), material);
        if placement.transform.is_none() {
            self.world.planes.push(Plane { normal, offset });
            return Ok(());
        }
        let linear = placement.matrix.matrix3;
        if robust::is_singular(linear) {
            return Err(placement.error(Problem::SingularTransform));
        }
        let outward = robust::cofactor(linear) * normal * linear.determinant().signum();
        let normal_there = robust::unit(outward);
        let point = placement.matrix.transform_point3(offset * normal);
        self.world.planes.push(Plane { normal: normal_there, offset: normal_there.dot(point) });
        if point.is_finite() && normal_there.is_finite() {
            Ok(())
        } else {
            Err(placement.error(Problem::TransformOverflow))
        }
    }

    fn grow(&mut self, bounds: Aabb, placement: &Placement) -> Result<(), SceneError> {
        self.world.bounds = self.world.bounds.union(bounds);
        // An empty group of triangles has an empty, infinite box, which is no fault.
        let sound = bounds.is_empty() || (bounds.min.is_finite() && bounds.max.is_finite());
        if sound { Ok(()) } else { Err(placement.error(Problem::TransformOverflow)) }
    }

    fn finish(self) -> Result<World, SceneError> {
        let mut world = self.world;
        let counts = [world.triangles.len(), world.spheres.len(), world.ellipsoids.len(), world.planes.len()];
        let mut start = 0;
        for (runs, count) in self.materials.into_iter().zip(counts) {
            world.material_runs.extend(runs.into_iter().map(|(first, material)| (first + start, material)));
            start += count as u32;
        }
        if !world.bounds.is_empty() {
            world.reach = world.bounds.min.abs().max(world.bounds.max.abs()).max_element();
        }
        Ok(world)
    }
}

/// The box of something whose coordinates overflowed.
const BROKEN: Aabb = Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };

/// The faces of a box over [`Aabb::corners`], counter-clockwise seen from outside.
const BOX_FACES: [[u32; 3]; 12] = [
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
];

fn with_unit_direction(light: Light) -> Light {
    match light {
        Light::Directional { direction, color } => {
            Light::Directional { direction: robust::unit(direction), color }
        }
        point => point,
    }
}

fn note_run(runs: &mut Vec<(u32, u32)>, first: usize, material: MaterialId) {
    if runs.last().is_none_or(|&(_, last)| last as MaterialId != material) {
        runs.push((first as u32, material as u32));
    }
}

/// The factor by which a matrix scales every length, if it does so within rounding.
fn similarity_scale(m: glam::DMat3) -> Option<f64> {
    let square = m.x_axis.length_squared();
    let gram = m.transpose() * m;
    let off = (gram - glam::DMat3::from_diagonal(DVec3::splat(square))).to_cols_array();
    off.iter().all(|x| x.abs() <= 1e-12 * square).then(|| square.sqrt())
}
