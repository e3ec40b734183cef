use super::*;

const SETTINGS: Adaptive = Adaptive { most: 1024, error: 1.0 };

type Scene<'a> = &'a dyn Fn(DVec2) -> Color;

/// The first samples of the pixel whose lower left corner is at `corner` of a scene.
fn quarters(corner: DVec2, scene: Scene, rng: &mut Drand48) -> Quarters {
    let offsets = [(-0.5, -0.5), (0.0, -0.5), (-0.5, 0.0), (0.0, 0.0)]
        .map(|at| DVec2::from(at) + 0.5 * DVec2::new(rng.random(), rng.random()));
    Quarters::new(offsets, offsets.map(|offset| scene(corner + 0.5 + offset)), [0.0; 4])
}

/// The first samples of the pixel whose lower left corner is the origin and of the eight around it.
fn around(scene: Scene, rng: &mut Drand48) -> [[Quarters; 3]; 3] {
    [-1.0, 0.0, 1.0].map(|y| [-1.0, 0.0, 1.0].map(|x| quarters(DVec2::new(x, y), scene, rng)))
}

/// Divides a pixel until it is finished.
fn divided<'a>(settings: Adaptive, pixel: Undivided<'a>, scene: Scene) -> Strata<'a> {
    let (mut strata, mut new) = (Strata::new(settings), vec![]);
    strata.start([pixel].into_iter());
    loop {
        strata.divide(&mut new);
        if new.is_empty() {
            return strata;
        }
        for &index in &new {
            let stratum = strata.stratum(index);
            stratum.color = scene(stratum.offset + 0.5);
        }
    }
}

fn undivided<'a>(pixels: &'a [[Quarters; 3]; 3], rng: Drand48) -> Undivided<'a> {
    let around = pixels.each_ref().map(|row| row.each_ref().map(Some));
    Undivided { column: 0, around, known: 0.0, rng }
}

/// Samples the pixel whose lower left corner is the origin; the eight pixels around it show the same scene.
fn sampled(settings: Adaptive, seed: u32, scene: Scene) -> Vec<Stratum> {
    let mut rng = Drand48::seeded(seed);
    let pixels = around(scene, &mut rng);
    divided(settings, undivided(&pixels, rng), scene).finish().flatten().copied().collect()
}

fn mean(strata: &[Stratum]) -> Color {
    strata.iter().map(|stratum| stratum.area() * stratum.color).sum()
}

fn edge(at: f64) -> impl Fn(DVec2) -> Color {
    move |point| if point.x + 0.3 * point.y < at { Color::ONE } else { Color::ZERO }
}

fn noise(point: DVec2) -> Color {
    Color::splat((point.x * 7919.0 + point.y * 104_729.0).sin().fract().abs())
}

#[test]
fn a_flat_pixel_keeps_its_four_samples() {
    assert_eq!(sampled(SETTINGS, 1, &|_| Color::splat(0.4)).len(), 4);
    // What changes by much less than the error is flat as well, and so is a gradient that the strata resolve.
    assert_eq!(sampled(SETTINGS, 1, &|point| Color::splat(0.4 + point.x / 1000.0)).len(), 4);
}

#[test]
fn strata_fill_the_pixel_and_hold_their_samples() {
    for error in [0.1, 1.0, 5.0] {
        let strata = sampled(Adaptive { error, ..SETTINGS }, 7, &edge(0.6));
        assert!(strata.len() > 10, "{error} {}", strata.len());
        assert_eq!(strata.iter().map(Stratum::area).sum::<f64>(), 1.0);
        let mut places: Vec<_> = strata.iter().map(|s| (s.size.to_bits(), s.corner.to_array().map(f64::to_bits))).collect();
        for Stratum { offset, corner, size, .. } in &strata {
            let inside = (offset + 0.5 - corner) / *size;
            assert!(inside.min_element() >= 0.0 && inside.max_element() < 1.0, "{inside}");
            assert_eq!((corner / *size).fract(), DVec2::ZERO);
        }
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), strata.len());
    }
}

#[test]
fn samples_gather_at_an_edge() {
    let strata = sampled(Adaptive { error: 0.5, ..SETTINGS }, 7, &edge(0.6));
    let distance = |s: &Stratum| (s.offset.x + 0.5 + 0.3 * (s.offset.y + 0.5) - 0.6).abs();
    let (fine, coarse): (Vec<_>, Vec<_>) = strata.iter().partition(|stratum| stratum.size < 0.05);
    assert!(fine.len() > 2 * coarse.len(), "{} {}", fine.len(), coarse.len());
    let near = fine.iter().filter(|stratum| distance(stratum) < 0.125).count();
    assert!(near * 5 > fine.len() * 4, "{near} of {}", fine.len());
}

/// The mean of a pixel over many seeds is that of the scene, however small a thing is that samples find by chance.
#[test]
fn what_is_found_by_chance_counts_no_more_and_no_less() {
    let dot = |point: DVec2| if (point - DVec2::new(0.6, 0.3)).length() < 0.12 { Color::ONE } else { Color::ZERO };
    let needle = |point: DVec2| if (point.x - 0.4 * point.y - 0.2).abs() < 0.03 { Color::ONE } else { Color::ZERO };
    let corner = |point: DVec2| if point.min_element() > 0.8 { Color::ONE } else { 0.2 * Color::X };
    // The share of the pixel, whose red channel counts.
    let scenes: [(Scene, f64); 3] =
        [(&dot, 0.12 * 0.12 * std::f64::consts::PI), (&needle, 0.06), (&corner, 0.2 + 0.04 * 0.8)];
    for (scene, expected) in scenes {
        for error in [0.5, 4.0, 30.0] {
            let seeds = 1..=3000;
            let settings = Adaptive { most: 256, error };
            let means: Vec<f64> = seeds.map(|seed| mean(&sampled(settings, seed, scene)).x).collect();
            let count = means.len() as f64;
            let average = means.iter().sum::<f64>() / count;
            let variance = means.iter().map(|x| (x - average).powi(2)).sum::<f64>() / (count - 1.0);
            let deviations = (average - expected) / (variance / count).sqrt();
            assert!(deviations.abs() < 3.5, "{expected} {error}: {average}, {deviations} standard errors off");
        }
    }
}

/// Gives every sample in turn another colour.
#[test]
fn whether_a_stratum_is_divided_does_not_depend_on_its_own_sample() {
    for seed in 1..40 {
        let mut rng = Drand48::seeded(seed);
        let pixels = around(&edge(0.6), &mut rng);
        let settings = Adaptive { most: 256, error: 2.0 };
        let is_divided = |scene: Scene, pixels: &[[Quarters; 3]; 3], place: usize| {
            divided(settings, undivided(pixels, rng), scene).families[0].children[place].is_some()
        };
        for place in 0..4 {
            let mut changed = pixels;
            changed[1][1].colors[place] = Color::splat(0.3);
            changed[1][1].hidden[place] = 1.0;
            assert_eq!(is_divided(&edge(0.6), &pixels, place), is_divided(&edge(0.6), &changed, place));
        }
        // The same for the parts of what has been divided, whose samples are those of the scene.
        let strata = divided(settings, undivided(&pixels, rng), &edge(0.6));
        for (index, family) in strata.families.iter().enumerate().skip(1) {
            for (place, stratum) in family.strata.iter().enumerate() {
                let corner = stratum.corner;
                let other = |point: DVec2| {
                    let inside = point - corner;
                    let is_own = inside.min_element() >= 0.0 && inside.max_element() < stratum.size;
                    if is_own { Color::splat(0.3) } else { edge(0.6)(point) }
                };
                let mut rest = pixels;
                for (offset, color) in pixels[1][1].offsets.iter().zip(&mut rest[1][1].colors) {
                    *color = other(offset + 0.5);
                }
                let again = divided(settings, undivided(&rest, rng), &other);
                let same = again.families.get(index).filter(|again| again.strata[place].corner == corner);
                if let Some(again) = same.filter(|again| again.strata[place].size == stratum.size) {
                    assert_eq!(again.children[place].is_some(), family.children[place].is_some(), "{seed} {index}");
                }
            }
        }
    }
}

#[test]
fn the_error_is_at_most_about_what_is_allowed() {
    for (error, most) in [(8.0, 256), (3.0, 1024), (1.0, 1024)] {
        let errors = (0..60).map(|k| {
            let at = 0.2 + f64::from(k) / 60.0;
            // The area below the line from (at, 0) to (at - 0.3, 1) within the pixel, where it stays inside.
            let part = |a: f64| a.clamp(0.0, 1.0).powi(2) / 2.0 + (a - 1.0).max(0.0);
            let covered = (part(at) - part(at - 0.3)) / 0.3;
            255.0 * (mean(&sampled(Adaptive { most, error }, k, &edge(at))).x - covered)
        });
        let square: f64 = errors.map(|e| e * e).sum::<f64>() / 60.0;
        assert!(square.sqrt() < 1.5 * error, "{error} {}", square.sqrt());
    }
}

#[test]
fn no_pixel_gets_more_than_the_most() {
    for (most, expected) in [(4, 4), (5, 4), (15, 4), (16, 16), (63, 16), (64, 64), (255, 64), (256, 256), (1024, 1024)] {
        assert_eq!(sampled(Adaptive { most, error: 0.0 }, 7, &noise).len(), expected, "{most}");
    }
}

#[test]
fn what_is_known_of_a_pixel_is_looked_for() {
    let flat = |_: DVec2| Color::splat(0.4);
    let mut rng = Drand48::seeded(3);
    let pixels = around(&flat, &mut rng);
    let count = |known: f64| {
        let pixel = Undivided { known, ..undivided(&pixels, rng) };
        divided(Adaptive { most: 1024, error: 1.0 }, pixel, &flat).finish().flatten().count()
    };
    assert_eq!([0.0, 1e-9, 0.25].map(count), [4, 4, 256]);
    // What a surface in a quarter may hide is looked for in the quarters around it.
    let mut hiding = pixels;
    hiding[1][1].hidden[0] = 0.25;
    let strata = divided(SETTINGS, undivided(&hiding, rng), &flat);
    assert_eq!(strata.families[0].children.map(|child| child.is_some()), [false, true, true, true]);
}

#[test]
fn colours_without_bounds_end_at_the_most() {
    for huge in [1e30, f64::MAX, f64::INFINITY, f64::NAN] {
        let strata = sampled(SETTINGS, 1, &|point| Color::splat(if point.x < 0.6 { huge } else { 0.0 }));
        assert!(strata.len() <= SETTINGS.most as usize, "{huge}");
    }
}

#[test]
fn a_pixel_at_the_border_has_fewer_neighbours() {
    let scene = edge(0.5);
    let mut rng = Drand48::seeded(7);
    let own = quarters(DVec2::ZERO, &scene, &mut rng);
    let around = [[None, None, None], [None, Some(&own), None], [None, None, None]];
    let pixel = Undivided { column: 0, around, known: 0.0, rng };
    assert!(divided(SETTINGS, pixel, &scene).finish().flatten().count() > 16);
    let flat = Quarters { colors: [Color::splat(0.7); 4], ..own };
    let around = [[None, None, None], [None, Some(&flat), None], [None, None, None]];
    let pixel = Undivided { around, ..pixel };
    assert_eq!(divided(SETTINGS, pixel, &|_| Color::splat(0.7)).finish().flatten().count(), 4);
}

#[test]
fn a_plane_of_colours_has_the_variance_within_its_strata() {
    let mut rng = Drand48::seeded(1);
    let gradient = |point: DVec2| Color::new(0.08 * point.x, 0.0, -0.08 * point.y);
    let mut sum = 0.0;
    for _ in 0..2000 {
        let pixels = around(&gradient, &mut rng);
        let mut strata = Strata::new(SETTINGS);
        strata.start([undivided(&pixels, rng)].into_iter());
        sum += f64::from(strata.block(0).variance(2));
    }
    // A uniform distribution over half a pixel has the variance 1 / 48.
    let expected = 2.0 * 0.08 * 0.08 / 48.0 / 3.0;
    assert!((sum / 2000.0 / expected - 1.0).abs() < 0.05, "{}", sum / 2000.0 / expected);
}
