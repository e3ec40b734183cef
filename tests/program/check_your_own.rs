//! The page `docs/check-your-own.md` ends at the line that makes the difference.

const PAGE: &str = include_str!("../../docs/check-your-own.md");

#[test]
fn the_line_that_the_page_ends_at_explains_the_difference() {
    let line = |text: &'static str, number: usize| text.lines().nth(number - 1).expect("a line");
    let (scene, misread) = (
        include_str!("../../docs/check-your-own/scene.txt"),
        include_str!("../../docs/check-your-own/misread.txt"),
    );
    let (_, after) = PAGE.split_once("`material 0 in line ").expect("a line is named");
    let named: usize = after.split('`').next().and_then(|number| number.parse().ok()).expect("a number");
    assert!(line(scene, named).contains("PhongMaterial"));
    let differing: Vec<usize> =
        (1..=scene.lines().count()).filter(|&n| line(scene, n) != line(misread, n)).collect();
    let [exponent] = differing[..] else { panic!("{differing:?}") };
    assert!((named..named + 5).contains(&exponent));
    assert_eq!([scene, misread].map(|text| line(text, exponent).trim()), ["exponent 40", "exponent 12"]);
}
