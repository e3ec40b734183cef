//! Mesh simplification by edge collapses that keep the surface a closed manifold.
//!
//! Garland and Heckbert, "Surface simplification using quadric error metrics",
//! SIGGRAPH 1997: the cheapest edge shrinks to the point nearest, in the sense
//! of least squares, to the planes of all faces the edge has come to stand for.

use crate::topology::{Mesh, area_normal, directed_edges};
use glam::{DMat3, DVec3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// The weight of moving a vertex within its plane, relative to moving it off the plane. It makes every
/// quadric invertible, and distributes vertices evenly.
const SLIDE_WEIGHT: f64 = 5e-3;
/// A face may turn by at most the angle of this cosine in one collapse.
const MIN_TURN_COSINE: f64 = 0.3;
/// Faces rounder than this (1 is equilateral) may lose shape down to it.
const MIN_ROUNDNESS: f64 = 0.3;
/// The share of the faces that a round of collapses leaves.
const ROUND_SHARE: f64 = 0.9;

/// A sum of squared weighted distances: `x A x + 2 b x + c`.
#[derive(Clone, Copy)]
struct Quadric {
    a: DMat3,
    b: DVec3,
    c: f64,
}

impl Quadric {
    const ZERO: Self = Self { a: DMat3::ZERO, b: DVec3::ZERO, c: 0.0 };

    fn plus(self, other: Self) -> Self {
        Self { a: self.a + other.a, b: self.b + other.b, c: self.c + other.c }
    }

    /// The quadric one corner gets from a face: the distance from the face's
    /// plane and, weakly, from the corner, both times the face's area.
    fn of_corner(corner: DVec3, normal: DVec3, area: f64) -> Self {
        let outer = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
        let offset = -normal.dot(corner);
        let slide = SLIDE_WEIGHT * area;
        Self {
            a: outer * area + DMat3::IDENTITY * slide,
            b: normal * (offset * area) - corner * slide,
            c: offset * offset * area + corner.length_squared() * slide,
        }
    }

    fn minimum(&self) -> DVec3 {
        self.a.inverse() * -self.b
    }

    fn at(&self, point: DVec3) -> f64 {
        point.dot(self.a * point) + 2.0 * self.b.dot(point) + self.c
    }
}

/// A candidate for a collapse. It is out of date when a stamp of its ends has changed.
struct Candidate {
    cost: f64,
    target: DVec3,
    ends: [u32; 2],
    stamps: [u32; 2],
}

impl Ord for Candidate {
    /// The greatest candidate is the cheapest one. Ties are ordered by the indices of the vertices, so that
    /// the order does not depend on the heap's implementation.
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .cost
            .total_cmp(&self.cost)
            .then_with(|| (other.ends, other.stamps).cmp(&(self.ends, self.stamps)))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

/// A mesh during its simplification.
pub struct Simplifier {
    mesh: Mesh,
    live_faces: usize,
    face_is_live: Vec<bool>,
    /// The remaining faces around each vertex; empty for a vertex that was removed.
    faces_around: Vec<Vec<u32>>,
    quadrics: Vec<Quadric>,
    /// The number of changes of each vertex or its neighbourhood.
    stamps: Vec<u32>,
    queue: BinaryHeap<Candidate>,
}

impl Simplifier {
    /// Starts from a closed manifold. `weight` returns the weight of an error at a point.
    pub fn new(mesh: Mesh, weight: &dyn Fn(DVec3) -> f64) -> Self {
        let mut faces_around = vec![Vec::new(); mesh.positions.len()];
        let mut quadrics = vec![Quadric::ZERO; mesh.positions.len()];
        for (index, &face) in (0u32..).zip(&mesh.faces) {
            let corners = mesh.corners(face);
            let normal = area_normal(corners);
            let unit = normal.normalize_or_zero();
            for (vertex, corner) in face.into_iter().zip(corners) {
                let quadric = Quadric::of_corner(corner, unit, normal.length() * weight(corner));
                quadrics[vertex as usize] = quadrics[vertex as usize].plus(quadric);
                faces_around[vertex as usize].push(index);
            }
        }
        Self {
            live_faces: mesh.faces.len(),
            face_is_live: vec![true; mesh.faces.len()],
            stamps: vec![0; mesh.positions.len()],
            queue: BinaryHeap::new(),
            mesh,
            faces_around,
            quadrics,
        }
    }

    /// Collapses edges, the cheapest first, until `count` faces are left. A
    /// collapse takes two faces, and a closed mesh has an even number of them.
    ///
    /// This is done in rounds, because an edge that was rejected may collapse after others around it have
    /// changed.
    pub fn reduce_to(&mut self, count: usize) -> Result<(), String> {
        while self.live_faces > count {
            let before = self.live_faces;
            let goal = ((before as f64 * ROUND_SHARE) as usize).max(count);
            self.queue_all();
            while self.live_faces > goal
                && let Some(candidate) = self.queue.pop()
            {
                if self.is_current(&candidate) && self.is_allowed(&candidate) {
                    self.collapse(&candidate);
                }
            }
            if self.live_faces == before {
                return Err(format!("stuck at {before} faces on the way to {count}"));
            }
        }
        Ok(())
    }

    /// The current mesh, with its vertices and faces in their original order.
    pub fn compacted(&self) -> Mesh {
        let mut new_index = vec![0; self.faces_around.len()];
        let mut positions = Vec::new();
        for (vertex, around) in self.faces_around.iter().enumerate() {
            if !around.is_empty() {
                new_index[vertex] = positions.len() as u32;
                positions.push(self.mesh.positions[vertex]);
            }
        }
        let live = self.mesh.faces.iter().zip(&self.face_is_live).filter(|(_, live)| **live);
        let faces = live.map(|(face, _)| face.map(|vertex| new_index[vertex as usize])).collect();
        Mesh { positions, faces }
    }

    /// Queues all edges of the mesh and nothing else.
    fn queue_all(&mut self) {
        self.queue.clear();
        for index in 0..self.mesh.faces.len() {
            if self.face_is_live[index] {
                for (from, to) in directed_edges(self.mesh.faces[index]) {
                    if from < to {
                        self.queue_edge(from, to);
                    }
                }
            }
        }
    }

    fn queue_edge(&mut self, a: u32, b: u32) {
        let ends = [a.min(b), a.max(b)];
        let quadric = self.quadrics[a as usize].plus(self.quadrics[b as usize]);
        let target = quadric.minimum();
        let stamps = ends.map(|end| self.stamps[end as usize]);
        self.queue.push(Candidate { cost: quadric.at(target), target, ends, stamps });
    }

    fn is_current(&self, candidate: &Candidate) -> bool {
        candidate.stamps == candidate.ends.map(|end| self.stamps[end as usize])
            && candidate.ends.iter().all(|&end| !self.faces_around[end as usize].is_empty())
    }

    fn is_allowed(&self, candidate: &Candidate) -> bool {
        self.keeps_topology(candidate.ends) && self.keeps_shape(candidate)
    }

    /// The link condition (Dey, Edelsbrunner, Guha and Nekhayev, "Topology
    /// preserving edge contraction", 1999). On a closed surface larger than a
    /// tetrahedron: the ends share no neighbours but the two of the edge's faces.
    fn keeps_topology(&self, [a, b]: [u32; 2]) -> bool {
        let others = self.neighbours(b);
        let shared = self.neighbours(a).into_iter().filter(|vertex| others.contains(vertex)).count();
        shared == 2 && self.live_faces > 4
    }

    /// No face around the edge turns over, and none becomes a sliver unless
    /// it was a worse one before.
    fn keeps_shape(&self, candidate: &Candidate) -> bool {
        let [a, b] = candidate.ends;
        let faces = self.faces_around[a as usize].iter().chain(&self.faces_around[b as usize]);
        faces.into_iter().all(|&index| {
            let face = self.mesh.faces[index as usize];
            if face.contains(&a) && face.contains(&b) {
                return true;
            }
            let before = self.mesh.corners(face);
            let mut after = before;
            for (corner, vertex) in after.iter_mut().zip(face) {
                if vertex == a || vertex == b {
                    *corner = candidate.target;
                }
            }
            turn_cosine(before, after) > MIN_TURN_COSINE
                && roundness(after) > roundness(before).min(MIN_ROUNDNESS)
        })
    }

    /// Moves the first end to the target and merges the second into it.
    fn collapse(&mut self, candidate: &Candidate) {
        let [kept, gone] = candidate.ends;
        for index in std::mem::take(&mut self.faces_around[gone as usize]) {
            let face = self.mesh.faces[index as usize];
            if face.contains(&kept) {
                self.remove_face(index);
            } else {
                self.mesh.faces[index as usize] =
                    face.map(|vertex| if vertex == gone { kept } else { vertex });
                self.faces_around[kept as usize].push(index);
            }
        }
        self.mesh.positions[kept as usize] = candidate.target;
        self.quadrics[kept as usize] = self.quadrics[kept as usize].plus(self.quadrics[gone as usize]);
        self.stamps[kept as usize] += 1;
        for neighbour in self.neighbours(kept) {
            self.queue_edge(kept, neighbour);
        }
    }

    fn remove_face(&mut self, index: u32) {
        self.face_is_live[index as usize] = false;
        self.live_faces -= 1;
        for vertex in self.mesh.faces[index as usize] {
            self.faces_around[vertex as usize].retain(|&other| other != index);
        }
    }

    /// The vertices that share an edge with a vertex.
    fn neighbours(&self, vertex: u32) -> Vec<u32> {
        let faces = self.faces_around[vertex as usize].iter().map(|&index| self.mesh.faces[index as usize]);
        // In a closed surface the edges that leave a vertex reach each neighbour once.
        let leaving = faces.flat_map(directed_edges).filter(|(from, _)| *from == vertex);
        leaving.map(|(_, to)| to).collect()
    }
}

/// The cosine of the angle between a triangle's normals before and after.
fn turn_cosine(before: [DVec3; 3], after: [DVec3; 3]) -> f64 {
    area_normal(before).normalize_or_zero().dot(area_normal(after).normalize_or_zero())
}

/// The area of a triangle over that of the equilateral one with the same sum
/// of squared sides.
fn roundness(corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let squares = (b - a).length_squared() + (c - b).length_squared() + (a - c).length_squared();
    2.0 * 3f64.sqrt() * area_normal(corners).length() / squares
}
