//! The table of `docs/command-line.md`, generated from the definitions of the flags.

use super::flag::Flag;
use super::flags::FLAGS;
use super::raw::is_flag;

/// How the table starts.
pub const HEAD: &str = "| Flag | Values |";

/// The table in Markdown.
pub fn table() -> String {
    let rows: String = FLAGS.iter().map(|flag| row(flag)).collect();
    format!("{HEAD} Default | Meaning |\n|---|---|---|---|\n{rows}")
}

fn row(flag: &Flag) -> String {
    let values: Vec<&str> = flag.values.iter().map(|value| value.name).collect();
    let meaning: Vec<String> = [flag.help, flag.details].join(" ").split_whitespace().map(code).collect();
    let cells = [format!("`-{}`", flag.name), values.join(" "), flag.default.to_owned(), meaning.join(" ")];
    let cells =
        cells.map(|cell| if cell.is_empty() { cell } else { format!(" {}", cell.replace('|', "\\|")) });
    format!("|{} |\n", cells.join(" |"))
}

/// A word, in the letters of code where it is a flag, a dash or the ending of a name.
fn code(word: &str) -> String {
    let end = word.trim_end_matches([',', '.', ';']).len();
    let (word, rest) = word.split_at(end);
    let is_code = is_flag(word.as_bytes()) || word == "-" || word.starts_with('.');
    if is_code { format!("`{word}`{rest}") } else { format!("{word}{rest}") }
}
