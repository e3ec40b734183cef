//! Scenes that are typed into the live page: the parser's messages, meshes beside the scene only, and hostile texts.

use crate::live_server::Server;
use crate::support::{CAMERA, Folder, scene, sphere};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

fn mesh(name: &str) -> String {
    scene(1, &format!("TriangleMesh {{ obj_file {name} }}"))
}

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// What the server says of a text.
fn typed(server: &Server, text: &str) -> Value {
    server.ask("/scene", &json!({ "text": text })).expect("an answer").0
}

/// A tiny picture of a scene with every effect; whether there is one does not matter, but that an answer comes does.
fn paint(server: &Server, said: &Value) {
    let words: Vec<&str> =
        "-size 4 4 -transparent_shadows -bounces 3 -shade_back -grid auto".split(' ').collect();
    let view = json!({ "scene": said["scene"]["revision"], "words": words, "camera": null, "cost": null });
    let question = json!({ "view": view });
    let _ = server.ask("/picture", &question);
    let _ = server.ask("/objects", &json!({ "view": view }));
    let _ = server.ask("/trace", &json!({ "view": view, "pixel": [1, 2] }));
}

#[test]
fn an_error_is_the_parser_s_and_the_last_scene_stays() {
    let folder = Folder::with_scene(&sphere());
    let server = Server::start(folder.path(), "");
    let said = typed(&server, &sphere().replace("radius", "raduis"));
    let error = &said["error"];
    folder.write("b.txt", sphere().replace("radius", "raduis"));
    let message = folder.run("-input b.txt").message(1);
    let [problem, hint] = ["problem", "hint"].map(|member| error[member].as_str().expect("a text"));
    let place = format!("b.txt:{}:{}: error: {problem}\n", error["at"][0], error["at"][1]);
    assert!(message.starts_with(&place) && message.contains(hint), "{message} {place}");
    assert_eq!(typed(&server, &sphere())["scene"]["camera"]["kind"], "orthographic");
    assert_eq!(folder.read("s.txt"), sphere().into_bytes());
}

#[test]
fn meshes_lie_beside_the_scene() {
    let outside = Folder::new();
    outside.write("secret.obj", OBJ);
    let folder = Folder::with_scene(&mesh("first.obj"));
    folder.write("first.obj", OBJ);
    folder.write("m.obj", OBJ);
    fs::create_dir(folder.path().join("sub")).expect("a folder");
    folder.write("sub/n.obj", OBJ);
    let server = Server::start(folder.path(), "");
    for name in ["first.obj", "m.obj", "sub/n.obj"] {
        assert!(typed(&server, &mesh(name))["scene"]["revision"].is_number(), "{name}");
    }
    let secret = outside.path().join("secret.obj").to_string_lossy().into_owned();
    let up = format!("../{}/secret.obj", outside.path().file_name().expect("a name").to_string_lossy());
    #[cfg_attr(not(unix), allow(unused_mut))]
    let mut names = vec![
        secret.clone(),
        up.clone(),
        format!("sub/../{up}"),
        "/no/such.obj".into(),
        "./m.obj".into(),
        "none.obj".into(),
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&secret, folder.path().join("link.obj")).expect("a link");
        std::os::unix::fs::symlink(outside.path(), folder.path().join("away")).expect("a link");
        names.extend(["link.obj".into(), "away/secret.obj".into()]);
    }
    for name in names {
        let said = typed(&server, &mesh(&name));
        let problem = said["error"]["problem"].as_str().expect("an error");
        assert!(problem.starts_with("cannot read the mesh"), "{name}: {problem}");
        // Nothing tells whether a file outside exists.
        assert!(!problem.contains("No such file") || !name.contains(".."), "{name}: {problem}");
    }
}

#[test]
fn a_scene_that_multiplies_its_meshes_is_refused() {
    let folder = Folder::with_scene(&sphere());
    folder.write("m.obj", format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", "f 1 2 3\n".repeat(30_000)));
    let server = Server::start(folder.path(), "");
    let objects = "TriangleMesh { obj_file m.obj }\n".repeat(100);
    let said = typed(&server, &scene(100, &objects));
    assert_eq!(said["error"]["problem"], "a page opens scenes of at most 1000000 primitives");
    let names: String =
        (0..40).map(|k| format!("TriangleMesh {{ obj_file {}m.obj }}\n", "./".repeat(k + 1))).collect();
    let said = typed(&server, &scene(40, &names));
    assert!(said["error"]["problem"].as_str().expect("an error").contains("beside the scene only"));
}

#[test]
fn hostile_texts_do_no_harm() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = Folder::with_scene(&sphere());
    fs::read_dir(root.join("fuzz/seeds/obj")).expect("seeds").for_each(|file| {
        let path = file.expect("a file").path();
        fs::copy(&path, folder.path().join(path.file_name().expect("a name"))).expect("a copy");
    });
    let server = Server::start(folder.path(), "");
    let seeds = fs::read_dir(root.join("fuzz/seeds/scene_text")).expect("seeds");
    let mut texts: Vec<String> =
        seeds.map(|file| fs::read_to_string(file.expect("a file").path()).expect("text")).collect();
    assert!(texts.len() >= 3, "{}", texts.len());
    texts.extend([
        String::new(),
        "\0\u{202e}<script>alert(1)</script>".into(),
        "{".repeat(200_000),
        format!(
            "{CAMERA}Group {{ numObjects 1 Material {{ }} {} Sphere {{ center 0 0 0 radius 1 }}",
            "Transform { Scale 2 2 2 ".repeat(20_000)
        ),
        format!("{CAMERA}Group {{ numObjects 4294967295 }}"),
        scene(1, "Sphere { center 1e100 0 0 radius 1e100 }"),
        scene(1, "Transform { Scale 0 0 0 Sphere { center 0 0 0 radius 1 } }"),
    ]);
    for text in &texts {
        let said = typed(&server, text);
        assert!(said["scene"].is_object() != said["error"].is_object(), "{said}");
        if said["scene"].is_object() {
            paint(&server, &said);
        }
    }
    assert!(server.ask("/start", &json!({})).is_ok());
}
