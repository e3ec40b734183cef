//! The page: one document, made of the files beside this one.

use super::http::Answer;
use super::key::random_digits;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
/// In the order in which they run; each uses what those before it define.
const SCRIPTS: [&str; 9] = [
    include_str!("asking.js"),
    include_str!("camera.js"),
    include_str!("controls.js"),
    include_str!("view.js"),
    include_str!("hand.js"),
    include_str!("rays.js"),
    include_str!("editor.js"),
    include_str!("compare.js"),
    include_str!("main.js"),
];

/// The page. Its policy lets nothing run or be loaded but what stands in it: the mark on its own parts is new each
/// time.
pub fn page() -> Answer {
    let Ok(mark) = random_digits() else { return Answer::text(503, "there are no random numbers") };
    let scripts: String =
        SCRIPTS.iter().map(|script| format!("<script nonce=\"{mark}\">\n{script}</script>\n")).collect();
    let style = format!("<style nonce=\"{mark}\">\n{STYLE}</style>");
    let body = PAGE.replace("<!-- style -->", &style).replace("<!-- scripts -->", &scripts).into_bytes();
    let policy = format!(
        "default-src 'none'; script-src 'nonce-{mark}'; style-src 'nonce-{mark}'; connect-src 'self'; img-src data:; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    );
    Answer { status: 200, content_type: "text/html; charset=utf-8", policy: Some(policy), body }
}
