//! The leaves of the object tree, each with the product of all transforms around it.

use crate::diagnostic::Diagnostic;
use crate::math::aabb::Aabb;
use crate::math::robust::{self, UNIT_ROUNDOFF};
use crate::math::rounded::{RoundedAffine, absolute};
use crate::scene::{Object, ObjectId, Position, Scene};
use glam::{DAffine3, DMat3, DVec3};

/// A leaf of the object tree, with the matrix that maps it to world space.
#[derive(Clone, Copy, Debug)]
pub struct Placement<'s> {
    /// The leaf.
    pub object: &'s Object,
    /// Its index in [`Scene::objects`].
    pub id: ObjectId,
    /// From object space to world space.
    pub matrix: DAffine3,
    /// The error bound of each number of the matrix.
    pub error: DAffine3,
    /// The exact sign of the matrix's determinant. It is 0 if the transforms flatten the object. The rounded matrix may
    /// then have a determinant of any sign.
    pub orientation: i32,
    /// The innermost transform around the object; `None` at the top.
    pub transform: Option<Position>,
    /// The object's material.
    pub(super) material: u32,
    /// The object's position in the text.
    at: Position,
}

impl Placement<'_> {
    /// Returns true if the transforms turn the object inside out. Transforms that flatten it do not.
    pub(super) fn is_mirrored(&self) -> bool {
        self.orientation < 0
    }

    /// Returns an error if the transforms flatten space, either exactly or as far as the rounded matrix tells.
    pub(super) fn check_regular(&self) -> Result<(), Diagnostic> {
        if self.orientation != 0 && !robust::is_singular(self.matrix.matrix3) {
            return Ok(());
        }
        Err(self.error("the transformation is singular: it flattens the object"))
    }

    /// Maps a point of the object to world space.
    pub(super) fn world_point(&self, point: DVec3) -> DVec3 {
        if self.transform.is_some() { robust::transformed(&self.matrix, point) } else { point }
    }

    /// Returns a map from upper bounds on the absolute coordinates of a point of the object to the error bound of the
    /// point in world space along each axis. It includes the one rounding of each coordinate.
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

    /// Returns the box by which the course's program bounds a placed box or shape: the box itself without a transform,
    /// and otherwise the box around its transformed corners.
    pub fn course_box(&self, of_object: Aabb) -> Aabb {
        match self.transform {
            None => of_object,
            Some(_) => Aabb::around(of_object.corners().map(|p| self.matrix.transform_point3(p))),
        }
    }

    /// Returns an error at the transform, or at the object without one.
    pub(super) fn error(&self, message: &str) -> Diagnostic {
        Diagnostic::error(message).at(self.transform.unwrap_or(self.at))
    }
}

/// Returns the leaves of a scene's tree in the order of its text. The traversal keeps its stack on the heap, so that
/// only memory limits the depth of the tree.
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
                Object::Transform { matrix: m, child, at, .. } => {
                    stack.push((*child, matrix * *m, Some(*at)))
                }
                object => {
                    let RoundedAffine { map: matrix, error, orientation } = matrix;
                    let material = object.material().unwrap_or_default() as u32;
                    let at = scene.positions.objects.get(id).copied().unwrap_or_default();
                    return Some(Placement {
                        object,
                        id,
                        matrix,
                        error,
                        orientation,
                        transform,
                        material,
                        at,
                    });
                }
            }
        }
    })
}
