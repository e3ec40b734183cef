//! Shared by the tests of the program: temporary folders, runs of the program, small scenes and pictures.

use raytracer::diagnostic::Diagnostic;
use raytracer::image_io::{Format, OutputFile};
use raytracer::picture::Picture;
use std::ffi::OsString;
use std::fs;
use std::io::{Write, pipe};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// The output and the status of a run.
#[derive(Debug)]
pub struct Run {
    /// None if the program was ended by a signal.
    pub status: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Run {
    /// The run, which must have succeeded.
    pub fn ok(self) -> Self {
        assert_eq!(self.status, Some(0), "{}", self.stderr);
        self
    }

    /// The value behind a label, in the first line of standard output that starts with the label.
    pub fn value(&self, label: &str) -> &str {
        let value = self.stdout.lines().find_map(|line| line.trim_start().strip_prefix(label));
        value.unwrap_or_else(|| panic!("no {label}: {}", self.stdout)).trim()
    }

    /// The message on standard error of a run that must have failed with `status` and printed nothing else.
    pub fn message(self, status: i32) -> String {
        assert_eq!(self.status, Some(status), "{self:?}");
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        assert_eq!(self.stdout, "");
        self.stderr
    }
}

/// The program, working in `folder`.
pub fn program(folder: &Path, words: impl IntoIterator<Item = impl Into<OsString>>) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_raytracer"));
    command.args(words.into_iter().map(Into::into)).current_dir(folder).stdin(Stdio::null());
    #[cfg(unix)]
    handle_hangup(&mut command);
    command
}

/// Lets the program handle SIGHUP. `nohup cargo test` ignores the signal, and programs inherit that.
#[cfg(unix)]
fn handle_hangup(command: &mut Command) {
    use nix::sys::signal::{SigHandler, Signal, signal};
    use std::os::unix::process::CommandExt;
    // SAFETY: between fork and exec the closure only makes the system call `sigaction`, which is safe there.
    unsafe {
        command.pre_exec(|| Ok(signal(Signal::SIGHUP, SigHandler::SigDfl).map(drop)?));
    }
}

pub fn finish(command: &mut Command) -> Run {
    let output = command.output().expect("the program starts");
    Run {
        status: output.status.code(),
        stdout: String::from_utf8(output.stdout).expect("standard output is text"),
        stderr: String::from_utf8(output.stderr).expect("standard error is text"),
    }
}

/// A pipe whose reader has been closed.
pub fn nobody() -> Stdio {
    let (reader, writer) = pipe().expect("a pipe");
    drop(reader);
    writer.into()
}

/// A temporary folder, which is removed when it is dropped.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    /// A folder with a scene called `s.txt`.
    pub fn with_scene(text: &str) -> Self {
        let folder = Self::new();
        folder.write("s.txt", text);
        folder
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path().join(name), bytes).expect("a file in the temporary folder");
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The sorted names of everything in the folder.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.path()).expect("a readable folder");
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The command of a line in the course's style, without the program's name.
    pub fn command(&self, line: &str) -> Command {
        program(self.path(), line.split_whitespace())
    }

    /// The command of a line within a limit, which are words of `ulimit`.
    #[cfg(unix)]
    pub fn command_within(&self, limit: &str, line: &str) -> Command {
        let mut command = Command::new("sh");
        let script = format!("ulimit -c 0 && ulimit {limit} && exec \"$@\"");
        command.args(["-c", &script, "sh", env!("CARGO_BIN_EXE_raytracer")]).args(line.split_whitespace());
        command.current_dir(self.path());
        command
    }

    /// Makes a named pipe.
    #[cfg(unix)]
    pub fn make_pipe(&self, name: &str) {
        let made = Command::new("mkfifo").arg(self.path().join(name)).status();
        assert!(made.is_ok_and(|status| status.success()));
    }

    pub fn run(&self, line: &str) -> Run {
        finish(&mut self.command(line))
    }

    /// The picture that `-input s.txt -output o.tga` writes together with `flags`.
    pub fn render(&self, flags: &str) -> Tga {
        self.run(&format!("-input s.txt -output o.tga {flags}")).ok();
        self.tga("o.tga")
    }

    pub fn tga(&self, name: &str) -> Tga {
        Tga::read(&self.read(name))
    }
}

/// Writes a picture in the format that its name tells.
pub fn write_picture(path: &Path, picture: &Picture) -> Result<(), Diagnostic> {
    let format = Format::of(path).expect("the name of a picture");
    OutputFile::prepare(path)?.picture(format, picture)?.put_in_place()
}

pub const CAMERA: &str = "OrthographicCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 size 2 }\n";
const LIGHT: &str = "Lights { numLights 1 DirectionalLight { direction 0 0 -1 color 1 1 1 } }\n";
const WHITE: &str = "Materials { numMaterials 1 Material { } }\n";

/// A scene of this number of objects, which are white, and one light.
pub fn scene(count: usize, objects: &str) -> String {
    format!("{CAMERA}{LIGHT}{WHITE}Group {{ numObjects {count} MaterialIndex 0\n{objects}\n}}\n")
}

/// A scene of one sphere.
pub fn sphere() -> String {
    scene(1, "Sphere { center 0 0 0 radius .7 }")
}

/// That scene with a camera of all editions.
pub fn sphere_in_perspective() -> String {
    sphere().replace(CAMERA, "PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 20 }\n")
}

/// Returns true if `message` is an error in one line, and perhaps a hint in another one, which have all these parts,
/// between which ` ... ` stands.
pub fn says(message: &str, parts: &str) -> bool {
    let mut rest = message.lines().skip(1);
    let is_error =
        message.starts_with("error: ") && rest.next().is_none_or(|hint| hint.starts_with("  hint: "));
    is_error && rest.next().is_none() && parts.split(" ... ").all(|part| message.contains(part))
}

/// The only line of `message`, without the newline.
pub fn only_line(message: &str) -> &str {
    let line = message.strip_suffix('\n').expect("a line ends with a newline");
    assert!(!line.contains('\n'), "{message}");
    line
}

/// A text without its mark `@`, and the line and column of the mark, counted from 1.
pub fn unmark(marked: &str) -> (String, usize, usize) {
    let (before, after) = marked.split_once('@').expect("every row has a mark");
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|&character| character != '\n').count() + 1;
    (format!("{before}{after}"), line, column)
}

/// A picture, read without the program's own code.
#[derive(Debug, PartialEq)]
pub struct Tga {
    pub width: usize,
    pub height: usize,
    /// The red, green and blue of each pixel, in rows from the top.
    pub pixels: Vec<[u8; 3]>,
}

impl Tga {
    fn read(bytes: &[u8]) -> Self {
        let side = |at: usize| usize::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]));
        let pixels: Vec<[u8; 3]> = bytes[18..].chunks(3).map(|p| [p[2], p[1], p[0]]).collect();
        let tga = Self { width: side(12), height: side(14), pixels };
        assert_eq!(tga.pixels.len(), tga.width * tga.height);
        tga
    }

    /// The pixel in column `x` and row `y`, counted from the top left.
    pub fn at(&self, x: usize, y: usize) -> [u8; 3] {
        self.pixels[y * self.width + x]
    }

    /// The red channel, for pictures that are grey.
    pub fn greys(&self) -> Vec<u8> {
        self.pixels.iter().map(|pixel| pixel[0]).collect()
    }
}

/// Says that this test, or a part of it, is left out. Cargo shows no output of a test that passes, so this goes to
/// standard error itself.
pub fn skip(reason: &str) {
    let name = std::thread::current().name().unwrap_or_default().to_owned();
    let _ = std::io::stderr().write_all(format!("skipped: {name}: {reason}\n").as_bytes());
}

/// A folder that is not part of this project, from a variable. A test that needs it is skipped if that is not set.
pub fn outer_folder(variable: &str) -> Option<PathBuf> {
    let folder = std::env::var_os(variable).map(PathBuf::from);
    if folder.is_none() {
        skip(&format!("{variable} is not set"));
    }
    folder
}

/// The course's folder.
pub fn course() -> Option<PathBuf> {
    outer_folder("COURSE_DIR")
}

/// Sends a signal to a program, which may have ended.
#[cfg(unix)]
pub fn send(signal: nix::sys::signal::Signal, child: &std::process::Child) {
    let _ = nix::sys::signal::kill(nix::unistd::Pid::from_raw(child.id() as i32), signal);
}
