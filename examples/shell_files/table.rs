//! The table of `docs/flags.md`, generated from the flags.

use clap::Arg;

/// How the table starts.
pub const HEAD: &str = "| Flag | Meaning |";
/// The words that are values after a flag.
const VALUES: [&str; 8] = ["-", "png", "aalto", "2012a5", "auto", "none", "size", "shadow"];

/// Returns the table in Markdown.
pub fn table() -> String {
    let rows: String = raytracer::cli::command().get_arguments().map(row).collect();
    format!("{HEAD}\n|---|---|\n{rows}")
}

fn row(flag: &Arg) -> String {
    let values = flag.get_value_names().filter(|_| flag.get_action().takes_values()).unwrap_or_default();
    let usage: String = values.iter().map(|value| format!(" {value}")).collect();
    let help = flag.get_long_help().or(flag.get_help()).map(ToString::to_string).unwrap_or_default();
    let mut meaning = vec![];
    for line in help.lines().filter(|line| !line.is_empty()) {
        meaning.push(match line.strip_prefix("Example: ") {
            Some(example) => format!("Example: `{example}`."),
            // clap leaves out the full stop of a single paragraph.
            None => line.trim_end_matches('.').split(' ').fold(String::new(), with_word) + ".",
        });
    }
    if !flag.get_default_values().is_empty() {
        let values: Vec<_> = flag.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
        meaning.push(format!("Default: {}.", values.join(" ")));
    }
    format!("| `-{}{usage}` | {} |\n", flag.get_id(), meaning.join(" ").replace('|', "\\|"))
}

/// Adds a word to a text: as code if it is a flag, a flag's value, a dash or the ending of a name.
fn with_word(text: String, word: &str) -> String {
    let (word, rest) = word.split_at(word.trim_end_matches([',', '.', ';']).len());
    let space = if text.is_empty() { "" } else { " " };
    let is_flag =
        word.strip_prefix('-').is_some_and(|name| name.starts_with(|c: char| c.is_ascii_lowercase()));
    match text.strip_suffix('`') {
        Some(code) if VALUES.contains(&word) => format!("{code} {word}`{rest}"),
        _ if is_flag || word == "-" || word.starts_with('.') => format!("{text}{space}`{word}`{rest}"),
        _ => format!("{text}{space}{word}{rest}"),
    }
}
