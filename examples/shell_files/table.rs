//! The table of `docs/flags.md`, generated from the flags.

use clap::Arg;

/// How the table starts.
pub const HEAD: &str = "| Flag | Meaning |";

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
            None => line.trim_end_matches('.').split(' ').map(code).collect::<Vec<_>>().join(" ") + ".",
        });
    }
    if !flag.get_default_values().is_empty() {
        let values: Vec<_> = flag.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
        meaning.push(format!("Default: {}.", values.join(" ")));
    }
    format!("| `-{}{usage}` | {} |\n", flag.get_id(), meaning.join(" ").replace('|', "\\|"))
}

/// A word, in the letters of code where it is a flag, a dash or the ending of a name.
fn code(word: &str) -> String {
    let end = word.trim_end_matches([',', '.', ';']).len();
    let (word, rest) = word.split_at(end);
    let is_flag =
        word.strip_prefix('-').is_some_and(|name| name.starts_with(|c: char| c.is_ascii_lowercase()));
    let is_code = is_flag || word == "-" || word.starts_with('.');
    if is_code { format!("`{word}`{rest}") } else { format!("{word}{rest}") }
}
