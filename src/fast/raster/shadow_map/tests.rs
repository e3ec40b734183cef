use super::*;
use crate::base::patience::Endless;
use crate::caster::{Caster, RayOrigin};
use crate::fast::raster::flat_triangle::{Projected, edge_functions};
use crate::fast::raster::light_view::SCREEN_ERROR;
use crate::math::ray::Ray;
use crate::scene::mesh::Mesh;
use crate::scene::parser::parse;
use crate::shading::light::incident;

const MANY_RAYS: usize = 1 << 20;

/// Numbers from 0 to 1, spread by golden ratios.
struct Spread(f64);

impl Spread {
    fn number(&mut self) -> f64 {
        self.0 += 1.0;
        (self.0 * 0.618_033_988_749_894_9).fract()
    }

    fn vector(&mut self) -> DVec3 {
        self.0 += 1.0;
        2.0 * (DVec3::new(0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9) * self.0).fract() - 1.0
    }
}

/// Returns a world of triangles of this size in a box around a point, and these objects, under these lights.
fn world(count: usize, size: f64, at: DVec3, objects: &[&str], lights: &[&str]) -> World {
    let text = format!(
        "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
         Lights {{ numLights {} {} }}
         Group {{ numObjects {} Material {{ }} TriangleMesh {{ obj_file a.obj }} {} }}",
        lights.len(),
        lights.join(" "),
        objects.len() + 1,
        objects.join(" ")
    );
    let mut spread = Spread(0.5);
    let mut vertices = vec![];
    for _ in 0..count {
        let a = at + spread.vector() * DVec3::new(2.0, 0.5, 1.0);
        vertices.extend([a, a + size * spread.vector(), a + size * spread.vector()]);
    }
    let triangles = (0..count as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    World::new(&parse(&text).unwrap(), &[Mesh { vertices, triangles }]).unwrap()
}

/// Checks the blockers of rays to all lights from points on these primitives. Returns the numbers of rays that hit
/// nothing, one triangle at most, or anything.
fn check(world: &World, maps: &ShadowMaps, points: &[(DVec3, Option<u32>)]) -> [usize; 3] {
    let caster = Caster::new(world, Some([9; 3])).unwrap();
    let mut counts = [0; 3];
    for (index, light) in world.lights.iter().enumerate() {
        for &(point, origin_primitive) in points {
            let incident = incident(light, point);
            let ray = Ray { t_max: incident.distance, ..Ray::new(point, incident.direction) };
            let origin = RayOrigin::on(world, origin_primitive);
            let is_blocked = caster.any(&ray, origin);
            match maps.blocker(index, point) {
                Blocker::Nothing => {
                    assert!(!is_blocked, "{light:?} {point}");
                    counts[0] += 1;
                }
                Blocker::Only(triangle) => {
                    let meets = caster.hits_triangle(&ray, triangle, origin);
                    assert_eq!(meets, is_blocked, "{light:?} {point} {triangle}");
                    counts[1] += 1;
                }
                Blocker::Any | Blocker::Certain => counts[2] += 1,
            }
        }
    }
    counts
}

const LIGHTS: [&str; 6] = [
    "DirectionalLight { direction 0.3 -1 0.2 color 1 1 1 }",
    "DirectionalLight { direction 0 0 -1 color 1 1 1 }",
    "DirectionalLight { direction -1 0 0 color 1 1 1 }",
    "PointLight { position 1 4 -2 color 1 1 1 }",
    "PointLight { position -9 0 0 color 1 1 1 }",
    "PointLight { position 300 900 500 color 1 1 1 }",
];

/// Returns points among the primitives and around them, up to this distance, and points of the triangles.
fn points(world: &World, distance: f64) -> Vec<(DVec3, Option<u32>)> {
    let mut spread = Spread(1e4);
    let center = 0.5 * (world.bounds.min + world.bounds.max);
    let around = |scale: f64, spread: &mut Spread| (center + scale * spread.vector(), None);
    let mut points: Vec<_> = (0..12_000).map(|_| around(2.0, &mut spread)).collect();
    points.extend((0..12_000).map(|_| around(distance, &mut spread)));
    // Points around each point light, with nothing between.
    for light in &world.lights {
        if let Light::Point { position, .. } = *light {
            points.extend((0..2000).map(|_| (position + 2.0 * spread.vector(), None)));
        }
    }
    for id in (0..world.triangles.len() as u32).cycle().take(12_000) {
        let [a, b, c] = world.corners(id as usize);
        let (x, y) = (spread.number(), spread.number());
        points.push((a + (1.0 - x) * (b - a) + x * y * (c - a), Some(id)));
    }
    points
}

#[test]
fn what_a_map_knows_is_what_rays_hit() {
    let ball = "Sphere { center 0.5 0.1 0.3 radius 0.4 }";
    let egg =
        "Transform { Translate -1 0.2 0 ZRotate 30 Scale 0.5 0.2 0.1 Sphere { center 0 0 0 radius 1 } }";
    for (count, size, at, objects, distance) in [
        (30, 1.0, DVec3::ZERO, &[][..], 20.0),
        (30, 1.0, DVec3::new(1000.0, -500.0, 200.0), &[], 1e4),
        (3000, 0.05, DVec3::ZERO, &[], 20.0),
        (10, 1.0, DVec3::ZERO, &[ball, egg], 20.0),
        (5, 1e-5, DVec3::ZERO, &[], 5.0),
        (12, 60.0, DVec3::ZERO, &[], 400.0),
    ] {
        let world = world(count, size, at, objects, &LIGHTS);
        let maps = ShadowMaps::new(&world, MANY_RAYS, &Endless);
        let [nothing, only, any] = check(&world, &maps, &points(&world, distance));
        println!("{count} {size}: {nothing} {only} {any}");
        assert!(nothing + only > any / 2 && nothing > 40_000, "{count} {size}: {nothing} {only} {any}");
    }
}

/// Looks up each pixel of a map of two walls, one hiding the other, in front of both, between them and behind them.
#[test]
fn of_two_walls_the_one_that_is_nearer_to_the_light_is_tested() {
    let wall = |z: f64, side: f64| [[-side, -side, z], [side, -side, z], [0.0, side, z]].map(DVec3::from);
    for light in
        ["PointLight { position 0 0 9 color 1 1 1 }", "DirectionalLight { direction 0 0 -1 color 1 1 1 }"]
    {
        let mut world = world(2, 1.0, DVec3::ZERO, &[], &[light]);
        world.vertices = [wall(0.0, 4.0), wall(1.0, 1.0)].concat();
        let maps = ShadowMaps::new(&world, MANY_RAYS, &Endless);
        let at = |x: f64, z: f64| maps.blocker(0, DVec3::new(x, 0.0, z));
        for z in [-1.0, 0.5, 2.0] {
            assert_eq!(
                [at(0.1, z), at(1.2, z), at(4.0, z)],
                [Blocker::Only(1), Blocker::Only(0), Blocker::Nothing]
            );
        }
        // At the edges of both.
        let edges = (0..2000).filter(|k| at(0.002 * f64::from(*k), -0.5) == Blocker::Any).count();
        assert!((20..200).contains(&edges), "{edges}");
    }
}

#[test]
fn there_are_maps_only_where_they_pay_and_numbers_are_usual() {
    let makes = |world: &World, rays: usize| ShadowMaps::new(world, rays, &Endless).0.len();
    let few = world(30, 1.0, DVec3::ZERO, &[], &LIGHTS);
    assert_eq!([makes(&few, SIZE * SIZE), makes(&few, SIZE * SIZE - 1)], [LIGHTS.len(), 0]);
    let many = world(SIZE * SIZE / RAYS_PER_TRIANGLE + 1, 0.1, DVec3::ZERO, &[], &LIGHTS);
    assert_eq!([makes(&many, SIZE * SIZE), makes(&many, 2 * SIZE * SIZE)], [0, LIGHTS.len()]);
    let ball = "Sphere { center 0 0 0 radius 1 }";
    let floor = "Plane { normal 0 1 0 offset -1 }";
    for (objects, expected) in [(&[ball][..], 0), (&[floor], 0), (&[ball, floor], LIGHTS.len())] {
        assert_eq!(makes(&world(0, 1.0, DVec3::ZERO, objects, &LIGHTS), MANY_RAYS), expected, "{objects:?}");
    }
    let map_of =
        |light: &str| ShadowMaps::new(&world(30, 1.0, DVec3::ZERO, &[], &[light]), MANY_RAYS, &Endless);
    // Among the triangles, too close to them, and too far away.
    for light in ["0.1 0 0", "0 1.9 0", "1e13 0 0"] {
        let map = map_of(&format!("PointLight {{ position {light} color 1 1 1 }}"));
        assert!(map.0[0].is_none(), "{light}");
    }
    for light in [LIGHTS[0], LIGHTS[3]] {
        let map = map_of(light);
        for (point, is_known) in [
            (DVec3::new(0.0, -9.0, 0.0), true),
            (DVec3::new(1e6, 0.0, 0.0), true),
            (DVec3::new(1e13, 0.0, 0.0), false),
            (DVec3::NAN, false),
        ] {
            assert_eq!(map.blocker(0, point) != Blocker::Any, is_known, "{light} {point}");
        }
    }
}

/// Tests the edge functions and the nearness of a triangle whose vertices are moved a little.
#[test]
fn the_error_bounds_cover_what_vertices_are_off() {
    let mut spread = Spread(7.0);
    let (mut largest_edge, mut largest_depth) = (0.0, 0.0);
    for size in (0..4000).map(|k| [0.5, 3.0, 40.0, 200.0][k % 4]) {
        let vertex = |spread: &mut Spread| Projected {
            at: size * spread.vector().truncate(),
            nearness: 1.5 + spread.number(),
        };
        let corners = [(); 3].map(|()| vertex(&mut spread));
        // Move the vertices by the allowed error along both axes.
        let off = |corner: Projected| {
            let signs = spread.vector().truncate().signum();
            Projected { at: corner.at + SCREEN_ERROR * signs, ..corner }
        };
        let moved = corners.map(off);
        let [Some(computed), Some(exact)] =
            [corners, moved].map(|corners| edge_functions(corners, SCREEN_ERROR))
        else {
            continue;
        };
        let weights = [spread.number(), spread.number(), spread.number()];
        let sum: f64 = weights.iter().sum();
        let inside = (0..3).map(|k| moved[k].at * weights[k] / sum).sum::<glam::DVec2>();
        for (edge, true_edge) in computed.edges.iter().zip(&exact.edges) {
            let error = (edge.at(inside.x, inside.y) - true_edge.at(inside.x, inside.y)).abs();
            largest_edge = f64::max(largest_edge, error / computed.edge_error_bound);
        }
        let [depth, true_depth] = [&computed, &exact].map(|functions| &functions.inv_depth_plane);
        let error =
            (depth.inv_depth.at(inside.x, inside.y) - true_depth.inv_depth.at(inside.x, inside.y)).abs();
        largest_depth = f64::max(largest_depth, error / depth.error_bound.at(0.0));
    }
    assert!(
        (0.2..1.0).contains(&largest_edge) && (0.2..1.0).contains(&largest_depth),
        "{largest_edge} {largest_depth}"
    );
}

#[test]
fn triangles_that_lie_in_too_many_pixels_get_no_map() {
    let light = "DirectionalLight { direction 0 0 -1 color 1 1 1 }";
    let has_map = |count: usize, size: f64, lights: &[&str]| {
        let maps = ShadowMaps::new(&world(count, size, DVec3::ZERO, &[], lights), MANY_RAYS, &Endless);
        maps.0.iter().filter(|map| map.is_some()).count()
    };
    assert_eq!((has_map(20_000, 0.1, &[light]), has_map(100_000, 50.0, &[light])), (1, 0));
    // Together they may take no more than one.
    assert_eq!((has_map(20_000, 0.9, &[light]), has_map(20_000, 0.9, &[light; 40])), (1, 0));
}
