//! The meshes: the rabbit, and finer subdivisions of it.

use glam::DVec3;
use raytracer::scene::mesh::Mesh;
use raytracer::scene::obj::parse_obj;
use std::collections::HashMap;
use std::error::Error;
use std::fs;
use std::path::Path;

/// The files of the rabbit, and the number of times that each triangle is divided into four.
const RABBITS: [(&str, u32); 7] = [
    ("bunny_200.obj", 0),
    ("bunny_1k.obj", 0),
    ("bunny_5k.obj", 0),
    ("bunny_40k.obj", 0),
    ("bunny_40k.obj", 1),
    ("bunny_40k.obj", 2),
    ("bunny_40k.obj", 3),
];

/// The number of meshes.
pub const COUNT: usize = RABBITS.len();

/// One of the meshes, in the order of their faces. Every coordinate is representable in single precision, so
/// that all contestants have the same triangles.
pub fn rabbit(scenes: &Path, number: usize) -> Result<Mesh, Box<dyn Error>> {
    let (file, splits) = RABBITS[number];
    let mut mesh = parse_obj(&fs::read(scenes.join(file))?)?;
    for _ in 0..splits {
        mesh = split(&mesh);
    }
    for vertex in &mut mesh.vertices {
        *vertex = vertex.as_vec3().as_dvec3();
    }
    Ok(mesh)
}

/// Divides each triangle into four, at the midpoints of its edges.
fn split(mesh: &Mesh) -> Mesh {
    let mut vertices = mesh.vertices.clone();
    let mut middles = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            vertices.push(0.5 * (mesh.vertices[a as usize] + mesh.vertices[b as usize]));
            vertices.len() as u32 - 1
        })
    };
    let mut triangles = Vec::with_capacity(4 * mesh.triangles.len());
    for &[a, b, c] in &mesh.triangles {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    Mesh { vertices, triangles }
}

/// The corners of each triangle.
pub fn corners(mesh: &Mesh) -> impl Iterator<Item = [DVec3; 3]> + '_ {
    mesh.triangles.iter().map(|triangle| triangle.map(|v| mesh.vertices[v as usize]))
}
