//! Writes what is made from the flags: the manual page, the completions, and the table in
//! `docs/flags.md`.

mod completions;
mod man_page;
mod table;

use std::fs;
use std::path::Path;

fn main() -> std::io::Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (file, text) in [
        ("man/raytracer.1", man_page::man_page()),
        ("completions/raytracer.bash", completions::bash()),
        ("completions/_raytracer", completions::zsh()),
        ("completions/raytracer.fish", completions::fish()),
    ] {
        fs::write(root.join(file), text)?;
    }
    let page = root.join("docs/flags.md");
    let text = fs::read_to_string(&page)?;
    let head = text.lines().take_while(|line| !line.starts_with(table::HEAD));
    let rest = text
        .lines()
        .skip_while(|line| !line.starts_with(table::HEAD))
        .skip_while(|line| line.starts_with('|'));
    let lines = |lines: Vec<&str>| lines.join("\n") + "\n";
    fs::write(page, lines(head.collect()) + &table::table() + &lines(rest.collect()))
}
