//! Transformations multiplied in the opposite order, or rotated by radians.

use crate::math::rounded::RoundedAffine;
use crate::scene::edition::Edition;
use crate::scene::lexer::Lexer;
use crate::scene::parser::read_in;
use crate::scene::transform::is_transformation;
use crate::scene::{Object, ObjectId, Scene};

/// Returns the scene of this text with each list of transformations reversed. `None` if no list has two.
pub fn with_lists_reversed(scene: &Scene, text: &str) -> Option<Scene> {
    let words = words(text);
    let mut rest = words.as_slice();
    let (mut reversed, mut changes) = (Vec::with_capacity(words.len()), false);
    while let Some(&word) = rest.first() {
        let list = split_list(&mut rest);
        changes |= list.len() > 1;
        if list.is_empty() {
            reversed.push(word);
            rest = &rest[1..];
        }
        reversed.extend(list.into_iter().rev().flatten());
    }
    if changes { with_objects_of(scene, &reversed.join(" ")) } else { None }
}

/// Returns `scene` with the objects of a text in which only transformations differ.
fn with_objects_of(scene: &Scene, text: &str) -> Option<Scene> {
    // The objects are the same in every edition that can read the text.
    let reading = Edition::ALL.into_iter().find_map(|edition| read_in(edition, text).ok())?;
    let Scene { objects, root, .. } = reading.scene;
    Some(Scene { objects, root, ..scene.clone() })
}

fn words(text: &str) -> Vec<&str> {
    let mut lexer = Lexer::new(text);
    std::iter::from_fn(|| Some(lexer.next_word()).filter(|word| !word.is_end()))
        .map(|word| word.text)
        .collect()
}

/// Takes the next transformations, each with its values.
fn split_list<'w, 't>(words: &mut &'w [&'t str]) -> Vec<&'w [&'t str]> {
    let mut list = Vec::new();
    while words.first().is_some_and(|word| is_transformation(word)) {
        let (transformation, rest) = words.split_at(1 + values(&words[1..]));
        list.push(transformation);
        *words = rest;
    }
    list
}

/// Returns the number of words in a transformation's values: numbers, or everything up to the closing brace.
fn values(words: &[&str]) -> usize {
    match words.first() {
        Some(&"{") => words.iter().position(|&word| word == "}").map_or(words.len(), |end| end + 1),
        _ => words.iter().take_while(|word| word.parse::<f64>().is_ok()).count(),
    }
}

/// Returns the scene of this text with rotation angles read as radians. `None` if nothing is rotated.
pub fn in_radians(scene: &Scene, text: &str) -> Option<Scene> {
    let mut words: Vec<String> = words(text).into_iter().map(str::to_owned).collect();
    let mut changes = false;
    for at in 0..words.len() {
        let number = match words[at].as_str() {
            "XRotate" | "YRotate" | "ZRotate" => 0,
            // The axis precedes the angle.
            "Rotate" => 3,
            _ => continue,
        };
        let first = at + 1 + usize::from(words.get(at + 1).is_some_and(|word| word == "{"));
        let Some(angle) = words.get_mut(first + number) else { continue };
        let Ok(radians) = angle.parse::<f64>() else { continue };
        *angle = radians.to_degrees().to_string();
        changes |= radians != 0.0;
    }
    if changes { with_objects_of(scene, &words.join(" ")) } else { None }
}

/// Returns the scene with nested transforms multiplied from the innermost to the outermost. `None` if none are nested.
pub fn with_nesting_reversed(scene: &Scene) -> Option<Scene> {
    let mut objects = Vec::new();
    let (mut children, mut is_nested) = (Vec::new(), false);
    let mut stack: Vec<(ObjectId, Option<RoundedAffine>)> = vec![(scene.root, None)];
    while let Some((id, outer)) = stack.pop() {
        match &scene.objects[id] {
            Object::Group(members) => stack.extend(members.iter().rev().map(|&member| (member, outer))),
            Object::Transform { matrix, child, .. } => {
                is_nested |= outer.is_some();
                stack.push((*child, Some(outer.map_or(*matrix, |outer| *matrix * outer))));
            }
            leaf => {
                objects.push(leaf.clone());
                let child = objects.len() - 1;
                objects.extend(outer.map(|matrix| Object::Transform {
                    matrix,
                    child,
                    at: Default::default(),
                }));
                children.push(objects.len() - 1);
            }
        }
    }
    objects.push(Object::Group(children));
    let root = objects.len() - 1;
    is_nested.then(|| Scene { objects, root, ..scene.clone() })
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
            let found = with_lists_reversed(&right, &list).unwrap();
            assert_eq!(matrix(&found), matrix(&parse(&reversed).unwrap()), "{list}");
            assert_ne!(matrix(&found), matrix(&right), "{list}");
        }
        let single = scene(&format!("Transform {{ Scale 1 2 3 {SPHERE} }}"));
        assert!(with_lists_reversed(&parse(&single).unwrap(), &single).is_none());
    }

    #[test]
    fn nested_transforms_change_their_order() {
        let nested = |outer: &str, inner: &str| {
            let inner = format!("Group {{ numObjects 1 Transform {{ {inner} {SPHERE} }} }}");
            parse(&scene(&format!("Transform {{ {outer} {inner} }}"))).unwrap()
        };
        let found = with_nesting_reversed(&nested("Translate 1 2 3", "Scale 1 2 3")).unwrap();
        assert_eq!(matrix(&found), matrix(&nested("Scale 1 2 3", "Translate 1 2 3")));
        assert!(with_nesting_reversed(&parse(&scene(SPHERE)).unwrap()).is_none());
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
            let found = in_radians(&parse(&scene(text)).unwrap(), &scene(text)).unwrap();
            let matrix = matrix(&found).matrix3;
            assert!(
                (matrix - expected).to_cols_array().iter().all(|rest| rest.abs() < 1e-12),
                "{text} {matrix}"
            );
        }
        let still = scene("Translate 1 2 3");
        assert!(in_radians(&parse(&still).unwrap(), &still).is_none());
    }
}
