//! The mesh type, and the check that a mesh is the boundary of one solid.

use glam::DVec3;
use std::collections::BTreeSet;

/// Vertices and counter-clockwise (seen from outside) triangles over them.
pub struct Mesh {
    pub positions: Vec<DVec3>,
    pub faces: Vec<[u32; 3]>,
}

impl Mesh {
    /// The three corner positions of a face.
    pub fn corners(&self, face: [u32; 3]) -> [DVec3; 3] {
        face.map(|vertex| self.positions[vertex as usize])
    }

    /// The same surface around its outside: what was inside is outside.
    pub fn inside_out(mut self) -> Self {
        self.faces.iter_mut().for_each(|face| face.swap(1, 2));
        self
    }

    /// All meshes as one.
    pub fn join(meshes: impl IntoIterator<Item = Self>) -> Self {
        let mut all = Self { positions: Vec::new(), faces: Vec::new() };
        for mesh in meshes {
            let first = all.positions.len() as u32;
            all.faces.extend(mesh.faces.iter().map(|face| face.map(|vertex| first + vertex)));
            all.positions.extend(mesh.positions);
        }
        all
    }
}

/// Twice the area of a triangle times its unit outward normal.
pub fn area_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// The three directed edges of a face, in the order the face runs through them.
pub fn directed_edges([a, b, c]: [u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

/// Checks that the mesh is one closed, outward-facing surface with so many holes
/// through it, whose faces all have an area and whose vertices are all distinct and used.
///
/// Faces are connected through edges here, not through vertices, so a vertex
/// where two sheets merely touch cannot hide: pulling it apart would leave a
/// connected closed surface with one vertex more, so that V - E + F is odd, and there is none.
pub fn check_closed(mesh: &Mesh, holes: i64) -> Result<(), String> {
    let twins = TwinTable::new(mesh)?;
    twins.check_connected(mesh)?;
    check_vertices(mesh)?;
    check_areas(mesh)?;
    let euler = mesh.positions.len() as i64 - twins.edge_count() as i64 + mesh.faces.len() as i64;
    if euler != 2 - 2 * holes {
        return Err(format!("V - E + F is {euler}, not that of a surface with {holes} holes"));
    }
    if enclosed_volume(mesh) <= 0.0 {
        return Err("the faces turn their backs outwards".to_string());
    }
    Ok(())
}

/// The directed edges of a mesh, sorted, each with the face it belongs to.
struct TwinTable(Vec<((u32, u32), u32)>);

impl TwinTable {
    /// Fails unless every edge has exactly two faces that run through it in
    /// opposite directions: the mesh is closed and consistently oriented.
    fn new(mesh: &Mesh) -> Result<Self, String> {
        let mut edges: Vec<_> = (0u32..)
            .zip(&mesh.faces)
            .flat_map(|(index, &face)| directed_edges(face).map(|edge| (edge, index)))
            .collect();
        edges.sort_unstable();
        if let Some(pair) = edges.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return Err(format!("two faces run through edge {:?} in one direction", pair[0].0));
        }
        let table = Self(edges);
        match table.0.iter().find(|(edge, _)| table.face_across(*edge).is_none()) {
            Some((edge, _)) => Err(format!("edge {edge:?} has one face only")),
            None => Ok(table),
        }
    }

    /// The face on the other side of a directed edge.
    fn face_across(&self, (from, to): (u32, u32)) -> Option<u32> {
        let place = self.0.binary_search_by_key(&(to, from), |(edge, _)| *edge).ok()?;
        Some(self.0[place].1)
    }

    fn edge_count(&self) -> usize {
        self.0.len() / 2
    }

    /// Fails unless a walk across edges reaches every face from the first.
    fn check_connected(&self, mesh: &Mesh) -> Result<(), String> {
        let mut seen = vec![false; mesh.faces.len()];
        let mut pending = vec![0];
        let mut reached = 0;
        while let Some(index) = pending.pop() {
            if std::mem::replace(&mut seen[index as usize], true) {
                continue;
            }
            reached += 1;
            let edges = directed_edges(mesh.faces[index as usize]);
            pending.extend(edges.into_iter().filter_map(|edge| self.face_across(edge)));
        }
        if reached == seen.len() {
            Ok(())
        } else {
            Err(format!("only {reached} of {} faces hang together", seen.len()))
        }
    }
}

/// Fails if two vertices coincide or a vertex is in no face.
fn check_vertices(mesh: &Mesh) -> Result<(), String> {
    let bits = mesh.positions.iter().map(|p| p.to_array().map(f64::to_bits));
    if bits.collect::<BTreeSet<_>>().len() != mesh.positions.len() {
        return Err("two vertices have the same position".to_string());
    }
    let used: BTreeSet<u32> = mesh.faces.iter().flatten().copied().collect();
    if used.len() != mesh.positions.len() {
        return Err("a vertex is in no face".to_string());
    }
    Ok(())
}

/// Fails if a face has collapsed to a line.
fn check_areas(mesh: &Mesh) -> Result<(), String> {
    match mesh.faces.iter().find(|&&face| area_normal(mesh.corners(face)).length_squared() < 1e-24) {
        Some(face) => Err(format!("face {face:?} has no area")),
        None => Ok(()),
    }
}

/// The volume inside a closed mesh (divergence theorem), positive if the faces
/// are counter-clockwise seen from outside.
fn enclosed_volume(mesh: &Mesh) -> f64 {
    let tetrahedra = mesh.faces.iter().map(|&face| {
        let [a, b, c] = mesh.corners(face);
        a.dot(b.cross(c)) / 6.0
    });
    tetrahedra.sum()
}
