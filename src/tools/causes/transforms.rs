//! Transformations multiplied in the opposite order, or rotated by radians.

use crate::math::rounded::RoundedAffine;
use crate::scene::edition::Edition;
use crate::scene::lexer::Lexer;
use crate::scene::parser::read_in;
use crate::scene::transform::is_transformation;
use crate::scene::{Object, ObjectId, Scene};

/// Reverses each list of transformations in the scene of this text.
pub fn reverse_lists(scene: &mut Scene, text: &str) {
    let mut phrases = phrases(text);
    let is_list =
        |one: &Vec<String>, next: &Vec<String>| is_transformation(&one[0]) && is_transformation(&next[0]);
    phrases.chunk_by_mut(is_list).for_each(<[_]>::reverse);
    read_objects(scene, text, &phrases);
}

/// Reads the angles of rotations in the scene of this text as radians.
pub fn read_in_radians(scene: &mut Scene, text: &str) {
    let mut phrases = phrases(text);
    for phrase in phrases.iter_mut().filter(|phrase| phrase[0].ends_with("Rotate")) {
        // The angle is the last number. An axis precedes it.
        let numbers = phrase.iter_mut().filter_map(|word| Some((word.parse::<f64>().ok()?, word)));
        if let Some((radians, word)) = numbers.last() {
            *word = radians.to_degrees().to_string();
        }
    }
    read_objects(scene, text, &phrases);
}

/// Returns the words of a text. The words of each transformation and its values form one phrase.
fn phrases(text: &str) -> Vec<Vec<String>> {
    let mut lexer = Lexer::new(text);
    let words = std::iter::from_fn(|| Some(lexer.next_word()).filter(|word| !word.is_end()));
    let words: Vec<&str> = words.map(|word| word.text).collect();
    let (mut rest, mut phrases) = (words.as_slice(), vec![]);
    while let [first, values @ ..] = rest {
        let length = if is_transformation(first) { 1 + count_values(values) } else { 1 };
        phrases.push(rest[..length].iter().map(|&word| word.to_owned()).collect());
        rest = &rest[length..];
    }
    phrases
}

/// Returns the number of words in a transformation's values: numbers, or everything up to the closing brace.
fn count_values(words: &[&str]) -> usize {
    match words.first() {
        Some(&"{") => words.iter().position(|&word| word == "}").map_or(words.len(), |end| end + 1),
        _ => words.iter().take_while(|word| word.parse::<f64>().is_ok()).count(),
    }
}

/// Replaces the scene's objects by the objects of its text with changed phrases. Only transformations differ.
fn read_objects(scene: &mut Scene, text: &str, changed: &[Vec<String>]) {
    if phrases(text) == changed {
        return;
    }
    let text = changed.concat().join(" ");
    // The objects are the same in every edition that can read the text.
    if let Some(reading) = Edition::ALL.into_iter().find_map(|edition| read_in(edition, &text).ok()) {
        (scene.objects, scene.root) = (reading.scene.objects, reading.scene.root);
    }
}

/// Multiplies nested transforms from the innermost to the outermost.
pub fn reverse_nesting(scene: &mut Scene) {
    let (mut objects, mut children) = (Vec::new(), Vec::new());
    let mut stack: Vec<(ObjectId, Option<RoundedAffine>)> = vec![(scene.root, None)];
    let mut is_nested = false;
    while let Some((id, outer)) = stack.pop() {
        match &scene.objects[id] {
            Object::Group(members) => stack.extend(members.iter().rev().map(|&member| (member, outer))),
            Object::Transform { matrix, child, .. } => {
                is_nested |= outer.is_some();
                stack.push((*child, Some(outer.map_or(*matrix, |outer| *matrix * outer))));
            }
            leaf => {
                objects.push(leaf.clone());
                let (child, at) = (objects.len() - 1, Default::default());
                objects.extend(outer.map(|matrix| Object::Transform { matrix, child, at }));
                children.push(objects.len() - 1);
            }
        }
    }
    objects.push(Object::Group(children));
    if is_nested {
        (scene.root, scene.objects) = (objects.len() - 1, objects);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parser::parse;
    use crate::world::placements;
    use glam::{DAffine3, DMat3};

    fn scene(objects: &str) -> String {
        format!(
            "OrthographicCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 0 size 4 }}
             Materials {{ numMaterials 1 Material {{ }} }}
             Group {{ numObjects 1 MaterialIndex 0 {objects} }}"
        )
    }

    fn matrix(scene: &Scene) -> DAffine3 {
        placements(scene).next().unwrap().matrix
    }

    fn changed(scene: &Scene, change: impl FnOnce(&mut Scene)) -> Scene {
        let mut scene = scene.clone();
        change(&mut scene);
        scene
    }

    const SPHERE: &str = "Sphere { center 0 0 0 radius 1 }";

    #[test]
    fn the_transformations_of_a_list_change_their_order() {
        let pairs = [
            ("Translate 1 2 3 XRotate { 90 } Scale 1 2 -.5", "Scale 1 2 -.5 XRotate { 90 } Translate 1 2 3"),
            ("Rotate { 0 1 0 30 } # a\n Scale 2 1 1", "Scale 2 1 1 Rotate { 0 1 0 30 }"),
        ];
        for (list, reversed) in pairs {
            let [list, reversed] =
                [list, reversed].map(|list| scene(&format!("Transform {{ {list} {SPHERE} }}")));
            let right = parse(&list).unwrap();
            let found = changed(&right, |scene| reverse_lists(scene, &list));
            assert_eq!(matrix(&found), matrix(&parse(&reversed).unwrap()), "{list}");
            assert_ne!(matrix(&found), matrix(&right), "{list}");
        }
        let single = scene(&format!("Transform {{ Scale 1 2 3 {SPHERE} }}"));
        let right = parse(&single).unwrap();
        assert_eq!(matrix(&changed(&right, |scene| reverse_lists(scene, &single))), matrix(&right));
    }

    #[test]
    fn nested_transforms_change_their_order() {
        let nested = |outer: &str, inner: &str| {
            let inner = format!("Group {{ numObjects 1 Transform {{ {inner} {SPHERE} }} }}");
            parse(&scene(&format!("Transform {{ {outer} {inner} }}"))).unwrap()
        };
        let found = changed(&nested("Translate 1 2 3", "Scale 1 2 3"), reverse_nesting);
        assert_eq!(matrix(&found), matrix(&nested("Scale 1 2 3", "Translate 1 2 3")));
    }

    #[test]
    fn every_kind_of_rotation_is_by_radians() {
        let scene = |transformation: &str| scene(&format!("Transform {{ {transformation} {SPHERE} }}"));
        for (text, expected) in [
            ("XRotate 0.5", DMat3::from_rotation_x(0.5)),
            ("YRotate { -30 } # degrees\n", DMat3::from_rotation_y(-30.0)),
            ("ZRotate 7e-1", DMat3::from_rotation_z(0.7)),
            ("Rotate { 0 0 1 1.25 }", DMat3::from_rotation_z(1.25)),
        ] {
            let found = changed(&parse(&scene(text)).unwrap(), |it| read_in_radians(it, &scene(text)));
            let matrix = matrix(&found).matrix3;
            assert!(
                (matrix - expected).to_cols_array().iter().all(|rest| rest.abs() < 1e-12),
                "{text} {matrix}"
            );
        }
        let still = scene("Translate 1 2 3");
        let right = parse(&still).unwrap();
        assert_eq!(matrix(&changed(&right, |scene| read_in_radians(scene, &still))), matrix(&right));
    }
}
