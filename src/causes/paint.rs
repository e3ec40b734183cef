//! A picture by any function from rays to colours, with the request's samples and filter.

use crate::camera::Camera;
use crate::math::instructions::Instructions;
use crate::math::ray::Ray;
use crate::picture::{BadSize, FloatPicture};
use crate::render::Request;
use crate::sampling::film::Film;
use crate::sampling::spread::Spread;
use crate::scene::Color;
use glam::DVec2;
use rayon::prelude::*;

/// How many rows are painted at once. They are kept until the film has taken them.
const ROWS: usize = 64;

/// Paints a picture. The rays run through points that are `shift` pixels to the right of the samples and above them.
pub fn paint(
    camera: &Camera,
    request: &Request,
    shift: DVec2,
    color: &(dyn Fn(&Ray) -> Color + Sync),
) -> Result<FloatPicture, BadSize> {
    let Request { size, filter, sampler, .. } = *request;
    let [width, height] = size;
    let instructions = Instructions::available()[0];
    let row = |j: usize| {
        let mut spread = Spread::new(filter, instructions, j, size);
        for i in 0..width {
            for offset in sampler.offsets((i * height + j) as u64) {
                let ray = camera.ray(DVec2::new(i as f64, j as f64), offset + shift);
                spread.add(i, offset, color(&ray), 1.0);
            }
        }
        spread
    };
    let mut picture = FloatPicture::with_room(size)?;
    let mut film = Film::new(filter, size);
    for start in (0..height).step_by(ROWS) {
        let spreads: Vec<Spread> = (start..height.min(start + ROWS)).into_par_iter().map(row).collect();
        spreads.into_iter().for_each(|spread| film.add(spread, |_, row| picture.colors.extend(row)));
    }
    turn_over(&mut picture.colors, width);
    Ok(picture)
}

/// Puts the last row first.
fn turn_over(colors: &mut [Color], width: usize) {
    colors.reverse();
    colors.chunks_exact_mut(width).for_each(<[Color]>::reverse);
}
