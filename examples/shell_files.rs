//! Writes the manual page and the completions of the command line to `man` and `completions`.

use raytracer::cli::{completions, man_page};
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
    Ok(())
}
