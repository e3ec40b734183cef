//! The figure of shadow acne: a rabbit on the ground in the sun, at three scales, with shadow rays of a fixed
//! t_min from points in f32, and with ours.

use crate::{Figure, panels};
use glam::{DVec2, DVec3};
use raytracer::camera::Camera;
use raytracer::caster::{Caster, RayOrigin};
use raytracer::math::ray::{Hit, Ray};
use raytracer::math::robust::offset_origin;
use raytracer::scene::material::{Material, Phong};
use raytracer::scene::mesh::Mesh;
use raytracer::scene::model::{Lighting, MeasureColors, MeshNormals, Screen, Shows};
use raytracer::scene::obj::parse_obj;
use raytracer::scene::{self, Background, MeshFile, Object, Scene};
use raytracer::world::World;
use std::path::Path;

const SCALES: [f64; 3] = [1e-6, 1.0, 1e6];
const SIDE: usize = 256;
/// The usual t_min of a shadow ray.
const FIXED: f64 = 1e-4;

/// The pictures at one scale: the brightness of each pixel with the fixed t_min and with ours, in rows from
/// the top.
struct Shot {
    fixed: Vec<u8>,
    ours: Vec<u8>,
}

pub fn draw() -> Result<Figure, Box<dyn std::error::Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/bunny_5k.obj");
    let mesh = parse_obj(&std::fs::read(path)?)?;
    let shots = SCALES.iter().map(|&scale| shoot(&mesh, scale)).collect::<Result<Vec<_>, _>>()?;
    let color = |panel: usize, [x, y]: [usize; 2]| {
        let shot = &shots[panel % SCALES.len()];
        let picture = if panel < SCALES.len() { &shot.fixed } else { &shot.ours };
        [picture[y * SIDE + x]; 3]
    };
    let different = |s: &Shot| s.fixed.iter().zip(&s.ours).filter(|(a, b)| a != b).count();
    let counts = shots.iter().map(|s| different(s).to_string()).collect::<Vec<_>>().join(", ");
    let caption = format!(
        "A rabbit on the ground in the sun, scaled by 1e-6, 1 and 1e6 from left to right. Above: shadow rays from \
         points in f32 with a smallest t of {FIXED}. Below: ours. Of {} pixels each, {counts} differ: at 1e-6 every \
         shadow is shorter than the smallest t and so lost, at 1e6 the rounding of the point exceeds it and surfaces \
         shadow themselves.",
        SIDE * SIDE
    );
    Ok(Figure { picture: panels(2, SCALES.len(), SIDE, color), caption })
}

fn shoot(mesh: &Mesh, scale: f64) -> Result<Shot, Box<dyn std::error::Error>> {
    let mesh = Mesh {
        vertices: mesh.vertices.iter().map(|&v| scale * v).collect(),
        triangles: mesh.triangles.clone(),
    };
    let scene = scene_on_ground(&mesh);
    let world = World::new(&scene, std::slice::from_ref(&mesh))?;
    let caster = Caster::new(&world, Some([30; 3]))?;
    let camera = Camera::new(&scene.camera, [SIDE; 2]);
    let (mut fixed, mut ours) = (vec![], vec![]);
    for y in (0..SIDE).rev() {
        for x in 0..SIDE {
            let ray = camera.ray(DVec2::new(x as f64, y as f64), DVec2::ZERO);
            let hit = caster.closest(&ray);
            let [a, b] = hit.map_or([SKY; 2], |hit| brightness(&caster, &ray, hit));
            fixed.push(a);
            ours.push(b);
        }
    }
    Ok(Shot { fixed, ours })
}

const SKY: u8 = 215;

/// The brightness of a hit with the fixed t_min and with ours.
fn brightness(caster: &Caster, ray: &Ray, hit: Hit) -> [u8; 2] {
    let to_light = DVec3::new(-0.8, 0.7, 0.6).normalize();
    let surface = caster.world.surface(ray, &hit);
    let cosine = surface.normal.dot(to_light);
    if cosine <= 0.0 {
        return [30; 2];
    }
    let fixed = Ray { t_min: FIXED, ..Ray::new(ray.at(hit.t).as_vec3().as_dvec3(), to_light) };
    let start = offset_origin(surface.position, surface.normal, to_light, surface.extent);
    [fixed, Ray::new(start, to_light)].map(|shadow| {
        let lit = !caster.any(&shadow, RayOrigin::FREE);
        (30.0 + if lit { 200.0 * cosine } else { 0.0 }) as u8
    })
}

fn scene_on_ground(mesh: &Mesh) -> Scene {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &v in &mesh.vertices {
        (min, max) = (min.min(v), max.max(v));
    }
    let (middle, extent) = ((min + max) / 2.0, (max - min).max_element());
    let eye = middle + extent * DVec3::new(0.5, 0.7, 2.2);
    Scene {
        camera: scene::Camera::Perspective {
            center: eye,
            direction: middle - eye,
            up: DVec3::Y,
            angle: 36.0,
        },
        background: Background::default(),
        lights: vec![],
        materials: vec![Material::Phong(Phong::default())],
        objects: vec![
            Object::Mesh { mesh: 0, material: 0 },
            Object::Plane { normal: DVec3::Y, offset: min.y, material: 0 },
            Object::Group(vec![0, 1]),
        ],
        positions: Default::default(),
        root: 2,
        meshes: vec![MeshFile { name: "bunny_5k.obj".into(), ..MeshFile::default() }],
        images: vec![],
        cube_map: None,
        screen: Screen::default(),
        lighting: Lighting::default(),
        mesh_normals: MeshNormals::default(),
        measure_colors: MeasureColors::default(),
        shows: Shows::default(),
    }
}
