use super::*;
use crate::base::patience::Endless;
use crate::caster::choose::Layout;
use crate::math::instructions;
use crate::sampling::sample_packet::{SamplePacket, Stage};
use crate::scene::Scene;
use crate::scene::edition::Edition;
use crate::scene::mesh::Mesh;
use crate::scene::model::{Lighting, MeshNormals, Screen};
use crate::scene::parser::read_in;
use crate::scene::texels::Texels;
use crate::stats::Counts;
use crate::trace::{Effects, RayCount, RayStack, Shadows, Tracer};
use fearless_simd::dispatch;
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Returns a scene of the later editions: glass, mirrors, highlights, a noise and an image as colours, two meshes, one
/// of them mirrored, a cube map, and a camera that looks down. All of it is moved up by `up`.
fn later(up: f64) -> (Scene, Vec<Mesh>) {
    let text = format!(
        "PerspectiveCamera {{ center 0 {} 6 direction .1 -.25 -1 up .1 1 .2 angle 40 }}
         Lights {{ numLights 2 DirectionalLight {{ direction -.4 -.7 -.6 color .6 .6 .5 }}
         PointLight {{ position -2 {} 2 color 1 .9 .8 falloff .2 }} }}
         Background {{ color .2 .3 .4 ambientLight .1 .2 .1 cubeMap sky }}
         Materials {{ numMaterials 4
         Material {{ diffuseColor .1 .1 .2 specularColor .9 .8 .9 shininess 9 refractionIndex 1.5 }}
         Material {{ diffuseColor .8 .5 .3 specularColor .3 .2 .2 shininess 0 texture tiles.bmp }}
         Material {{ specularColor .2 .2 .2 shininess 3
         Noise {{ color .7 .5 .3 color .2 .1 0 octaves 3 frequency 6 amplitude 5 }} }}
         Material {{ diffuseColor .4 .5 .4 specularColor .3 .3 .3 shininess 20 }} }}
         Group {{ numObjects 2
         MaterialIndex 3 Plane {{ normal 0 1 0 offset {up} }}
         Transform {{ Translate 0 {up} 0 Group {{ numObjects 5
         MaterialIndex 0 Transform {{ Translate -1 .8 0 TriangleMesh {{ obj_file gem.obj }} }}
         MaterialIndex 1 Transform {{ Translate 1 .6 .5 Scale -1 .7 1 TriangleMesh {{ obj_file gem.obj }} }}
         MaterialIndex 2 Sphere {{ center 0 .5 1.2 radius .5 }}
         MaterialIndex 0 Transform {{ Translate .2 1.6 -1 Scale 1 .5 .7 Sphere {{ center 0 0 0 radius 1 }} }}
         MaterialIndex 3 Triangle {{ vertex0 -3 0 -2 vertex1 3 .2 -2 vertex2 0 3 -3 }} }} }} }}",
        up + 1.8,
        up + 3.0
    );
    let mut scene = read_in(Edition::Y2012A5, &text).expect("a scene").scene;
    for (k, image) in scene.images.iter_mut().enumerate() {
        let rgb = (0..3 * 5 * 4).map(|i| (i * (37 + 2 * k) % 256) as u8).collect();
        image.texels = Arc::new(Texels { size: [5, 4], rgb, divides_last: k % 2 == 0 });
    }
    let vertices = DVec3::AXES.into_iter().flat_map(|axis| [axis, -0.8 * axis]).collect();
    let triangles: Vec<_> = (0..8u32)
        .map(|k| {
            let [x, y, z] = [k & 1, 2 + (k >> 1 & 1), 4 + (k >> 2)];
            if k.count_ones() % 2 == 0 { [x, y, z] } else { [x, z, y] }
        })
        .collect();
    let corners = |k: usize| [[0.0, 0.0], [1.0, 0.1 * k as f64], [0.3, 1.0]].map(DVec2::from);
    for file in &mut scene.meshes {
        file.texture_coordinates = Arc::new((0..8).map(|k| (k != 5).then(|| corners(k))).collect());
    }
    let gem = Mesh { vertices, triangles };
    let meshes = scene.meshes.iter().map(|_| gem.clone()).collect();
    (scene, meshes)
}

/// Compares all colours with the tracer's. Returns the number of pixels of a picture that are known without casting
/// their rays, and the number of background colours.
fn compared(
    world: &World,
    camera: &Camera,
    size: [usize; 2],
    effects: Effects,
    is_center: bool,
) -> [usize; 2] {
    let footprint = Some(if is_center { Footprint::Center } else { Footprint::Pixel });
    let mut found = [0; 2];
    for level in instructions::available() {
        let caster = Caster::with(world, Layout::Grid([4; 3]), level).expect("a grid");
        // Enough shadow rays that there are shadow maps.
        let demand = Demand { size, footprint, enters_objects: false, shadow_rays: 1 << 20 };
        let hints = RasterHints::new(world, demand, &Endless).in_rows(camera, &caster, 0..size[1]);
        let (fast, tracer) = (Tracer::with_hints(&caster, effects, &hints), Tracer::new(&caster, effects));
        let mut stack = RayStack::default();
        let mut packet = SamplePacket::default();
        for j in 0..size[1] {
            let columns: Vec<usize> = (0..size[0]).collect();
            for columns in columns.chunks(SamplePacket::SIZE) {
                packet.clear();
                for &column in columns {
                    let part = (column * 7 + j * 3) as f64 * 0.618_033_988_749_894_9;
                    let offset = DVec2::new(part.fract() - 0.5, (0.4 * part).fract() - 0.5);
                    packet.push(column, if is_center { DVec2::ZERO } else { offset }, true);
                }
                let (stage, rays) = (Stage::Colors, &mut RayCount::default());
                let (samples, kept) = (&mut packet, &mut stack);
                dispatch!(level, simd => fast.trace(simd, camera, j, stage, samples, kept, rays));
                for (sample, color) in packet.samples().iter().zip(packet.colors()) {
                    let ray = camera.ray(DVec2::new(sample.column as f64, j as f64), sample.offset);
                    let is_known = hints.first_hit(world, &ray, [sample.column, j]) != FirstHit::Unknown;
                    found[0] += usize::from(is_known);
                    let expected = tracer.color(&ray, &mut stack, &mut Counts::default());
                    let bits = |color: crate::picture::Color| color.to_array().map(f64::to_bits);
                    assert_eq!(bits(*color), bits(expected), "{effects:?} {:?} {ray:?}", world.lighting);
                    found[1] += usize::from(expected == world.background_along(ray.direction));
                }
            }
        }
    }
    found
}

/// Returns the rules of the editions, and others with epsilons that matter.
fn rules() -> Vec<(Screen, Lighting, MeshNormals)> {
    let editions = [Edition::Y2012A4, Edition::Y2012A5, Edition::Y2019];
    let [a4, a5, a2019] = editions.map(|it| (it.screen(), it.lighting(), it.mesh_normals()));
    let smooth = (a5.0, a5.1, a2019.2);
    let coarse = |(screen, lighting, normals)| (screen, Lighting { epsilon: Some(0.7), ..lighting }, normals);
    vec![a4, a5, a2019, smooth, coarse(a4), coarse(smooth)]
}

#[test]
fn all_rules_have_the_colours_of_the_tracer() {
    let size = [39, 26];
    for (rules, up) in rules().into_iter().flat_map(|rules| [(rules, 0.0), (rules, 1e14)]) {
        let (mut scene, meshes) = later(up);
        (scene.screen, scene.lighting, scene.mesh_normals) = rules;
        let world = World::new(&scene, &meshes).expect("a world");
        let camera = Camera::with_screen(&scene.camera, size, scene.screen);
        for shadows in [Shadows::None, Shadows::Opaque, Shadows::Transparent] {
            for is_center in [true, false] {
                let effects = Effects { shadows, shade_back: is_center, bounces: 3, min_weight: 0.0 };
                let [known, missed] = compared(&world, &camera, size, effects, is_center);
                if up == 0.0 {
                    let least = if is_center { 500 } else { 200 };
                    assert!(known > least && missed > 100, "{known} {missed} {rules:?}");
                }
            }
        }
    }
}
