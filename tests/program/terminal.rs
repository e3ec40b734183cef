//! What a person at a terminal sees: colours, and what a finished run wrote. Elsewhere all stays as it is.

use crate::support::{Folder, scene, skip, sphere};
use std::process::{Command, Stdio};

/// What a terminal gets from a run, and its status; none, with a note, where there is no program `script`, which has
/// pseudo terminals.
fn on_terminal(folder: &Folder, line: &str, variable: Option<(&str, &str)>) -> Option<(String, Option<i32>)> {
    let mut command = Command::new("script");
    // The terminal gets its width from a variable.
    let script = format!("stty rows 24 cols ${{WIDTH:-80}}; {} {line}", env!("CARGO_BIN_EXE_raytracer"));
    command.args(["-qec", &script, "/dev/null"]);
    command.current_dir(folder.path()).stdin(Stdio::null()).env_remove("NO_COLOR").env("TERM", "xterm");
    command.envs(variable);
    let Ok(output) = command.output() else {
        skip("script is not installed");
        return None;
    };
    Some((String::from_utf8(output.stdout).expect("text").replace("\r\n", "\n"), output.status.code()))
}

#[test]
fn a_finished_run_says_what_it_wrote_and_how_long_it_took() {
    let folder = Folder::with_scene(&sphere());
    let line = "-input s.txt -size 9 9 -output o.tga -normals n.png -json j.json";
    let Some((told, status)) = on_terminal(&folder, line, None) else { return };
    let time =
        told.strip_prefix("wrote `o.tga`, `n.png`, `j.json` in ").and_then(|rest| rest.strip_suffix(" ms\n"));
    assert!(time.is_some_and(|time| time.parse::<u32>().is_ok()) && status == Some(0), "{told}");
    let parts = "-input s.txt -size 9 9 -region 0 0 9 9 -output p.png";
    on_terminal(&folder, parts, None);
    for (line, start) in [
        ("-merge p.png -output m.tga", "wrote `m.tga` in "),
        ("-input s.txt -size 9 9 -stats -output o.tga", "****"),
    ] {
        let told = on_terminal(&folder, line, Some(("NO_COLOR", "1"))).unwrap().0;
        assert!(told.starts_with(start), "{line}: {told}");
    }
    // Nothing to tell, or nobody who wants to know.
    let quiet = on_terminal(&folder, "-input s.txt -size 9 9 -output o.tga -quiet", None).unwrap().0;
    assert!(!quiet.contains("wrote"), "{quiet}");
    let elsewhere = folder.run(line).ok();
    assert_eq!((elsewhere.stdout, elsewhere.stderr), (String::new(), String::new()));
}

#[test]
fn help_is_as_wide_as_the_terminal() {
    let folder = Folder::new();
    for (columns, longest) in [("60", 55..=60), ("200", 75..=80)] {
        let Some((told, _)) = on_terminal(&folder, "-help", Some(("WIDTH", columns))) else { return };
        let most = told.lines().map(|line| line.trim_end().chars().count()).max().unwrap_or(0);
        assert!(longest.contains(&most), "{columns}: {told}");
    }
}

#[test]
fn errors_have_colour_on_a_terminal_that_may_have_it() {
    let folder = Folder::with_scene(&scene(1, "Sphere { center 0 0 zero radius .7 }"));
    let Some((told, status)) = on_terminal(&folder, "-sise", None) else { return };
    let rest = told.strip_prefix("\u{1b}[1;31merror:\u{1b}[0m ").expect("a red word");
    assert!(rest.contains("-sise") && rest.contains("did you mean '-size'?"), "{told}");
    assert_eq!(status, Some(2));
    let (told, _) = on_terminal(&folder, "-input s.txt -output o.tga", None).unwrap();
    assert!(told.starts_with("s.txt:5:21: \u{1b}[1;31merror:\u{1b}[0m expected a number"), "{told}");
    for variable in [("NO_COLOR", "1"), ("TERM", "dumb")] {
        let (told, _) = on_terminal(&folder, "-sise", Some(variable)).unwrap();
        assert_eq!(told, format!("error: {rest}"), "{variable:?}");
    }
}
