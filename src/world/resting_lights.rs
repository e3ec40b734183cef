//! Point lights that lie on a surface.
//!
//! A ray from elsewhere to such a light ends on the surface, so roundings of the ray would decide whether it meets the
//! surface. This module decides it once for each light: an opaque surface shadows everything from a light that lies on
//! it, on both of its sides.

use super::point_error::weights;
use super::{Primitive, World};
use crate::base::patience::Steps;
use crate::diagnostic::Diagnostic;
use crate::math::aabb::Aabb;
use crate::math::box_tree::{BoxTree, Extents, Node};
use crate::math::exact::area_vector;
use crate::math::robust::{UNIT_ROUNDOFF, unit};
use crate::picture::Color;
use crate::scene::Light;
use crate::scene::material::Material;
use crate::world::plane::Plane;
use crate::world::shape::{Shape, UnitSphereMaps};
use glam::DVec3;
use std::cmp::Ordering;

/// The largest distance between a surface and a light that lies on it, in roundings of the largest of their
/// coordinates. It is added to the flattening error of the surface. It allows for the rounded coordinates of a light
/// that was computed to lie on the surface.
const RESTING_ROUNDINGS: f64 = 32.0;

/// A surface on which a light lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestingPlace {
    /// The primitive's id.
    pub primitive: u32,
    /// The outward normal at the light, for a round surface.
    outward: Option<DVec3>,
}

impl RestingPlace {
    /// Returns true if a ray to the light that meets this primitive meets it at the light. `is_leaving` is true if the
    /// ray goes outwards at the hit. A round surface has two crossings, and the ray goes outwards at only one of them.
    pub fn is_crossed(&self, primitive: u32, direction: DVec3, is_leaving: bool) -> bool {
        primitive == self.primitive
            && self.outward.is_none_or(|outward| (outward.dot(direction) >= 0.0) == is_leaving)
    }
}

/// Upper bound on the pairs of a light and a surface that is within some roundings of it and does not block it alone.
/// It bounds their memory and the time to find them.
const MOST_NEAR: usize = 1 << 20;

impl World {
    /// Returns the surfaces on which the light with this index lies, in the order of their ids. The list ends with the
    /// first opaque one, which alone blocks the light.
    #[inline(always)]
    pub fn primitives_at_light(&self, light: usize) -> &[RestingPlace] {
        self.resting_places.get(light).map_or(&[], Vec::as_slice)
    }

    /// Returns the surfaces on which each light lies. The lights near a surface are found in a tree.
    pub(super) fn find_resting_places(
        &self,
        steps: &mut Steps,
    ) -> Result<Vec<Vec<RestingPlace>>, Diagnostic> {
        let mut places = vec![vec![]; self.lights.len()];
        let points: Vec<(usize, DVec3)> = self.lights.iter().enumerate().filter_map(point_of).collect();
        let is_opaque = opaque(&self.materials);
        let mut search = Search::new(self, points.iter().map(|&(_, point)| point));
        let (mut near, mut pairs) = (vec![], 0);
        for id in search.ids() {
            steps.take(search.find_near(id, &mut near))?;
            for &index in &near {
                let (light, point) = points[index as usize];
                let place = self.place_at(point, id);
                places[light].extend(place);
                if place.is_some() && is_opaque.get(self.material_of(id)) == Some(&true) {
                    search.leave_out(index);
                    continue;
                }
                pairs += 1;
                if pairs > MOST_NEAR {
                    let message =
                        "too many lights lie on surfaces, or within rounding of them: a million pairs";
                    return Err(Diagnostic::error(message));
                }
            }
            steps.take(8 * near.len())?;
        }
        Ok(places)
    }

    /// Returns the place of a light on a primitive, or `None` if it does not lie on it.
    fn place_at(&self, point: DVec3, primitive: u32) -> Option<RestingPlace> {
        let flat = RestingPlace { primitive, outward: None };
        match self.primitive(primitive) {
            Primitive::Triangle(i) => lies_on(point, i, self).then_some(flat),
            Primitive::Shape(i) => {
                let moved = self.flattening_error(primitive, point).max_element();
                let outward = normal_at(point, &self.shapes[i], moved)?;
                Some(RestingPlace { primitive, outward: Some(outward) })
            }
            Primitive::Plane(i) => {
                let (plane, flattening) = (&self.planes[i], self.flattening_error(primitive, point).length());
                let largest = margin(point, plane.offset.abs()) + flattening;
                (plane.ahead_of(point).abs() <= largest).then_some(flat)
            }
        }
    }
}

/// Returns the index and the position of a point light.
fn point_of((index, light): (usize, &Light)) -> Option<(usize, DVec3)> {
    match *light {
        Light::Point { position, .. } => Some((index, position)),
        Light::Directional { .. } => None,
    }
}

/// Returns true for each material that transmits no light anywhere.
fn opaque(materials: &[Material]) -> Vec<bool> {
    materials.iter().fold(vec![], |mut known, material| {
        known.push(match material {
            Material::Phong(phong) | Material::Painted(phong, _) => phong.transparent == Color::ZERO,
            // It mixes earlier materials.
            Material::Texture(texture) => {
                texture.children.iter().all(|&child| known.get(child) == Some(&true))
            }
        });
        known
    })
}

/// Finds the lights near a primitive.
struct Search<'w> {
    world: &'w World,
    tree: BoxTree<3>,
    /// The lights below each node that are not left out.
    left: Vec<usize>,
    /// The largest distance at which a light below each node lies on a triangle.
    reach_of_triangles: Vec<f64>,
    is_left_out: Vec<bool>,
}

impl<'w> Search<'w> {
    fn new(world: &'w World, points: impl Iterator<Item = DVec3>) -> Self {
        let boxes: Vec<_> =
            points.map(|point| Extents { min: point.to_array(), max: point.to_array() }).collect();
        let tree = BoxTree::new(&boxes);
        let mut left = vec![0; tree.nodes().len()];
        for index in 0..boxes.len() as u32 {
            tree.nodes_of(index).for_each(|node| left[node] += 1);
        }
        let flattening = world.largest_flattening_error();
        let reach = |node: &Node<3>| margin(farthest(node), world.max_abs_coord) + flattening;
        let reach_of_triangles = tree.nodes().iter().map(reach).collect();
        Self { world, tree, left, reach_of_triangles, is_left_out: vec![false; boxes.len()] }
    }

    /// Returns the ids of the primitives that may be near a light.
    fn ids(&self) -> impl Iterator<Item = u32> + use<> {
        let world = self.world;
        let is_empty = self.tree.nodes().is_empty();
        let bounds = Extents { min: world.bounds.min.to_array(), max: world.bounds.max.to_array() };
        let is_outside =
            is_empty || !self.tree.nodes()[0].bounds.widened(self.reach_of_triangles[0]).meets(&bounds);
        let first = if is_outside { world.triangles.len() as u32 } else { 0 };
        let end = if is_empty { 0 } else { world.ids().end };
        first..end
    }

    /// Sets `near` to the indices of the lights that may lie on a primitive. Returns the number of steps.
    fn find_near(&self, id: u32, near: &mut Vec<u32>) -> usize {
        near.clear();
        let take = |index: u32| near.extend((!self.is_left_out[index as usize]).then_some(index));
        let world = self.world;
        match world.primitive(id) {
            Primitive::Triangle(i) => {
                let triangle = NearTriangle::new(world.corners(i));
                let is_near = |node: usize, bounds: &Extents<3>| {
                    triangle.may_touch(bounds, self.reach_of_triangles[node])
                };
                self.tree.visit(|id, node| self.left[id] > 0 && is_near(id, &node.bounds), take)
            }
            Primitive::Shape(i) => {
                let (shape, moved) =
                    (&world.shapes[i], world.flattening_error(id, DVec3::ZERO).max_element());
                let (bounds, maps) = (shape.form().bounds(), shape.form().unit_sphere_maps());
                let is_near = |node: &Node<3>| {
                    let reach = margin(farthest(node), shape.form().extent()) + moved;
                    may_touch_shape(&node.bounds, &bounds, maps, 2.0 * reach)
                };
                self.tree.visit(|id, node| self.left[id] > 0 && is_near(node), take)
            }
            Primitive::Plane(i) => {
                let (plane, error) = (&world.planes[i], world.plane_error(i));
                let is_near = |node: &Node<3>| {
                    let farthest = farthest(node);
                    let reach = margin(farthest, plane.offset.abs()) + error.at(farthest);
                    may_touch_plane(&node.bounds, plane, 2.0 * reach)
                };
                self.tree.visit(|id, node| self.left[id] > 0 && is_near(node), take)
            }
        }
    }

    /// Does not find a light any more.
    fn leave_out(&mut self, index: u32) {
        self.is_left_out[index as usize] = true;
        self.tree.nodes_of(index).for_each(|node| self.left[node] -= 1);
    }
}

/// Returns the outward normal of a shape at a point that lies on it, if the shape may have moved by `moved`.
fn normal_at(point: DVec3, shape: &Shape, moved: f64) -> Option<DVec3> {
    /// The number of steps. A step ends beside a flat shape if the point is beyond its rim, however close to its plane.
    const STEPS: usize = 3;
    let margin = margin(point, shape.form().extent()) + moved;
    let UnitSphereMaps { center, inverse, .. } = shape.form().unit_sphere_maps();
    let (mut place, mut outward) = (point, DVec3::ZERO);
    for _ in 0..STEPS {
        // The length is 1 on the surface, and the gradient gives the distance to it.
        let on_unit_sphere = inverse * (place - center);
        let length = on_unit_sphere.length();
        let gradient = inverse.transpose() * (on_unit_sphere / length);
        outward = unit(gradient);
        let height = (length - 1.0) / gradient.dot(outward);
        // Also false for a NaN.
        let is_close = height.abs() <= margin;
        if !is_close {
            return None;
        }
        place -= height * outward;
    }
    Some(outward)
}

/// Returns the largest absolute coordinates of the points below a node.
fn farthest(node: &Node<3>) -> DVec3 {
    DVec3::from(node.bounds.min).abs().max(DVec3::from(node.bounds.max).abs())
}

/// The rounding of the sums that compare a surface with a box, with much to spare.
const SPARE: f64 = 1e-12;

/// A triangle that is compared with boxes.
struct NearTriangle {
    corner: DVec3,
    bounds: Extents<3>,
    /// A normal, and the product of the lengths of the sides from which it is computed.
    normal: DVec3,
    sides: f64,
}

impl NearTriangle {
    fn new([a, b, c]: [DVec3; 3]) -> Self {
        let bounds = Extents { min: a.min(b).min(c).to_array(), max: a.max(b).max(c).to_array() };
        let (p, q) = (b - a, c - a);
        Self { corner: a, bounds, normal: p.cross(q), sides: p.length() * q.length() }
    }

    /// Returns true if a box may have points closer to the triangle than `reach`.
    #[inline(always)]
    fn may_touch(&self, bounds: &Extents<3>, reach: f64) -> bool {
        if !self.bounds.widened(reach).meets(bounds) {
            return false;
        }
        let [center, half] = center_and_half(bounds);
        let from_corner = center - self.corner;
        let spare = SPARE * self.sides * (from_corner.length() + half.length());
        is_within(self.normal.dot(from_corner).abs(), self.normal.abs().dot(half + reach) + spare)
    }
}

/// Returns true if a box may have points closer to the surface of a shape than `reach`. `bounds` and `maps` are those
/// of the shape.
fn may_touch_shape(
    bounds: &Extents<3>,
    of_shape: &Aabb,
    UnitSphereMaps { center, inverse, .. }: UnitSphereMaps,
    reach: f64,
) -> bool {
    let of_shape = Extents { min: of_shape.min.to_array(), max: of_shape.max.to_array() };
    if !of_shape.widened(reach).meets(bounds) {
        return false;
    }
    let [middle, half] = center_and_half(bounds);
    // In the space of the unit sphere.
    let length = (inverse * (middle - center)).length();
    let size = inverse.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
    let half = (inverse.abs() * half).length() + size * reach;
    let spare = SPARE * (1.0 + length + size * middle.abs().max(center.abs()).length());
    is_within((length - 1.0).abs(), half + spare)
}

/// Returns true if a box may have points closer to a plane than `reach`.
fn may_touch_plane(bounds: &Extents<3>, plane: &Plane, reach: f64) -> bool {
    let [center, half] = center_and_half(bounds);
    let spare = SPARE * (plane.offset.abs() + plane.normal.abs().dot(center.abs()));
    is_within(plane.ahead_of(center).abs(), plane.normal.abs().dot(half) + reach + spare)
}

/// Returns true if a distance is at most the largest one, or if either is a NaN.
fn is_within(distance: f64, largest: f64) -> bool {
    distance.partial_cmp(&largest) != Some(Ordering::Greater)
}

fn center_and_half(bounds: &Extents<3>) -> [DVec3; 2] {
    let [min, max] = [bounds.min, bounds.max].map(DVec3::from);
    [0.5 * min + 0.5 * max, 0.5 * max - 0.5 * min]
}

fn margin(point: DVec3, extent: f64) -> f64 {
    RESTING_ROUNDINGS * UNIT_ROUNDOFF * point.abs().max_element().max(extent)
}

/// Returns true if a point lies on a triangle. No point lies on a triangle without area, which no ray hits.
///
/// Each corner's error is weighted by the corner's weight at the nearest point of the triangle, since a distant corner
/// has little influence at the light.
fn lies_on(point: DVec3, triangle: usize, world: &World) -> bool {
    let corners = world.corners(triangle);
    let errors = corners.map(|corner| {
        let flattening = world.flattening_error(triangle as u32, corner).max_element();
        margin(point, corner.abs().max_element()) + flattening
    });
    // Divided by the largest size, so that no product overflows, and no product that matters underflows.
    let relative = corners.map(|corner| corner - point);
    let unit = relative.iter().map(|v| v.abs().max_element()).fold(errors[0], f64::max);
    let relative = relative.map(|v| v / unit);
    let is_at_edge = [[0, 1], [1, 2], [2, 0]].into_iter().any(|[i, j]| {
        let (distance, part) = distance_to_edge([relative[i], relative[j]]);
        distance * unit <= (1.0 - part) * errors[i] + part * errors[j]
    });
    let is_inside = || {
        let [u, v, w] = weights(point, corners);
        is_above(relative) && height(relative) * unit <= u * errors[0] + v * errors[1] + w * errors[2]
    };
    (is_at_edge || is_inside()) && area_vector(corners).iter().any(|component| component.sign() != 0)
}

/// Returns the distance of the origin from an edge, and the part of the edge before the nearest point.
fn distance_to_edge([p, q]: [DVec3; 2]) -> (f64, f64) {
    let along = q - p;
    let square = along.length_squared();
    let nearest = if square > 0.0 { (-p.dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
    // From the nearer end, which has the smaller rounding error.
    let from_nearer = if nearest <= 0.5 { p + nearest * along } else { q - (1.0 - nearest) * along };
    (from_nearer.length(), nearest)
}

/// Returns true if the foot of the origin on a triangle's plane lies within the triangle.
fn is_above([a, b, c]: [DVec3; 3]) -> bool {
    let normal = (b - a).cross(c - a);
    [[a, b], [b, c], [c, a]].into_iter().all(|[p, q]| p.cross(q).dot(normal) >= 0.0)
}

/// Returns the distance of the origin from a triangle's plane, measured from the nearest corner, which has the smallest
/// rounding error.
fn height([a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let nearest = [a, b, c].into_iter().min_by(|p, q| p.length_squared().total_cmp(&q.length_squared()));
    nearest.map_or(f64::INFINITY, |corner| corner.dot(normal).abs() / normal.length())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::patience::Endless;
    use crate::math::worst_case::Rng;
    use crate::scene::parser::parse;
    use std::fmt::Write;

    /// Objects of all kinds with three materials, and lights of which most lie on one of them or close to it.
    fn scene(rng: &mut Rng) -> String {
        let (mut objects, mut lights) = (String::new(), String::new());
        let mut points = vec![];
        let text = |v: DVec3| format!("{} {} {}", v.x, v.y, v.z);
        for _ in 0..40 {
            let (material, center) = (rng.below(4), 3.0 * rng.vector());
            write!(objects, "MaterialIndex {material} ").unwrap();
            let on = rng.vector().normalize();
            let (object, place) = match rng.below(4) {
                0 => (format!("Sphere {{ center {} radius 0.7 }}", text(center)), center + 0.7 * on),
                1 => {
                    let sphere = "Sphere { center 0 0 0 radius 1 }";
                    let transform = format!("Translate {} Scale 0.5 2 1", text(center));
                    let place = center + DVec3::new(0.5, 2.0, 1.0) * on;
                    (format!("Transform {{ {transform} {sphere} }}"), place)
                }
                2 => (format!("Plane {{ normal {} offset {} }}", text(on), on.dot(center)), center),
                _ => {
                    let corners = [center, center + rng.vector(), center + rng.vector()];
                    let [a, b, c] = corners.map(text);
                    let place = (corners[0] + corners[1] + corners[2]) / 3.0;
                    (format!("Triangle {{ vertex0 {a} vertex1 {b} vertex2 {c} }}"), place)
                }
            };
            objects += &format!("{object} ");
            points.push(place);
        }
        for _ in 0..60 {
            let away = [0.0, 0.0, 1e-15, 1e-14, 1e-9, 1.0][rng.below(6)];
            let place = points[rng.below(points.len() as u64)] + away * rng.vector();
            write!(lights, "PointLight {{ position {} color 1 1 1 }} ", text(place)).unwrap();
        }
        format!(
            "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
             Lights {{ numLights 61 DirectionalLight {{ direction 1 0 0 color 1 1 1 }} {lights} }}
             Materials {{ numMaterials 4 Material {{ }} Material {{ transparentColor 1 1 1 }}
             Checkerboard {{ materialIndex 0 materialIndex 1 }} Checkerboard {{ materialIndex 0 materialIndex 0 }} }}
             Group {{ numObjects 40 {objects} }}"
        )
    }

    #[test]
    fn the_tree_of_lights_leaves_out_no_surface() {
        let (mut found, mut ended) = (0, 0);
        for seed in 1..150 {
            let world = World::new(&parse(&scene(&mut Rng(seed))).unwrap(), &[]).unwrap();
            let places = world.find_resting_places(&mut Steps::new(&Endless)).unwrap();
            assert_eq!(places.len(), 61);
            for (light, places) in world.lights.iter().zip(&places) {
                let mut expected = vec![];
                if let Light::Point { position, .. } = *light {
                    for place in world.ids().filter_map(|id| world.place_at(position, id)) {
                        expected.push(place);
                        if [0, 3].contains(&world.material_of(place.primitive)) {
                            ended += 1;
                            break;
                        }
                    }
                }
                assert_eq!(*places, expected, "{light:?}");
                found += places.len();
            }
        }
        assert!(found > 2000 && ended > 1000, "{found} {ended}");
    }

    /// 1100 equal triangles, and as many lights in one place, at a distance of `away` above their middle.
    fn many_on_one(material: &str, away: f64) -> Result<World, Diagnostic> {
        let light = format!("PointLight {{ position 0 0 {} color 1 1 1 }}\n", 2.0 + away).repeat(1100);
        let triangle = "Triangle { vertex0 -3 -3 1 vertex1 3 -3 2 vertex2 0 6 3 }\n".repeat(1100);
        let text = format!(
            "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
             Lights {{ numLights 1100 {light} }}
             Group {{ numObjects 1100 Material {{ {material} }} {triangle} }}"
        );
        World::new(&parse(&text).unwrap(), &[])
    }

    #[test]
    fn more_than_a_million_lights_near_surfaces_are_an_error() {
        let glass = "transparentColor 1 1 1";
        let message = |found: Result<World, Diagnostic>| found.unwrap_err().message;
        for (material, away) in [(glass, 0.0), (glass, 1e-13), ("", 1e-13)] {
            assert!(message(many_on_one(material, away)).starts_with("too many lights lie on surfaces"));
        }
        // An opaque surface alone blocks a light that lies on it.
        let world = many_on_one("", 0.0).unwrap();
        assert!((0..1100).all(|light| world.primitives_at_light(light).len() == 1));
        assert!(many_on_one("", 1e-9).unwrap().primitives_at_light(0).is_empty());
    }
}
