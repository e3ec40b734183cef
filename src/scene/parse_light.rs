//! Reads lights.

use super::edition::Edition;
use super::list::counted_list;
use super::reader::{Parsed, Reader, is_byte_like};
use super::{Light, Position};
use crate::diagnostic::Diagnostic;
use crate::picture::Color;
use glam::DVec3;

const LIGHTS: [&str; 2] = ["DirectionalLight", "PointLight"];

/// Reads the lights, each with the position of its keyword.
pub fn parse_lights(reader: &mut Reader<'_>) -> Parsed<Vec<(Light, Position)>> {
    let name = reader.open()?.text;
    counted_list(reader, name, "numLights", &LIGHTS, |reader, _| {
        let at = reader.peek().at;
        Ok((parse_light(reader)?, at))
    })
}

fn parse_light(reader: &mut Reader<'_>) -> Parsed<Light> {
    match reader.peek().text {
        "DirectionalLight" => parse_directional_light(reader),
        "PointLight" => parse_point_light(reader),
        _ => Err(reader.unexpected("a light", &LIGHTS)),
    }
}

fn parse_directional_light(reader: &mut Reader<'_>) -> Parsed<Light> {
    let name = reader.open()?.text;
    let direction = reader.direction_field("direction")?;
    let (color, at) = parse_light_color(reader)?;
    warn_if_bytes(reader, at, color);
    reader.close(name)?;
    Ok(Light::Directional { direction, color })
}

fn parse_point_light(reader: &mut Reader<'_>) -> Parsed<Light> {
    if matches!(reader.edition, Edition::Y2012A5 | Edition::Y2019) {
        return parse_later_point_light(reader);
    }
    let name = reader.open()?.text;
    let position = reader.vector_field("position")?;
    let (color, at) = parse_light_color(reader)?;
    let constant = DVec3::X;
    let may_be_attenuated = !reader.edition.is_later();
    let has_attenuation = may_be_attenuated && reader.accept("attenuation");
    let attenuation = if has_attenuation { reader.vector("attenuation")? } else { constant };
    if attenuation == constant {
        warn_if_bytes(reader, at, color);
    }
    if may_be_attenuated && !has_attenuation && !reader.is_at("}") {
        return Err(
            reader.unexpected(&format!("`attenuation` or `}}` at the end of `{name}`"), &["attenuation"])
        );
    }
    reader.close(name)?;
    Ok(Light::Point { position, color, attenuation: attenuation.to_array() })
}

/// Reads a light of assignment 5 of 2012 or of 2019, whose fields may come in any order. Its light is divided by
/// 1 + falloff d^2 in the one, and by falloff d^2 in the other.
fn parse_later_point_light(reader: &mut Reader<'_>) -> Parsed<Light> {
    const FIELDS: [&str; 3] = ["position", "color", "falloff"];
    let word = reader.open()?;
    let (mut position, mut color, mut falloff) = (DVec3::ZERO, Color::ZERO, 0.0);
    while !reader.is_at("}") {
        if reader.accept("position") {
            position = reader.vector("position")?;
        } else if reader.accept("color") {
            color = reader.color("color")?;
        } else if reader.accept("falloff") {
            falloff = reader.number_that("falloff", "must not be negative", |number| number >= 0.0)?;
        } else {
            return Err(reader.unexpected("a field of `PointLight` or `}`", &FIELDS));
        }
    }
    reader.close(word.text)?;
    let constant = if reader.edition == Edition::Y2019 { 0.0 } else { 1.0 };
    if constant == 0.0 && falloff == 0.0 {
        let message =
            format!("without `falloff` the light is infinitely bright in the edition {}", reader.edition);
        let hint = "`-edition 2012a4` and `-edition 2012a5` take such a light to be the same everywhere";
        return Err(Diagnostic::error(message).at(word.at).with_hint(hint));
    }
    Ok(Light::Point { position, color, attenuation: [constant, 0.0, falloff] })
}

fn parse_light_color(reader: &mut Reader<'_>) -> Parsed<(Color, Position)> {
    reader.keyword("color")?;
    let at = reader.peek().at;
    Ok((reader.color("color")?, at))
}

/// Records a light whose colour looks like bytes. A bright light is no mistake in itself.
fn warn_if_bytes(reader: &mut Reader<'_>, at: Position, color: Color) {
    const LEAST_BYTE: f64 = 16.0;
    if color.max_element() >= LEAST_BYTE && is_byte_like(color) {
        reader.warn_if_above_one(at, "color", color);
    }
}
