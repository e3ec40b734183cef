//! Renders the pictures of a student's tracer with the request's samples and filter.

use super::first_layer;
use super::rules::Rule;
use super::student::{HitsItself, Student};
use crate::base::memory;
use crate::camera::{Camera, Projection};
use crate::math::instructions;
use crate::math::ray::Ray;
use crate::picture::{BadSize, Color, FloatPicture};
use crate::render::{Layer, Request, Window};
use crate::sampling::blur::{Blur, reduced};
use crate::sampling::film::Film;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::Sampler;
use crate::sampling::spread::Spread;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// The number of rows painted at a time. They are kept until the film has taken them.
const ROWS: usize = 64;

/// Returns how far a point of the picture moves. The arguments are the point, in pixels from the lower left corner, and
/// the size of the picture.
pub type Move = fn(DVec2, DVec2) -> DVec2;

/// Paints the first layer of a request by a student's tracer.
#[derive(Clone, Copy)]
pub struct Painter<'a> {
    student: &'a Student<'a>,
    request: &'a Request,
    layer: Layer,
    camera: Camera,
    /// Moves of the points that rays pass through.
    moves: &'a [Move],
    /// One more move, of all points alike.
    moved: DVec2,
}

impl<'a> Painter<'a> {
    /// Returns a painter. Pixels have unspecified colours after the student's patience is over.
    pub fn new(student: &'a Student, request: &'a Request, moves: &'a [Move]) -> Self {
        let (layer, camera) = (first_layer(request), student.renderer.camera(request));
        Self { student, request, layer, camera, moves, moved: DVec2::ZERO }
    }

    /// Returns the colour of a pixel, by its column and row from the top left, with its point moved. `hits_itself`
    /// decides which rays hit the surface that they leave.
    pub fn pixel_with_self_hits(&self, pixel: [usize; 2], moved: DVec2, hits_itself: HitsItself) -> Color {
        let student = &Student { hits_itself: Some(hits_itself), ..*self.student };
        Painter { student, ..*self }.pixels(&[pixel], moved)[0]
    }

    /// Returns the colour along a ray in the request's layer.
    fn color(&self, ray: &Ray) -> Color {
        let student = self.student;
        let breaks = |rule| student.rules.contains(&rule);
        let measures = student.renderer.scene.measure_colors;
        match self.layer {
            Layer::Depth { near, far } => {
                let Some((t, surface)) = student.seen(ray) else {
                    return Color::splat(f64::from(breaks(Rule::DepthInverted)));
                };
                let (Projection::Perspective(eye) | Projection::Orthographic(eye)) = self.camera.projection();
                let t = match breaks(Rule::DepthAlongAxis) {
                    true => (surface.position - ray.origin).dot(eye.direction),
                    false => t,
                };
                let grey = measures.depths.grey(t, [near, far]);
                Color::splat(if breaks(Rule::DepthInverted) { 1.0 - grey } else { grey })
            }
            Layer::Normals => {
                let normal = student.seen(ray).map_or(DVec3::ZERO, |(_, surface)| surface.normal);
                if breaks(Rule::NormalsClamped) {
                    normal.max(DVec3::ZERO)
                } else if breaks(Rule::NormalsShifted) && normal != DVec3::ZERO {
                    0.5 * normal + 0.5
                } else if breaks(Rule::NormalsShifted) {
                    Color::ZERO
                } else {
                    measures.normals.color(normal)
                }
            }
            _ => student.color(ray),
        }
    }

    /// Returns the request's sampler and filter. Depths and normals are seen through the centres of pixels.
    fn sampling(&self) -> (Sampler, Filter) {
        match self.layer {
            Layer::Color => (self.request.sampler, self.request.filter),
            _ => (Sampler::CENTER, Filter::PIXEL),
        }
    }

    /// Returns the colour seen at an offset from the centre of the pixel in this column and row from the bottom.
    fn sample(&self, pixel: [usize; 2], offset: DVec2) -> Color {
        if self.student.patience.is_over() {
            return Color::ZERO;
        }
        let pixel = DVec2::new(pixel[0] as f64, pixel[1] as f64);
        let size = DVec2::new(self.request.size[0] as f64, self.request.size[1] as f64);
        let point = pixel + 0.5 + offset;
        let shift = self.moves.iter().fold(self.moved, |sum, shift| sum + shift(point, size));
        self.color(&self.camera.ray(pixel, offset + shift))
    }

    /// Returns the colours of pixels, by their columns and rows from the top left, with all points moved.
    pub fn pixels(&self, pixels: &[[usize; 2]], moved: DVec2) -> Vec<Color> {
        let painter = Self { moved: self.moved + moved, ..*self };
        if !self.request.is_reduced {
            return pixels.par_iter().map(|&pixel| painter.pixel(pixel)).collect();
        }
        let Ok(picture) = painter.picture() else { return vec![Color::ZERO; pixels.len()] };
        pixels.iter().map(|&[x, y]| picture.colors[y * picture.size[0] + x]).collect()
    }

    /// Returns the colour of a pixel of a picture that is not reduced.
    fn pixel(&self, [x, y]: [usize; 2]) -> Color {
        let (sampler, filter) = self.sampling();
        let [width, height] = self.request.size;
        // Shortcut: without a border or shared random numbers, a pixel needs no film.
        if filter.support() == 0 && sampler.c_rand([0, 0], width).is_none() {
            let j = height - 1 - y;
            let (mut sum, mut weights) = (Color::ZERO, 0.0);
            for offset in sampler.offsets((x * height + j) as u64) {
                let weight = filter.weight(offset);
                sum += weight * self.sample([x, j], offset);
                weights += weight;
            }
            return sum / weights;
        }
        let window = Some(Window { x, y, width: 1, height: 1 });
        let request = Request { window, ..self.request.clone() };
        let one = Painter { request: &request, ..*self };
        one.picture().map_or(Color::ZERO, |picture| picture.colors[0])
    }

    /// Returns the window of the picture.
    pub fn picture(&self) -> Result<FloatPicture, BadSize> {
        let (sampler, filter) = self.sampling();
        let (request, size) = (self.request, self.request.size);
        let [width, height] = size;
        let (columns, rows) = (request.columns(), request.rows());
        let (traced_columns, traced_rows) = (request.traced_columns(), request.traced_rows(rows.clone()));
        let level = instructions::available()[0];
        let row = |j: usize| {
            let mut spread = Spread::new(filter, level, j, size);
            let mut c_rand = sampler.c_rand([traced_columns.start, j], width);
            for i in traced_columns.clone() {
                match &mut c_rand {
                    Some(c_rand) => {
                        spread.add(i, DVec2::ZERO, self.sample([i, j], c_rand.next_offset()), 1.0)
                    }
                    None => {
                        for offset in sampler.offsets((i * height + j) as u64) {
                            spread.add(i, offset, self.sample([i, j], offset), 1.0);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::patience::Endless;
    use crate::picture::Picture;
    use crate::render::renderer::{Meshes, Renderer};
    use crate::sampling::{drand48::Drand48, sampler};
    use crate::scene::load;
    use crate::trace::{Effects, Shadows};
    use std::path::Path;

    /// Renders one of the project's scenes with the renderer, with the student's tracer, and pixel by pixel.
    fn all(scene: &str, request: &Request) -> [Picture; 3] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
        let renderer = Renderer::new(load::load(&path).unwrap(), Meshes::Kept).unwrap();
        let prepared = renderer.prepare(request).unwrap();
        let real = prepared.render(request).unwrap().remove(0);
        let caster = prepared.caster(&Endless).unwrap();
        let student = Student::new(&renderer, &caster, request.effects);
        let painter = Painter::new(&student, request, &[]);
        let painted = painter.picture().unwrap();
        let places: Vec<[usize; 2]> =
            (0..real.size[1]).flat_map(|y| (0..real.size[0]).map(move |x| [x, y])).collect();
        let pixels = FloatPicture { size: real.size, colors: painter.pixels(&places, DVec2::ZERO) };
        [real, painted, pixels].map(|colors| colors.to_picture())
    }

    #[test]
    fn without_a_mistake_the_picture_is_the_real_one() {
        let shadows = Effects { shadows: Shadows::Opaque, bounces: 3, min_weight: 0.1, shade_back: false };
        let transparent = Effects { shadows: Shadows::Transparent, shade_back: true, ..shadows };
        let sampler = sampler::Sampler::new(sampler::Pattern::Jittered, 4, Drand48::UNSEEDED);
        let one = Request { effects: shadows, ..Request::new([50, 40]) };
        let many = Request { sampler, effects: transparent, ..one.clone() };
        let wide = Request { filter: Filter::Gaussian { sigma: 0.7 }, ..many.clone() };
        let depths = Request { layers: vec![Layer::Depth { near: 5.0, far: 12.0 }], ..many.clone() };
        let reduced = Request { is_reduced: true, ..one.clone() };
        for scene in [
            "scene6_02_sphere_triangles.txt",
            "scene6_10_nested_transformations.txt",
            "scene6_11_mirrored_floor.txt",
            "scene6_13_checkerboard.txt",
            "scene7_05_glass_sphere.txt",
        ] {
            for (name, request) in
                [("one", &one), ("many", &many), ("wide", &wide), ("depths", &depths), ("reduced", &reduced)]
            {
                let [real, painted, pixels] = all(scene, request);
                assert!(real == painted, "{scene} {name}");
                assert!(real == pixels, "{scene} {name} by pixels");
            }
        }
    }

    #[test]
    fn a_picture_taller_than_a_batch_of_rows_is_in_order() {
        let request = Request { filter: Filter::Tent { radius: 2.0 }, ..Request::new([20, 150]) };
        let [real, painted, _] = all("scene6_02_sphere_triangles.txt", &request);
        assert!(real == painted);
    }
}
