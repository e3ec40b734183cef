//! Reads materials.

use super::edition::Edition;
use super::material::{Material, Paint, Pattern, Phong, Texture};
use super::reader::{Parsed, Reader};
use super::transform::{Factor, TRANSFORMATIONS, Transformations, parse_transformations};
use super::{MaterialId, Position};
use crate::diagnostic::Diagnostic;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::math::rounded::RoundedAffine;
use crate::picture::Color;
use glam::{DAffine3, DMat3, DVec3};

/// The keywords that start a Phong material. They are synonyms.
pub const PHONG_KINDS: [&str; 2] = ["Material", "PhongMaterial"];
const KINDS: [&str; 6] = ["PhongMaterial", "Material", "Checkerboard", "Noise", "Marble", "Wood"];

/// The fields of Phong materials in all editions. `Noise` is a field only in assignment 5 of 2012.
const PHONG_FIELDS: [&str; 13] = [
    "diffuseColor",
    "specularColor",
    "exponent",
    "shininess",
    "reflectiveColor",
    "transparentColor",
    "indexOfRefraction",
    "texture",
    "mipmap",
    "linearInterpolation",
    "refractionIndex",
    "bump",
    "Noise",
];

/// The largest number of octaves. Each octave halves the amplitude, so a further one is below the rounding error.
const MAX_OCTAVES: u64 = 64;

/// Reads a whole `Materials { ... }` block. Returns each material with the position of its keyword.
pub fn parse_materials(reader: &mut Reader<'_>) -> Parsed<Vec<(Material, Position)>> {
    let kinds = if reader.edition.is_later() { &PHONG_KINDS[..] } else { &KINDS };
    reader.list("numMaterials", &KINDS, |reader, index| {
        if reader.is_at_any(&PHONG_KINDS) {
            parse_phong(reader)
        } else if reader.is_at_any(kinds) {
            Ok(Material::Texture(parse_texture(reader, index)?))
        } else {
            Err(reader.unexpected("a material", kinds))
        }
    })
}

/// Reads a Phong material with its keyword and braces. Its fields may come in any order.
///
/// From 2012 on, the specular colour is also the factor for mirrored rays. Assignment 5 of 2012 has no highlights, and
/// its materials with an index of refraction use the same colour for refracted rays.
pub fn parse_phong(reader: &mut Reader<'_>) -> Parsed<Material> {
    let edition = reader.edition;
    let mut phong = Phong::default();
    if edition.is_later() {
        phong.exponent = 0.0;
    }
    let (mut image, mut noise, mut refraction_index) = (None, None, 0.0);
    reader.block(|reader, name| {
        let expected = format!("a field of `{name}` or `}}`");
        let count = PHONG_FIELDS.len() - usize::from(edition != Edition::Y2012A5);
        reader.fields(&expected, &PHONG_FIELDS[..count], |reader, field| {
            match field {
                "diffuseColor" => phong.diffuse = reader.shown_color()?,
                "specularColor" => phong.specular = reader.shown_color()?,
                "reflectiveColor" => phong.reflective = reader.shown_color()?,
                "transparentColor" => phong.transparent = reader.shown_color()?,
                "exponent" | "shininess" => phong.exponent = reader.nonnegative()?,
                "indexOfRefraction" => phong.index_of_refraction = reader.positive()?,
                "refractionIndex" => refraction_index = reader.nonnegative()?,
                "mipmap" | "linearInterpolation" => {}
                "Noise" => noise = Some(parse_noise(reader)?),
                "texture" if edition != Edition::Aalto => {
                    let file = reader.file_name()?;
                    let tints_ambient = edition == Edition::Y2012A4;
                    let image_index = reader.images.index(file.text.to_owned(), file.at);
                    image = Some(Paint::Image { image: image_index, tints_ambient });
                }
                // As in the course's programs, bump maps have no effect. Textures have none on Aalto's triangles, which
                // have no texture coordinates.
                _ => {
                    let name = reader.file_name()?.text.to_owned();
                    reader.unread.push(("texture", name));
                }
            }
            Ok(())
        })
    })?;
    if edition.is_later() {
        phong.reflective = phong.specular;
    }
    if edition == Edition::Y2012A5 {
        // The exponent is kept for the bug that shows highlights anyway.
        phong.specular = Color::ZERO;
        if refraction_index > 0.0 {
            (phong.transparent, phong.index_of_refraction) = (phong.reflective, refraction_index);
        }
    }
    // As in the course's program, noise replaces the colour of a texture, regardless of their order.
    Ok(noise.or(image).map_or(Material::Phong(phong), |paint| Material::Painted(phong, paint)))
}

/// Reads the noise in a material of assignment 5 of 2012. Its fields may come in any order.
fn parse_noise(reader: &mut Reader<'_>) -> Parsed<Paint> {
    let (mut colors, mut octaves, mut frequency, mut amplitude) = (vec![], 0, 1.0, 1.0);
    reader.open_brace("Noise")?;
    let fields = ["color", "octaves", "frequency", "amplitude"];
    reader.fields("a field of `Noise` or `}`", &fields, |reader, field| {
        match field {
            "color" => colors.push(reader.shown_color()?),
            "octaves" => octaves = parse_octaves(reader)?,
            "frequency" => frequency = reader.number()?,
            _ => amplitude = reader.number()?,
        }
        Ok(())
    })?;
    let &[one, other] = colors.as_slice() else { return Err(reader.unexpected("two colours in all", &[])) };
    reader.close("Noise")?;
    Ok(Paint::Pattern(Pattern::Marble { octaves, frequency, amplitude }, [one, other]))
}

/// Reads the texture whose index is `own`.
fn parse_texture(reader: &mut Reader<'_>, own: MaterialId) -> Parsed<Texture> {
    reader.block(|reader, name| {
        let Transformations { factors, matrix } = parse_texture_map(reader)?;
        let children = [parse_child(reader, own)?, parse_child(reader, own)?];
        if name == "Checkerboard" {
            let at = reader.peek().at;
            let scale = parse_square_size(reader)?;
            let world_to_texture = scale * matrix;
            if !world_to_texture.is_finite() {
                return Err(Diagnostic::error("the squares are too small after the transformation").at(at));
            }
            let factors = [&factors[..], &[Factor::Matrix(scale.map)]].concat().into();
            return Ok(Texture { pattern: Pattern::Checkerboard, world_to_texture, factors, children });
        }
        let world_to_texture = matrix;
        let octaves = parse_octaves(reader.keyword("octaves")?)?;
        if name == "Noise" {
            return Ok(Texture { pattern: Pattern::Noise { octaves }, world_to_texture, factors, children });
        }
        let frequency = reader.keyword("frequency")?.number()?;
        let amplitude = reader.keyword("amplitude")?.number()?;
        let pattern = match name {
            "Marble" => Pattern::Marble { octaves, frequency, amplitude },
            _ => Pattern::Wood { octaves, frequency, amplitude },
        };
        Ok(Texture { pattern, world_to_texture, factors, children })
    })
}

/// Reads the optional `Transform` of a texture. It maps world space to texture space as written, without inversion.
fn parse_texture_map(reader: &mut Reader<'_>) -> Parsed<Transformations> {
    if !reader.is_at("Transform") {
        return Ok(Transformations { factors: Box::default(), matrix: RoundedAffine::IDENTITY });
    }
    reader.block(|reader, _| {
        let map = parse_transformations(reader)?;
        let is_at_end = reader.is_at("}");
        if is_at_end { Ok(map) } else { Err(reader.unexpected("a transformation or `}`", &TRANSFORMATIONS)) }
    })
}

/// Reads one `materialIndex` of the texture whose index is `own`.
fn parse_child(reader: &mut Reader<'_>, own: MaterialId) -> Parsed<MaterialId> {
    let at = reader.keyword("materialIndex")?.peek().at;
    let index = reader.whole()?;
    let earlier = usize::try_from(index).ok().filter(|&index| index < own);
    earlier.ok_or_else(|| {
        let message = format!("texture {own} may mix only materials before it, found index {index}");
        Diagnostic::error(message).at(at)
    })
}

/// Reads the optional `size` of a checkerboard's squares (2003 edition). Returns the scale that maps such squares to
/// unit squares.
fn parse_square_size(reader: &mut Reader<'_>) -> Parsed<RoundedAffine> {
    if !reader.accept("size") {
        return Ok(RoundedAffine::IDENTITY);
    }
    // The reciprocal of a very small number overflows, so it is checked as well.
    let size = reader.number_that("must be positive", |size| size > 0.0 && (1.0 / size).is_finite())?;
    let scale = DVec3::splat(1.0 / size);
    let error = DAffine3::from_mat3(DMat3::from_diagonal(scale * UNIT_ROUNDOFF));
    Ok(RoundedAffine { error, ..DAffine3::from_scale(scale).into() })
}

fn parse_octaves(reader: &mut Reader<'_>) -> Parsed<u32> {
    let word = reader.peek();
    match reader.whole()? {
        octaves @ 0..=MAX_OCTAVES => Ok(octaves as u32),
        _ => Err(reader.bad_value(word, "must be at most 64")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::patience::Endless;

    fn read(text: &str) -> Vec<Material> {
        let materials = parse_materials(&mut Reader::new(Edition::Y2004, text, &Endless)).unwrap();
        materials.into_iter().map(|(material, _)| material).collect()
    }

    #[test]
    fn an_empty_material_has_the_defaults() {
        let defaults = Material::Phong(Phong::default());
        assert_eq!(
            read("Materials { numMaterials 2 Material { } PhongMaterial { } }"),
            [defaults.clone(), defaults]
        );
        assert_eq!(read("Materials { numMaterials 0 }"), []);
    }

    #[test]
    fn fields_come_in_any_order_and_spelling() {
        let text =
            "Materials { num_materials 1 Material { index_of_refraction 1.5 exponent 3 transparentColor 1 2 3
            reflectiveColor 4 5 6 specular_color 7 8 9 diffuseColor .1 .2 .3 exponent 4 } }";
        let expected = Phong {
            diffuse: DVec3::new(0.1, 0.2, 0.3),
            specular: DVec3::new(7.0, 8.0, 9.0),
            exponent: 4.0,
            reflective: DVec3::new(4.0, 5.0, 6.0),
            transparent: DVec3::new(1.0, 2.0, 3.0),
            index_of_refraction: 1.5,
        };
        assert_eq!(read(text), [Material::Phong(expected)]);
    }

    #[test]
    fn a_checkerboard_with_a_size_has_squares_of_that_size() {
        let text = "Materials { numMaterials 2 Material { }
            Checkerboard { Transform { Translate 1 0 0 } materialIndex 0 materialIndex 0 size .5 } }";
        let Material::Texture(texture) = &read(text)[1] else { panic!("not a texture") };
        assert_eq!(texture.world_to_texture.map.transform_point3(DVec3::ONE), DVec3::new(4.0, 2.0, 2.0));
    }
}
