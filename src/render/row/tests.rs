use super::*;
use crate::camera::Camera;
use crate::caster::Caster;
use crate::render::Tracing;
use crate::render::tracing::PictureTracer;
use crate::scene::Scene;
use crate::scene::parser::parse;
use glam::DVec3;

const TEXT: &str = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 2 }
     Background { color 0 0 0 ambientLight 0.25 0 0 }
     Lights { numLights 3 DirectionalLight { direction 0 -3 -4 color 0.5 1 0 }
     DirectionalLight { direction 0 0 1 color 9 9 9 }
     PointLight { position 0 0 3 color 0 0 2 attenuation 0 1 0 } }
     Group { numObjects 0 }";

/// Calls `check` with a painter of row 5 of a picture of ten by eight pixels, whose window begins at column 2 and
/// whose samples are plotted as squares of four by four.
fn with_painter(check: impl FnOnce(&mut Painter)) {
    let scene: Scene = parse(TEXT).unwrap();
    let world = World::new(&scene, &[]).unwrap();
    let caster = Caster::new(&world, None).unwrap();
    let (layers, tracing) = (vec![Layer::Samples { zoom: 4 }], Tracing::Counted);
    let request = Request { layers, tracing, ..Request::new([10, 8]) };
    let camera = Camera::new(&scene.camera, request.size);
    let tracer = PictureTracer::new(&camera, &caster, View::Scene, &request, &|_| false);
    check(&mut Painter { shown: 2..10, center_weight: 1.0, ..tracer.painter(5, true) });
}

/// A sample whose position is rounded to the next pixel, or lies on the border, is plotted in its own pixel.
#[test]
fn a_sample_is_plotted_within_its_pixel() {
    with_painter(|painter| {
        painter.plot_background(0, 4, 2..10);
        let offset = 0.5f64.next_down();
        assert_eq!(5.5 + offset, 6.0);
        painter.plot(5, DVec2::splat(offset), Color::X);
        painter.plot(5, DVec2::splat(-0.5), Color::Y);
        painter.plot(6, DVec2::new(-0.5, offset), Color::Z);
        painter.plot(1, DVec2::ZERO, Color::ONE);
        let colors = &painter.row.layers[0];
        let at = |color: Color| {
            colors.iter().enumerate().filter(|&(_, c)| *c == color).map(|(k, _)| k).collect::<Vec<_>>()
        };
        let place = |x: usize, y: usize| vec![32 * y + x - 8];
        assert_eq!([Color::X, Color::Y, Color::Z].map(at), [place(23, 3), place(20, 0), place(24, 3)]);
        assert_eq!((at(Color::ONE), colors.len()), (vec![], 4 * 32));
    });
}

#[test]
fn rows_beside_the_strip_plot_no_samples() {
    let request =
        |zoom| Request { layers: vec![Layer::Color, Layer::Samples { zoom }], ..Request::new([9, 9]) };
    assert_eq!(plots(&request(3), true), [(1, 3)]);
    assert_eq!(plots(&request(3), false), []);
}

#[test]
fn the_face_of_a_cell_is_lit_by_every_light_before_it() {
    let world = World::new(&parse(TEXT).unwrap(), &[]).unwrap();
    let face = Face { t: 4.0, normal: DVec3::Z, color: Color::new(1.0, 0.5, 0.25) };
    let ray = Ray::new(DVec3::Z * 5.0, DVec3::NEG_Z);
    // Ambient light, then 4/5 of the first light, nothing of the second, and half of the third.
    let expected = face.color * Color::new(0.25 + 0.8 * 0.5, 0.8, 1.0);
    assert!((cell_color(&face, &ray, &world) - expected).abs().max_element() < 1e-15);
}
