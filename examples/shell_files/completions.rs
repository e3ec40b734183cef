//! Completions of the command line for bash, zsh and fish, generated from the flags.
//!
//! clap_complete's scripts offer files of all kinds, and nothing for the second value of a flag.

use clap::Arg;
use raytracer::cli::command;

const ORIGIN: &str = "Made from the flags by `cargo run --example shell_files`.";

/// What completions offer for a value.
enum Offer {
    /// Files with these extensions, and folders on the way to them.
    Files(&'static str),
    Folders,
    Words(String),
    Nothing,
}

/// A value of a flag.
struct Value {
    name: String,
    offer: Offer,
    /// Its index, counted from 0, or `*` if it stands for any number of values.
    index: String,
    is_required: bool,
}

fn values(flag: &Arg) -> Vec<Value> {
    let names = flag.get_value_names().filter(|_| flag.get_action().takes_values()).unwrap_or_default();
    let counts = flag.get_num_args().unwrap_or((names.len()..=names.len()).into());
    let is_endless = counts.max_values() == usize::MAX;
    let value = |(index, name): (usize, &clap::builder::Str)| Value {
        name: name.to_string(),
        offer: offer(flag, name),
        index: if is_endless { "*".to_owned() } else { index.to_string() },
        is_required: index < counts.min_values(),
    };
    // The name of a format is short, and follows few pictures.
    names.iter().filter(|name| *name != "format").enumerate().map(value).collect()
}

/// The first sentence about a flag.
fn summary(flag: &Arg) -> String {
    let help = flag.get_help().map(ToString::to_string).unwrap_or_default();
    help.split(". ").next().unwrap_or_default().to_owned()
}

/// The name of a value tells what it is.
fn offer(flag: &Arg, name: &str) -> Offer {
    let words: Vec<String> =
        flag.get_possible_values().iter().map(|word| word.get_name().to_owned()).collect();
    match name {
        _ if !words.is_empty() => Offer::Words(words.join(" ")),
        "scene" | "commands" => Offer::Files("txt"),
        "picture" if ["compare", "convert", "reference"].contains(&flag.get_id().as_str()) => {
            Offer::Files("tga png bmp ppm pgm pbm pnm pam pfm exr")
        }
        "picture" => Offer::Files("tga png bmp ppm pfm exr"),
        "parts" => Offer::Files("tga png"),
        "page" => Offer::Files("html"),
        "document" => Offer::Files("json"),
        "folder" => Offer::Folders,
        "nx" => Offer::Words("auto none".to_owned()),
        "kind" => Offer::Words("rays tests cells".to_owned()),
        _ => Offer::Nothing,
    }
}

/// The text of a shell for all values of all flags.
fn of_values(text: fn(&Arg, &Value) -> String) -> String {
    let command = command();
    command
        .get_arguments()
        .flat_map(|flag| values(flag).into_iter().map(move |value| text(flag, &value)))
        .collect()
}

/// All spellings of a flag.
fn names(flag: &Arg) -> impl Iterator<Item = &str> {
    std::iter::once(flag.get_id().as_str()).chain(flag.get_all_aliases().into_iter().flatten())
}

fn flag_names() -> String {
    command().get_arguments().map(|flag| format!("-{}", flag.get_id())).collect::<Vec<_>>().join(" ")
}

/// The completions for bash.
pub fn bash() -> String {
    let cases: String = of_values(bash_case);
    let flags = flag_names();
    format!(
        r#"# Completions of raytracer for bash. {ORIGIN}

# Offers the files with these extensions in any case, and folders.
_raytracer_files() {{
    local current=$1 extension name
    shift
    for extension; do
        while IFS= read -r name; do COMPREPLY+=("$name"); done < <(
            shopt -s nocasematch
            compgen -f -X "!*.$extension" -- "$current"
        )
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

fn bash_case(flag: &Arg, value: &Value) -> String {
    let action = match &value.offer {
        Offer::Files(extensions) => format!("_raytracer_files \"$current\" {extensions}; "),
        Offer::Folders => "_raytracer_files \"$current\"; ".to_owned(),
        Offer::Words(words) => format!("COMPREPLY=($(compgen -W '{words}' -- \"$current\")); "),
        Offer::Nothing => String::new(),
    };
    let names: Vec<String> = names(flag).map(|name| format!("{name}:{}", value.index)).collect();
    format!("            {}) {action}return ;;\n", names.join(" | "))
}

/// The completions for zsh.
pub fn zsh() -> String {
    let specs: Vec<String> = command().get_arguments().flat_map(zsh_specs).collect();
    format!(
        "#compdef raytracer\n# Completions of raytracer for zsh. {ORIGIN}\n\n_arguments \\\n{}\n",
        specs.join(" \\\n")
    )
}

/// The specification of a flag, and those of its other names.
fn zsh_specs(flag: &Arg) -> Vec<String> {
    // A flag is given once, by one of its names.
    let once: Vec<String> = names(flag).map(|name| format!("-{name}")).collect();
    let values: String = values(flag).iter().map(zsh_value).collect();
    let doc = summary(flag).replace(['[', ']'], "").replace('\'', "'\\''");
    names(flag).map(|name| format!("    '({})-{name}[{doc}]{values}'", once.join(" "))).collect()
}

fn zsh_value(value: &Value) -> String {
    let action = match &value.offer {
        // A single word in brackets would be the qualifier of a pattern.
        Offer::Files(extension) if !extension.contains(' ') => format!("_files -g \"(#i)*.{extension}\""),
        Offer::Files(extensions) => format!("_files -g \"(#i)*.({})\"", extensions.replace(' ', "|")),
        Offer::Folders => "_files -/".to_owned(),
        Offer::Words(words) => format!("({words})"),
        Offer::Nothing => " ".to_owned(),
    };
    let start = match () {
        // Up to the next flag.
        () if value.index == "*" => ":*-*:",
        () if value.is_required => ":",
        () => "::",
    };
    format!("{start}{}:{action}", value.name)
}

/// The completions for fish.
pub fn fish() -> String {
    let flags: String = command().get_arguments().map(fish_flag).collect();
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

# The files that fish itself offers and that have one of these extensions, in any case, and folders.
function __raytracer_files
    set -l endings / '\.'$argv
    complete -C "__raytracer_no_command "(commandline -ct) | string match -ri -- '^.*(?:'(string join '|' $endings)')$'
end

complete -c raytracer -f
{flags}{values}"#
    )
}

fn fish_flag(flag: &Arg) -> String {
    let doc = summary(flag).replace('\\', "\\\\").replace('\'', "\\'");
    names(flag).map(|name| format!("complete -c raytracer -o {name} -d '{doc}'\n")).collect()
}

fn fish_value(flag: &Arg, value: &Value) -> String {
    let candidates = match &value.offer {
        Offer::Files(extensions) => format!("(__raytracer_files {extensions})"),
        Offer::Folders => "(__raytracer_files)".to_owned(),
        Offer::Words(words) => words.clone(),
        Offer::Nothing => return String::new(),
    };
    let number = value.index.replace('*', "\\*");
    let line =
        |name| format!("complete -c raytracer -n '__raytracer_is_value {name} {number}' -a '{candidates}'\n");
    names(flag).map(line).collect()
}
