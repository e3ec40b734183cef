//! The leaves of the object tree, each with the matrix of all transforms around it.

use crate::diagnostic::Diagnostic;
use crate::math::aabb::Aabb;
use crate::math::robust::{self, UNIT_ROUNDOFF};
use crate::math::rounded::{RoundedAffine, absolute};
use crate::scene::{Object, ObjectId, Position, Scene};
use glam::{DAffine3, DMat3, DVec3};

/// A leaf of the object tree with the matrix that takes it to world space.
#[derive(Clone, Copy, Debug)]
pub struct Placement<'s> {
    /// The leaf.
    pub object: &'s Object,
    /// From object space to world space.
    pub matrix: DAffine3,
    /// The error bound of each number of the matrix.
    pub error: DAffine3,
    /// The exact sign of the matrix's determinant. It is 0 where the transforms flatten the object, and then the matrix,
    /// which is rounded, may have a determinant of any sign.
    pub orientation: i32,
    /// The innermost transform around the object; None at the top.
    pub transform: Option<Position>,
}

impl Placement<'_> {
    /// Whether the transforms turn the object inside out. Those that flatten it do not.
    pub(super) fn is_mirrored(&self) -> bool {
        self.orientation < 0
    }

    /// Whether the transforms flatten space: exactly, or as far as the rounded matrix tells.
    pub(super) fn is_singular(&self) -> bool {
        self.orientation == 0 || robust::is_singular(self.matrix.matrix3)
    }

    /// A point of the object in world space.
    pub(super) fn world_point(&self, point: DVec3) -> DVec3 {
        if self.transform.is_some() { robust::transformed(&self.matrix, point) } else { point }
    }

    /// The map from upper bounds on the absolute coordinates of a point of the object to how far along each axis the point
    /// in world space may be from the exact one. It includes the one rounding of each coordinate.
    pub(super) fn point_error(&self) -> DAffine3 {
        let sizes = absolute(self.matrix);
        let rounded = |error: DVec3, size: DVec3| error + UNIT_ROUNDOFF * (size + error);
        let (error, linear) = (self.error.matrix3, sizes.matrix3);
        DAffine3 {
            matrix3: DMat3::from_cols(
                rounded(error.x_axis, linear.x_axis),
                rounded(error.y_axis, linear.y_axis),
                rounded(error.z_axis, linear.z_axis),
            ),
            translation: rounded(self.error.translation, sizes.translation),
        }
    }

    /// The box by which the course's program bounds a placed box or shape: that of a shape without a transform, and
    /// otherwise the box around its transformed corners.
    pub fn course_box(&self, of_object: Aabb) -> Aabb {
        match self.transform {
            None => of_object,
            Some(_) => Aabb::around(of_object.corners().map(|p| self.matrix.transform_point3(p))),
        }
    }

    /// An error at the transform, or at the start of the text where there is none.
    pub(super) fn error(&self, message: &str) -> Diagnostic {
        Diagnostic::error(message).at(self.transform.unwrap_or(Position { line: 1, column: 1 }))
    }

    /// The error of an object that needs the inverse of a singular transform.
    pub(super) fn singular(&self) -> Diagnostic {
        self.error("the transformation is singular: it flattens the object")
    }

    /// The error of an object with coordinates beyond [`LARGEST`](crate::scene::limits::LARGEST).
    pub(super) fn too_large(&self) -> Diagnostic {
        self.error("the object has coordinates beyond 1e100")
    }
}

/// The leaves of a scene's tree in the order of its text. The traversal keeps its stack on the heap, so that
/// the depth of the tree is limited by nothing but memory.
pub fn placements(scene: &Scene) -> impl Iterator<Item = Placement<'_>> {
    let mut stack: Vec<(ObjectId, RoundedAffine, Option<Position>)> =
        vec![(scene.root, RoundedAffine::IDENTITY, None)];
    std::iter::from_fn(move || {
        loop {
            let (id, matrix, transform) = stack.pop()?;
            match &scene.objects[id] {
                Object::Group(children) => {
                    stack.extend(children.iter().rev().map(|&c| (c, matrix, transform)))
                }
                Object::Transform { matrix: m, child, at } => stack.push((*child, matrix * *m, Some(*at))),
                object => {
                    let RoundedAffine { map: matrix, error, orientation } = matrix;
                    return Some(Placement { object, matrix, error, orientation, transform });
                }
            }
        }
    })
}
