//! Brute force: every triangle is tested against a ray, without a grid. This is the reference of the grid's
//! cases.
//!
//! Triangles are grouped in a hierarchy of bounding balls. A ball is skipped if the ray's line misses it by
//! more than a tenth of its radius, which is far more than rounding errors.

use super::exact::{cross, dot, exact, exact3, sub};
use glam::DVec3;
use num_rational::BigRational;
use num_traits::Zero;
use raytracer::math::ray::{Hit, Ray};
use raytracer::world::World;
use raytracer::world::triangle::Shear;

pub struct Brute<'w> {
    world: &'w World,
    /// Each ball comes before those inside it.
    balls: Vec<Ball>,
}

struct Ball {
    center: DVec3,
    radius: f64,
    /// The index of the next ball that is not inside this one.
    next: usize,
    /// The triangles of a leaf; empty for a ball with smaller balls inside.
    triangles: Vec<u32>,
}

impl<'w> Brute<'w> {
    pub fn new(world: &'w World) -> Self {
        let mut balls = Vec::new();
        split(world, (0..world.triangles.len() as u32).collect(), &mut balls);
        Self { world, balls }
    }

    /// The nearest hit by exact arithmetic. Of equally near ones, as at a vertex, it is the one with the lower index.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut hits = Vec::new();
        self.each_hit(ray, |hit| hits.push(hit));
        let first = hits.iter().map(|hit| hit.t).fold(f64::INFINITY, f64::min);
        // Roundings do not change the order of others.
        hits.retain(|hit| hit.t <= first + 1e-9 * first.abs());
        match hits[..] {
            [] => None,
            [hit] => Some(hit),
            _ => hits.into_iter().min_by_key(|hit| (self.exact_t(ray, hit), hit.primitive)),
        }
    }

    /// The t at which the ray meets the plane of the triangle that it hits.
    fn exact_t(&self, ray: &Ray, hit: &Hit) -> BigRational {
        let [a, b, c] = self.world.corners(hit.primitive as usize).map(exact3);
        let normal = cross(&sub(&b, &a), &sub(&c, &a));
        let slope = dot(&normal, &exact3(ray.direction));
        // A triangle that is seen from its edge has any t.
        if slope.is_zero() { exact(hit.t) } else { dot(&normal, &sub(&a, &exact3(ray.origin))) / slope }
    }

    /// The triangles near the ray's line, in no particular order.
    pub fn near(&self, ray: &Ray) -> impl Iterator<Item = u32> {
        let (origin, line) = (ray.origin, ray.direction.normalize());
        let mut i = 0;
        std::iter::from_fn(move || {
            while let Some(ball) = self.balls.get(i) {
                let from_line = line.cross(ball.center - origin).length();
                let is_near = from_line <= 1.1 * ball.radius + 1e-9 * (ball.center - origin).length();
                i = if is_near { i + 1 } else { ball.next };
                if is_near && !ball.triangles.is_empty() {
                    return Some(ball.triangles.iter().copied());
                }
            }
            None
        })
        .flatten()
    }

    fn each_hit(&self, ray: &Ray, mut visit: impl FnMut(Hit)) {
        let shear = Shear::new(ray);
        for primitive in self.near(ray) {
            let crossing = shear.intersect(self.world.corners_in_place(primitive as usize));
            if let Some(t) = crossing.filter(|&t| ray.covers(t)) {
                visit(Hit { t, primitive });
            }
        }
    }
}

fn split(world: &World, mut triangles: Vec<u32>, balls: &mut Vec<Ball>) {
    const LARGEST: usize = 8;
    let corners = |i: u32| world.corners(i as usize);
    let points = || triangles.iter().flat_map(|&i| corners(i));
    let low = points().fold(DVec3::INFINITY, |a, b| a.min(b));
    let high = points().fold(DVec3::NEG_INFINITY, |a, b| a.max(b));
    let extent = high - low;
    let (this, radius) = (balls.len(), 0.5 * extent.length());
    balls.push(Ball { center: low + 0.5 * extent, radius, next: 0, triangles: vec![] });
    if triangles.len() <= LARGEST {
        balls[this].triangles = triangles;
    } else {
        let axis = (0..3).fold(0, |best, i| if extent[i] > extent[best] { i } else { best });
        let place = |i: u32| corners(i).iter().map(|v| v[axis]).sum::<f64>();
        triangles.sort_by(|&i, &j| place(i).total_cmp(&place(j)));
        let rest = triangles.split_off(triangles.len() / 2);
        split(world, triangles, balls);
        split(world, rest, balls);
    }
    balls[this].next = balls.len();
}
