//! Differences that no cause explains, or only in part.

use crate::causes::{FLAGS, SCENE, cause, equal, folder, transformed, write};
use crate::support::Folder;
use raytracer::picture::Picture;
use std::fs;

#[test]
fn equal_pictures_have_no_cause() {
    let folder = folder();
    folder.run(&format!("-input s.txt {FLAGS} -output a.png")).ok();
    assert_eq!(cause(&folder, FLAGS), "");
    // Nor has a difference without a scene, or one of the rendered picture.
    folder.run("-input s.txt -size 48 36 -output b.png").ok();
    // Shadows are not known from pictures alone.
    for line in ["-compare a.png -reference b.png", &format!("-input s.txt {FLAGS} -reference b.png")] {
        let run = folder.run(line).ok();
        assert!(
            run.stdout.contains("PICTURE COMPARISON") && !run.stdout.contains("  cause"),
            "{}",
            run.stdout
        );
    }
}

#[test]
fn what_became_of_a_file_is_known_without_a_scene() {
    let folder = folder();
    let tga = folder.render(FLAGS);
    write(&folder, &transformed(&tga, |x, y| tga.at(x, y)));
    fs::rename(folder.path().join("a.png"), folder.path().join("b.png")).unwrap();
    let (right, bottom) = (tga.width - 1, tga.height - 1);
    for (picture, words) in [
        (transformed(&tga, |x, y| tga.at(right - x, bottom - y)), "turned by 180 degrees"),
        (
            transformed(&tga, |x, y| tga.at(x, y).map(|byte| byte.saturating_add(1))),
            "one level brighter everywhere",
        ),
    ] {
        write(&folder, &picture);
        let run = folder.run("-compare a.png -reference b.png").ok();
        assert!(
            run.stdout.contains(&format!("  cause                      {}\n", equal(words))),
            "{}",
            run.stdout
        );
    }
}

/// Numbers below `end` without an order, the same in every run.
fn random(mut state: u64) -> impl FnMut(u64) -> u64 {
    move |end| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % end
    }
}

#[test]
fn noise_has_no_cause() {
    let folder = folder();
    let tga = folder.render(FLAGS);
    let cell = |seed| std::cell::RefCell::new(random(seed));
    let (any, small, rare) = (cell(1), cell(2), cell(3));
    let pictures = [
        ("random bytes", transformed(&tga, |_, _| [(); 3].map(|()| any.borrow_mut()(256) as u8))),
        (
            "small noise",
            transformed(&tga, |x, y| {
                tga.at(x, y).map(|byte| byte.saturating_add(small.borrow_mut()(5) as u8).saturating_sub(2))
            }),
        ),
        (
            "black specks",
            transformed(&tga, |x, y| if rare.borrow_mut()(20) == 0 { [0; 3] } else { tga.at(x, y) }),
        ),
    ];
    for (name, picture) in pictures {
        write(&folder, &picture);
        let found = cause(&folder, FLAGS);
        let tried: u32 =
            found.strip_prefix("none of ").and_then(|rest| rest.split(' ').next()?.parse().ok()).unwrap_or(0);
        assert!(tried > 20, "{name}: {found}");
    }
}

#[test]
fn a_mistake_among_others_is_named_with_its_share() {
    let folder = folder();
    folder.run("-input s.txt -size 48 36 -bounces 2 -output b.tga").ok();
    let wrong = folder.tga("b.tga");
    // Something else is wrong in a corner, and everywhere by a level.
    write(
        &folder,
        &transformed(
            &wrong,
            |x, y| if x < 5 && y < 5 { [0; 3] } else { wrong.at(x, y).map(|byte| byte | 1) },
        ),
    );
    let found = cause(&folder, FLAGS);
    let share = found
        .strip_prefix("in part this program's picture without -shadows, which makes ")
        .and_then(|rest| rest.strip_suffix("% of the wrong pixels right"));
    let percent = share.unwrap_or_else(|| panic!("{found}"));
    assert!((50..100).contains(&percent.parse::<u32>().unwrap()), "{found}");
    // A white half of the picture is most of the error.
    write(&folder, &transformed(&wrong, |x, y| if y < 20 { [255; 3] } else { wrong.at(x, y) }));
    let found = cause(&folder, FLAGS);
    assert!(found.starts_with("none of "), "{found}");
}

#[test]
fn pixels_that_differ_by_a_level_are_counted() {
    let folder = folder();
    folder.run("-input s.txt -size 48 36 -bounces 2 -output b.tga").ok();
    let wrong = folder.tga("b.tga");
    let near = |x, y| if (x, y) == (0, 0) { wrong.at(x, y).map(|byte| byte ^ 1) } else { wrong.at(x, y) };
    write(&folder, &transformed(&wrong, near));
    let expected = "this program's picture without -shadows (rounding: 1 pixel by one level)";
    assert_eq!(cause(&folder, FLAGS), expected);
}

#[test]
fn where_the_reference_is_another_picture_this_program_s_own_is_tried_first() {
    let folder = folder();
    folder.run(&format!("-input s.txt {FLAGS} -output a.png")).ok();
    folder.run("-input s.txt -size 48 36 -output b.png").ok();
    let expected = "equals this program's picture (0 pixels differ)";
    assert_eq!(cause(&folder, &format!("{FLAGS} -reference b.png")), expected);
}

#[test]
fn the_kind_of_an_unknown_difference_is_told() {
    let folder = folder();
    let flags = "-size 120 90";
    let tga = folder.render(flags);
    let line = SCENE.lines().position(|line| line.contains("Sphere { center -1.2 .6 0")).unwrap() + 1;
    folder.write("larger.txt", SCENE.replace("0 radius .8", "0 radius .84"));
    folder.run(&format!("-input larger.txt {flags} -output larger.tga")).ok();
    let larger = folder.tga("larger.tga");
    let is_far = |x, y| (0..3).any(|i| larger.at(x, y)[i].abs_diff(tga.at(x, y)[i]) > 40);
    let outline = |x, y| if is_far(x, y) { larger.at(x, y) } else { tga.at(x, y) };
    write(&folder, &transformed(&tga, outline));
    let expected = format!("; the outline of the Sphere in line {line} is elsewhere: ");
    let found = cause(&folder, flags);
    assert!(found.contains(&expected), "{found}");
    // Each pixel in a way of its own, and all pixels in one way.
    let random = |x: usize, y: usize| (x * 7919 + y * 104_729) % 97 % 8;
    write(&folder, &transformed(&tga, |x, y| tga.at(x, y).map(|byte| byte / 8 * random(x, y) as u8)));
    let found = cause(&folder, flags);
    assert!(found.contains(" differ in different ways, as with an epsilon that is too small "), "{found}");
    write(&folder, &transformed(&tga, |x, y| tga.at(x, y).map(|byte| byte / 4 * 3)));
    let found = cause(&folder, flags);
    assert!(found.starts_with("none of ") && !found.contains("different ways"), "{found}");
}

/// A sphere of radius 1.5 in the light along (-1, -1, -1), traced in single precision with this epsilon.
fn sphere_in_single_precision(size: usize, epsilon: f32) -> Picture {
    type V = [f32; 3];
    let dot = |a: V, b: V| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let radius = 1.5_f32;
    // Where a ray meets the sphere.
    let crossings = |origin: V, direction: V| {
        let (b, c) = (dot(origin, direction), dot(origin, origin) - radius * radius);
        let discriminant = b * b - c;
        (discriminant >= 0.0).then(|| [-b - discriminant.sqrt(), -b + discriminant.sqrt()])
    };
    let to_light = [1.0 / 3.0_f32.sqrt(); 3];
    let diffuse = [0.8, 0.7, 0.6];
    let screen = |pixel: usize| 4.0 * ((pixel as f32 + 0.5) / size as f32 - 0.5);
    let color = |x: usize, y: usize| {
        let (eye, direction) = ([screen(x), -screen(y), 5.0], [0.0, 0.0, -1.0]);
        let Some([t, _]) = crossings(eye, direction) else { return [0; 3] };
        let point = [0, 1, 2].map(|axis: usize| eye[axis] + t * direction[axis]);
        let cosine = dot(point, to_light) / radius;
        let is_blocked = crossings(point, to_light).is_some_and(|all| all.into_iter().any(|t| t > epsilon));
        let light = if cosine > 0.0 && !is_blocked { 0.9 * cosine } else { 0.0 };
        diffuse.map(|channel: f32| (255.0 * channel * (0.1 + light)) as u8)
    };
    let pixels = (0..size).flat_map(|y| (0..size).flat_map(move |x| color(x, y)));
    Picture::from_rgb(size as u32, size as u32, pixels.collect())
}

#[test]
fn the_speckles_of_single_precision_are_known() {
    let folder = Folder::with_scene(
        "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 4 }
         Background { color 0 0 0 ambientLight .1 .1 .1 }
         Lights { numLights 1 DirectionalLight { direction -1 -1 -1 color .9 .9 .9 } }
         Materials { numMaterials 1 Material { diffuseColor .8 .7 .6 } }
         Group { numObjects 1 MaterialIndex 0 Sphere { center 0 0 0 radius 1.5 } }",
    );
    for (epsilon, is_known) in [(0.0, true), (2e-7, true), (1e-3, false)] {
        write(&folder, &sphere_in_single_precision(150, epsilon));
        let found = cause(&folder, "-size 150 150 -shadows");
        assert_eq!(found.contains("scattered pixels show shadow acne"), is_known, "{epsilon}: {found}");
    }
}
