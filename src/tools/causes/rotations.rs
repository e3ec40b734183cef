//! Rotations with angles in radians.

use super::transform_order::{with_objects_of, words};
use crate::scene::Scene;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parser::parse;
    use crate::world::placements;
    use glam::DMat3;

    #[test]
    fn every_kind_of_rotation_is_by_radians() {
        let scene = |transformation: &str| {
            format!(
                "OrthographicCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 0 size 4 }}
                 Materials {{ numMaterials 1 Material {{ }} }}
                 Group {{ numObjects 1 MaterialIndex 0
                    Transform {{ {transformation} Sphere {{ center 0 0 0 radius 1 }} }} }}"
            )
        };
        for (text, expected) in [
            ("XRotate 0.5", DMat3::from_rotation_x(0.5)),
            ("YRotate { -30 } # degrees\n", DMat3::from_rotation_y(-30.0)),
            ("ZRotate 7e-1", DMat3::from_rotation_z(0.7)),
            ("Rotate { 0 0 1 1.25 }", DMat3::from_rotation_z(1.25)),
        ] {
            let found = in_radians(&parse(&scene(text)).unwrap(), &scene(text)).unwrap();
            let matrix = placements(&found).next().unwrap().matrix.matrix3;
            assert!(
                (matrix - expected).to_cols_array().iter().all(|rest| rest.abs() < 1e-12),
                "{text} {matrix}"
            );
        }
        let still = scene("Translate 1 2 3");
        assert!(in_radians(&parse(&still).unwrap(), &still).is_none());
    }
}
