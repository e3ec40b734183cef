//! The plot `docs/front.svg` shows the errors and times of the glass scene in `docs/speed-against-error.md`.

use std::fmt::Write;
use std::path::Path;

const PAGE: &str = include_str!("../../docs/speed-against-error.md");

/// The frame of the plot, in pixels.
const LEFT: f64 = 52.0;
const RIGHT: f64 = 420.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 230.0;
/// The ends of the logarithmic axes, in seconds and in levels.
const SECONDS: [f64; 2] = [0.001, 2.0];
const LEVELS: [f64; 2] = [0.5, 50.0];

/// The first word of a row of the page's tables, and the colour of its line.
const SERIES: [(&str, &str, &str); 5] = [
    ("random", "random", "#888888"),
    ("uniform", "uniform", "#cc8800"),
    ("jittered", "jittered", "#0066cc"),
    ("sobol", "Sobol'", "#228833"),
    ("", "adaptive", "#cc2222"),
];

/// Returns where an error and a time are in the plot.
fn place(error: f64, seconds: f64) -> [f64; 2] {
    let along = |value: f64, [least, most]: [f64; 2]| (value / least).ln() / (most / least).ln();
    [LEFT + (RIGHT - LEFT) * along(seconds, SECONDS), BOTTOM + (TOP - BOTTOM) * along(error, LEVELS)]
}

/// Returns the points of a row with cells such as `5.69 in 0.0242 s`.
fn points(first_word: &str) -> Vec<[f64; 2]> {
    let (_, section) = PAGE.split_once("\n### Glass\n").expect("a section");
    let is_meant = |cells: &Vec<&str>| cells.len() > 3 && cells[1] == first_word && cells[2].contains(" in ");
    let mut rows = section.lines().map(|line| line.split('|').map(str::trim).collect());
    let row: Vec<&str> = rows.find(is_meant).expect("a row");
    let number = |text: &str| text.trim_end_matches(" s").parse::<f64>().expect("a number");
    let pairs = row.iter().filter_map(|cell| cell.split_once(" in "));
    pairs.map(|(error, seconds)| place(number(error), number(seconds))).collect()
}

fn plot() -> String {
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 520 270\" width=\"520\" height=\"270\" \
         font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"520\" height=\"270\" fill=\"#ffffff\"/>\n",
    );
    for (seconds, label) in [(0.001, "1 ms"), (0.01, "10 ms"), (0.1, "100 ms"), (1.0, "1 s")] {
        let [x, _] = place(1.0, seconds);
        let _ = writeln!(svg, "<path d=\"M{x:.1} {TOP}V{BOTTOM}\" stroke=\"#dddddd\"/>");
        let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"246\" text-anchor=\"middle\">{label}</text>");
    }
    for error in [1.0, 2.0, 5.0, 10.0, 20.0] {
        let [_, y] = place(error, 1.0);
        let _ = writeln!(svg, "<path d=\"M{LEFT} {y:.1}H{RIGHT}\" stroke=\"#dddddd\"/>");
        let _ = writeln!(svg, "<text x=\"46\" y=\"{:.1}\" text-anchor=\"end\">{error}</text>", y + 4.0);
    }
    for (first_word, name, color) in SERIES {
        let points = points(first_word);
        let line: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>",
            line.join(" ")
        );
        for [x, y] in &points {
            let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{color}\"/>");
        }
        let row = SERIES.iter().position(|(_, other, _)| *other == name).unwrap_or_default() as f64;
        let y = 30.0 + 20.0 * row;
        let _ = writeln!(svg, "<text x=\"432\" y=\"{y}\" fill=\"{color}\">{name}</text>");
    }
    svg + "<text x=\"236\" y=\"263\" text-anchor=\"middle\">processor time</text>\n\
           <text transform=\"translate(14 122) rotate(-90)\" text-anchor=\"middle\">RMSE, levels</text>\n</svg>\n"
}

#[test]
fn the_plot_shows_the_table() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/front.svg");
    let plot = plot();
    if std::env::var_os("BLESS").is_some_and(|value| value == "1") {
        return std::fs::write(&path, plot).expect("the plot is written");
    }
    assert!(std::fs::read_to_string(&path).unwrap_or_default() == plot, "BLESS=1 writes docs/front.svg anew");
}
