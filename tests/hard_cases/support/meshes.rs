//! Meshes with their adjacency, and rays that are aimed at them.

use super::rng::Rng;
use glam::{DMat3, DVec3};
use raytracer::math::ray::Ray;
use raytracer::scene::mesh::Mesh;
use raytracer::scene::obj::parse_obj;
use std::collections::BTreeSet;

/// The six orders of three vertices. The last three reverse the winding.
pub const VERTEX_ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

/// A mesh with the triangles around each vertex.
pub struct Closed {
    pub mesh: Mesh,
    /// The triangles at each vertex, in increasing order.
    pub rings: Vec<Vec<u32>>,
    /// Each edge once, with the lower index first.
    pub edges: Vec<[u32; 2]>,
}

impl Closed {
    pub fn new(mesh: Mesh) -> Self {
        let mut rings = vec![Vec::new(); mesh.vertices.len()];
        let mut edges = BTreeSet::new();
        for (i, t) in mesh.triangles.iter().enumerate() {
            for k in 0..3 {
                rings[t[k] as usize].push(i as u32);
                edges.insert([t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3])]);
            }
        }
        Self { mesh, rings, edges: edges.into_iter().collect() }
    }

    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.mesh.triangles[triangle as usize].map(|v| self.mesh.vertices[v as usize])
    }

    pub fn random_vertex(&self, rng: &mut Rng) -> DVec3 {
        self.mesh.vertices[rng.below(self.mesh.vertices.len())]
    }

    pub fn random_edge_point(&self, rng: &mut Rng) -> DVec3 {
        let [a, b] = self.edges[rng.below(self.edges.len())].map(|i| self.mesh.vertices[i as usize]);
        a.lerp(b, rng.unit())
    }

    /// A random vertex, point of an edge or point of a face, in turn by the index of the input.
    pub fn random_point(&self, rng: &mut Rng, index: u64) -> DVec3 {
        match index % 3 {
            0 => self.random_vertex(rng),
            1 => self.random_edge_point(rng),
            _ => point_in(self.corners(rng.below(self.mesh.triangles.len()) as u32), rng),
        }
    }

    /// A ray from around the mesh to such a point, with a unit vector as its direction for every other index.
    pub fn ray_at(&self, rng: &mut Rng, index: u64) -> Ray {
        let (center, radius) = center_and_radius(&self.mesh);
        let origin = rounded(center + 4.0 * radius * rng.direction());
        aimed(origin, self.random_point(rng, index), index.is_multiple_of(2))
    }

    /// The triangles at either end of an edge, each once.
    pub fn around(&self, [a, b]: [u32; 2]) -> Vec<u32> {
        let (a, b) = (&self.rings[a as usize], &self.rings[b as usize]);
        a.iter().chain(b.iter().filter(|t| !a.contains(t))).copied().collect()
    }
}

/// A rotation that maps no axis to an axis.
pub fn oblique_rotation() -> DMat3 {
    let axis = DVec3::new(0.267_261_241_912_424_4, -0.534_522_483_824_848_8, 0.801_783_725_737_273_2);
    DMat3::from_axis_angle(axis, 0.7)
}

/// Coordinates rounded to single precision.
pub fn rounded(v: DVec3) -> DVec3 {
    v.as_vec3().as_dvec3()
}

/// A sphere of 20 * 4^level triangles, in no special orientation, with vertices that are representable in
/// f32.
pub fn icosphere(level: u32, radius: f64, center: DVec3) -> Closed {
    let rotation = oblique_rotation();
    Closed::new(moved(&unit_icosphere(level), |v| rounded(center + radius * (rotation * v))))
}

/// The unit icosahedron, subdivided this number of times with all vertices moved to the unit sphere.
pub fn unit_icosphere(level: u32) -> Mesh {
    (0..level).fold(icosahedron(), |mesh, _| subdivided(&mesh))
}

fn icosahedron() -> Mesh {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let mut vertices = Vec::new();
    for axis in 0..3 {
        for (s, t) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
            let mut v = DVec3::ZERO;
            (v[axis], v[(axis + 1) % 3]) = (s, t);
            vertices.push(v.normalize());
        }
    }
    let edge = (vertices[0] - vertices[1]).length();
    let near = |i: usize, j: usize| (vertices[i] - vertices[j]).length() < 1.1 * edge;
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(i, k) {
                    triangles.push(outward(&vertices, [i as u32, j as u32, k as u32]));
                }
            }
        }
    }
    Mesh { vertices, triangles }
}

fn outward(vertices: &[DVec3], [a, b, c]: [u32; 3]) -> [u32; 3] {
    let [p, q, r] = [a, b, c].map(|i| vertices[i as usize]);
    if (q - p).cross(r - p).dot(p) > 0.0 { [a, b, c] } else { [a, c, b] }
}

fn subdivided(mesh: &Mesh) -> Mesh {
    let mut vertices = mesh.vertices.clone();
    let mut middles = std::collections::HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
            vertices.len() as u32 - 1
        })
    };
    let mut triangles = Vec::new();
    for &[a, b, c] in &mesh.triangles {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    Mesh { vertices, triangles }
}

/// One of the meshes in the folder `scenes`.
pub fn mesh(name: &str) -> Mesh {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    parse_obj(&std::fs::read(path).expect("a mesh file")).expect("a valid mesh")
}

/// The rabbit with this number of triangles, rounded to f32 so that single-precision methods use the same
/// mesh.
pub fn bunny(triangles: &str) -> Mesh {
    moved(&mesh(&format!("bunny_{triangles}.obj")), rounded)
}

/// The mesh with a map applied to its vertices.
pub fn moved(mesh: &Mesh, map: impl Fn(DVec3) -> DVec3) -> Mesh {
    Mesh { vertices: mesh.vertices.iter().map(|&v| map(v)).collect(), triangles: mesh.triangles.clone() }
}

/// The centre of the mesh's bounds, and half the diagonal.
pub fn center_and_radius(mesh: &Mesh) -> (DVec3, f64) {
    let min = mesh.vertices.iter().fold(DVec3::INFINITY, |a, &b| a.min(b));
    let max = mesh.vertices.iter().fold(DVec3::NEG_INFINITY, |a, &b| a.max(b));
    ((min + max) / 2.0, (max - min).length() / 2.0)
}

/// A random point of a triangle.
pub fn point_in([a, b, c]: [DVec3; 3], rng: &mut Rng) -> DVec3 {
    let (mut u, mut v) = (rng.unit(), rng.unit());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    a + u * (b - a) + v * (c - a)
}

/// The ray from `origin` to `target`. Its direction is rounded to f32, so that methods of either precision
/// use the same ray, and normalised before that if `unit`.
pub fn aimed(origin: DVec3, target: DVec3, unit: bool) -> Ray {
    let d = target - origin;
    Ray::new(origin, rounded(if unit { d.normalize() } else { d }))
}

/// Shuffles the items.
pub fn shuffle<T>(items: &mut [T], rng: &mut Rng) {
    for i in (1..items.len()).rev() {
        items.swap(i, rng.below(i + 1));
    }
}
