//! The contents of the layers of small pictures.

use super::*;
use crate::base::patience::Endless;
use crate::caster::RayOrigin;
use std::cell::RefCell;

#[test]
fn depths_are_white_at_the_near_bound_and_black_at_the_far_bound_and_beyond() {
    let text = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 2 }
         Group { numObjects 1 Material { } Triangle { vertex0 0 -9 1 vertex1 9 0 1 vertex2 0 9 1 } }";
    for (near, far, shown) in [(2.0, 10.0, 0.75), (3.0, 5.0, 0.5), (5.0, 10.0, 1.0), (1.0, 3.0, 0.0)] {
        let layers = vec![Layer::Depth { near, far }, Layer::Normals];
        let request = Request { layers, sampler: jittered(2), ..Request::new([4, 2]) };
        let [depths, normals] = pictures(text, &request).try_into().unwrap();
        let expected = |x: Color| [Color::ZERO, Color::ZERO, x, x].repeat(2);
        assert_eq!(depths.colors, expected(Color::splat(shown)), "{near} {far}");
        assert_eq!(normals.colors, expected(Color::Z));
    }
}

#[test]
fn samples_are_plotted_where_they_lie_on_a_chequered_ground() {
    let text = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 2 }
         Background { color 1 0.5 0.25 } Group { numObjects 0 }";
    let ([width, height], zoom, sampler) = ([5, 4], 6, jittered(3));
    let request = Request { sampler, layers: vec![Layer::Samples { zoom }], ..Request::new([width, height]) };
    let picture = &pictures(text, &request)[0];
    let mut expected: Vec<Vec<Color>> = (0..height * zoom)
        .map(|y| {
            let grey = |x: usize| if (x / zoom + y / zoom).is_multiple_of(2) { 0.2 } else { 0.0 };
            (0..width * zoom).map(|x| Color::splat(grey(x))).collect()
        })
        .collect();
    for (i, j) in (0..width).flat_map(|i| (0..height).map(move |j| (i, j))) {
        for offset in sampler.offsets((i * height + j) as u64) {
            let within = (offset + 0.5) * zoom as f64;
            let [x, y] = [i * zoom + within.x as usize, j * zoom + within.y as usize];
            expected[y][x] = Color::new(1.0, 0.5, 0.25);
        }
    }
    // The first row of a picture is the last one from the bottom.
    let expected: Vec<Color> = expected.into_iter().rev().flatten().collect();
    assert_eq!((picture.size, &picture.colors), ([width * zoom, height * zoom], &expected));
}

#[test]
fn a_filter_is_drawn_around_the_middle_pixel_with_lines_between_pixels() {
    let (filter, zoom, [width, height]) = (Filter::Tent { radius: 1.4 }, 4, [7, 5]);
    let drawn = RefCell::new(vec![]);
    render_filter(filter, [width, height], zoom, &|_| ControlFlow::Continue(()), &mut |row| {
        drawn.borrow_mut().push(row.to_vec());
        Ok(())
    })
    .unwrap();
    let drawn = drawn.into_inner();
    assert_eq!((drawn.len(), drawn[0].len()), (height * zoom + 1, width * zoom + 1));
    for (y, row) in drawn.iter().rev().enumerate() {
        for (x, &color) in row.iter().enumerate() {
            let is_line = x % zoom == 0 || y % zoom == 0;
            // Pixel 3 is the middle, and the support is one pixel.
            let is_reached = (8..20).contains(&x) && (8..20).contains(&y);
            let from_middle = DVec2::new(x as f64, y as f64) / 4.0 - 3.5;
            let expected = match (is_line, is_reached) {
                (true, _) => Color::Z,
                (false, true) => Color::splat(filter.weight(from_middle)),
                (false, false) => 0.5 * Color::Z,
            };
            assert_eq!(color, expected, "{x} {y}");
        }
    }
}

#[test]
fn a_pixel_is_the_weighted_mean_of_its_own_samples() {
    let text = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 2 }
         Background { color 0 0 0 } Group { numObjects 1 Material { }
         Triangle { vertex0 -1.1 -0.7 0 vertex1 0.9 -0.3 0 vertex2 0.1 0.8 0 } }";
    let scene = parse(text).unwrap();
    let world = World::new(&scene, &[]).unwrap();
    let caster = Caster::new(&world, None).unwrap();
    let (sampler, size @ [width, height]) = (jittered(4), [9, 8]);
    let camera = Camera::new(&scene.camera, size);
    for filter in [Filter::PIXEL, Filter::Tent { radius: 0.5 }] {
        let request = Request { sampler, filter, ..Request::new(size) };
        let picture = &pictures(text, &request)[0];
        assert_eq!(picture.colors.len(), width * height);
        for (i, j) in (0..width).flat_map(|i| (0..height).map(move |j| (i, j))) {
            let (mut lit, mut all) = (0.0, 0.0);
            for offset in sampler.offsets((i * height + j) as u64) {
                let ray = camera.ray(DVec2::new(i as f64, j as f64), offset);
                let weight = filter.weight(offset);
                lit += if caster.any(&ray, RayOrigin::FREE) { weight } else { 0.0 };
                all += weight;
            }
            let expected = if all == 0.0 { 0.0 } else { lit / all };
            let color = picture.colors[(height - 1 - j) * width + i];
            assert!((color - expected).abs().max_element() < 1e-15, "{filter:?} {i} {j}: {color} {expected}");
        }
    }
}

/// A view of cells casts no ray into the scene, unless a layer measures the scene's hits.
#[test]
fn a_view_of_cells_tests_no_primitive() {
    let text = parse(
        &scene("")
            .replace("Plane", "Transform { Scale 1 2 3 Sphere { center 0 0 0 radius 1 } } Plane")
            .replace("Objects 4", "Objects 5"),
    )
    .unwrap();
    let world = World::new(&text, &[]).unwrap();
    let caster = LazyCaster::new(Caster::of_planes(&world), Layout::List);
    let occupancy = grid_view::Occupancy::new(&text, &[], world.bounds, [4; 3], &Endless).unwrap();
    for (layers, tests) in [(vec![Layer::Color], false), (vec![Layer::Color, Layer::Normals], true)] {
        let request = Request { layers, tracing: Tracing::Counted, ..Request::new([9, 8]) };
        let (camera, view) = (Camera::new(&text.camera, request.size), View::Cells(&occupancy));
        let (pictures, counts) =
            render_in_memory(&Shot { camera, caster: &caster, view }, &request, &goes_on).unwrap();
        assert_eq!((counts.non_shadow_rays, counts.intersections > 0), (72, tests));
        assert!(pictures[0].colors.iter().any(|&color| color != world.background));
    }
}
