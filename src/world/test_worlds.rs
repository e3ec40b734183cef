//! Makes worlds for tests.

use super::World;
use crate::scene::mesh::Mesh;
use crate::scene::parser::parse;
use glam::DVec3;

/// Returns a world of these objects.
pub fn world_of(objects: &[impl AsRef<str>]) -> World {
    world_with_mesh(objects, &[])
}

/// Returns a world of triangles, and of these objects behind them.
pub fn world_of_triangles(triangles: impl IntoIterator<Item = [DVec3; 3]>, objects: &[&str]) -> World {
    let vertices: Vec<DVec3> = triangles.into_iter().flatten().collect();
    let triangles = (0..vertices.len() as u32).step_by(3).map(|i| [i, i + 1, i + 2]).collect();
    let objects = [&["TriangleMesh { obj_file a.obj }"], objects].concat();
    world_with_mesh(&objects, &[Mesh { vertices, triangles }])
}

fn world_with_mesh(objects: &[impl AsRef<str>], meshes: &[Mesh]) -> World {
    let list: Vec<&str> = objects.iter().map(AsRef::as_ref).collect();
    let text = format!(
        "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
         Group {{ numObjects {} Material {{ }} {} }}",
        list.len(),
        list.join(" ")
    );
    World::new(&parse(&text).unwrap(), meshes).unwrap()
}
