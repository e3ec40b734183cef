//! The pictures to grade by: files, or renderings of command lines.

use super::folder::entries;
use crate::base::escape::quoted;
use crate::base::stdio::is_stdio;
use crate::caster::choose::Structure;
use crate::cli::{self, Command, Options, Output};
use crate::diagnostic::Diagnostic;
use crate::image_io::{Format, ReadFile, Wanted, read_pixels};
use crate::render::renderer::{Meshes, Renderer};
use crate::render::{Layer, Request, Tracing, Watch};
use crate::scene::load::named_files;
use crate::tools::causes::{Original, can_try};
use crate::tools::grade::Reference;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// The names and origins of references, in order. Each is made when it is needed.
pub struct References(Vec<(OsString, Origin)>);

enum Origin {
    File(PathBuf),
    Rendered(Box<Options>, Output),
}

/// The file or the scene of a reference.
pub enum Opened<'o> {
    File(&'o Path),
    Scene(Box<Renderer>, Box<Options>, &'o Output),
}

impl References {
    /// Lists the folder's pictures, or the pictures that the command lines write. If two lines write the same file, the
    /// later one counts, as it would on the disk.
    pub fn open(from: &cli::References) -> Result<Self, Diagnostic> {
        let all = match from {
            cli::References::Folder(folder) => files(folder)?,
            cli::References::Commands(file) => rendered(file)?,
        };
        match all.is_empty() {
            true => Err(Diagnostic::error("there is no picture to grade by")),
            false => Ok(Self(all)),
        }
    }

    /// The files to read: pictures, or scenes with the files that they name.
    pub fn files(&self) -> impl Iterator<Item = ReadFile> {
        self.0.iter().flat_map(|(_, origin)| match origin {
            Origin::File(path) => vec![("picture", path.clone())],
            Origin::Rendered(options, _) => {
                let scenes = options.input.iter();
                let named = scenes.clone().flat_map(|scene| named_files(scene, &options.hints()));
                scenes.map(|scene| ("scene", scene.clone())).chain(named).collect()
            }
        })
    }

    pub fn names(&self) -> impl Iterator<Item = &OsStr> {
        self.0.iter().map(|(name, _)| name.as_os_str())
    }

    /// Opens the file of a reference, or reads its scene and settles the options in its edition.
    pub fn open_one(&self, index: usize) -> Result<Opened<'_>, Diagnostic> {
        match &self.0[index].1 {
            Origin::File(path) => Ok(Opened::File(path)),
            Origin::Rendered(options, output) => {
                let loaded = options.load_scene()?;
                let options = options.in_edition(loaded.choice.edition);
                Ok(Opened::Scene(Box::new(Renderer::new(loaded, Meshes::Kept)?), Box::new(options), output))
            }
        }
    }
}

impl Opened<'_> {
    /// Reads or renders the reference. `watch` is called often while it is rendered or searched for mistakes.
    pub fn reference<'r>(&'r self, watch: Watch<'r>) -> Result<Reference<'r>, Diagnostic> {
        let (renderer, options, output) = match self {
            Self::File(path) => {
                return read_pixels(path, Wanted::Numbers).map(|(pixels, _)| Reference::of_file(pixels));
            }
            Self::Scene(renderer, options, output) => (renderer, options, output),
        };
        let layers = vec![output.layer];
        let request = Request { layers, tracing: Tracing::Fast, ..options.request() };
        let has_numbers = output.format.is_float();
        if can_try(renderer, &request) {
            let with_any = Request { structure: Structure::Any, ..request };
            let original = Original::watched(renderer, &with_any, watch)
                .ok_or_else(|| Diagnostic::error("there is no memory for the picture"))?;
            return Ok(Reference::of_scene(original, has_numbers));
        }
        let (mut pictures, _) = options.prepare(renderer, &request)?.render_watched(&request, watch)?;
        let colors = pictures.remove(0);
        Ok(Reference::rendered(colors, has_numbers))
    }
}

fn files(folder: &Path) -> Result<Vec<(OsString, Origin)>, Diagnostic> {
    let mut names = entries(folder)?;
    names.retain(|name| Format::of_input(Path::new(name)).is_some());
    Ok(names.into_iter().map(|name| (name.clone(), Origin::File(folder.join(name)))).collect())
}

/// The pictures of the command lines in a file, in the order in which they are first written.
fn rendered(file: &Path) -> Result<Vec<(OsString, Origin)>, Diagnostic> {
    let shown = quoted(file);
    if file.exists() && !file.is_file() {
        return Err(Diagnostic::error(format!("cannot read the commands {shown}: it is not a regular file")));
    }
    let text = std::fs::read_to_string(file);
    let text =
        text.map_err(|error| Diagnostic::error(format!("cannot read the commands {shown}: {error}")))?;
    let in_file = |error: Diagnostic| Diagnostic { message: format!("{shown}, {}", error.message), ..error };
    let commands = parse_commands(&text).map_err(in_file)?;
    let mut all: Vec<(OsString, Origin)> = Vec::new();
    for options in commands {
        for output in &options.outputs {
            let Some(name) = output.file.file_name() else { continue };
            let origin = Origin::Rendered(Box::new(options.clone()), output.clone());
            match all.iter_mut().find(|(other, _)| other == name) {
                Some((_, earlier)) => *earlier = origin,
                None => all.push((name.to_owned(), origin)),
            }
        }
    }
    Ok(all)
}

/// Parses the command lines of a text, all of which render a scene. Each starts with the name of the program, which may
/// be any; words are separated by white space. Empty lines and lines that start with `#` are skipped. The error about
/// the first line that cannot be used has its number.
fn parse_commands(text: &str) -> Result<Vec<Options>, Diagnostic> {
    let lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.trim()));
    let commands = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let in_line = |number, error: Diagnostic| Diagnostic {
        message: format!("line {number}: {}", error.message),
        ..error
    };
    commands.map(|(number, line)| rendering(line).map_err(|error| in_line(number, error))).collect()
}

fn rendering(line: &str) -> Result<Options, Diagnostic> {
    let options = match cli::parse(line.split_whitespace().map(OsString::from))? {
        Command::Render(options) if options.input.is_some() => *options,
        _ => return Err(Diagnostic::error("the command does not render a scene")),
    };
    let is_cost = |output: &Output| matches!(output.layer, Layer::Cost(_));
    let is_stream = options.input.as_deref().is_some_and(is_stdio);
    let problem = if options.outputs.iter().any(is_cost) {
        "a cost map cannot be graded: leave out `-cost_map`"
    } else if options.region.is_some() {
        "a part cannot be graded: leave out `-region`"
    } else if is_stream || options.outputs.iter().any(Output::is_standard_output) {
        "`-` cannot be graded: name a file"
    } else {
        return Ok(options);
    };
    Err(Diagnostic::error(problem))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_lines_and_comments_are_skipped() {
        let text = "# a\n\nraytracer -input a.txt -output a.tga\r\n  ./rt -input b.txt -size 7 8\n";
        let found = parse_commands(text).unwrap();
        assert_eq!(found.iter().map(|options| options.size).collect::<Vec<_>>(), [[100, 100], [7, 8]]);
    }

    #[test]
    fn a_line_that_cannot_be_used_is_named() {
        for (line, message) in [
            ("rt -input a.txt -sise 1 1", "line 2: unexpected argument '-sise' found"),
            ("rt -help", "line 2: the command does not render a scene"),
            ("rt -compare a.tga -reference b.tga", "line 2: the command does not render a scene"),
            ("rt -grade a -reference b", "line 2: the command does not render a scene"),
            (
                "rt -input a.txt -region 0 0 9 9 -output a.tga",
                "line 2: a part cannot be graded: leave out `-region`",
            ),
            ("rt -input - -output a.tga", "line 2: `-` cannot be graded: name a file"),
            ("rt -input a.txt -output - tga", "line 2: `-` cannot be graded: name a file"),
            (
                "rt -input a.txt -cost_map rays a.tga",
                "line 2: a cost map cannot be graded: leave out `-cost_map`",
            ),
        ] {
            assert_eq!(parse_commands(&format!("\n{line}")).unwrap_err().message, message);
        }
    }
}
