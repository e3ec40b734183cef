//! Warns about `-bounces`, `-weight` and `-shade_back` without effect on the materials of a scene.

use crate::diagnostic::Diagnostic;
use crate::scene::material::Material;
use crate::scene::model::Highlight;
use crate::scene::{MaterialId, Scene};
use crate::trace::{Effects, Shadows};

/// Warns about `-bounces` and `-weight` that affect no ray, transparent shadows that nothing tints, and `-shade_back`
/// where light from behind is shown anyway. `says_no_bounces` is true for an explicit `-bounces 0`, because the
/// course's commands combine it with `-weight`.
pub fn rays_without_effect(scene: &Scene, effects: &Effects, says_no_bounces: bool) -> Vec<Diagnostic> {
    let Effects { bounces, min_weight, shadows, shade_back } = *effects;
    let heaviest = used(scene).map(|it| it.reflected.max(it.refracted)).fold(0.0, f64::max);
    let of_bounces = match bounces {
        0 if min_weight > 0.0 && !says_no_bounces => {
            Some(format!("`-weight {min_weight}` has no effect without `-bounces`"))
        }
        0 => None,
        _ if heaviest == 0.0 => {
            Some(format!("`-bounces {bounces}` has no effect: no object reflects or transmits light"))
        }
        _ if heaviest <= min_weight => Some(format!(
            "`-bounces {bounces}` has no effect: `-weight {min_weight}` ends all rays that are reflected or transmitted"
        )),
        _ => None,
    };
    let nothing_transmits = used(scene).all(|it| it.refracted == 0.0);
    let of_shadows = (shadows == Shadows::Transparent && nothing_transmits).then(|| {
        "`-transparent_shadows` has no effect beyond that of `-shadows`: no object transmits light".into()
    });
    let of_backs = (shade_back && scene.lighting.highlight == Highlight::Phong).then(|| {
        "`-shade_back` has no effect in this edition: surfaces look the same from both sides".into()
    });
    [of_bounces, of_shadows, of_backs].into_iter().flatten().map(Diagnostic::warning).collect()
}

/// Warns about the first material that reflects or transmits light, if no ray is followed without `-bounces`.
pub fn rays_not_followed(scene: &Scene, effects: &Effects, says_no_bounces: bool) -> Option<Diagnostic> {
    if effects.bounces > 0 || says_no_bounces {
        return None;
    }
    let material = used(scene).find(|it| it.reflected > 0.0 || it.refracted > 0.0)?;
    let way = if material.refracted > 0.0 { "transmits" } else { "reflects" };
    let message = format!("the material {way} light, but without `-bounces` no ray is followed");
    Some(material.warning(scene, message).with_hint("add `-bounces 5`, or `-bounces 0` if that is meant"))
}

/// Warns about the first material that transmits light and is black from inside because `-shade_back` is missing.
pub fn black_inside(scene: &Scene, effects: &Effects) -> Option<Diagnostic> {
    let is_lit_as_outside = effects.shade_back || scene.lighting.highlight == Highlight::Phong;
    if effects.bounces == 0 || is_lit_as_outside {
        return None;
    }
    let material = used(scene).find(|it| it.refracted > effects.min_weight)?;
    let message = "the material transmits light, but without `-shade_back` it is black from inside";
    Some(material.warning(scene, message).with_hint("add `-shade_back`"))
}

/// The secondary rays at a material: the lengths of its reflective and its transparent colour. They multiply the
/// weights of rays.
#[derive(Clone, Copy)]
struct Secondary {
    material: MaterialId,
    reflected: f64,
    refracted: f64,
}

impl Secondary {
    fn warning(&self, scene: &Scene, message: impl Into<String>) -> Diagnostic {
        let at = scene.positions.materials.get(self.material).copied().unwrap_or_default();
        Diagnostic::warning(message).at(at)
    }
}

/// Returns the secondary rays at each material used by an object.
fn used(scene: &Scene) -> impl Iterator<Item = Secondary> {
    let mut all: Vec<Secondary> = Vec::with_capacity(scene.materials.len());
    for (id, material) in scene.materials.iter().enumerate() {
        let [reflected, refracted] = match material {
            Material::Phong(phong) | Material::Painted(phong, _) => {
                [phong.reflective.length(), phong.transparent.length()]
            }
            // A texture comes after the materials that it mixes.
            Material::Texture(texture) => {
                let of =
                    |child: &MaterialId| all.get(*child).map_or([0.0; 2], |it| [it.reflected, it.refracted]);
                let [[a, b], [c, d]] = texture.children.each_ref().map(of);
                [a.max(c), b.max(d)]
            }
        };
        all.push(Secondary { material: id, reflected, refracted });
    }
    let mut is_used = vec![false; all.len()];
    for material in scene.objects.iter().filter_map(|object| object.material()) {
        if let Some(used) = is_used.get_mut(material) {
            *used = true;
        }
    }
    all.into_iter().filter(move |it| is_used[it.material])
}
