//! Marching tetrahedra: the zero surface of a function as a closed mesh.
//!
//! Doi and Koide, "An efficient method of triangulating equi-valued surfaces
//! by using tetrahedral cells", 1991. Unlike marching cubes it has no ambiguous
//! case, so its output is always a closed 2-manifold.

use crate::topology::{Mesh, area_normal, directed_edges};
use glam::DVec3;

/// A lattice of cubes with `counts` points per axis from `origin` on.
pub struct Lattice {
    pub origin: DVec3,
    pub step: f64,
    pub counts: [usize; 3],
}

/// Kuhn's division of the cube into six tetrahedra around its diagonal: each is a path from corner 0 to
/// corner 7 along one axis at a time. Bit n of a corner is its offset along axis n. Neighbouring cubes divide
/// their shared face in the same way.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 1, 5, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 6, 7]];

/// Every lattice edge is a step by one of the seven non-zero corner offsets.
const EDGES_PER_POINT: usize = 7;

/// The value of a lattice edge without a vertex.
const ABSENT: u32 = u32::MAX;

/// Polygonises the surface where `field`, negative inside, changes its sign.
/// The surface must not reach the border of the lattice.
pub fn polygonise(lattice: &Lattice, field: &dyn Fn(DVec3) -> f64) -> Mesh {
    let values = (0..lattice.len()).map(|index| field(lattice.point(index))).collect();
    let edge_vertices = vec![ABSENT; lattice.len() * EDGES_PER_POINT];
    let mesh = Mesh { positions: Vec::new(), faces: Vec::new() };
    let mut march = March { lattice, field, values, edge_vertices, mesh };
    for index in lattice.cubes() {
        march.cube(index);
    }
    march.mesh
}

impl Lattice {
    fn len(&self) -> usize {
        self.counts.iter().product()
    }

    fn point(&self, index: usize) -> DVec3 {
        let [nx, ny, _] = self.counts;
        let cell = DVec3::new((index % nx) as f64, (index / nx % ny) as f64, (index / (nx * ny)) as f64);
        self.origin + cell * self.step
    }

    /// The index of the point at a corner offset of the cube that starts at `index`.
    fn corner(&self, index: usize, offset: usize) -> usize {
        let [nx, ny, _] = self.counts;
        index + (offset & 1) + (offset >> 1 & 1) * nx + (offset >> 2) * nx * ny
    }

    /// The lowest points of all cubes.
    fn cubes(&self) -> impl Iterator<Item = usize> {
        let [nx, ny, nz] = self.counts;
        (0..nz - 1)
            .flat_map(move |z| (0..ny - 1).flat_map(move |y| (0..nx - 1).map(move |x| (z * ny + y) * nx + x)))
    }
}

/// The state of one polygonisation.
struct March<'a> {
    lattice: &'a Lattice,
    field: &'a dyn Fn(DVec3) -> f64,
    values: Vec<f64>,
    /// The mesh vertex on each lattice edge, by start point and offset.
    edge_vertices: Vec<u32>,
    mesh: Mesh,
}

impl March<'_> {
    fn inside(&self, point: usize) -> bool {
        self.values[point] < 0.0
    }

    fn cube(&mut self, index: usize) {
        let inside = (0..8).filter(|&offset| self.inside(self.lattice.corner(index, offset))).count();
        if inside == 0 || inside == 8 {
            return;
        }
        for corners in TETRAHEDRA {
            self.tetrahedron(corners.map(|offset| self.lattice.corner(index, offset)));
        }
    }

    /// Adds the one or two triangles that separate the inner corners from the outer ones.
    fn tetrahedron(&mut self, corners: [usize; 4]) {
        let (inner, outer): (Vec<_>, Vec<_>) = corners.into_iter().partition(|&corner| self.inside(corner));
        match (inner.as_slice(), outer.as_slice()) {
            (&[a], &[d, e, f]) => self.triangle([(a, d), (a, e), (a, f)]),
            (&[a, b, c], &[d]) => self.triangle([(a, d), (b, d), (c, d)]),
            (&[a, b], &[c, d]) => {
                self.triangle([(a, c), (a, d), (b, d)]);
                self.triangle([(a, c), (b, d), (b, c)]);
            }
            _ => {}
        }
    }

    /// Adds the triangle through three crossed (inner, outer) lattice edges,
    /// wound so that it faces the outer points.
    fn triangle(&mut self, edges: [(usize, usize); 3]) {
        let mut face = edges.map(|(inner, outer)| self.edge_vertex(inner, outer));
        // The orientation is computed from the midpoints of the lattice edges, because the vertices
        // themselves may be too close together.
        let middles = edges.map(|(a, b)| (self.lattice.point(a) + self.lattice.point(b)) * 0.5);
        let outwards: DVec3 = edges.iter().map(|&(a, b)| self.lattice.point(b) - self.lattice.point(a)).sum();
        if area_normal(middles).dot(outwards) < 0.0 {
            face.swap(1, 2);
        }
        self.mesh.faces.push(face);
    }

    /// The vertex on a crossed lattice edge, which is created when it is first used.
    fn edge_vertex(&mut self, inner: usize, outer: usize) -> u32 {
        let (low, high) = (inner.min(outer), inner.max(outer));
        let offset = (1..8).find(|&offset| self.lattice.corner(low, offset) == high).unwrap_or(0);
        let slot = low * EDGES_PER_POINT + offset - 1;
        if self.edge_vertices[slot] == ABSENT {
            self.edge_vertices[slot] = self.mesh.positions.len() as u32;
            let position = self.crossing(self.lattice.point(inner), self.lattice.point(outer));
            self.mesh.positions.push(position);
        }
        self.edge_vertices[slot]
    }

    /// The point at which the surface crosses a lattice edge, by bisection. It is kept away from the ends,
    /// where the vertices of several edges would coincide.
    fn crossing(&self, inner: DVec3, outer: DVec3) -> DVec3 {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..16 {
            let middle = 0.5 * (low + high);
            if (self.field)(inner.lerp(outer, middle)) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        inner.lerp(outer, low.clamp(0.03, 0.97))
    }
}

/// Evens out the triangles, whose sizes differ much after marching: each vertex moves to the centre of its
/// neighbours and then back to the surface.
pub fn relax(mesh: &mut Mesh, field: &dyn Fn(DVec3) -> f64, rounds: usize) {
    for _ in 0..rounds {
        let mut sums = vec![(DVec3::ZERO, 0.0); mesh.positions.len()];
        for (from, to) in mesh.faces.iter().flat_map(|&face| directed_edges(face)) {
            let (sum, count) = &mut sums[from as usize];
            *sum += mesh.positions[to as usize];
            *count += 1.0;
        }
        for (position, (sum, count)) in mesh.positions.iter_mut().zip(sums) {
            *position = onto_surface(sum / count, field);
        }
    }
}

/// Moves a point near the surface onto it, by Newton steps along the gradient.
fn onto_surface(mut point: DVec3, field: &dyn Fn(DVec3) -> f64) -> DVec3 {
    const REACH: f64 = 1e-5;
    for _ in 0..2 {
        let slope = DVec3::AXES.map(|axis| field(point + axis * REACH) - field(point - axis * REACH));
        let gradient = DVec3::from(slope) / (2.0 * REACH);
        // A gradient near 0 would move the point far away.
        point -= gradient * (field(point) / gradient.length_squared().max(0.25));
    }
    point
}
