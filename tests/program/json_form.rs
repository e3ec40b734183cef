//! The form of the JSON document: `docs/json.md` and what the program writes agree, member by member.

use crate::causes::{self, FLAGS, with_original};
use crate::pixel_scenes::{BOARD, GLASS, MARBLE, MESH, OBJ};
use crate::support::{Folder, finish, program, scene};
use raytracer::scene::texels::FACES;
use raytracer::tools::causes::Mistake;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

const DOCS: &str = include_str!("../../docs/json.md");

/// A member in the tables.
struct Row {
    /// What it may be.
    kinds: Vec<&'static str>,
    /// Whether it exists only for some things of its kind.
    is_optional: bool,
}

/// The rows of each table by the paths of their members.
struct Form(BTreeMap<&'static str, BTreeMap<&'static str, Row>>);

/// What is wrong with documents, and the members that they have.
#[derive(Default)]
struct Findings {
    wrong: BTreeSet<String>,
    seen: BTreeSet<(&'static str, String)>,
}

impl Form {
    fn read() -> Self {
        let sections = DOCS.split("\n## ").skip(1).map(|section| {
            let (title, text) = section.split_once('\n').expect("a title");
            let rows = text.lines().filter_map(|line| line.strip_prefix("| `"));
            (title, rows.map(Self::row).collect())
        });
        Self(sections.collect())
    }

    fn row(line: &'static str) -> (&'static str, Row) {
        let cells: Vec<&str> = line.split(" | ").collect();
        let [path, kinds, meaning] = cells[..] else { panic!("{line}") };
        let path = path.strip_suffix('`').expect("a member");
        let row = Row { kinds: kinds.split(" or ").collect(), is_optional: meaning.starts_with("Only of ") };
        (path, row)
    }

    /// Compares an object with the rows of a table whose paths start with `prefix`.
    fn check(&self, table: &'static str, prefix: &str, object: &Value, findings: &mut Findings) {
        let rows = &self.0[table];
        let object = object.as_object().expect("an object");
        for (name, value) in object {
            let path = format!("{prefix}{name}");
            match rows.get(path.as_str()) {
                Some(row) => self.check_value(table, &path, row, value, findings),
                None => drop(findings.wrong.insert(format!("{table}: {path} is not documented"))),
            }
            findings.seen.insert((table, path));
        }
        for (path, _) in rows.iter().filter(|(_, row)| !row.is_optional) {
            let lacks = path
                .strip_prefix(prefix)
                .is_some_and(|name| !name.contains('.') && !object.contains_key(name));
            if lacks {
                findings.wrong.insert(format!("{table}: {path} is missing"));
            }
        }
    }

    fn check_value(
        &self,
        table: &'static str,
        path: &str,
        row: &Row,
        value: &Value,
        findings: &mut Findings,
    ) {
        let Some(kind) = row.kinds.iter().find(|kind| is_of(kind, value)) else {
            findings.wrong.insert(format!("{table}: {path} is {value}"));
            return;
        };
        let (of_each, elements, prefix) = match kind.strip_prefix("list of ") {
            Some(rest) => (rest, value.as_array().expect("a list").iter().collect(), format!("{path}[].")),
            None => (*kind, vec![value], format!("{path}.")),
        };
        for element in elements {
            if let Some((name, _)) = of_each.strip_prefix('[').and_then(|link| link.split_once(']')) {
                self.check(self.0.get_key_value(name).expect("a table").0, "", element, findings);
            } else if of_each.starts_with("object") {
                self.check(table, &prefix, element, findings);
            }
        }
    }
}

/// Whether a value is of a kind, as the tables name them.
fn is_of(kind: &str, value: &Value) -> bool {
    let all = |kind: &str| value.as_array().is_some_and(|list| list.iter().all(|one| is_of(kind, one)));
    match kind {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" | "strings" => value.is_string(),
        "number" | "numbers" => value.is_number(),
        "object" | "objects" => value.is_object(),
        "2 numbers" => all("number") && value.as_array().is_some_and(|list| list.len() == 2),
        "3 numbers" => all("number") && value.as_array().is_some_and(|list| list.len() == 3),
        _ if kind.starts_with('[') => value.is_object(),
        _ => all(kind.strip_prefix("list of ").unwrap_or_else(|| panic!("what is {kind}?"))),
    }
}

fn document(folder: &Folder, flags: &str) -> Value {
    let run = folder.run(&format!("{flags} -json -"));
    assert!(matches!(run.status, Some(0 | 3)), "{}", run.stderr);
    serde_json::from_str(&run.stdout).unwrap_or_else(|error| panic!("{error}: {}", run.stdout))
}

/// Documents of scenes whose pixels show every kind of ray and surface.
fn of_pixels(documents: &mut Vec<Value>) {
    for (text, flags) in [
        (GLASS, "-transparent_shadows -bounces 5 -weight .2 -shade_back"),
        (GLASS, "-shadows -bounces 2 -random_samples 2 -box_filter .7 -grid auto"),
        (BOARD, "-shadows -jittered_samples 3 -seed 7 -gaussian_filter .6"),
        (MESH, "-shadows -grid 3 4 5"),
        (MARBLE, "-uniform_samples 4"),
        (GLASS, "-shadows -adaptive_samples 20 3"),
    ] {
        let folder = Folder::with_scene(text);
        folder.write("m.obj", OBJ);
        let places = (0..4).flat_map(|y| (0..4).map(move |x| (6 * x + 2, 4 * y + 3)));
        let explain = |(x, y)| document(&folder, &format!("-input s.txt -size 24 18 {flags} -pixel {x} {y}"));
        documents.extend(places.map(explain));
    }
    let sphere = "Sphere { center 0 0 0 radius .7 } ";
    let folder = Folder::with_scene(&scene(2, &sphere.repeat(2)));
    documents.push(document(&folder, "-input s.txt -size 9 9 -pixel 4 4"));
}

/// Documents of comparisons with every kind of finding.
fn of_comparisons(documents: &mut Vec<Value>) {
    let folder = causes::folder();
    let compare = |more: &str| document(&folder, &format!("-input s.txt {FLAGS} -compare a.png {more}"));
    for name in ["shifted", "far_hit", "normals_by_matrix"] {
        let rule = Mistake::all().find(|mistake| mistake.name == name).expect("a known mistake");
        let wrong = with_original(&folder, FLAGS, |original| original.picture(&[rule]));
        causes::write(&folder, &wrong.expect("a wrong picture"));
        documents.push(compare("-tolerance 3 5 -difference d.png"));
    }
    let own = folder.render(FLAGS);
    let wrong = folder.render("-size 48 36 -bounces 2");
    for picture in [
        causes::transformed(&wrong, |x, y| if x < 5 && y < 5 { [0; 3] } else { wrong.at(x, y) }),
        causes::transformed(&wrong, |_, _| [255; 3]),
        causes::transformed(&wrong, |x, y| wrong.at(x, y).map(|byte| byte.saturating_sub(1))),
        causes::transformed(&own, |x, y| own.at(x, y).map(|byte| byte ^ u8::from((x, y) == (0, 0)))),
        causes::transformed(&own, |x, y| own.at(x, y)),
    ] {
        causes::write(&folder, &picture);
        documents.push(compare(""));
    }
    // A shadow is missing in a few pixels.
    let shadowed = |x: usize, y: usize| own.at(x, y) != wrong.at(x, y);
    let places = (0..36).flat_map(|y| (0..48).map(move |x| (x, y)));
    let (left, top) = places.into_iter().find(|&(x, y)| shadowed(x, y)).expect("a shadow");
    let is_near = |x: usize, y: usize| (left..left + 4).contains(&x) && (top..top + 3).contains(&y);
    let patched = causes::transformed(&own, |x, y| if is_near(x, y) { wrong.at(x, y) } else { own.at(x, y) });
    causes::write(&folder, &patched);
    documents.push(compare(""));
    folder.run("-input s.txt -size 48 36 -shadows -bounces 1 -output a.png").ok();
    documents.push(compare(""));
    folder.run(&format!("-input s.txt {FLAGS} -output a.png")).ok();
    folder.run("-input s.txt -size 48 36 -output b.png").ok();
    documents.push(compare("-reference b.png"));
    documents.push(document(&folder, "-compare a.png -reference b.png"));
    // Here and there a plain floor does not get the light.
    let text = causes::SCENE.replace("MaterialIndex 4 Plane", "MaterialIndex 3 Plane");
    folder.write("s.txt", &text);
    let own = folder.render("-size 100 75 -shadows");
    folder.write("s.txt", text.replace("color 2.2 2 1.8", "color 0 0 0"));
    let dark = folder.render("-size 100 75 -shadows");
    folder.write("s.txt", &text);
    let at = |x: usize, y: usize| x % 4 == 1 && y % 5 == 2;
    let speckled = causes::transformed(&own, |x, y| if at(x, y) { dark.at(x, y) } else { own.at(x, y) });
    causes::write(&folder, &speckled);
    documents.push(document(&folder, "-input s.txt -size 100 75 -shadows -compare a.png"));
}

/// Documents of comparisons of numbers.
fn of_numbers(documents: &mut Vec<Value>) {
    let folder = Folder::new();
    let write = |name: &str, numbers: [f32; 3]| {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        folder.write(name, [b"Pf\n3 1\n-1.0\n", &bytes[..]].concat());
    };
    write("a.pfm", [1.0, 2.0, f32::NAN]);
    write("b.pfm", [1.0, 3.0, 4.0]);
    documents.push(document(&folder, "-compare a.pfm -reference b.pfm -difference d.png -tolerance 0.5 0"));
    documents.push(document(&folder, "-compare b.pfm -reference b.pfm"));
}

/// Documents of gradings.
fn of_gradings() -> Vec<Value> {
    let folder = Folder::with_scene(&scene(1, "Sphere { center 0 0 0 radius .7 }"));
    folder.write("commands.txt", "rt -input s.txt -output o.tga\nrt -input none.txt -output n.tga\n");
    fs::create_dir_all(folder.path().join("class/anna")).expect("a folder");
    folder.write("class/loose.tga", "");
    folder.write("class/anna/o.jpg", "");
    let line = "-grade class -commands commands.txt";
    let mut documents = vec![document(&folder, line)];
    folder.run("-input s.txt -output class/anna/o.tga").ok();
    documents.push(document(&folder, &format!("{line} -tolerance 0.5 1")));
    folder.run("-input s.txt -uv -output class/anna/o.tga").ok();
    documents.push(document(&folder, line));
    documents
}

/// A document of a comparison with a picture in which faces of the cube map are swapped.
fn of_a_cube_map(documents: &mut Vec<Value>) {
    let folder = Folder::with_scene(
        "PerspectiveCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 angle 120 }
        Background { cubeMap sky }
        Lights { numLights 1 PointLight { position 0 0 5 color .5 .5 .5 falloff 1 } }
        Materials { numMaterials 1 Material { shininess 5 } }
        Group { numObjects 1 MaterialIndex 0 Sphere { center 0 0 0 radius 1 } }",
    );
    fs::create_dir(folder.path().join("sky")).expect("a folder");
    let sky = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/editions/sky");
    for face in FACES.map(|face| format!("{face}.png")) {
        fs::copy(sky.join(&face), folder.path().join("sky").join(face)).expect("a copy");
    }
    let swapped =
        Mistake::all().find(|mistake| mistake.name == "cube_faces_swapped").expect("a known mistake");
    let wrong = with_original(&folder, "-size 48 36", |original| original.picture(&[swapped]));
    causes::write(&folder, &wrong.expect("a wrong picture"));
    documents.push(document(&folder, "-input s.txt -size 48 36 -compare a.png"));
}

/// A document of each other kind.
fn of_pictures(documents: &mut Vec<Value>) {
    let folder = Folder::with_scene(GLASS);
    for flags in [
        "-output o.png -depth 3 9 d.tga -normals n.tga -render_samples r.png 3 -render_filter f.png 9 -gui",
        "-cost_map cells c.png -grid 3 4 5 -stats",
        "-cost_map rays c.png -jittered_samples 3 -mitchell_filter 2",
        "-visualize_grid -grid auto -output o.png",
        "-repeat 3",
        "-region 3 4 5 6 -output o.png",
    ] {
        documents.push(document(&folder, &format!("-input s.txt -size 24 18 {flags}")));
    }
    folder.run("-input s.txt -json o.json").ok();
    documents.push(serde_json::from_slice(&folder.read("o.json")).expect("a document"));
}

#[test]
fn every_member_is_documented_and_every_documented_member_exists() {
    let mut documents = vec![];
    of_pixels(&mut documents);
    of_comparisons(&mut documents);
    of_a_cube_map(&mut documents);
    of_pictures(&mut documents);
    of_numbers(&mut documents);
    let form = Form::read();
    let mut findings = Findings::default();
    documents.iter().for_each(|document| form.check("Document", "", document, &mut findings));
    let gradings = of_gradings();
    gradings.iter().for_each(|document| form.check("Document of a grading", "", document, &mut findings));
    let rows =
        form.0.iter().flat_map(|(table, rows)| rows.keys().map(move |path| (*table, path.to_string())));
    let unseen = rows.filter(|row| !findings.seen.contains(row));
    findings.wrong.extend(unseen.map(|(table, path)| format!("{table}: {path} is in no document")));
    assert!(findings.wrong.is_empty(), "{:#?}", findings.wrong);
}

#[test]
fn the_example_is_what_the_program_writes() {
    let (_, example) = DOCS.split_once("\n    raytracer ").expect("a command");
    let (line, shown) = example.split_once("\n\n```json\n").expect("a document");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = Folder::new();
    let scenes = root.join("scenes");
    let words = line.split_whitespace().map(|word| word.replace("scenes", &scenes.to_string_lossy()));
    let run = finish(&mut program(folder.path(), words)).ok();
    let in_json = Value::from(&*scenes.to_string_lossy()).to_string();
    let written = run.stdout.replace(in_json.trim_matches('"'), "scenes");
    let read = |text: &str| {
        let mut document: Value = serde_json::from_str(text).expect("a document");
        for (_, seconds) in document["timings"].as_object_mut().expect("timings") {
            assert!(seconds.as_f64().is_some_and(|seconds| seconds >= 0.0), "{seconds}");
            seconds.take();
        }
        document
    };
    let shown = shown.strip_suffix("\n```\n").expect("the end");
    assert_eq!(read(&written), read(shown), "docs/json.md should show {written}");
}

#[test]
fn the_names_of_all_mistakes_are_listed() {
    let (_, list) = DOCS.split_once("\n## Mistakes\n").expect("a list");
    let items = list.split("\n* `").skip(1).filter_map(|item| item.split("\n\n").next()?.split_once("`: "));
    let listed = items.flat_map(|(kind, names)| {
        let name = |name: &str| name.trim().trim_matches(['`', '.']).to_owned();
        names.split(',').map(move |one| (kind.to_owned(), name(one)))
    });
    let name = |mistake: Mistake| {
        let value = serde_json::to_value(&mistake).expect("a value");
        (mistake.kind().to_owned(), value["name"].as_str().expect("a name").to_owned())
    };
    assert_eq!(listed.collect::<BTreeSet<_>>(), Mistake::all().map(name).collect::<BTreeSet<_>>());
    let page = include_str!("../../docs/check-your-own.md");
    for (kind, name) in Mistake::all().map(name) {
        assert!(page.contains(&format!("\n| {kind} | `{name}` | ")), "{name}");
    }
}
