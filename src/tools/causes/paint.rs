//! A picture by any function from rays to colours, with the request's samples and filter.

use crate::base::memory;
use crate::camera::Camera;
use crate::math::instructions;
use crate::math::ray::Ray;
use crate::picture::{BadSize, Color, FloatPicture};
use crate::render::Request;
use crate::sampling::blur::{Blur, reduced};
use crate::sampling::film::Film;
use crate::sampling::spread::Spread;
use glam::DVec2;
use rayon::prelude::*;
use std::ops::Range;

/// How many rows are painted at once. They are kept until the film has taken them.
const ROWS: usize = 64;

/// Paints the window of a picture. The rays run through points that are `shift` pixels to the right of the samples
/// and above them. The rest is black as soon as `is_over` says so.
pub fn paint(
    camera: &Camera,
    request: &Request,
    shift: DVec2,
    color: &(dyn Fn(&Ray) -> Color + Sync),
    is_over: &(dyn Fn() -> bool + Sync),
) -> Result<FloatPicture, BadSize> {
    let Request { size, filter, sampler, .. } = *request;
    let [width, height] = size;
    let (columns, rows) = (request.columns(), request.rows());
    let traced_columns = with_border(&columns, filter.support(), width);
    let traced_rows = with_border(&rows, filter.support(), height);
    let level = instructions::available()[0];
    let color = |ray: &Ray| if is_over() { Color::ZERO } else { color(ray) };
    let row = |j: usize| {
        let mut spread = Spread::new(filter, level, j, size);
        let mut c_rand = sampler.c_rand([traced_columns.start, j], width);
        for i in traced_columns.clone() {
            let ray = |offset| camera.ray(DVec2::new(i as f64, j as f64), offset + shift);
            match &mut c_rand {
                Some(c_rand) => spread.add(i, DVec2::ZERO, color(&ray(c_rand.next_offset())), 1.0),
                None => {
                    for offset in sampler.offsets((i * height + j) as u64) {
                        spread.add(i, offset, color(&ray(offset)), 1.0);
                    }
                }
            }
        }
        spread
    };
    let mut picture = FloatPicture::with_room(request.window_size())?;
    let in_progress = ROWS.min(traced_rows.len()) * Spread::bytes(filter, size);
    memory::ask(in_progress as u64).map_err(|_| BadSize { width: columns.len(), height: rows.len() })?;
    let mut film = Film::starting_at(filter, size, traced_rows.start);
    for start in traced_rows.clone().step_by(ROWS) {
        let spreads: Vec<_> = (start..traced_rows.end.min(start + ROWS)).into_par_iter().map(row).collect();
        for spread in spreads {
            let mut finish = |j: usize, colors: &mut dyn Iterator<Item = Color>| {
                if rows.contains(&j) {
                    picture.colors.extend(colors.skip(columns.start).take(columns.len()));
                }
            };
            film.add(spread, &mut finish);
        }
    }
    turn_over(&mut picture.colors, columns.len());
    Ok(if request.is_reduced { blurred(&picture) } else { picture })
}

/// A picture, blurred and reduced.
fn blurred(picture: &FloatPicture) -> FloatPicture {
    let [width, height] = picture.size;
    let (mut blur, mut colors) = (Blur::new(height), vec![]);
    for row in picture.colors.chunks_exact(width) {
        colors.extend(blur.add(row).unwrap_or_default());
    }
    colors.extend(blur.end().unwrap_or_default());
    FloatPicture { size: reduced(picture.size), colors }
}

/// The range with the pixels around it whose samples contribute to it.
fn with_border(range: &Range<usize>, support: usize, end: usize) -> Range<usize> {
    range.start.saturating_sub(support)..(range.end + support).min(end)
}

/// Puts the last row first.
fn turn_over(colors: &mut [Color], width: usize) {
    colors.reverse();
    colors.chunks_exact_mut(width).for_each(<[Color]>::reverse);
}
