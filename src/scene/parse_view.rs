//! Reads cameras and lights.

use super::edition::Edition;
use super::reader::{Parsed, Reader, is_byte_like};
use super::{Camera, Light, Position};
use crate::diagnostic::Diagnostic;
use crate::math::robust::unit;
use crate::picture::Color;
use glam::DVec3;

const LIGHTS: [&str; 2] = ["DirectionalLight", "PointLight"];

/// Reads a camera. The caller has checked its name.
pub fn parse_camera(reader: &mut Reader<'_>) -> Parsed<Camera> {
    reader.block(|reader, name| {
        let center = reader.keyword("center")?.vector()?;
        let direction = reader.keyword("direction")?.direction()?;
        let at = reader.keyword("up")?.peek().at;
        let up = reader.direction()?;
        if are_parallel(direction, up) {
            return Err(Diagnostic::error("`up` must not be parallel to `direction`").at(at));
        }
        let camera = if name == "OrthographicCamera" {
            let size = reader.keyword("size")?.positive()?;
            Camera::Orthographic { center, direction, up, size }
        } else {
            let rule = "must be above 0 and below 180 degrees";
            let angle = reader.keyword("angle")?.number_that(rule, |angle| angle > 0.0 && angle < 180.0)?;
            Camera::Perspective { center, direction, up, angle }
        };
        if matches!(reader.peek().text, "width" | "height") {
            let message = format!("a camera has no {}", reader.peek().quoted());
            let hint = "the flag `-size` sets the width and height of the picture, as in `-size 200 200`";
            return Err(Diagnostic::error(message).at(reader.peek().at).with_hint(hint));
        }
        Ok(camera)
    })
}

/// Returns true if two nonzero vectors are parallel, up to rounding.
fn are_parallel(a: DVec3, b: DVec3) -> bool {
    const MAX_SINE: f64 = 1e-12;
    unit(a).cross(unit(b)).length() < MAX_SINE
}

/// Reads the lights, each with the position of its keyword.
pub fn parse_lights(reader: &mut Reader<'_>) -> Parsed<Vec<(Light, Position)>> {
    reader.list("numLights", &LIGHTS, |reader, _| match reader.peek().text {
        "DirectionalLight" => reader.block(|reader, _| {
            let direction = reader.keyword("direction")?.direction()?;
            let (color, at) = parse_light_color(reader)?;
            warn_if_bytes(reader, at, color);
            Ok(Light::Directional { direction, color })
        }),
        "PointLight" if matches!(reader.edition, Edition::Y2012A5 | Edition::Y2019) => {
            parse_light_with_falloff(reader)
        }
        "PointLight" => reader.block(parse_point_light),
        _ => Err(reader.unexpected("a light", &LIGHTS)),
    })
}

fn parse_point_light(reader: &mut Reader<'_>, name: &str) -> Parsed<Light> {
    const CONSTANT: DVec3 = DVec3::X;
    let position = reader.keyword("position")?.vector()?;
    let (color, at) = parse_light_color(reader)?;
    let may_be_attenuated = !reader.edition.is_later();
    let has_attenuation = may_be_attenuated && reader.accept("attenuation");
    let attenuation = if has_attenuation { reader.vector()? } else { CONSTANT };
    if attenuation == CONSTANT {
        warn_if_bytes(reader, at, color);
    }
    if may_be_attenuated && !has_attenuation && !reader.is_at("}") {
        let expected = format!("`attenuation` or `}}` at the end of `{name}`");
        return Err(reader.unexpected(&expected, &["attenuation"]));
    }
    Ok(Light::Point { position, color, attenuation: attenuation.to_array() })
}

/// Reads a light of assignment 5 of 2012 or of 2019. Its fields may come in any order. The light is divided by 1 +
/// falloff d^2 in 2012 and by falloff d^2 in 2019.
fn parse_light_with_falloff(reader: &mut Reader<'_>) -> Parsed<Light> {
    let at = reader.peek().at;
    let (mut position, mut color, mut falloff) = (DVec3::ZERO, Color::ZERO, 0.0);
    reader.block(|reader, name| {
        let expected = format!("a field of `{name}` or `}}`");
        reader.fields(&expected, &["position", "color", "falloff"], |reader, field| {
            match field {
                "position" => position = reader.vector()?,
                "color" => color = reader.color()?,
                _ => falloff = reader.nonnegative()?,
            }
            Ok(())
        })
    })?;
    let constant = if reader.edition == Edition::Y2019 { 0.0 } else { 1.0 };
    if constant == 0.0 && falloff == 0.0 {
        let message =
            format!("without `falloff` the light is infinitely bright in the edition {}", reader.edition);
        let hint = "`-edition 2012a4` and `-edition 2012a5` take such a light to be the same everywhere";
        return Err(Diagnostic::error(message).at(at).with_hint(hint));
    }
    Ok(Light::Point { position, color, attenuation: [constant, 0.0, falloff] })
}

fn parse_light_color(reader: &mut Reader<'_>) -> Parsed<(Color, Position)> {
    let at = reader.keyword("color")?.peek().at;
    Ok((reader.color()?, at))
}

/// Warns about a light whose colour looks like bytes. A bright light alone is not a mistake.
fn warn_if_bytes(reader: &mut Reader<'_>, at: Position, color: Color) {
    const LEAST_BYTE: f64 = 16.0;
    if color.max_element() >= LEAST_BYTE && is_byte_like(color) {
        reader.warn_if_above_one(at, "color", color);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearly_parallel_is_not_parallel() {
        assert!(are_parallel(DVec3::ONE, DVec3::ONE * -3.0));
        assert!(are_parallel(DVec3::ONE * 1e-300, DVec3::ONE * 1e300));
        assert!(!are_parallel(DVec3::Y, DVec3::new(1e-6, 1.0, 0.0)));
    }

    #[test]
    fn vectors_are_parallel_within_less_than_1e_12() {
        let parallel = |angle: f64| are_parallel(DVec3::X * 3.0, DVec3::new(-1.0, angle, 0.0));
        assert_eq!([0.0, 0.99e-12, 1e-12, 1e-9].map(parallel), [true, true, false, false]);
    }
}
