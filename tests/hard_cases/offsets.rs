//! The offset of secondary rays, in addition to the cases: it is so large that no ray hits the surface it
//! leaves, and so small that it skips nothing close by. The rays of every kind of primitive are made as in
//! the renderer: from the surface point that the world returns, with the offset, and with a query that
//! excludes the triangle it leaves. The reference is geometric: a ray never hits again the plane, square or
//! convex body that it leaves on the outside, and a cover blocks every ray that leaves the surface on its
//! side.

use crate::support::measure::{Failures, measure};
use crate::support::rays;
use crate::support::rng::Rng;
use crate::support::scenes::scene_of;
use crate::support::secondary::{blocked, secondary};
use crate::support::textbook_offsets::FIXED;
use glam::{DAffine3, DMat3, DVec3};
use raytracer::caster::{Caster, RayOrigin};
use raytracer::math::ray::Ray;
use raytracer::math::robust::UNIT_ROUNDOFF;
use raytracer::scene::{Object, Position};
use raytracer::world::{SurfacePoint, World};

const SEED: u64 = 3700;

#[derive(Clone, Copy, Debug)]
enum Kind {
    Sphere,
    Ellipsoid,
    Plane,
    /// Two triangles in one plane. The query excludes the one that the ray leaves, but the ray could hit the
    /// other.
    Square,
}

const KINDS: [Kind; 4] = [Kind::Sphere, Kind::Ellipsoid, Kind::Plane, Kind::Square];

/// A primitive at some position, and a point of it that a ray is aimed at.
struct Stage {
    kind: Kind,
    center: DVec3,
    /// The radius of the sphere, or the size of the square.
    size: f64,
    /// The edges of the square or the semi-axes of the ellipsoid, of length at most one.
    axes: DMat3,
    /// The unit normal of a flat primitive.
    normal: DVec3,
    /// The approximate point of the surface.
    target: DVec3,
    /// The outward normal at it.
    outward: DVec3,
    /// The largest coordinate, which scales the offset.
    magnitude: f64,
}

/// A vector of so few bits that sums of three are exact, so that the four corners of a square lie in one
/// plane.
fn short(v: DVec3) -> DVec3 {
    const BITS: f64 = (1u64 << 20) as f64;
    (v * BITS).round() / BITS
}

impl Stage {
    fn new(kind: Kind, rng: &mut Rng) -> Self {
        let scale = f64::powi(2.0, rng.below(40) as i32 - 20);
        let size = scale * f64::powi(2.0, -(rng.below(12) as i32));
        let center = scale * short(rng.in_cube());
        let turn = DMat3::from_axis_angle(rng.direction(), rng.range(0.0, 3.0));
        let stretch = DVec3::new(1.0, rng.range(0.3, 1.0), rng.range(0.3, 1.0));
        let (edge, other) = (short(rng.direction()), short(rng.direction()));
        let axes = match kind {
            Kind::Square => DMat3::from_cols(edge, other, DVec3::ZERO),
            _ => turn * DMat3::from_diagonal(stretch),
        };
        let normal = edge.cross(other).normalize();
        let on_unit_sphere = rng.direction();
        let (target, outward) = match kind {
            Kind::Sphere => (center + size * on_unit_sphere, on_unit_sphere),
            Kind::Ellipsoid => {
                let normal = axes.inverse().transpose() * on_unit_sphere;
                (center + size * (axes * on_unit_sphere), normal.normalize())
            }
            Kind::Plane => (center, normal),
            // Sometimes the point is near the edge that the two triangles share.
            Kind::Square => {
                let (x, aside) = (rng.range(0.1, 0.9), f64::powf(10.0, rng.range(-6.0, -1.0)));
                (center + size * (x * edge + (x + aside) * other), normal)
            }
        };
        let magnitude = target.abs().max_element() + center.abs().max_element() + size;
        Self { kind, center, size, axes, normal, target, outward, magnitude }
    }

    /// A world of the primitive and, with a gap, of another that covers it on the outer side.
    fn world(&self, gap: Option<f64>) -> World {
        let mut objects: Vec<Object> = self.layer(0.0);
        objects.extend(gap.into_iter().flat_map(|gap| self.layer(gap)));
        // The child of a transform comes just before it in the arena, and is not an object of the group
        // itself.
        let is_child = |i: usize| matches!(objects.get(i + 1), Some(Object::Transform { .. }));
        let children: Vec<usize> = (0..objects.len()).filter(|&i| !is_child(i)).collect();
        let transforms: Vec<(usize, usize)> =
            (1..objects.len()).filter(|&i| is_child(i - 1)).map(|i| (i, i - 1)).collect();
        for (transform, sphere) in transforms {
            if let Object::Transform { child, .. } = &mut objects[transform] {
                *child = sphere;
            }
        }
        let mut scene = scene_of(objects, vec![]);
        let root = scene.root;
        scene.objects[root] = Object::Group(children);
        World::new(&scene, &[]).expect("a sound scene")
    }

    /// The primitive, moved outward by a gap.
    fn layer(&self, gap: f64) -> Vec<Object> {
        let Self { center, size, axes, normal, .. } = *self;
        let material = 0;
        match self.kind {
            Kind::Sphere => vec![Object::Sphere { center, radius: size + gap, material }],
            Kind::Ellipsoid => {
                let shortest = axes.transpose().determinant().abs().min(0.3);
                let matrix = DAffine3::from_mat3_translation((size + gap / shortest) * axes, center);
                let at = Position { line: 1, column: 1 };
                vec![
                    Object::Sphere { center: DVec3::ZERO, radius: 1.0, material },
                    Object::Transform { matrix: matrix.into(), factors: Box::default(), child: 0, at },
                ]
            }
            Kind::Plane => vec![Object::Plane { normal, offset: normal.dot(center) + gap, material }],
            Kind::Square => {
                let corner =
                    |i: f64, j: f64| center + size * (i * axes.x_axis + j * axes.y_axis) + gap * normal;
                let [a, b, c, d] = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
                [[a, b, c], [a, c, d]].map(|vertices| Object::Triangle { vertices, material }).into()
            }
        }
    }

    /// A ray to the target, from outside if there is an outside.
    fn ray(&self, rng: &mut Rng) -> Ray {
        let away = rng.direction();
        let is_flat = matches!(self.kind, Kind::Plane | Kind::Square);
        let side = if is_flat { 1.0 } else { away.dot(self.outward).signum() };
        let distance = self.size * f64::powf(10.0, rng.range(0.0, 4.0));
        let eye = self.target + distance * (side * away + 0.1 * self.outward).normalize();
        Ray::new(eye, (self.target - eye).normalize())
    }
}

/// The surface that a ray of the stage hits, in a world without the cover.
fn surface(stage: &Stage, world: &World, rng: &mut Rng) -> Option<SurfacePoint> {
    let (caster, ray) = (Caster::new(world, None).expect("no grid"), stage.ray(rng));
    Some(world.visible_surface(&ray, caster.nearest(&ray, RayOrigin::FREE)?))
}

/// A direction outward, or to either side of a flat primitive, with this cosine to the normal.
fn direction(stage: &Stage, surface: &SurfacePoint, cosine: f64, rng: &mut Rng) -> DVec3 {
    let is_flat = matches!(stage.kind, Kind::Plane | Kind::Square);
    let side = if is_flat && rng.below(2) == 0 { -surface.normal } else { surface.normal };
    let along = side.cross(rng.direction()).normalize();
    ((1.0 - cosine * cosine).sqrt() * along + cosine * side).normalize()
}

/// Runs `one` for every kind. It returns whether ours is wrong, and whether the textbook is.
fn every_kind(inputs: u64, one: impl Fn(Kind, &mut Rng) -> Option<[bool; 2]> + Sync) {
    let mut wrong_kinds = vec![];
    for (seed, kind) in (SEED..).zip(KINDS) {
        let failures = Failures::default();
        let ([wrong, textbook, decided], []) = measure(inputs, |index| {
            let Some(wrong) = one(kind, &mut Rng::at(seed, index)) else { return ([0; 3], []) };
            failures.note(wrong[0], || format!("{kind:?}: seed {seed}, index {index}"));
            ([wrong[0] as u64, wrong[1] as u64, 1], [])
        });
        println!("{kind:?}: {decided} rays, wrong: {wrong}, textbook {textbook}");
        assert!(textbook > 0 && decided > inputs / 2, "the test tests nothing: {kind:?}");
        wrong_kinds.extend((wrong > 0).then_some(kind));
    }
    assert!(wrong_kinds.is_empty(), "wrong: {wrong_kinds:?}");
}

#[test]
fn no_ray_meets_the_surface_that_it_leaves() {
    every_kind(rays(20_000, 2_000_000), |kind, rng| {
        let stage = Stage::new(kind, rng);
        let world = stage.world(None);
        let surface = surface(&stage, &world, rng)?;
        let cosine = f64::powf(10.0, rng.range(-12.0, 0.0));
        let direction = direction(&stage, &surface, cosine, rng);
        let caster = Caster::new(&world, None).expect("no grid");
        let single = Ray::new(surface.position.as_vec3().as_dvec3(), direction);
        Some([blocked(&caster, &surface, direction), caster.any(&single, RayOrigin::FREE)])
    });
}

#[test]
fn no_ray_skips_what_covers_the_surface() {
    every_kind(rays(20_000, 2_000_000), |kind, rng| {
        let stage = Stage::new(kind, rng);
        // The offset moves a point by 32 roundings of up to twice the magnitude, and the position of the
        // cover is rounded as well.
        let gap = 80.0 * UNIT_ROUNDOFF * stage.magnitude;
        let surface = surface(&stage, &stage.world(None), rng)?;
        let cosine = rng.range(0.1, 1.0);
        let mut direction = direction(&stage, &surface, cosine, rng);
        // The direction is on the side of the cover.
        if direction.dot(stage.outward) < 0.0 {
            direction = -direction;
        }
        let covered = stage.world(Some(gap));
        let caster = Caster::new(&covered, None).expect("no grid");
        let fixed = Ray { t_min: FIXED * stage.size, ..secondary(&surface, direction) };
        Some([!blocked(&caster, &surface, direction), !caster.any(&fixed, RayOrigin::FREE)])
    });
}
