//! Transformations that are combined in wrong ways.

use crate::math::rounded::RoundedAffine;
use crate::scene::material::Material;
use crate::scene::transform::Factor;
use crate::scene::{Object, ObjectId, Scene};

/// Changes each list of transformations, of objects and of textures.
fn each_list(scene: &mut Scene, change: impl Fn(&mut [Factor])) {
    let apply = |factors: &mut [Factor], matrix: &mut RoundedAffine| {
        let before = factors.to_vec();
        change(factors);
        if *factors != before[..] {
            *matrix = factors.iter().fold(RoundedAffine::IDENTITY, |product, factor| factor.after(product));
        }
    };
    for object in &mut scene.objects {
        if let Object::Transform { matrix, factors, .. } = object {
            apply(factors, matrix);
        }
    }
    for material in &mut scene.materials {
        if let Material::Texture(texture) = material {
            apply(&mut texture.factors, &mut texture.world_to_texture);
        }
    }
}

/// Multiplies the transformations of each list in the other order.
pub fn reverse_lists(scene: &mut Scene) {
    each_list(scene, <[_]>::reverse);
}

/// Changes the angles of rotations, in degrees.
pub fn each_rotation(scene: &mut Scene, change: fn(f64) -> f64) {
    let turned = |factor: Factor| match factor {
        Factor::Rotation { axis, degrees } => Factor::Rotation { axis, degrees: change(degrees) },
        other => other,
    };
    each_list(scene, |factors| factors.iter_mut().for_each(|factor| *factor = turned(*factor)));
}

/// Combines nested transforms by `combine`, which is given the product of the outer ones and the next inner one.
pub fn combine_nested(scene: &mut Scene, combine: fn(RoundedAffine, RoundedAffine) -> RoundedAffine) {
    let (mut objects, mut children) = (Vec::new(), Vec::new());
    let mut stack: Vec<(ObjectId, Option<RoundedAffine>)> = vec![(scene.root, None)];
    let mut is_nested = false;
    while let Some((id, outer)) = stack.pop() {
        match &scene.objects[id] {
            Object::Group(members) => stack.extend(members.iter().rev().map(|&member| (member, outer))),
            Object::Transform { matrix, child, .. } => {
                is_nested |= outer.is_some();
                stack.push((*child, Some(outer.map_or(*matrix, |outer| combine(outer, *matrix)))));
            }
            leaf => {
                objects.push(leaf.clone());
                let (child, at, factors) = (objects.len() - 1, Default::default(), Default::default());
                objects.extend(outer.map(|matrix| Object::Transform { matrix, factors, child, at }));
                children.push(objects.len() - 1);
            }
        }
    }
    objects.push(Object::Group(children));
    if is_nested {
        (scene.root, scene.objects) = (objects.len() - 1, objects);
    }
}

/// Transposes the matrices of all transforms, as if rows were columns.
pub fn transpose_matrices(scene: &mut Scene) {
    for object in &mut scene.objects {
        if let Object::Transform { matrix, .. } = object {
            matrix.map.matrix3 = matrix.map.matrix3.transpose();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parser::parse;
    use crate::world::placements;
    use glam::{DAffine3, DMat3};

    fn scene(objects: &str) -> Scene {
        parse(&format!(
            "OrthographicCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 0 size 4 }}
             Materials {{ numMaterials 1 Material {{ }} }}
             Group {{ numObjects 1 MaterialIndex 0 {objects} }}"
        ))
        .unwrap()
    }

    fn matrix(scene: &Scene) -> DAffine3 {
        placements(scene).next().unwrap().matrix
    }

    fn changed(mut scene: Scene, change: impl FnOnce(&mut Scene)) -> DAffine3 {
        change(&mut scene);
        matrix(&scene)
    }

    const SPHERE: &str = "Sphere { center 0 0 0 radius 1 }";

    #[test]
    fn nested_transforms_are_combined_otherwise() {
        let nested = |outer: &str, inner: &str| {
            let inner = format!("Group {{ numObjects 1 Transform {{ {inner} {SPHERE} }} }}");
            scene(&format!("Transform {{ {outer} {inner} }}"))
        };
        let right = || nested("Translate 1 2 3", "Scale 1 2 3");
        let reversed = changed(right(), |scene| combine_nested(scene, |outer, inner| inner * outer));
        assert_eq!(reversed, matrix(&nested("Scale 1 2 3", "Translate 1 2 3")));
        let innermost = changed(right(), |scene| combine_nested(scene, |_, inner| inner));
        assert_eq!(innermost, DAffine3::from_scale(glam::DVec3::new(1.0, 2.0, 3.0)));
    }

    #[test]
    fn every_kind_of_rotation_is_by_radians() {
        for (text, expected) in [
            ("XRotate 0.5", DMat3::from_rotation_x(0.5)),
            ("YRotate { -30 } # degrees\n", DMat3::from_rotation_y(-30.0)),
            ("ZRotate 7e-1", DMat3::from_rotation_z(0.7)),
            ("Rotate { 0 0 1 1.25 }", DMat3::from_rotation_z(1.25)),
        ] {
            let list = scene(&format!("Transform {{ {text} {SPHERE} }}"));
            let found = changed(list, |scene| each_rotation(scene, f64::to_degrees)).matrix3;
            assert!((found - expected).to_cols_array().iter().all(|rest| rest.abs() < 1e-12), "{text}");
        }
    }
}
