use super::*;
use crate::base::patience::tests::Counted;
use crate::math::worst_case::Rng;
use crate::scene::Position;
use crate::scene::parser::parse;

#[test]
fn a_mesh_taken_over_is_the_mesh_copied() {
    let mesh = Mesh {
        vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let mirrored = "Transform { Scale { -1 2 3 } TriangleMesh { obj_file a.obj } }";
    let sphere = "Sphere { center 0 0 0 radius 1 }";
    let triangle = "Triangle { vertex0 0 0 0 vertex1 1 0 0 vertex2 0 1 0 }";
    for objects in [
        [mirrored, sphere],
        [sphere, mirrored],
        [triangle, mirrored],
        [mirrored, triangle],
        [mirrored, mirrored],
        ["TriangleMesh { obj_file b.obj }", mirrored],
    ] {
        let world = |objects: &[&str]| {
            let text = format!(
                "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
                 Group {{ numObjects {} Material {{ }} {} }}",
                objects.len(),
                objects.concat()
            );
            let scene = parse(&text).unwrap();
            World::new(&scene, &vec![mesh.clone(); scene.meshes.len()]).unwrap()
        };
        // Behind another object, no mesh is taken over.
        let (taken, copied) = (world(&objects), world(&[triangle, objects[0], objects[1]]));
        let copied_triangles: Vec<_> = copied.triangles[1..].iter().map(|ids| ids.map(|id| id - 3)).collect();
        let copied_count = copied_triangles.len();
        assert_eq!((taken.vertices.as_slice(), taken.triangles), (&copied.vertices[3..], copied_triangles));
        let count = |text: &str| {
            let of = |name, count| if text.contains(name) { count } else { 0 };
            of("Mesh", 2) + of("vertex0", 1)
        };
        assert_eq!(copied_count, objects.map(count).iter().sum::<usize>(), "{objects:?}");
    }
}

/// Builds the world of one object, or returns its error.
fn world_of(object: &str, meshes: &[Mesh]) -> Result<World, Diagnostic> {
    let text = format!(
        "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
         Group {{ numObjects 1 Material {{ }}\n{object} }}"
    );
    World::new(&parse(&text).unwrap(), meshes)
}

#[test]
fn a_mesh_with_a_corner_out_of_range_is_an_error_where_it_stands() {
    for corner in [DVec3::X * 1e101, DVec3::NEG_Y * 1e101, DVec3::Z * f64::INFINITY, DVec3::NAN] {
        let mesh = Mesh { vertices: vec![DVec3::ZERO, DVec3::X, corner], triangles: vec![[0, 1, 2]] };
        let error = |object, meshes: &[Mesh]| world_of(object, meshes).map(|_| ()).unwrap_err();
        let meshes = [mesh];
        let moved = "Transform { Translate 1 0 0 TriangleMesh { obj_file a.obj } }";
        for object in ["TriangleMesh { obj_file a.obj }", moved] {
            let found = error(object, &meshes);
            assert_eq!(found.position(), Some(Position { line: 3, column: 1 }), "{corner}");
            assert!(found.message.contains("coordinates beyond 1e100"), "{found}");
        }
    }
    let empty = Mesh { vertices: vec![], triangles: vec![] };
    assert!(world_of("TriangleMesh { obj_file a.obj }", &[empty]).is_ok());
}

#[test]
fn a_sphere_has_the_radius_and_the_semi_axes_of_its_transform() {
    let transformed = |scale: &str, sphere: &str| {
        world_of(&format!("Transform {{ Scale {scale} Sphere {{ {sphere} }} }}"), &[])
    };
    let world = transformed("3 3 3", "center 1 0 0 radius 0.5").unwrap();
    assert_eq!(world.shapes[0], Shape::Sphere(Sphere { center: DVec3::X * 3.0, radius: 1.5 }));
    let world = transformed("3 4 8", "center 0 1 0 radius 0.5").unwrap();
    assert_eq!(
        world.boxes().collect::<Vec<_>>(),
        [Aabb { min: DVec3::new(-1.5, 2.0, -4.0), max: DVec3::new(1.5, 6.0, 4.0) }]
    );
    // A radius may be 1e-100 and no less. Neither the radius nor the centre may be beyond 1e100.
    assert!(transformed("1 1 1", "center 0 0 0 radius 1e-100").is_ok());
    for (scale, sphere, expected) in [
        ("0.9 0.9 0.9", "center 0 0 0 radius 1e-100", "radius below 1e-100"),
        ("1e-50 1e-50 1e-50", "center 0 0 0 radius 1e-60", "radius below 1e-100"),
        ("1 1 1e-50", "center 0 0 0 radius 1e-60", "radius below 1e-100"),
        ("1e60 1e60 1e60", "center 0 0 0 radius 1e60", "coordinates beyond 1e100"),
        ("1 1e60 1", "center 0 0 0 radius 1e60", "coordinates beyond 1e100"),
        ("1e60 1e60 1e60", "center 1e60 0 0 radius 1", "coordinates beyond 1e100"),
    ] {
        let error = transformed(scale, sphere).err().map(|error| error.message).unwrap_or_default();
        assert!(error.contains(expected), "{scale} {sphere}: {error}");
    }
}

/// The number of questions whether building a world should end, which is proportional to its steps.
fn questions(objects: &str, count: usize, lights: &[String]) -> usize {
    let text = format!(
        "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
         Lights {{ numLights {} {} }} Group {{ numObjects {count} Material {{ }} {objects} }}",
        lights.len(),
        lights.concat()
    );
    let patience = Counted::up_to(usize::MAX);
    World::within(&parse(&text).unwrap(), vec![], &patience).unwrap();
    patience.asked()
}

/// Returns the objects of a kind, and the lights, of a scene of `count` objects.
type Family = fn(&mut Rng, usize) -> (Vec<String>, Vec<String>);

fn lights(rng: &mut Rng, count: usize, z: Option<f64>) -> Vec<String> {
    let mut at = || 2.0 * rng.signed();
    let light =
        |_| format!("PointLight {{ position {} {} {} color 1 1 1 }} ", at(), at(), z.unwrap_or_else(&mut at));
    (0..count).map(light).collect()
}

fn objects(count: usize, object: impl FnMut(usize) -> String) -> Vec<String> {
    (0..count).map(object).collect()
}

#[test]
fn the_steps_of_building_grow_with_the_scene() {
    let families: [(&str, f64, Family); 9] = [
        ("random planes", 6.0, |rng, count| {
            let object = |_: usize| {
                let [x, y, z, offset] = [0; 4].map(|_| rng.signed());
                format!("Plane {{ normal {x} {y} {z} offset {offset} }} ")
            };
            (objects(count, object), vec![])
        }),
        ("planes some roundings apart", 6.0, |_, count| {
            (
                objects(count, |k| format!("Plane {{ normal 0 1 0.3 offset {} }} ", -1.0 - k as f64 * 1e-15)),
                vec![],
            )
        }),
        ("planes some roundings apart, each under a transform", 6.0, |_, count| {
            let object = |k: usize| {
                let offset = -1.0 - k as f64 * 1e-15;
                format!("Transform {{ Translate {k} 0 0 Plane {{ normal 0 1 0.3 offset {offset} }} }} ")
            };
            (objects(count, object), vec![])
        }),
        ("lights on equal triangles", 6.0, |rng, count| {
            let triangle = "Triangle { vertex0 -9 -9 1 vertex1 9 -9 1 vertex2 0 19 1 } ";
            (objects(count, |_| triangle.into()), lights(rng, count, Some(1.0)))
        }),
        ("lights and small spheres", 6.0, |rng, count| {
            let object = |_: usize| {
                let [x, y, z] = [0; 3].map(|_| 2.0 * rng.signed());
                format!("Sphere {{ center {x} {y} {z} radius 0.03 }} ")
            };
            (objects(count, object), lights(rng, count, None))
        }),
        // A surface across the scene is near n^(2/3) of the lights.
        ("lights and large spheres", 12.0, |rng, count| {
            let object = |k: usize| format!("Sphere {{ center 0 0 0 radius {} }} ", 1.0 + k as f64 * 1e-5);
            (objects(count, object), lights(rng, count, None))
        }),
        ("lights and planes", 12.0, |rng, count| {
            let object = |k: usize| format!("Plane {{ normal 1 1 {} offset 0.1 }} ", k as f64 * 1e-3);
            (objects(count, object), lights(rng, count, None))
        }),
        ("lights and tilted triangles", 12.0, |rng, count| {
            let object = |k: usize| {
                format!("Triangle {{ vertex0 -9 -9 {} vertex1 9 -9 2 vertex2 0 19 -3 }} ", k as f64 * 1e-3)
            };
            (objects(count, object), lights(rng, count, None))
        }),
        ("nested transforms", 6.0, |_, count| {
            let (before, after) = ("Transform { Translate 1 0 0 ", "}");
            let sphere = "Sphere { center 0 0 0 radius 1 } ";
            (vec![format!("{}{sphere}{}", before.repeat(count), after.repeat(count))], vec![])
        }),
    ];
    for (name, growth, family) in families {
        let [few, many] = [3000, 12_000].map(|count| {
            let (objects, lights) = family(&mut Rng(3), count);
            questions(&objects.concat(), objects.len(), &lights)
        });
        println!("{name}: {few} {many}");
        assert!(many as f64 <= growth * few as f64 + 6.0, "{name}: {few} questions, then {many}");
    }
}

#[test]
fn building_ends_at_any_question() {
    let rng = &mut Rng(4);
    let sphere = |_: usize| "Sphere { center 0 0 0 radius 1 } Plane { normal 0 1 0 offset 1 } ".to_string();
    let objects = objects(3000, sphere).concat();
    let text = format!(
        "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
         Lights {{ numLights 300 {} }} Group {{ numObjects 6000 Material {{ }} {objects} }}",
        lights(rng, 300, None).concat()
    );
    let scene = parse(&text).unwrap();
    let mut built = (0..).map(|most| World::within(&scene, vec![], &Counted::up_to(most)));
    let ended = built.by_ref().take_while(Result::is_err).count();
    assert!(ended > 2, "{ended}");
}
