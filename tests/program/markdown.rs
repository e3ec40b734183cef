//! The code blocks, links and pictures of a document in Markdown, and the commands in its blocks.

/// Stands before a block that the tests do not run, and says why.
pub const NOT_RUN: &str = "<!-- Not run by the tests: ";

/// The first words of lines that are commands, in a block without a prompt.
const COMMANDS: &[&str] = &[
    "cargo",
    "cat",
    "cp",
    "curl",
    "export",
    "for",
    "mkdir",
    "mv",
    "parallel",
    "proofs/run",
    "python3",
    "raytracer",
    "sbatch",
    "ssh",
    "sudo",
];

/// An indented or fenced block.
pub struct Block<'a> {
    /// What stands behind the fence, such as `console`.
    pub info: &'a str,
    pub lines: Vec<&'a str>,
    /// Whether the line above says that it is not run.
    pub is_not_run: bool,
}

/// A command, and the lines that it is shown to print, if the block shows any output at all.
pub struct Command {
    pub line: String,
    pub shown: Option<Vec<String>>,
}

/// All blocks of a document.
pub fn blocks(text: &str) -> Vec<Block<'_>> {
    let lines: Vec<&str> = text.lines().collect();
    let mut blocks = vec![];
    // The last line of text above.
    let (mut above, mut after_blank, mut next) = ("", true, 0);
    while let Some(&line) = lines.get(next) {
        next += 1;
        let is_indented = line.starts_with("    ") && after_blank;
        after_blank = line.is_empty();
        let is_not_run = above.starts_with(NOT_RUN);
        if let Some(info) = line.strip_prefix("```") {
            let inside: Vec<_> = lines[next..].iter().copied().take_while(|line| *line != "```").collect();
            next += inside.len() + 1;
            blocks.push(Block { info, lines: inside, is_not_run });
        } else if is_indented {
            let is_inside = |line: &&str| line.starts_with("    ") || line.is_empty();
            let inside: Vec<_> = lines[next - 1..].iter().copied().take_while(is_inside).collect();
            next += inside.len() - 1;
            blocks.push(Block {
                info: "",
                lines: inside.iter().map(|line| line.trim_start()).collect(),
                is_not_run,
            });
        } else if !line.is_empty() {
            above = line;
            continue;
        } else {
            continue;
        }
        above = "";
        after_blank = true;
    }
    blocks
}

impl Block<'_> {
    /// The commands: all lines with a prompt of a console, or those that start with the name of a program.
    pub fn commands(&self) -> Vec<Command> {
        if self.info == "console" { self.of_console() } else { self.of_listing() }
    }

    fn of_console(&self) -> Vec<Command> {
        let mut commands: Vec<Command> = vec![];
        for line in &self.lines {
            match (line.strip_prefix("$ "), commands.last_mut()) {
                (Some(line), _) => commands.push(Command { line: line.into(), shown: Some(vec![]) }),
                (None, Some(Command { shown: Some(shown), .. })) => shown.push(line.to_string()),
                (None, _) => panic!("`{line}` stands before every command"),
            }
        }
        commands
    }

    fn of_listing(&self) -> Vec<Command> {
        let text = self.lines.join("\n").replace("\\\n", " ");
        let is_command = |line: &&str| {
            let first = line.split_whitespace().next().unwrap_or("");
            self.info.is_empty() && (COMMANDS.contains(&first) || first.starts_with("target/"))
        };
        text.lines().filter(is_command).map(|line| Command { line: line.into(), shown: None }).collect()
    }
}

/// The targets of all links and pictures, with whether each is a picture.
pub fn links(text: &str) -> Vec<(&str, bool)> {
    let mut links = vec![];
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("](") {
        let is_picture = before.rfind('[').is_some_and(|start| before[..start].ends_with('!'));
        links.push((after.split(')').next().unwrap_or(""), is_picture));
        rest = after;
    }
    links
}

/// The name by which a link finds a heading.
pub fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}
