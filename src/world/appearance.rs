//! The features of only some editions: smooth normals, textures, and a background of pictures.

use super::{SurfacePoint, World};
use crate::math::robust;
use crate::picture::Color;
use crate::scene::material::{Material, Paint};
use crate::scene::mesh::Mesh;
use crate::scene::model::{FaceWeights, MeshNormals};
use crate::scene::texels::{Texels, face};
use glam::{DMat3, DVec2, DVec3};
use std::sync::Arc;

impl World {
    /// Returns the colour along a ray that hits nothing.
    #[inline(always)]
    pub fn background_along(&self, direction: DVec3) -> Color {
        match &self.cube_map {
            Some(faces) => cube_color(faces, direction),
            None => self.background,
        }
    }

    /// Returns true if there are smooth meshes.
    #[inline(always)]
    pub fn has_smooth_normals(&self) -> bool {
        !self.vertex_normals.is_empty()
    }

    /// Returns the normal on a smooth mesh, interpolated between the vertices; `None` on other surfaces.
    pub fn smooth_normal(&self, surface: &SurfacePoint) -> Option<DVec3> {
        let triangle = surface.triangle? as usize;
        let normal =
            |vertex: u32| self.vertex_normals.get(vertex as usize).copied().filter(|n| *n != DVec3::ZERO);
        let [a, b, c] = self.triangles[triangle];
        let normals = [normal(a)?, normal(b)?, normal(c)?];
        let weights = self.weights_at(triangle, surface.position);
        let sum = normals.into_iter().zip(weights).map(|(normal, weight)| normal * weight).sum::<DVec3>();
        Some(robust::unit(sum)).filter(|normal| normal.is_finite())
    }

    /// Returns the colour of the picture on a surface; `None` if the surface has no texture coordinates.
    pub fn image_color(&self, image: usize, surface: &SurfacePoint) -> Option<Color> {
        let triangle = surface.triangle? as usize;
        let corners = (*self.texture_coordinates.get(triangle)?)?;
        let weights = self.weights_at(triangle, surface.position);
        let place = corners.into_iter().zip(weights).map(|(corner, weight)| corner * weight).sum::<DVec2>();
        self.images.get(image).map(|image| image.color(place.as_vec2().to_array()))
    }

    /// Returns the factor of ambient light at a surface whose diffuse colour at this point is `diffuse`.
    #[inline(always)]
    pub fn ambient_color(&self, surface: &SurfacePoint, diffuse: Color) -> Color {
        match self.materials[surface.material] {
            Material::Painted(phong, Paint::Pattern(..) | Paint::Image { tints_ambient: false, .. }) => {
                phong.diffuse
            }
            _ => diffuse,
        }
    }

    /// Returns the barycentric weights of a point of a triangle.
    fn weights_at(&self, triangle: usize, point: DVec3) -> [f64; 3] {
        let [a, b, c] = self.corners(triangle);
        let (p, q, r) = (b - a, c - a, point - a);
        let normal = p.cross(q);
        let square = normal.length_squared();
        let (v, w) = (r.cross(q).dot(normal) / square, p.cross(r).dot(normal) / square);
        [1.0 - v - w, v, w]
    }
}

fn cube_color(faces: &[Arc<Texels>; 6], direction: DVec3) -> Color {
    let (index, place) = face(direction);
    faces[index].color(place)
}

/// Returns a vector along the normal of each vertex of a mesh under a linear map; `None` for a flat mesh. `listed` is
/// the number of vertices in the mesh's file, including vertices that no face uses. `is_mirrored` is true if the map's
/// determinant is negative.
pub fn vertex_normals(
    mesh: &Mesh,
    listed: usize,
    (linear, is_mirrored): (DMat3, bool),
    normals: MeshNormals,
) -> Option<Vec<DVec3>> {
    let MeshNormals::Smooth { weights, flat_up_to } = normals else { return None };
    if listed <= flat_up_to {
        return None;
    }
    let mut sums = vec![DVec3::ZERO; mesh.vertices.len()];
    for corners in &mesh.triangles {
        let [a, b, c] = corners.map(|vertex| mesh.vertices[vertex as usize]);
        let normal = (b - a).cross(c - a);
        let normal = match weights {
            FaceWeights::Area => normal,
            FaceWeights::Equal => normal.normalize_or_zero(),
        };
        corners.iter().for_each(|&vertex| sums[vertex as usize] += normal);
    }
    // The cofactor matrix has the sign of the determinant.
    let normal_matrix = robust::cofactor(linear) * if is_mirrored { -1.0 } else { 1.0 };
    Some(sums.into_iter().map(|sum| normal_matrix * sum.normalize_or_zero()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a large triangle that faces up, and a small one that faces x, with an edge in common.
    fn folded() -> Mesh {
        Mesh {
            vertices: vec![DVec3::ZERO, DVec3::Z, DVec3::new(-4.0, 0.0, 0.0), DVec3::NEG_Y],
            triangles: vec![[0, 2, 1], [0, 3, 1]].into_iter().map(|[a, b, c]| [a, c, b]).collect(),
        }
    }

    fn normals(weights: FaceWeights, linear: DMat3) -> Vec<DVec3> {
        let smooth = MeshNormals::Smooth { weights, flat_up_to: 3 };
        vertex_normals(&folded(), 4, (linear, linear.determinant() < 0.0), smooth).unwrap()
    }

    #[test]
    fn faces_count_by_their_area_or_alike() {
        let mesh = folded();
        let face = |k: usize| {
            let [a, b, c] = mesh.triangles[k].map(|vertex| mesh.vertices[vertex as usize]);
            (b - a).cross(c - a)
        };
        let [large, small] = [face(0), face(1)];
        assert_eq!((large.length(), small.length()), (4.0, 1.0));
        let of = |weights| normals(weights, DMat3::IDENTITY);
        let area = of(FaceWeights::Area);
        assert!((area[0] - (large + small).normalize()).length() < 1e-15 && area[0] == area[1]);
        assert_eq!([area[2], area[3]], [large.normalize(), small]);
        let equal = of(FaceWeights::Equal);
        assert!((equal[0] - (large.normalize() + small).normalize()).length() < 1e-15);
    }

    #[test]
    fn normals_are_transformed_by_the_inverse_transpose() {
        let linear = DMat3::from_diagonal(DVec3::new(-2.0, 1.0, 1.0));
        let (moved, still) =
            (normals(FaceWeights::Area, linear), normals(FaceWeights::Area, DMat3::IDENTITY));
        for (moved, still) in moved.into_iter().zip(still) {
            let expected = (linear.inverse().transpose() * still).normalize();
            assert!((moved.normalize() - expected).length() < 1e-15, "{moved}");
        }
    }
}
