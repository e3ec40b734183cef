//! Every keyword of a scene is in the grammar, in the fuzzer's lists and, if it is a material, in the JSON document.
//!
//! The keywords come from the program: an unknown word is an error that lists the possible ones.

use crate::support::Folder;

const GRAMMAR: &str = include_str!("../../docs/scene.md");
const JSON: &str = include_str!("../../docs/json.md");
const FUZZ_DICTIONARY: &str = include_str!("../../fuzz/scene.dict");
const FUZZ_TARGET: &str = include_str!("../../fuzz/fuzz_targets/scene_text.rs");

/// Returns the words that the program accepts in place of `Unknown` in a scene.
fn possible_words(scene: &str) -> Vec<String> {
    let folder = Folder::new();
    folder.write("s.txt", scene);
    let message = folder.run("-input s.txt").message(1);
    let (_, words) = message.split_once("possible here: ").expect("a list of words");
    words.trim().split(", ").map(str::to_owned).collect()
}

#[test]
fn every_keyword_is_documented_and_fuzzed() {
    let materials = possible_words("Materials { numMaterials 1 Unknown { } }");
    let scenes =
        ["Unknown { }", "Lights { numLights 1 Unknown { } }", "Group { numObjects 1 Transform { Unknown"];
    let others = scenes.into_iter().flat_map(possible_words);
    let mut count = 0;
    for word in others.chain(materials.iter().cloned()) {
        let mut documented = GRAMMAR.split(|c: char| !c.is_alphanumeric());
        assert!(documented.any(|other| other == word), "docs/scene.md lacks {word}");
        let quoted = format!("\"{word}\"");
        assert!(FUZZ_DICTIONARY.contains(&quoted), "fuzz/scene.dict lacks {word}");
        assert!(FUZZ_TARGET.contains(&quoted), "fuzz/fuzz_targets/scene_text.rs lacks {word}");
        count += 1;
    }
    assert!(count > 25, "{count}");
    for texture in materials.iter().filter(|word| !word.ends_with("Material")) {
        let member = format!("`materials.{}`", texture.to_lowercase());
        assert!(JSON.contains(&member), "docs/json.md lacks {member}");
    }
}
