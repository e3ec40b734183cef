use super::*;

const SETTINGS: Adaptive = Adaptive { most: 256, error: 1.0 };

/// The quarters of a pixel, each sampled in its middle, whose lower left corner is at `corner` of a scene.
fn quarters(corner: DVec2, scene: &dyn Fn(DVec2) -> Color) -> Quarters {
    let offsets = [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)].map(DVec2::from);
    Quarters::new(offsets, offsets.map(|offset| scene(corner + 0.5 + offset)))
}

/// Samples the pixel whose lower left corner is the origin; the eight pixels around it show the same scene.
fn sampled(settings: Adaptive, scene: &dyn Fn(DVec2) -> Color) -> Vec<Stratum> {
    let pixels: [[Quarters; 3]; 3] = std::array::from_fn(|j| {
        std::array::from_fn(|i| quarters(DVec2::new(i as f64 - 1.0, j as f64 - 1.0), scene))
    });
    let around = pixels.each_ref().map(|row| row.each_ref().map(Some));
    let mut rng = Drand48::seeded(7);
    let mut strata = Strata::default();
    strata.start(&pixels[1][1]);
    loop {
        let new = strata.divide(settings, &around, &mut rng);
        if new.is_empty() {
            return strata.all().to_vec();
        }
        new.iter_mut().for_each(|stratum| stratum.color = scene(stratum.offset + 0.5));
    }
}

fn mean(strata: &[Stratum]) -> Color {
    strata.iter().map(|stratum| stratum.area() * stratum.color).sum()
}

fn edge(at: f64) -> impl Fn(DVec2) -> Color {
    move |point| if point.x + 0.3 * point.y < at { Color::ONE } else { Color::ZERO }
}

fn flat(_: DVec2) -> Color {
    Color::splat(0.4)
}

#[test]
fn a_flat_pixel_keeps_its_four_samples() {
    assert_eq!(sampled(SETTINGS, &flat).len(), 4);
    // What changes by much less than the error is flat as well.
    assert_eq!(sampled(SETTINGS, &|point| Color::splat(0.4 + point.x / 1000.0)).len(), 4);
}

#[test]
fn strata_fill_the_pixel_and_hold_their_samples() {
    for error in [0.1, 1.0, 5.0] {
        let strata = sampled(Adaptive { error, ..SETTINGS }, &edge(0.6));
        assert!(strata.len() > 16, "{}", strata.len());
        assert_eq!(strata.iter().map(Stratum::area).sum::<f64>(), 1.0);
        let mut places: Vec<_> = strata.iter().map(|stratum| (stratum.depth, stratum.place)).collect();
        for stratum in &strata {
            let place = ((stratum.offset + 0.5) * f64::from(1 << stratum.depth)).floor();
            assert_eq!(place.to_array().map(|n| n as usize), stratum.place);
            assert!((1..=MAX_DEPTH).contains(&stratum.depth));
        }
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), strata.len());
    }
}

#[test]
fn samples_gather_at_an_edge() {
    let strata = sampled(SETTINGS, &edge(0.6));
    let distance = |stratum: &Stratum| (stratum.offset.x + 0.5 + 0.3 * (stratum.offset.y + 0.5) - 0.6).abs();
    let (fine, coarse): (Vec<_>, Vec<_>) = strata.iter().partition(|stratum| stratum.depth >= 4);
    assert!(fine.len() > 2 * coarse.len(), "{} {}", fine.len(), coarse.len());
    let near = fine.iter().filter(|stratum| distance(stratum) < 0.125).count();
    assert!(near * 5 > fine.len() * 4, "{near} of {}", fine.len());
}

#[test]
fn the_error_is_about_what_is_allowed() {
    for (error, most) in [(8.0, 256), (3.0, 256), (1.0, 1024)] {
        let errors = (0..60).map(|k| {
            let at = 0.2 + f64::from(k) / 60.0;
            // The area below the line from (at, 0) to (at - 0.3, 1) within the pixel, where it stays inside.
            let part = |a: f64| a.clamp(0.0, 1.0).powi(2) / 2.0 + (a - 1.0).max(0.0);
            let covered = (part(at) - part(at - 0.3)) / 0.3;
            255.0 * (mean(&sampled(Adaptive { most, error }, &edge(at))).x - covered)
        });
        let square: f64 = errors.map(|e| e * e).sum::<f64>() / 60.0;
        assert!(square.sqrt() < error, "{error} {}", square.sqrt());
    }
}

#[test]
fn no_pixel_gets_more_than_the_most() {
    let noise = |point: DVec2| Color::splat((point.x * 7919.0 + point.y * 104_729.0).sin().fract().abs());
    for most in [4, 5, 6, 7, 20, 64, 255, 1024] {
        let count = sampled(Adaptive { most, error: 0.0 }, &noise).len();
        // Each division adds three samples.
        assert_eq!(count, 4 + (most as usize - 4) / 3 * 3, "{most}");
    }
}

#[test]
fn the_strata_that_differ_most_go_first() {
    let corner = |point: DVec2| if point.x > 0.5 && point.y > 0.5 { Color::ONE } else { 0.01 * Color::X };
    let strata = sampled(Adaptive { most: 7, error: 0.0 }, &corner);
    assert_eq!(strata.len(), 7);
    assert_eq!(strata.iter().filter(|stratum| stratum.depth == 2 && stratum.color == Color::ONE).count(), 4);
}

#[test]
fn what_a_pixel_beside_it_has_found_is_looked_for() {
    // The samples of the pixel agree, and those to its left do not.
    let needle = |point: DVec2| if point.x < -0.1 && point.y < 0.5 { Color::ONE } else { Color::ZERO };
    let inside = quarters(DVec2::ZERO, &needle);
    assert_eq!(inside.colors, [Color::ZERO; 4]);
    assert!(sampled(SETTINGS, &needle).len() > 4);
    // Above it as well, which has no side in common with the needle's samples.
    let above = |point: DVec2| needle(point + DVec2::new(0.0, 1.0));
    assert!(sampled(SETTINGS, &above).len() > 4);
}

#[test]
fn colours_without_bounds_end_at_the_most() {
    for huge in [1e30, f64::MAX, f64::INFINITY, f64::NAN] {
        let strata = sampled(SETTINGS, &|point| Color::splat(if point.x < 0.6 { huge } else { 0.0 }));
        assert!(strata.len() <= SETTINGS.most as usize, "{huge}");
    }
}

#[test]
fn a_pixel_at_the_border_has_fewer_neighbours() {
    let scene = edge(0.6);
    let own = quarters(DVec2::ZERO, &scene);
    let around = [[None, None, None], [None, Some(&own), None], [None, None, None]];
    let mut strata = Strata::default();
    strata.start(&own);
    let mut rng = Drand48::seeded(7);
    assert!(!strata.divide(SETTINGS, &around, &mut rng).is_empty());
}

#[test]
fn a_stratum_is_compared_with_the_samples_beside_it() {
    // Each sample around the pixel has a number of its own, whose bits tell which have been counted.
    let value = |pixel: usize, quarter: usize| f64::from(1 << (2 * pixel + quarter / 2 + quarter % 2 * 9));
    let offsets = quarters(DVec2::ZERO, &flat).offsets;
    let pixels: [[Quarters; 3]; 3] = std::array::from_fn(|j| {
        std::array::from_fn(|i| {
            let colors = [0, 1, 2, 3].map(|k| if (i, j) == (1, 1) { 0.0 } else { value(3 * j + i, k) });
            Quarters::new(offsets, colors.map(Color::splat))
        })
    });
    let around = pixels.each_ref().map(|row| row.each_ref().map(Some));
    let mut strata = Strata::default();
    strata.start(&pixels[1][1]);
    let (below, left, right, above) = (1, 3, 5, 7);
    for (k, beside) in
        [[(left, 1), (below, 2)], [(right, 0), (below, 3)], [(left, 3), (above, 0)], [(right, 2), (above, 1)]]
            .into_iter()
            .enumerate()
    {
        let depth = strata.index();
        let expected: f64 = beside.map(|(pixel, quarter)| value(pixel, quarter).powi(2)).iter().sum();
        assert_eq!(strata.contrast(&strata.strata[k], depth, &around), expected, "{k}");
    }
    // Finer strata are compared with the same samples outside, and with those beside them inside.
    let mut rng = Drand48::seeded(7);
    strata.divide(Adaptive { most: 16, error: 0.0 }, &around, &mut rng);
    assert_eq!(strata.strata.len(), 16);
    for stratum in &mut strata.strata {
        stratum.color = Color::splat(0.25 * (4 * stratum.place[1] + stratum.place[0]) as f64);
    }
    let depth = strata.index();
    for stratum in &strata.strata {
        let [x, y] = stratum.place;
        let own = stratum.color.x;
        let outside = |pixel, quarter| (value(pixel, quarter) - own).powi(2);
        let half = |place: usize| place / 2;
        let expected = [
            if x == 0 { outside(left, 2 * half(y) + 1) } else { 0.0625 },
            if x == 3 { outside(right, 2 * half(y)) } else { 0.0625 },
            if y == 0 { outside(below, 2 + half(x)) } else { 1.0 },
            if y == 3 { outside(above, half(x)) } else { 1.0 },
        ];
        assert_eq!(strata.contrast(stratum, depth, &around), expected.iter().sum::<f64>(), "{x} {y}");
    }
}
