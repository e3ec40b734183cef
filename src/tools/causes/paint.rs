//! Renders the pictures of a student's tracer with the request's samples and filter.

use super::mistakes::Mistake;
use super::student::Student;
use crate::base::memory;
use crate::math::instructions;
use crate::math::ray::Ray;
use crate::picture::{BadSize, Color, FloatPicture};
use crate::render::{Layer, Request};
use crate::sampling::blur::{Blur, reduced};
use crate::sampling::film::Film;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::Sampler;
use crate::sampling::spread::Spread;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::ops::Range;

/// The number of rows painted at a time. They are kept until the film has taken them.
const ROWS: usize = 64;

/// Renders the request's first layer with a student's tracer. Pixels are black after `is_over` returns true.
pub fn colors(
    student: &Student,
    request: &Request,
    is_over: &(dyn Fn() -> bool + Sync),
) -> Result<FloatPicture, BadSize> {
    let measures = student.renderer.scene.measure_colors;
    let centers = || Request { sampler: Sampler::CENTER, filter: Filter::PIXEL, ..request.clone() };
    match request.layers.first() {
        Some(&Layer::Depth { near, far }) => {
            let grey = |(t, _)| Color::splat(measures.depths.grey(t, [near, far]));
            let color = |ray: &Ray| student.seen(ray).map_or(Color::ZERO, grey);
            paint(student, &centers(), &color, is_over)
        }
        Some(Layer::Normals) => {
            let normal = |ray: &Ray| student.seen(ray).map_or(DVec3::ZERO, |(_, surface)| surface.normal);
            paint(student, &centers(), &|ray| measures.normals.color(normal(ray)), is_over)
        }
        _ => paint(student, request, &|ray| student.color(ray), is_over),
    }
}

/// Paints the window of a picture.
fn paint(
    student: &Student,
    request: &Request,
    color: &(dyn Fn(&Ray) -> Color + Sync),
    is_over: &(dyn Fn() -> bool + Sync),
) -> Result<FloatPicture, BadSize> {
    let Request { size, filter, sampler, .. } = *request;
    let [width, height] = size;
    let (columns, rows) = (request.columns(), request.rows());
    let traced_columns = with_border(&columns, filter.support(), width);
    let traced_rows = with_border(&rows, filter.support(), height);
    let (camera, level) = (student.renderer.camera(request), instructions::available()[0]);
    // From the samples to the points that the rays pass through, in pixels to the right and up.
    let shift = match student.mistake {
        Some(Mistake::Shifted { half_pixels: [x, y] }) => 0.5 * DVec2::new(x.into(), y.into()),
        _ => DVec2::ZERO,
    };
    let row = |j: usize| {
        let mut spread = Spread::new(filter, level, j, size);
        let mut c_rand = sampler.c_rand([traced_columns.start, j], width);
        for i in traced_columns.clone() {
            let color = |offset| match is_over() {
                true => Color::ZERO,
                false => color(&camera.ray(DVec2::new(i as f64, j as f64), offset + shift)),
            };
            match &mut c_rand {
                Some(c_rand) => spread.add(i, DVec2::ZERO, color(c_rand.next_offset()), 1.0),
                None => {
                    for offset in sampler.offsets((i * height + j) as u64) {
                        spread.add(i, offset, color(offset), 1.0);
                    }
                }
            }
        }
        spread
    };
    let mut picture = FloatPicture::with_room(request.window_size())?;
    let in_progress = ROWS.min(traced_rows.len()) * Spread::bytes(filter, size);
    memory::ask(in_progress as u64).map_err(|_| BadSize { width: columns.len(), height: rows.len() })?;
    let mut film = Film::new(filter, size, traced_rows.start);
    for start in traced_rows.clone().step_by(ROWS) {
        let end = traced_rows.end.min(start + ROWS);
        let spreads: Vec<_> = (start..end).into_par_iter().map(row).collect();
        for spread in spreads {
            let mut finish = |j: usize, colors: &mut dyn Iterator<Item = Color>| {
                if rows.contains(&j) {
                    picture.colors.extend(colors.skip(columns.start).take(columns.len()));
                }
            };
            film.add(spread, &mut finish);
        }
    }
    // The film's rows run upwards.
    picture.colors.reverse();
    picture.colors.chunks_exact_mut(columns.len()).for_each(<[Color]>::reverse);
    Ok(if request.is_reduced { blurred(&picture) } else { picture })
}

/// Returns the picture, blurred and reduced.
fn blurred(picture: &FloatPicture) -> FloatPicture {
    let [width, height] = picture.size;
    let (mut blur, mut colors) = (Blur::new(height), vec![]);
    for row in picture.colors.chunks_exact(width) {
        colors.extend(blur.add(row).unwrap_or_default());
    }
    colors.extend(blur.end().unwrap_or_default());
    FloatPicture { size: reduced(picture.size), colors }
}

/// Returns the range extended by the pixels whose samples contribute to it.
fn with_border(range: &Range<usize>, support: usize, end: usize) -> Range<usize> {
    range.start.saturating_sub(support)..(range.end + support).min(end)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Picture;
    use crate::render::Window;
    use crate::render::renderer::{Meshes, Renderer};
    use crate::sampling::{drand48::Drand48, sampler};
    use crate::scene::load;
    use crate::tools::causes::window::part_of_colors;
    use crate::tools::causes::{Mistake, Original};
    use crate::trace::{Effects, Shadows};
    use std::path::Path;

    /// Renders one of the project's scenes with the renderer, and with the student's tracer without a mistake.
    fn both(scene: &str, request: &Request) -> [Picture; 2] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
        let renderer = Renderer::new(load::load(&path).unwrap(), Meshes::Kept).unwrap();
        let original = Original::new(&renderer, request).unwrap();
        let student = Student::new(&renderer, original.prepared.caster(), request.effects);
        let painted = colors(&student, request, &|| false).unwrap();
        [original.colors, painted].map(|colors| colors.to_picture())
    }

    #[test]
    fn without_a_mistake_the_picture_is_the_real_one() {
        let shadows = Effects { shadows: Shadows::Opaque, bounces: 3, min_weight: 0.1, shade_back: false };
        let transparent = Effects { shadows: Shadows::Transparent, shade_back: true, ..shadows };
        let sampler = sampler::Sampler::new(sampler::Pattern::Jittered, 4, Drand48::UNSEEDED);
        let one = Request { effects: shadows, ..Request::new([50, 40]) };
        let many =
            Request { sampler, filter: Filter::Gaussian { sigma: 0.7 }, effects: transparent, ..one.clone() };
        for scene in [
            "scene6_02_sphere_triangles.txt",
            "scene6_10_nested_transformations.txt",
            "scene6_11_mirrored_floor.txt",
            "scene6_13_checkerboard.txt",
            "scene7_05_glass_sphere.txt",
        ] {
            for request in [&one, &many] {
                let [real, textbook] = both(scene, request);
                assert!(real == textbook, "{scene}");
            }
        }
    }

    #[test]
    fn a_window_is_a_part_of_the_picture() {
        let sampler = sampler::Sampler::new(sampler::Pattern::Jittered, 4, Drand48::UNSEEDED);
        let window = Window { x: 30, y: 7, width: 20, height: 9 };
        for filter in [Filter::PIXEL, Filter::Gaussian { sigma: 0.7 }] {
            let request = Request { sampler, filter, ..Request::new([50, 40]) };
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/scene6_02_sphere_triangles.txt");
            let renderer = Renderer::new(load::load(&path).unwrap(), Meshes::Kept).unwrap();
            let original = Original::new(&renderer, &request).unwrap();
            for cause in Mistake::all() {
                let [whole, found] = [None, Some(window)].map(|window| original.made(&[cause], window));
                let expected = whole.map(|whole| part_of_colors(&whole, window).to_picture());
                assert!(found.map(|found| found.to_picture()) == expected, "{cause:?} {filter:?}");
            }
        }
    }

    #[test]
    fn a_picture_taller_than_a_batch_of_rows_is_in_order() {
        let request = Request { filter: Filter::Tent { radius: 2.0 }, ..Request::new([20, 150]) };
        let [real, textbook] = both("scene6_02_sphere_triangles.txt", &request);
        assert!(real == textbook);
    }
}
