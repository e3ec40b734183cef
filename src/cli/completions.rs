//! Completions of the command line for bash, zsh and fish, generated from the definitions of the flags.

use super::flag::{Flag, Offer, Value};
use super::flags::FLAGS;

const ORIGIN: &str = "Made from the table of flags by `cargo run --example shell_files`.";

/// What a shell has for all values, each with its flag and index. That of a flag with any number of values stands for
/// all of them.
fn of_values(text: fn(&Flag, usize, Offer) -> String) -> String {
    let values = |flag: &&'static Flag| flag.values.iter().enumerate();
    FLAGS.iter().flat_map(|flag| values(flag).map(|(index, value)| text(flag, index, value.offer))).collect()
}

/// The words that are offered.
fn words(offer: Offer) -> String {
    match offer {
        Offer::Words(words) => words.join(" "),
        Offer::Flags => flag_names(""),
        _ => String::new(),
    }
}

fn flag_names(dash: &str) -> String {
    FLAGS.iter().map(|flag| format!("{dash}{}", flag.name)).collect::<Vec<_>>().join(" ")
}

/// The completions for bash.
pub fn bash() -> String {
    let cases: String = of_values(bash_case);
    let flags = flag_names("-");
    format!(
        r#"# Completions of raytracer for bash. {ORIGIN}

# Offers the files with these extensions, and folders.
_raytracer_files() {{
    local current=$1 extension name
    shift
    for extension; do
        while IFS= read -r name; do COMPREPLY+=("$name"); done < <(compgen -f -X "!*.$extension" -- "$current")
    done
    while IFS= read -r name; do COMPREPLY+=("$name"); done < <(compgen -d -- "$current")
    compopt -o filenames 2>/dev/null
}}

_raytracer() {{
    local current=${{COMP_WORDS[COMP_CWORD]}} flag= count=0 i
    COMPREPLY=()
    # The last flag before the word, and the number of values between.
    for ((i = COMP_CWORD - 1; i > 0; i--)); do
        case ${{COMP_WORDS[i]}} in
            -[a-zA-Z]* | --[a-zA-Z]*)
                flag=${{COMP_WORDS[i]#-}}
                flag=${{flag#-}}
                break
                ;;
        esac
        count=$((count + 1))
    done
    if [[ $current != -[a-zA-Z]* ]]; then
        case $flag:$count in
{cases}        esac
    fi
    COMPREPLY=($(compgen -W '{flags}' -- "$current"))
}}

complete -F _raytracer raytracer
"#
    )
}

fn bash_case(flag: &Flag, index: usize, offer: Offer) -> String {
    let action = match offer {
        Offer::Files(extensions) => format!("_raytracer_files \"$current\" {}", extensions.join(" ")),
        Offer::Folders => "_raytracer_files \"$current\"".to_owned(),
        Offer::Words(_) | Offer::Flags => {
            format!("COMPREPLY=($(compgen -W '{}' -- \"$current\"))", words(offer))
        }
        Offer::Nothing => String::new(),
    };
    let separator = if action.is_empty() { "" } else { "; " };
    let number = if flag.takes_any_number() { "*".to_owned() } else { index.to_string() };
    let names = flag.names().map(|name| format!("{name}:{number}"));
    format!("            {}) {action}{separator}return ;;\n", names.collect::<Vec<_>>().join(" | "))
}

/// The completions for zsh.
pub fn zsh() -> String {
    let specs: Vec<String> = FLAGS.iter().flat_map(|flag| zsh_specs(flag)).collect();
    format!(
        "#compdef raytracer\n# Completions of raytracer for zsh. {ORIGIN}\n\n_arguments \\\n{}\n",
        specs.join(" \\\n")
    )
}

/// The specification of a flag, and those of its other names.
fn zsh_specs(flag: &Flag) -> Vec<String> {
    let excluded: Vec<String> = flag.excluded().map(|other| format!("-{}", other.name)).collect();
    // A flag is given once, by one of its names.
    let once: Vec<String> = flag.names().map(|name| format!("-{name}")).chain(excluded).collect();
    let values: String = (0..flag.values.len()).map(|index| zsh_value(flag, index)).collect();
    let doc = flag.summary().replace(['[', ']'], "").replace('\'', "'\\''");
    flag.names().map(|name| format!("    '({})-{name}[{doc}]{values}'", once.join(" "))).collect()
}

fn zsh_value(flag: &Flag, index: usize) -> String {
    let Value { name, offer, .. } = flag.values[index];
    let name = name.trim_end_matches('.');
    let action = match offer {
        // A single word in brackets would be the qualifier of a pattern.
        Offer::Files([extension]) => format!("_files -g \"*.{extension}\""),
        Offer::Files(extensions) => format!("_files -g \"*.({})\"", extensions.join("|")),
        Offer::Folders => "_files -/".to_owned(),
        Offer::Words(_) | Offer::Flags => format!("({})", words(offer)),
        Offer::Nothing => " ".to_owned(),
    };
    let start = match () {
        // Up to the next flag.
        () if flag.takes_any_number() => ":*-*:",
        () if index >= *flag.value_counts().start() => "::",
        () => ":",
    };
    format!("{start}{name}:{action}")
}

/// The completions for fish.
pub fn fish() -> String {
    let flags: String = FLAGS.iter().map(|flag| fish_flag(flag)).collect();
    let values: String = of_values(fish_value);
    format!(
        r#"# Completions of raytracer for fish. {ORIGIN}

# Whether the word is the value with this index, counted from 0, of the flag, or with * any value of it.
function __raytracer_is_value
    set -l words (commandline -opc)
    set -l count 0
    for word in $words[-1..2]
        if string match -qr -- '^--?[a-zA-Z]' $word
            test (string replace -r -- '^--?' '' $word) = $argv[1]
            and contains -- $argv[2] '*' $count
            return
        end
        set count (math $count + 1)
    end
    return 1
end

# The files with these extensions, and folders.
function __raytracer_files
    set -l start (commandline -ct)
    set -l names $start*/
    for extension in $argv
        set -a names $start*.$extension
    end
    string join \n -- $names
end

complete -c raytracer -f
{flags}{values}"#
    )
}

fn fish_flag(flag: &Flag) -> String {
    let doc = flag.summary().replace('\\', "\\\\").replace('\'', "\\'");
    flag.names().map(|name| format!("complete -c raytracer -o {name} -d '{doc}'\n")).collect()
}

fn fish_value(flag: &Flag, index: usize, offer: Offer) -> String {
    let candidates = match offer {
        Offer::Files(extensions) => format!("(__raytracer_files {})", extensions.join(" ")),
        Offer::Folders => "(__raytracer_files)".to_owned(),
        Offer::Words(_) | Offer::Flags => words(offer),
        Offer::Nothing => return String::new(),
    };
    let number = if flag.takes_any_number() { "\\*".to_owned() } else { index.to_string() };
    let line =
        |name| format!("complete -c raytracer -n '__raytracer_is_value {name} {number}' -a '{candidates}'\n");
    flag.names().map(line).collect()
}
