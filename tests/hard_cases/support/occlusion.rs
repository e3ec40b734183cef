//! Occlusion decided in double-double: a bounding volume hierarchy of triangles, which is traversed
//! completely. In its leaves most triangles are rejected in f64, with an error bound that is far larger than
//! needed.

use super::double_double::{self as dd, Dd, Dd3};
use glam::DVec3;

pub struct Occluders {
    corners: Vec<[DVec3; 3]>,
    /// Ids of triangles, in such an order that those of each node are contiguous.
    order: Vec<u32>,
    nodes: Vec<Node>,
    /// The padding of every box, which is far above the rounding errors of coordinates and far below a
    /// triangle's size.
    padding: f64,
}

struct Node {
    min: DVec3,
    max: DVec3,
    /// The range in `order`, and the children of an inner node.
    first: usize,
    last: usize,
    children: Option<[usize; 2]>,
}

impl Occluders {
    pub fn new(corners: Vec<[DVec3; 3]>) -> Self {
        let all = corners.as_flattened();
        let (min, max) = bounds(all);
        let padding = 1e-9 * (max - min).max_element() + 1e-12 * min.abs().max(max.abs()).max_element();
        let order = (0..corners.len() as u32).collect();
        let mut tree = Self { corners, order, nodes: vec![], padding };
        tree.split(0, tree.order.len());
        tree
    }

    /// Builds the node of `order[first..last]` with all its descendants, and returns its index.
    fn split(&mut self, first: usize, last: usize) -> usize {
        let range = &self.order[first..last];
        let points: Vec<DVec3> = range.iter().flat_map(|&i| self.corners[i as usize]).collect();
        let (min, max) = bounds(&points);
        let number = self.nodes.len();
        let (low, high) = (min - self.padding, max + self.padding);
        self.nodes.push(Node { min: low, max: high, first, last, children: None });
        if last - first > 4 {
            let axis = (max - min).max_position();
            let corners = &self.corners;
            let key = |i: &u32| corners[*i as usize].iter().map(|v| v[axis]).sum::<f64>();
            self.order[first..last].sort_by(|a, b| key(a).total_cmp(&key(b)));
            let middle = (first + last) / 2;
            let children = [self.split(first, middle), self.split(middle, last)];
            self.nodes[number].children = Some(children);
        }
        number
    }

    /// The point at which a ray's line crosses the plane of triangle `i`, in double-double.
    pub fn point_on(&self, i: u32, origin: DVec3, direction: DVec3) -> Dd3 {
        let [a, b, c] = self.corners[i as usize].map(dd::vector);
        let normal = dd::cross(&dd::sub(&b, &a), &dd::sub(&c, &a));
        let (o, d) = (dd::vector(origin), dd::vector(direction));
        let t = dd::dot(&dd::sub(&a, &o), &normal) / dd::dot(&d, &normal);
        dd::add(&o, &dd::scaled(&d, t))
    }

    /// Whether any triangle other than `own` blocks the ray. None if that is too close to decide.
    pub fn block(&self, origin: &Dd3, direction: DVec3, own: Option<u32>) -> Option<bool> {
        let near = DVec3::from_array(origin.map(Dd::value));
        let (mut stack, mut doubt) = (vec![0], false);
        while let Some(number) = stack.pop() {
            let node = &self.nodes[number];
            if !reaches(near, direction, node) {
                continue;
            }
            if let Some(children) = node.children {
                stack.extend(children);
                continue;
            }
            for &i in self.order[node.first..node.last].iter().filter(|&&i| Some(i) != own) {
                match self.crosses(i, origin, near, direction) {
                    Some(true) => return Some(true),
                    Some(false) => {}
                    None => doubt = true,
                }
            }
        }
        (!doubt).then_some(false)
    }

    /// Whether the ray crosses triangle `i` in front of its origin. None if that is too close to decide.
    fn crosses(&self, i: u32, origin: &Dd3, near: DVec3, direction: DVec3) -> Option<bool> {
        let [a, b, c] = self.corners[i as usize];
        let normal = (b - a).cross(c - a);
        let [u, v, w] = [(b, c), (c, a), (a, b)].map(|(p, q)| direction.dot((p - near).cross(q - near)));
        // A millionth of the triangle is far above the error in f64.
        let slack = 1e-6 * (u.abs() + v.abs() + w.abs() + direction.length() * normal.length());
        if u.min(v).min(w) < -slack && u.max(v).max(w) > slack {
            return Some(false);
        }
        let corners = [a, b, c].map(|v| dd::sub(&dd::vector(v), origin));
        let d = dd::vector(direction);
        let [u, v, w] =
            [(1, 2), (2, 0), (0, 1)].map(|(p, q)| dd::dot(&d, &dd::cross(&corners[p], &corners[q])));
        let size = corners.iter().map(|v| dd::dot(v, v).value()).fold(0.0, f64::max) * direction.length();
        let sign = |x: Dd, size: f64| if x.value().abs() > 1e-28 * size { Some(x.sign()) } else { None };
        let sides = [sign(u, size), sign(v, size), sign(w, size)];
        if sides.contains(&Some(1)) && sides.contains(&Some(-1)) {
            return Some(false);
        }
        let side = sides[0].filter(|_| sides[0] == sides[1] && sides[1] == sides[2])?;
        let [ab, ac] = [1, 2].map(|k| dd::sub(&corners[k], &corners[0]));
        let volume = dd::dot(&corners[0], &dd::cross(&ab, &ac));
        Some(sign(volume, size.powf(1.5))? * side > 0)
    }
}

fn bounds(points: &[DVec3]) -> (DVec3, DVec3) {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    points.iter().fold(start, |(min, max), &p| (min.min(p), max.max(p)))
}

/// Whether the ray hits a node's box. The box is padded, so that rounding errors do not matter.
fn reaches(origin: DVec3, direction: DVec3, node: &Node) -> bool {
    let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
    for axis in 0..3 {
        if direction[axis] == 0.0 {
            if origin[axis] < node.min[axis] || origin[axis] > node.max[axis] {
                return false;
            }
            continue;
        }
        let t0 = (node.min[axis] - origin[axis]) / direction[axis];
        let t1 = (node.max[axis] - origin[axis]) / direction[axis];
        enter = enter.max(t0.min(t1));
        leave = leave.min(t0.max(t1));
    }
    enter <= leave
}
