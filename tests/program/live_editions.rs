//! The live page's choice of edition: what is painted is what the shown command line writes.

use crate::live_server::{Server, view};
use crate::support::Folder;
use serde_json::{Value, json};

/// A sphere that mirrors, in the language of 2012 and later, with these words in its light.
fn scene(light: &str) -> String {
    format!(
        "PerspectiveCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 .3 angle 40 }}
        Background {{ color .2 .3 .4 ambientLight .1 .1 .1 }}
        Lights {{ numLights 1 PointLight {{ position 3 3 5 color 1 1 1 {light} }} }}
        Materials {{ numMaterials 1 Material {{ diffuseColor .5 .4 .3 specularColor .6 .6 .6 shininess 9 }} }}
        Group {{ numObjects 2 MaterialIndex 0 Sphere {{ center 0 0 0 radius 1 }} Plane {{ normal 0 1 0 offset -1 }} }}\n"
    )
}

/// What the page is told of a text that is opened with these flags.
fn opened(server: &Server, text: &str, words: &str) -> Value {
    let words: Vec<&str> = words.split_whitespace().collect();
    let (meta, _) = server.ask("/scene", &json!({ "text": text, "words": words })).expect("an answer");
    meta["scene"].clone()
}

#[test]
fn a_picture_of_each_edition_is_the_one_of_its_command_line() {
    let text = scene("falloff .02");
    let folder = Folder::with_scene(&text);
    let server = Server::start(folder.path(), "-output o.tga");
    for words in [
        "",
        "-edition 2012a5",
        "-edition 2012a5 -bounces 1",
        "-jitter",
        "-filter",
        "-edition 2019 -jitter -filter -shadows",
    ] {
        let words = format!("-size 30 18 {words}");
        let revision = opened(&server, &text, &words)["revision"].as_u64().expect("a scene");
        let question = json!({ "view": view(revision, &words) });
        let (meta, bytes) = server.ask("/picture", &question).expect("a picture");
        let line = meta["command"].as_str().and_then(|line| line.strip_prefix("raytracer ")).expect("a line");
        // Nothing is left to be said of the edition.
        assert_eq!(folder.run(line).ok().stderr, "", "{line}");
        let pixels: Vec<[u8; 3]> = bytes.chunks(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        let written = folder.tga("o.tga");
        assert_eq!(written.pixels, pixels, "{line}");
        assert_eq!(meta["shows"], json!([written.width, written.height]), "{line}");
    }
}

#[test]
fn the_page_is_told_which_edition_is_taken_and_what_goes_without_a_flag() {
    let text = scene("falloff .02");
    let folder = Folder::with_scene(&text);
    let server = Server::start(folder.path(), "");
    for (text, words, edition, note, bounces) in [
        (&text, "", "2019", "because of `shininess` with `falloff`", 0),
        (&text, "-edition 2012a5", "2012a5", "", 4),
        (&text, "-jitter -filter", "2012a5", "", 4),
        (&scene(""), "", "2012a4", "because of `shininess`", 0),
    ] {
        let scene = opened(&server, text, words);
        assert_eq!((&scene["edition"], &scene["defaults"]["bounces"]), (&json!(edition), &json!(bounces)));
        let said = scene["note"].as_str().unwrap_or_default();
        assert!(said.contains(note) && said.is_empty() == note.is_empty(), "{words}: {said}");
    }
    let said =
        server.ask("/scene", &json!({ "text": text, "words": ["-edition", "2004"] })).expect("an error");
    assert!(said.0["error"]["hint"].as_str().is_some_and(|hint| hint.contains("`-edition 2019`")));
    let (status, why) =
        server.ask("/scene", &json!({ "text": text, "words": ["-edition", "2005"] })).unwrap_err();
    assert!(status == 422 && why.contains("2004, 2012a4, 2012a5, 2019, aalto"), "{status} {why}");
}

#[test]
fn flags_of_one_edition_show_no_scene_of_another() {
    let folder = Folder::with_scene(&scene("falloff .02"));
    let server = Server::start(folder.path(), "-edition 2012a5");
    let painted = |words: &str| {
        let question = json!({ "view": view(0, words) });
        server.ask("/picture", &question).map(|_| ()).map_err(|(status, _)| status)
    };
    assert_eq!(painted("-size 9 9 -edition 2012a5"), Ok(()));
    assert_eq!(painted("-size 9 9 -edition 2019"), Err(410));
    assert_eq!(painted("-size 9 9"), Err(410));
    assert_eq!(painted("-size 9 9 -edition 2004 -jitter"), Err(422));
}
