//! The nodes of the object tree.

use super::mesh::Mesh;
use super::{MaterialId, ObjectId, Position};
use crate::math::aabb::Aabb;
use crate::math::rounded_affine::RoundedAffine;
use glam::DVec3;
use std::sync::Arc;

/// A node of the object tree.
#[derive(Clone, Debug, PartialEq)]
pub enum Object {
    Group(Vec<ObjectId>),
    Transform {
        /// The map from the child's space to the parent's. It may be singular.
        matrix: RoundedAffine,
        child: ObjectId,
        /// The position of the `Transform` in the text.
        at: Position,
    },
    Sphere {
        center: DVec3,
        radius: f64,
        material: MaterialId,
    },
    /// The points p with n.p = `offset`, where n is `normal` scaled to unit length.
    Plane {
        /// The normal, which need not be a unit vector.
        normal: DVec3,
        /// The plane's distance from the origin along its normal.
        offset: f64,
        material: MaterialId,
    },
    Triangle {
        /// The corners, counter-clockwise seen from outside.
        vertices: [DVec3; 3],
        material: MaterialId,
    },
    /// The axis-aligned box of the 2003 edition.
    Box {
        min: DVec3,
        max: DVec3,
        material: MaterialId,
    },
    /// The cells of the 2003 edition that a sphere fills.
    Grid {
        /// The faces between filled cells and others.
        surface: Arc<Mesh>,
        material: MaterialId,
    },
    /// A triangle mesh from a file.
    Mesh {
        /// The index of the file in [`Scene::meshes`](super::Scene::meshes).
        mesh: usize,
        material: MaterialId,
    },
}

impl Object {
    /// The word that it begins with in the text.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Group(_) => "Group",
            Self::Transform { .. } => "Transform",
            Self::Sphere { .. } => "Sphere",
            Self::Plane { .. } => "Plane",
            Self::Triangle { .. } => "Triangle",
            Self::Box { .. } => "Box",
            Self::Grid { .. } => "Grid",
            Self::Mesh { .. } => "TriangleMesh",
        }
    }

    /// The material of a primitive's surface.
    pub fn material(&self) -> Option<MaterialId> {
        match *self {
            Self::Group(_) | Self::Transform { .. } => None,
            Self::Sphere { material, .. }
            | Self::Plane { material, .. }
            | Self::Triangle { material, .. }
            | Self::Box { material, .. }
            | Self::Grid { material, .. }
            | Self::Mesh { material, .. } => Some(material),
        }
    }

    pub fn material_mut(&mut self) -> Option<&mut MaterialId> {
        match self {
            Self::Group(_) | Self::Transform { .. } => None,
            Self::Sphere { material, .. }
            | Self::Plane { material, .. }
            | Self::Triangle { material, .. }
            | Self::Box { material, .. }
            | Self::Grid { material, .. }
            | Self::Mesh { material, .. } => Some(material),
        }
    }

    /// The bounding box of a shape, before any transform. The course's program bounds the transformed shape by that of its
    /// corners.
    pub fn shape_box(&self) -> Option<Aabb> {
        match *self {
            Self::Sphere { center, radius, .. } => Some(Aabb { min: center - radius, max: center + radius }),
            _ => None,
        }
    }
}
