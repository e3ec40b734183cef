use super::*;
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

#[test]
fn a_plane_is_transformed_with_its_points() {
    let object = "Transform { Translate 0 0 5 Scale 1 1 3 Plane { normal 0 0 2 offset 4 } }";
    let world = world_of(object, &[]).unwrap();
    assert_eq!(world.planes, [Plane { normal: DVec3::Z, offset: 17.0 }]);
}
