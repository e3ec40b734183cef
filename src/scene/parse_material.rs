//! Reads materials.

use super::edition::Edition;
use super::list::counted_list;
use super::material::{Material, Paint, Pattern, Phong, Texture};
use super::reader::{Parsed, Reader, bad_value};
use super::transform::{TRANSFORMATIONS, parse_transformations};
use super::{MaterialId, Position};
use crate::diagnostic::Diagnostic;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::math::rounded::RoundedAffine;
use glam::{DAffine3, DMat3, DVec3};

/// The keywords that start a Phong material. They have the same meaning.
pub const PHONG_KINDS: [&str; 2] = ["Material", "PhongMaterial"];
const KINDS: [&str; 6] = ["PhongMaterial", "Material", "Checkerboard", "Noise", "Marble", "Wood"];

const PHONG_FIELDS: [&str; 9] = [
    "diffuseColor",
    "specularColor",
    "exponent",
    "reflectiveColor",
    "transparentColor",
    "indexOfRefraction",
    // Those of Aalto alone.
    "texture",
    "mipmap",
    "linearInterpolation",
];
/// How many of them there are elsewhere.
const USUAL_FIELDS: usize = 6;

/// The largest number of octaves. Each one halves the amplitude, so a further octave is below the rounding
/// error.
const MAX_OCTAVES: u64 = 64;

/// Reads a whole `Materials { ... }` block: each material with the position of its keyword.
pub fn parse_materials(reader: &mut Reader<'_>) -> Parsed<Vec<(Material, Position)>> {
    let name = reader.open()?.text;
    counted_list(reader, name, "numMaterials", &KINDS, |reader, earlier: &[_]| {
        let at = reader.peek().at;
        Ok((parse_material(reader, earlier.len())?, at))
    })
}

/// Reads the material whose index is `own`.
fn parse_material(reader: &mut Reader<'_>, own: MaterialId) -> Parsed<Material> {
    if reader.is_at_any(&PHONG_KINDS) {
        return parse_phong(reader);
    }
    let kinds = if reader.edition.is_later() { &PHONG_KINDS[..] } else { &KINDS };
    if !reader.is_at_any(kinds) {
        return Err(reader.unexpected("a material", kinds));
    }
    Ok(Material::Texture(parse_texture(reader, own)?))
}

/// Reads a Phong material with its keyword and braces. The fields may come in any order, and a repeated field
/// replaces the earlier one.
pub fn parse_phong(reader: &mut Reader<'_>) -> Parsed<Material> {
    if reader.edition.is_later() {
        return parse_later_phong(reader);
    }
    let name = reader.open()?.text;
    let mut phong = Phong::default();
    let fields =
        if reader.edition == Edition::Aalto { &PHONG_FIELDS[..] } else { &PHONG_FIELDS[..USUAL_FIELDS] };
    while let Some(field) = fields.iter().find(|field| reader.is_at(field)) {
        reader.take();
        parse_phong_value(reader, field, &mut phong)?;
    }
    if !reader.is_at("}") {
        return Err(reader.unexpected(&format!("a field of `{name}` or `}}`"), fields));
    }
    reader.close(name)?;
    Ok(Material::Phong(phong))
}

/// Reads a material of 2012 and later.
///
/// There the specular colour is also the factor for mirrored rays. Assignment 5 of 2012 has no highlights, and a material
/// with an index of refraction lets the same colour through.
fn parse_later_phong(reader: &mut Reader<'_>) -> Parsed<Material> {
    let (name, fields) = (reader.open()?.text, later_fields(reader.edition));
    let mut phong = Phong { exponent: 0.0, ..Phong::default() };
    let (mut image, mut noise, mut index) = (None, None, 0.0);
    while let Some(field) = fields.iter().find(|field| reader.is_at(field)) {
        match *field {
            "Noise" => {
                noise = Some(parse_noise(reader)?);
                continue;
            }
            _ => reader.take(),
        };
        match *field {
            "diffuseColor" => phong.diffuse = reader.shown_color(field)?,
            "specularColor" => phong.specular = reader.shown_color(field)?,
            "shininess" => {
                phong.exponent = reader.number_that(field, "must not be negative", |number| number >= 0.0)?
            }
            "refractionIndex" => {
                index = reader.number_that(field, "must not be negative", |number| number >= 0.0)?
            }
            "texture" => {
                let file = reader.file_name(field)?;
                let tints_ambient = reader.edition == Edition::Y2012A4;
                image = Some(Paint::Image { image: reader.image(file.text.into(), file.at), tints_ambient });
            }
            // It is read and has no effect, as in the course's program.
            _ => _ = reader.file_name(field)?,
        }
    }
    if !reader.is_at("}") {
        return Err(reader.unexpected(&format!("a field of `{name}` or `}}`"), fields));
    }
    reader.close(name)?;
    phong.reflective = phong.specular;
    if reader.edition == Edition::Y2012A5 {
        // The exponent is that of the highlights which a program has by mistake.
        phong.specular = DVec3::ZERO;
        if index > 0.0 {
            (phong.transparent, phong.index_of_refraction) = (phong.reflective, index);
        }
    }
    // As in the course's program the noise replaces the colour of a texture, whichever stands first.
    Ok(noise.or(image).map_or(Material::Phong(phong), |paint| Material::Painted(phong, paint)))
}

fn later_fields(edition: Edition) -> &'static [&'static str] {
    match edition {
        Edition::Y2012A4 => &["diffuseColor", "specularColor", "shininess", "texture"],
        Edition::Y2012A5 => {
            &["diffuseColor", "specularColor", "shininess", "texture", "refractionIndex", "bump", "Noise"]
        }
        _ => &["diffuseColor", "specularColor", "shininess", "bump"],
    }
}

/// Reads the noise within a material of assignment 5 of 2012, whose fields may come in any order.
fn parse_noise(reader: &mut Reader<'_>) -> Parsed<Paint> {
    const FIELDS: [&str; 4] = ["color", "octaves", "frequency", "amplitude"];
    let name = reader.open()?.text;
    let (mut colors, mut octaves, mut frequency, mut amplitude) = (vec![], 0, 1.0, 1.0);
    loop {
        let at = reader.peek();
        match at.text {
            "color" => {
                reader.take();
                colors.push(reader.shown_color("color")?);
            }
            "octaves" => octaves = parse_octaves(reader)?,
            "frequency" => frequency = reader.number_field("frequency")?,
            "amplitude" => amplitude = reader.number_field("amplitude")?,
            "}" => {
                let &[one, other] = colors.as_slice() else {
                    return Err(reader.unexpected("two colours in all", &[]));
                };
                reader.close(name)?;
                return Ok(Paint::Pattern(Pattern::Marble { octaves, frequency, amplitude }, [one, other]));
            }
            _ => return Err(reader.unexpected("a field of `Noise` or `}`", &FIELDS)),
        }
    }
}

fn parse_phong_value(reader: &mut Reader<'_>, field: &str, phong: &mut Phong) -> Parsed<()> {
    match field {
        "diffuseColor" => phong.diffuse = reader.shown_color(field)?,
        "specularColor" => phong.specular = reader.shown_color(field)?,
        "reflectiveColor" => phong.reflective = reader.shown_color(field)?,
        "transparentColor" => phong.transparent = reader.shown_color(field)?,
        "exponent" => {
            phong.exponent = reader.number_that(field, "must not be negative", |number| number >= 0.0)?
        }
        "indexOfRefraction" => {
            phong.index_of_refraction =
                reader.number_that(field, "must be positive", |number| number > 0.0)?
        }
        // Aalto's program reads these, and shows the diffuse colour: its triangles have no texture coordinates.
        "texture" => _ = reader.file_name(field)?,
        "mipmap" | "linearInterpolation" => {}
        _ => return Err(reader.unexpected("a value of another field", &PHONG_FIELDS)),
    }
    Ok(())
}

fn parse_texture(reader: &mut Reader<'_>, own: MaterialId) -> Parsed<Texture> {
    let name = reader.open()?.text;
    let mut world_to_texture = parse_texture_map(reader)?;
    let children = [parse_child(reader, own)?, parse_child(reader, own)?];
    let pattern = match name {
        "Checkerboard" => {
            world_to_texture = parse_square_size(reader)? * world_to_texture;
            Pattern::Checkerboard
        }
        "Noise" => Pattern::Noise { octaves: parse_octaves(reader)? },
        "Marble" => {
            let (octaves, frequency, amplitude) = parse_wave(reader)?;
            Pattern::Marble { octaves, frequency, amplitude }
        }
        "Wood" => {
            let (octaves, frequency, amplitude) = parse_wave(reader)?;
            Pattern::Wood { octaves, frequency, amplitude }
        }
        _ => return Err(reader.unexpected("the values of another texture", &KINDS)),
    };
    reader.close(name)?;
    Ok(Texture { pattern, world_to_texture, children })
}

/// Reads the optional `Transform` of a texture. As written, without an inversion, it maps world space to
/// texture space.
fn parse_texture_map(reader: &mut Reader<'_>) -> Parsed<RoundedAffine> {
    if !reader.is_at("Transform") {
        return Ok(RoundedAffine::IDENTITY);
    }
    reader.open()?;
    let map = parse_transformations(reader)?;
    if !reader.is_at("}") {
        return Err(reader.unexpected("a transformation or `}`", &TRANSFORMATIONS));
    }
    reader.close("Transform")?;
    Ok(map)
}

/// Reads one `materialIndex` of the texture whose index is `own`.
fn parse_child(reader: &mut Reader<'_>, own: MaterialId) -> Parsed<MaterialId> {
    reader.keyword("materialIndex")?;
    let at = reader.peek().at;
    let index = reader.whole("materialIndex")?;
    let earlier = usize::try_from(index).ok().filter(|&index| index < own);
    earlier.ok_or_else(|| {
        let message = format!("texture {own} may mix only materials before it, found index {index}");
        Diagnostic::error(message).at(at)
    })
}

/// Reads the optional `size` of a checkerboard's squares from the 2003 edition, and returns the scale that
/// maps such squares to unit squares.
fn parse_square_size(reader: &mut Reader<'_>) -> Parsed<RoundedAffine> {
    if !reader.accept("size") {
        return Ok(RoundedAffine::IDENTITY);
    }
    // The reciprocal of the smallest numbers overflows, so it is checked as well.
    let size =
        reader.number_that("size", "must be positive", |size| size > 0.0 && (1.0 / size).is_finite())?;
    let scale = DVec3::splat(1.0 / size);
    let error = DAffine3::from_mat3(DMat3::from_diagonal(scale * UNIT_ROUNDOFF));
    Ok(RoundedAffine { error, ..DAffine3::from_scale(scale).into() })
}

fn parse_octaves(reader: &mut Reader<'_>) -> Parsed<u32> {
    reader.keyword("octaves")?;
    let word = reader.peek();
    match reader.whole("octaves")? {
        octaves @ 0..=MAX_OCTAVES => Ok(octaves as u32),
        _ => Err(bad_value(word, "octaves", "must be at most 64")),
    }
}

/// Reads the fields that `Marble` and `Wood` share: octaves, frequency and amplitude.
fn parse_wave(reader: &mut Reader<'_>) -> Parsed<(u32, f64, f64)> {
    Ok((parse_octaves(reader)?, reader.number_field("frequency")?, reader.number_field("amplitude")?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Vec<Material> {
        let materials = parse_materials(&mut Reader::new(text)).unwrap();
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
    fn every_texture_is_read() {
        let text = "Materials { numMaterials 5 Material { }
            Noise { materialIndex 0 materialIndex 0 octaves 0 }
            Marble { Transform { } materialIndex 1 materialIndex 0 octaves 1 frequency 2 amplitude 3 }
            Wood { materialIndex 2 materialIndex 1 octaves 64 frequency -4 amplitude .5 }
            Checkerboard { Transform { Translate 1 0 0 UniformScale 2 } materialIndex 0 materialIndex 3 } }";
        let textures: Vec<_> = read(text)
            .into_iter()
            .filter_map(
                |material| if let Material::Texture(texture) = material { Some(texture) } else { None },
            )
            .map(|texture| {
                (texture.pattern, texture.children, texture.world_to_texture.map.transform_point3(DVec3::X).x)
            })
            .collect();
        let expected = [
            (Pattern::Noise { octaves: 0 }, [0, 0], 1.0),
            (Pattern::Marble { octaves: 1, frequency: 2.0, amplitude: 3.0 }, [1, 0], 1.0),
            (Pattern::Wood { octaves: 64, frequency: -4.0, amplitude: 0.5 }, [2, 1], 1.0),
            (Pattern::Checkerboard, [0, 3], 3.0),
        ];
        assert_eq!(textures, expected);
    }

    #[test]
    fn a_checkerboard_with_a_size_has_squares_of_that_size() {
        let text = "Materials { numMaterials 2 Material { }
            Checkerboard { Transform { Translate 1 0 0 } materialIndex 0 materialIndex 0 size .5 } }";
        let Material::Texture(texture) = &read(text)[1] else { panic!("not a texture") };
        assert_eq!(texture.world_to_texture.map.transform_point3(DVec3::ONE), DVec3::new(4.0, 2.0, 2.0));
    }
}
