//! The manual page, the completions and the table in `docs/flags.md` agree with the flags, and the completions
//! work in the shells.

#[path = "../../examples/shell_files/completions.rs"]
mod completions;
#[path = "../../examples/shell_files/man_page.rs"]
mod man_page;
#[path = "../../examples/shell_files/table.rs"]
mod table;

use crate::support::skip;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The output of a program; none, with a note, where it is not installed.
fn output(program: &str, arguments: &[&str], folder: &Path) -> Option<String> {
    let mut command = Command::new(program);
    command.args(arguments).current_dir(folder).stdin(Stdio::null()).env("TERM", "dumb");
    command.env("HOME", folder.join("home"));
    match command.output() {
        Ok(output) => {
            let error = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{program}: {error}");
            Some(String::from_utf8(output.stdout).expect("text"))
        }
        Err(_) => {
            skip(&format!("{program} is not installed"));
            None
        }
    }
}

/// A folder with files and folders to choose from.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir_all(folder.path().join("home/h folder")).expect("a folder");
    for name in ["home/hut.TXT", "home/hut.c", "home/h folder/deep.txt"] {
        fs::write(folder.path().join(name), "").expect("a file");
    }
    for name in
        ["one.txt", "two words.txt", "p.tga", "q.png", "other.c", "r.json", "s.exr", "UP.TXT", "P2.Tga"]
    {
        fs::write(folder.path().join(name), "").expect("a file");
    }
    fs::create_dir(folder.path().join("scenes")).expect("a folder");
    folder
}

/// Words that are typed, the last of which is completed, and what is offered for it.
const TYPED: &[(&[&str], &[&str])] = &[
    (&["-siz"], &["-size"]),
    (&["-input", "one.txt", "-shad"], &["-shade_back", "-shadows"]),
    (&["-input", ""], &["UP.TXT", "home", "one.txt", "scenes", "two words.txt"]),
    (&["-input", "U"], &["UP.TXT"]),
    (&["-compare", "P"], &["P2.Tga"]),
    (&["-size", "3", "4", "-output", ""], &["P2.Tga", "home", "p.tga", "q.png", "s.exr", "scenes"]),
    (&["-depth", "-2", ".5", ""], &["P2.Tga", "home", "p.tga", "q.png", "s.exr", "scenes"]),
    (&["-compare", "s"], &["s.exr", "scenes"]),
    (&["-merge", "p.tga", ""], &["P2.Tga", "home", "p.tga", "q.png", "scenes"]),
    (&["-grid", ""], &["auto", "none"]),
    (&["-cost_map", ""], &["cells", "rays", "tests"]),
    (&["-size", ""], &[]),
];

/// Words that fish reads in its own way: the home folder, blanks and open quotes.
const TYPED_IN_FISH: &[(&str, &[&str])] = &[
    ("~/h", &["~/h folder", "~/hut.TXT"]),
    ("$HOME/h", &["$HOME/h folder", "$HOME/hut.TXT"]),
    ("\"home/h f", &["home/h folder"]),
];

/// The sorted lines without the slash after a folder.
fn lines(text: &str) -> Vec<String> {
    let mut lines: Vec<String> = text.lines().map(|line| line.trim_end_matches('/').to_owned()).collect();
    lines.sort();
    lines.dedup();
    lines
}

#[test]
fn the_files_are_those_of_the_table() {
    for (file, text) in [
        ("man/raytracer.1", man_page::man_page()),
        ("completions/raytracer.bash", completions::bash()),
        ("completions/_raytracer", completions::zsh()),
        ("completions/raytracer.fish", completions::fish()),
    ] {
        let found = fs::read_to_string(root().join(file)).unwrap_or_default();
        assert!(found == text, "{file}: write it anew by `cargo run --example shell_files`");
    }
    let is_row = |line: &&str| line.starts_with('|');
    let page = include_str!("../../docs/flags.md").lines();
    let rows = page.skip_while(|line| !line.starts_with(table::HEAD)).take_while(is_row);
    let found: String = rows.map(|line| line.to_owned() + "\n").collect();
    assert!(found == table::table(), "the table: write it anew by `cargo run --example shell_files`");
}

#[test]
fn bash_completes() {
    let folder = folder();
    let script = root().join("completions/raytracer.bash");
    for (words, expected) in TYPED {
        let code = r#"source "$0"; COMP_WORDS=(raytracer "$@"); COMP_CWORD=$#
            _raytracer; [ ${#COMPREPLY[@]} -eq 0 ] || printf '%s\n' "${COMPREPLY[@]}""#;
        let script = script.to_str().expect("a path");
        let arguments = [&["--norc", "-c", code, script][..], words].concat();
        let Some(offered) = output("bash", &arguments, folder.path()) else { return };
        assert_eq!(lines(&offered), *expected, "{words:?}");
    }
}

#[test]
fn fish_completes() {
    let folder = folder();
    let script = root().join("completions/raytracer.fish");
    let typed = TYPED.iter().map(|(words, expected)| (words.join(" "), *expected));
    let in_fish = TYPED_IN_FISH.iter().map(|(word, expected)| (format!("-input {word}"), *expected));
    for (words, expected) in typed.chain(in_fish) {
        let code = format!("source {}; complete -C 'raytracer {words}'", script.display());
        let Some(offered) = output("fish", &["--no-config", "-c", &code], folder.path()) else { return };
        // A description follows after a tab.
        let names: String = offered
            .lines()
            .map(|line| line.split('\t').next().unwrap_or_default().to_owned() + "\n")
            .collect();
        assert_eq!(lines(&names.replace('\\', "")), expected, "{words:?}");
    }
}

/// Prepares an interactive zsh: the matches of a completion go to a file, and ^X ends a row.
const ZSH_RC: &str = r#"
PS1=
autoload -Uz compinit
compinit -u -d ./dump
row=0
compadd() {
    if [[ ${@[1,(i)(-|--)]} == *-(O|A|D)\ * ]]; then
        builtin compadd "$@"
        return
    fi
    typeset -a hits
    builtin compadd -A hits "$@"
    (( $#hits )) && print -rl -- $hits >>hits.$row
    builtin compadd "$@"
}
end-of-row() {
    row=$((row + 1))
    BUFFER="print END-$row-"
    zle accept-line
}
zle -N end-of-row
bindkey '^I' complete-word
bindkey '^X' end-of-row
print READY
"#;

/// Types each argument in an interactive zsh, followed by a tab.
const ZSH_DRIVER: &str = r#"
zmodload zsh/zpty
zpty shell zsh -f -i
wait_for() { while zpty -r shell line; do [[ $line == *$1* ]] && return; done; }
zpty -w shell "source ./rc.zsh"
wait_for READY
row=0
for words; do
    row=$((row + 1))
    zpty -w -n shell "raytracer $words"$'\t\x18'
    wait_for END-$row-
done
zpty -d shell
"#;

#[test]
fn zsh_completes() {
    let folder = folder();
    let completions = root().join("completions");
    fs::write(folder.path().join("rc.zsh"), format!("fpath=('{}' $fpath)\n{ZSH_RC}", completions.display()))
        .expect("a file");
    let typed: Vec<String> = TYPED.iter().map(|(words, _)| words.join(" ")).collect();
    let arguments: Vec<&str> =
        ["-f", "-c", ZSH_DRIVER, "driver"].into_iter().chain(typed.iter().map(String::as_str)).collect();
    if output("zsh", &arguments, folder.path()).is_none() {
        return;
    }
    for (row, (words, expected)) in TYPED.iter().enumerate() {
        let hits = fs::read_to_string(folder.path().join(format!("hits.{row}"))).unwrap_or_default();
        assert_eq!(lines(&hits.replace('\\', "")), *expected, "{words:?}");
    }
}

#[test]
fn the_manual_page_has_no_fault() {
    let page: PathBuf = root().join("man/raytracer.1");
    let page = page.to_str().expect("a path");
    // The date is left to the day of installation, which is a warning.
    let Some(faults) = output("mandoc", &["-T", "lint", "-W", "error", page], root()) else { return };
    assert_eq!(faults, "");
}
