//! Point lights less than a millionth of the scene's size off a surface, above floors up to 1e8 times as large: whether
//! the surface shadows a point of the floor is decided as in exact arithmetic.

use crate::support::exact::{dot, exact, exact3, sub};
use crate::support::measure::{Failures, measure};
use crate::support::rays;
use crate::support::rng::Rng;
use crate::support::scenes::scene_of;
use glam::{DAffine3, DVec3};
use num_rational::BigRational;
use num_traits::Signed;
use raytracer::caster::Caster;
use raytracer::math::ray::Ray;
use raytracer::scene::{Light, Object, Position};
use raytracer::stats::Counts;
use raytracer::trace::Quiet;
use raytracer::trace::{Effects, RayStack, Shadows, Tracer};
use raytracer::world::World;

/// The points of the floor that are looked at for one light.
const POINTS: usize = 16;

/// The height of the floor.
const FLOOR: f64 = -2.5;

/// The largest error of the end of a shadow ray, in roundings of its length.
const ROUNDINGS: f64 = 64.0;

/// A surface of about unit size around the origin.
#[derive(Clone, Copy, Debug)]
enum Surface {
    /// The unit sphere, stretched along the axes. The factors are powers of two.
    Ellipsoid(DVec3),
    /// At y = 0.
    Plane,
    /// At y = 0, with these corners along x and z.
    Triangle([DVec3; 3]),
}

impl Surface {
    fn any(rng: &mut Rng) -> Self {
        match rng.below(4) {
            0 => Self::Ellipsoid(DVec3::ONE),
            1 => Self::Ellipsoid(DVec3::new(1.0, [0.5, 2.0][rng.below(2)], [0.25, 1.0][rng.below(2)])),
            2 => Self::Plane,
            _ => {
                let mut corner =
                    |x: f64, z: f64| DVec3::new(x + rng.range(-0.3, 0.3), 0.0, z + rng.range(-0.3, 0.3));
                Self::Triangle([corner(-1.0, -1.0), corner(0.2, 1.0), corner(1.0, -1.0)])
            }
        }
    }

    /// The objects of the surface. The last one contains the others.
    fn objects(self) -> Vec<Object> {
        let (material, at) = (0, Position { line: 1, column: 1 });
        let sphere = Object::Sphere { center: DVec3::ZERO, radius: 1.0, material };
        match self {
            Self::Ellipsoid(DVec3::ONE) => vec![sphere],
            Self::Ellipsoid(stretch) => {
                let matrix = DAffine3::from_scale(stretch).into();
                vec![sphere, Object::Transform { matrix, factors: Box::default(), child: 0, at }]
            }
            Self::Plane => vec![Object::Plane { normal: DVec3::Y, offset: 0.0, material }],
            Self::Triangle(vertices) => vec![Object::Triangle { vertices, material }],
        }
    }

    /// A point of the surface, and the normal there, which may point to either side of a flat surface.
    fn point(self, rng: &mut Rng) -> (DVec3, DVec3) {
        let side = [DVec3::Y, -DVec3::Y][rng.below(2)];
        match self {
            Self::Ellipsoid(stretch) => {
                let on = rng.direction();
                (stretch * on, (on / stretch).normalize())
            }
            Self::Plane => (DVec3::new(rng.range(-0.5, 0.5), 0.0, rng.range(-0.5, 0.5)), side),
            Self::Triangle([a, b, c]) => {
                let (u, v) = (rng.range(0.1, 0.4), rng.range(0.1, 0.4));
                (a + u * (b - a) + v * (c - a), side)
            }
        }
    }

    /// Returns true if the surface, grown by a distance, crosses the way between two points. The way starts outside.
    fn blocks(self, from: DVec3, to: DVec3, grown: f64) -> bool {
        let (p, l, grown) = (exact3(from), exact3(to), exact(grown));
        match self {
            Self::Ellipsoid(stretch) => {
                let unstretched = |v: &[BigRational; 3]| [0, 1, 2].map(|k| &v[k] / exact(stretch[k]));
                let (p, l) = (unstretched(&p), unstretched(&l));
                let radius = exact(1.0) + grown / exact(stretch.min_element());
                let way = sub(&l, &p);
                let (a, b, c) = (dot(&way, &way), -dot(&p, &way), dot(&p, &p) - &radius * &radius);
                let ends_inside = dot(&l, &l) < &radius * &radius;
                ends_inside || (b.is_positive() && b < a && &b * &b > a * c)
            }
            Self::Plane => l[1] > -grown,
            Self::Triangle(corners) => {
                if l[1] <= -grown.clone() {
                    return false;
                }
                // The crossing of y = 0, where the edge functions have one sign.
                let t = &p[1] / (&p[1] - &l[1]);
                let [x, z] = [0, 2].map(|k| &p[k] + &t * (&l[k] - &p[k]));
                let side = |k: usize| {
                    let [a, b] = [corners[k], corners[(k + 1) % 3]].map(exact3);
                    let (along, across) = (&b[0] - &a[0], &b[2] - &a[2]);
                    (&x - &a[0]) * across - (&z - &a[2]) * along
                };
                (0..3).all(|k| side(k) > -&grown) || (0..3).all(|k| side(k) < grown)
            }
        }
    }
}

/// Counts for one light: points whose shadow is certain in spite of the rounding of the way, and points whose shadow is
/// wrong.
fn one(index: u64, failures: &Failures) -> ([u64; 3], [f64; 0]) {
    let mut rng = Rng::at(73, index);
    let surface = Surface::any(&mut rng);
    let size = 10f64.powf(rng.range(0.0, 8.0));
    let (on, outward) = surface.point(&mut rng);
    let position = on + 10f64.powf(rng.range(-16.0, -6.0)) * outward;
    let light = Light::Point { position, color: DVec3::ONE, attenuation: [1.0, 0.0, 0.0] };
    let mut objects = surface.objects();
    let corner = |x: f64, z: f64| DVec3::new(4.0 * size * x, FLOOR, 4.0 * size * z);
    let vertices = [corner(-1.0, -1.0), corner(-0.5, 3.0), corner(3.0, -1.0)];
    let floor = Object::Triangle { vertices, material: 0 };
    let whole = objects.len() - 1;
    objects.push(floor);
    let mut scene = scene_of(objects, vec![light]);
    if let Object::Group(children) = &mut scene.objects[scene.root] {
        children.retain(|&child| child >= whole);
    }
    let world = World::new(&scene, &[]).expect("a sound scene");
    let caster = Caster::new(&world, None).expect("no grid");
    let effects = Effects { shadows: Shadows::Opaque, shade_back: true, bounces: 0, min_weight: 0.0 };
    let tracer = Tracer::new(&caster, effects);
    let is_at_rest = !world.primitives_at_light(0).is_empty();
    let [mut certain, mut wrong, mut lit] = [0; 3];
    for _ in 0..POINTS {
        let farthest = [0.2, 0.2 + size.log10()][rng.below(2)];
        let reach = 10f64.powf(rng.range(-1.0, farthest));
        let target = DVec3::new(rng.range(-reach, reach), FLOOR, rng.range(-reach, reach));
        let ray = Ray::new(target + 0.1 * DVec3::Y, -DVec3::Y);
        let seen = caster.closest(&ray).expect("the floor");
        let from = world.surface(&ray, &seen).position;
        let color = tracer.color(&ray, &mut RayStack::default(), &mut Quiet);
        assert_eq!(tracer.color(&ray, &mut RayStack::default(), &mut Counts::default()), color);
        let is_dark = color == DVec3::ZERO;
        let error = ROUNDINGS * f64::EPSILON / 2.0 * (position - from).length();
        let [surely, possibly] = [-error, error].map(|grown| surface.blocks(from, position, grown));
        if is_at_rest || surely == possibly {
            certain += 1;
            lit += u64::from(!is_dark);
            wrong += failures.note(is_dark != (is_at_rest || surely), || {
                format!("{index}: {surface:?}, light {position}, floor {size}, from {from}: dark {is_dark}")
            });
        }
    }
    ([certain, wrong, lit], [])
}

#[test]
fn lights_close_to_surfaces_shine_where_nothing_is_between() {
    let inputs = rays(6000, 600_000);
    let failures = Failures::default();
    let ([certain, wrong, lit], []) = measure(inputs, |index| one(index, &failures));
    assert!(certain > 6 * inputs && lit > 2 * inputs, "{certain} of {inputs}, {lit} lit");
    assert_eq!(wrong, 0, "of {certain}");
}
