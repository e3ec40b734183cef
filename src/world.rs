//! Flattening: the object tree times its matrices becomes lists of world-space primitives.
//!
//! After this only true ellipsoids keep a matrix. Primitives are numbered through the lists in one
//! order: triangles, spheres, ellipsoids, planes.

mod builder;

use crate::math::aabb::Aabb;
use crate::math::prefetch::prefetch;
use crate::math::ray::{Hit, Ray, Visible};
use crate::math::robust;
use crate::primitive::{ellipsoid::Ellipsoid, plane::Plane, sphere::Sphere, triangle};
use crate::scene::error::{Problem, SceneError};
use crate::scene::limits;
use crate::scene::mesh::Mesh;
use crate::scene::{Color, Light, MaterialId, Object, ObjectId, Position, Scene, material::Material};
use builder::Builder;
use glam::{DAffine3, DVec3};
use std::borrow::Cow;
use std::cmp::Ordering;

/// What the tracer works on.
#[derive(Clone, Debug)]
pub struct World {
    /// The triangles' corners.
    pub vertices: Vec<DVec3>,
    /// Indices into `vertices`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The spheres, numbered after the triangles.
    pub spheres: Vec<Sphere>,
    /// The ellipsoids, numbered after the spheres.
    pub ellipsoids: Vec<Ellipsoid>,
    /// The planes, numbered last.
    pub planes: Vec<Plane>,
    /// The scene's materials.
    pub materials: Vec<Material>,
    /// Directions are unit vectors.
    pub lights: Vec<Light>,
    /// Seen where a ray meets nothing.
    pub background: Color,
    /// The light that reaches every surface.
    pub ambient: Color,
    /// The box of the finite primitives by the course's rule, which is not tight around a rotated
    /// sphere; empty where there are none.
    pub bounds: Aabb,
    /// The largest absolute coordinate of a finite primitive: the scale of its rounding.
    pub max_abs_coord: f64,
    /// The material from each primitive's number on, up to the next entry's.
    material_runs: Vec<(u32, u32)>,
}

/// A primitive by its kind and its index in the world's list of that kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Primitive {
    /// Index into [`World::triangles`].
    Triangle(usize),
    /// Index into [`World::spheres`].
    Sphere(usize),
    /// Index into [`World::ellipsoids`].
    Ellipsoid(usize),
    /// Index into [`World::planes`].
    Plane(usize),
}

/// The surface at a hit.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// On the surface within a few roundings of its coordinates and the primitive's.
    pub position: DVec3,
    /// Outward unit normal, not turned towards the ray.
    pub normal: DVec3,
    /// What the surface is made of.
    pub material: MaterialId,
    /// The triangle's number, if it is on one: what leaves a triangle never meets it again.
    pub triangle: Option<u32>,
}

/// A leaf of the object tree with the matrix that takes it to the world.
#[derive(Clone, Copy, Debug)]
pub struct Placement<'s> {
    /// The leaf.
    pub object: &'s Object,
    /// From the object's space to the world's.
    pub matrix: DAffine3,
    /// The innermost transform around the object; None at the top.
    pub transform: Option<Position>,
}

impl Placement<'_> {
    /// A point of the object in the world.
    fn place(&self, point: DVec3) -> DVec3 {
        if self.transform.is_some() { robust::transformed(&self.matrix, point) } else { point }
    }

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
        Self::build(scene, meshes.iter().map(Cow::Borrowed).collect())
    }

    /// As [`World::new`], but without copying a mesh that can be taken over.
    pub fn of_meshes(scene: &Scene, meshes: Vec<Mesh>) -> Result<Self, SceneError> {
        Self::build(scene, meshes.into_iter().map(Cow::Owned).collect())
    }

    fn build(scene: &Scene, meshes: Vec<Cow<Mesh>>) -> Result<Self, SceneError> {
        limits::check(scene)?;
        let mut builder = Builder::new(Self::without_objects(scene), scene, meshes);
        placements(scene).try_for_each(|placement| builder.place(&placement))?;
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
            max_abs_coord: 0.0,
            material_runs: vec![],
        }
    }

    /// How many primitives have a box: all but the planes.
    pub fn finite_count(&self) -> usize {
        self.triangles.len() + self.spheres.len() + self.ellipsoids.len()
    }

    /// The primitive of a number.
    pub fn primitive(&self, id: u32) -> Primitive {
        let i = id as usize;
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

    /// The tight boxes of the finite primitives behind the triangles, in the order of their numbers.
    /// The triangles are within `bounds`.
    pub fn boxes(&self) -> impl Iterator<Item = Aabb> + '_ {
        self.spheres.iter().map(Sphere::bounds).chain(self.ellipsoids.iter().map(Ellipsoid::bounds))
    }

    /// The tight box of a finite primitive; nothing's of a plane.
    pub fn box_of(&self, id: u32) -> Aabb {
        match self.primitive(id) {
            Primitive::Triangle(i) => Aabb::around(self.corners(i)),
            Primitive::Sphere(i) => self.spheres[i].bounds(),
            Primitive::Ellipsoid(i) => self.ellipsoids[i].bounds(),
            Primitive::Plane(_) => Aabb::EMPTY,
        }
    }

    /// The corners of a triangle.
    #[inline(always)]
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        // Written out: a mapped array goes through memory, and waits for it.
        let [a, b, c] = self.corners_in_place(triangle);
        [*a, *b, *c]
    }

    /// The same without a copy, for what reads their coordinates in an order of its own.
    #[inline(always)]
    pub fn corners_in_place(&self, triangle: usize) -> [&DVec3; 3] {
        let [a, b, c] = self.triangles[triangle];
        [&self.vertices[a as usize], &self.vertices[b as usize], &self.vertices[c as usize]]
    }

    /// Asks for the corners of a triangle whose surface will be wanted soon.
    #[inline(always)]
    pub fn prefetch(&self, primitive: u32) {
        if let Some(corners) = self.triangles.get(primitive as usize) {
            corners.iter().for_each(|&corner| prefetch(&self.vertices[corner as usize]));
        }
    }

    /// Whether the primitive `one`, which a ray meets at `t`, hides `other`, which the ray meets at `other_t`.
    ///
    /// The nearer one does. Of two at the same t it is the one that [`comes_first`](Self::comes_first), so that
    /// the answer depends neither on the grid, nor on the order of tests, nor on that of a mesh's faces.
    #[inline]
    pub fn precedes(&self, (t, one): (f64, u32), (other_t, other): (f64, u32)) -> bool {
        t < other_t || (t == other_t && self.comes_first(one, other))
    }

    /// Orders triangles by their corners' coordinates. Other primitives, and triangles with the same corners, are
    /// ordered by their ids.
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

    /// Where `ray` meets the primitive that it sees.
    pub fn hit(&self, ray: &Ray, Visible { primitive, t_bound }: Visible) -> Hit {
        let crossing = match self.primitive(primitive) {
            Primitive::Triangle(i) => triangle::Shear::new(ray).hit(self.corners_in_place(i)),
            _ => None,
        };
        let (t, weights) = crossing.map_or((t_bound, None), |(t, weights)| (t, Some(weights)));
        Hit { t, primitive, weights }
    }

    /// The surface that `ray` sees. The t of a triangle's hit is not needed for it, and not computed.
    pub fn visible_surface(&self, ray: &Ray, Visible { primitive, t_bound }: Visible) -> SurfacePoint {
        let weights = |i| triangle::Shear::new(ray).weights(self.corners_in_place(i));
        self.surface_with(ray, t_bound, primitive, weights)
    }

    /// The surface at a hit of `ray`.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        self.surface_with(ray, hit.t, hit.primitive, |_| hit.weights)
    }

    /// The surface of a primitive at `t`; `weights` are those of a triangle's corners there.
    #[inline(always)]
    fn surface_with(
        &self,
        ray: &Ray,
        t: f64,
        primitive: u32,
        weights: impl FnOnce(usize) -> Option<[f64; 3]>,
    ) -> SurfacePoint {
        let along = ray.at(t);
        let (normal, position) = match self.primitive(primitive) {
            Primitive::Triangle(i) => self.triangle_surface(i, weights(i), along),
            Primitive::Sphere(i) => self.spheres[i].surface(ray, along),
            Primitive::Ellipsoid(i) => self.ellipsoids[i].surface(ray, t),
            Primitive::Plane(i) => (self.planes[i].normal, self.planes[i].project(along)),
        };
        let triangle = (primitive < self.triangles.len() as u32).then_some(primitive);
        SurfacePoint { position, normal, material: self.material_of(primitive), triangle }
    }

    /// The point of the weights lies on the triangle to within rounding, unlike one that is `along` the ray.
    #[inline(always)]
    fn triangle_surface(&self, i: usize, weights: Option<[f64; 3]>, along: DVec3) -> (DVec3, DVec3) {
        let corners = self.corners(i);
        (triangle::normal(corners), weights.map_or(along, |weights| triangle::point(corners, weights)))
    }

    fn material_of(&self, primitive: u32) -> MaterialId {
        let run = self.material_runs.partition_point(|&(start, _)| start <= primitive);
        self.material_runs[run - 1].1 as MaterialId
    }
}

fn with_unit_direction(light: Light) -> Light {
    match light {
        Light::Directional { direction, color } => {
            Light::Directional { direction: robust::unit(direction), color }
        }
        point => point,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parser::parse;

    /// Two of each kind, one kind between the other, each with a material of its own, in the order of the text.
    fn world() -> World {
        let kinds = [
            "Plane { normal 0 1 0 offset 1 }",
            "Transform { Scale 1 2 3 Sphere { center 0 0 0 radius 1 } }",
            "Sphere { center 0 0 0 radius 1 }",
            "Triangle { vertex0 0 0 1 vertex1 1 0 1 vertex2 0 1 1 }",
            "Triangle { vertex0 0 0 0 vertex1 1 0 0 vertex2 0 1 0 }",
            "Triangle { vertex0 0 0 1 vertex1 1 0 1 vertex2 0 1 1 }",
        ];
        let objects: Vec<String> =
            (0..12).map(|k| format!("MaterialIndex {k} {}", kinds[k % kinds.len()])).collect();
        let text = format!(
            "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
             Materials {{ numMaterials 12 {} }} Group {{ numObjects 12 {} }}",
            "Material { } ".repeat(12),
            objects.join(" ")
        );
        World::new(&parse(&text).unwrap(), &[]).unwrap()
    }

    #[test]
    fn every_number_is_that_of_one_primitive_and_its_material() {
        use Primitive::*;
        let world = world();
        let kinds: Vec<Primitive> = (0..12).map(|id| world.primitive(id)).collect();
        let triangles = (0..6).map(Triangle);
        let others = [Sphere(0), Sphere(1), Ellipsoid(0), Ellipsoid(1), Plane(0), Plane(1)];
        assert_eq!(kinds, triangles.chain(others).collect::<Vec<_>>());
        assert_eq!((world.finite_count(), world.first_plane()), (10, 10));
        let materials: Vec<MaterialId> = (0..12).map(|id| world.material_of(id)).collect();
        assert_eq!(materials, [3, 4, 5, 9, 10, 11, 2, 8, 1, 7, 0, 6]);
        let ray = Ray::new(DVec3::new(0.1, 0.2, -5.0), DVec3::Z);
        let left = |primitive| world.surface(&ray, &Hit { t: 5.0, primitive, weights: None }).triangle;
        assert_eq!([0, 5, 6, 8, 10].map(left), [Some(0), Some(5), None, None, None]);
    }

    #[test]
    fn of_two_hits_the_nearer_is_seen_and_else_the_one_whose_place_is_first() {
        let world = world();
        let precedes = |t: f64, one: u32, other: u32| world.precedes((t, one), (2.0, other));
        for (one, other) in (0..12).flat_map(|i| (0..12).map(move |j| (i, j))) {
            assert!(precedes(1.0, one, other) && !precedes(3.0, one, other));
            // Triangles 1 and 4 stand before the others, whose places are the same.
            let rank = |id| if id < 6 { (id % 3 != 1, id) } else { (true, id) };
            let expected = rank(one) < rank(other);
            let is_between_kinds = (one < 6) != (other < 6);
            let expected = if is_between_kinds { one < other } else { expected };
            assert_eq!(precedes(2.0, one, other), expected, "{one} {other}");
        }
    }
}
