//! Tables of invalid command lines, each with the flags and words that its message names.

use super::command_line::parse_line;
use super::support::says;
use raytracer::cli::parse;
use std::ffi::OsString;
#[cfg(unix)]
use std::os::unix::ffi::OsStringExt;

/// Invalid command lines and the parts of their messages, between which ` ... ` stands. All of them have
/// `-input s.txt`, unless the error is that it is missing.
const FAULTS: &[(&str, &str)] = &[
    ("", "-input"),
    ("-output a.tga", "-input"),
    ("-input", "-input"),
    ("-input s.txt -shadow", "-shadow ... -shadows"),
    ("-imput s.txt", "-imput ... -input"),
    ("-input s.txt -qqq", "-qqq"),
    ("-input s.txt -shadows=yes", "-shadows ... yes"),
    ("-input s.txt foo", "foo"),
    ("s.txt", "s.txt ... -input s.txt"),
    ("-input s.txt -shadows o.tga", "o.tga ... -output o.tga"),
    ("-help shadwos", "-shadwos ... -shadows"),
    ("-input s.txt -o a.png", "-o ... -output"),
    ("-input s.txt --width 200", "-width ... -size"),
    ("-input s.txt -aa 4", "-aa ... -jittered_samples"),
    ("-input s.txt -verbose", "-verbose ... -stats"),
    ("-input s.txt -repeat 0", "-repeat ... 0"),
    ("-input s.txt -size 200x", "-size"),
    ("-input s.txt -size a..=b 5", "'a..=b' for '-size"),
    ("-input s.txt -threads 0", "0 is not from 1 to 4096"),
    ("-tolerance 1 2", "-input ... -compare ... -reference"),
    ("-input s.txt -size 200x200 3", "-size ... 2 values ... 3 given"),
    ("-input s.txt -grid 3 none", "-grid ... none"),
    ("-input s.txt shadows", "shadows ... -shadows"),
    ("-input s.txt -size 3 4 -5.5", "-5"),
    ("-input s.txt -- foo", "foo"),
    ("-input s.txt -", "-"),
    ("-input s.txt -output a.jpg", "-output ... a.jpg"),
    ("-input s.txt -normals tga", "-normals ... tga"),
    ("-input s.txt -size 3", "-size"),
    ("-input s.txt -size 3 3.0", "-size ... 3.0"),
    ("-input s.txt -size 3 65536", "-size ... 65536"),
    ("-input s.txt -size -3 3", "-size ... -3"),
    ("-input s.txt -size 0 3", "-size ... 0"),
    ("-input s.txt -depth d.tga 1 2", "-depth ... d.tga"),
    ("-input s.txt -depth 1 1e999 d.tga", "-depth ... 1e999"),
    ("-input s.txt -depth 2 2 d.tga", "-depth"),
    ("-input s.txt -depth 2 -2 d.tga", "-depth"),
    ("-input s.txt -depth -1e308 1e308 d.tga", "-depth"),
    ("-input s.txt -depth 1 2 a.tga -depth 1 2 b.tga", "-depth ... multiple times"),
    ("-input s.txt -port 80", "-gui"),
    ("-input s.txt -no_browser", "-gui"),
    ("-input s.txt -gui -port 65536", "-port ... 65536"),
    ("-input s.txt -input s.txt", "-input ... multiple times"),
    ("-input s.txt -normals a.tga -normal b.tga", "-normals ... multiple times"),
    ("-input s.txt -bounces 2147483648", "-bounces ... 2147483648"),
    ("-input s.txt -weight -0.1", "-weight ... -0.1"),
    ("-input s.txt -weight infinity", "-weight ... infinity"),
    ("-input s.txt -grid 10", "-grid"),
    ("-input s.txt -grid auto 3 3", "-grid ... auto"),
    ("-input s.txt -grid 10 0 10", "-grid ... 0"),
    ("-input s.txt -grid 2048 1024 1024", "-grid"),
    ("-input s.txt -region 1 2 3", "-region"),
    ("-input s.txt -region -1 2 3 4", "-region ... -1"),
    ("-input s.txt -region 1 65535 3 4", "-region ... 100 x 100"),
    ("-input s.txt -region 1 2 0 4", "-region ... at least 1"),
    ("-input s.txt -region 1 2 100 4", "-region"),
    ("-input s.txt -size 9 8 -region 0 8 9 1", "-region"),
    ("-input s.txt -region 1 2 3 4 -render_filter f.tga 5", "-region ... -render_filter"),
    ("-input s.txt -region 1 2 3 4 -cost_map rays c.tga", "-region ... -cost_map"),
    ("-input s.txt -compare a.tga -region 1 2 3 4", "-compare ... -region"),
    ("-merge a.tga b.png", "-output"),
    ("-merge a.tga b.jpg -output a.tga", "-merge ... b.jpg"),
    ("-merge a.tga -merge b.tga -output a.tga", "-merge ... multiple times"),
    ("-merge a.tga -output a.tga -shadows", "-merge ... -shadows"),
    ("-input s.txt -merge a.tga -output a.tga", "-merge ... -input"),
    ("-input s.txt -visualize_grid", "-grid"),
    ("-input s.txt -shadows -no_shadows", "-shadows ... -no_shadows"),
    ("-input s.txt -no_shadows -transparent_shadows", "-no_shadows ... -transparent_shadows"),
    ("-input s.txt -random_samples 0", "-random_samples ... 0"),
    ("-input s.txt -adaptive_samples 3 1", "-adaptive_samples ... 3"),
    ("-input s.txt -adaptive_samples 1025 1", "-adaptive_samples ... 1025"),
    ("-input s.txt -adaptive_samples 16 -1", "-adaptive_samples ... -1"),
    ("-input s.txt -adaptive_samples 16 1 -jittered_samples 4", "-adaptive_samples ... -jittered_samples"),
    ("-input s.txt -uniform_samples 65537", "-uniform_samples ... 65537"),
    ("-input s.txt -random_samples 4 -uniform_samples 4", "-random_samples ... -uniform_samples"),
    ("-input s.txt -seed 4294967296", "-seed ... 4294967296"),
    ("-input s.txt -box_filter 0", "-box_filter ... 0"),
    ("-input s.txt -tent_filter 1e7", "-tent_filter ... 1e7"),
    ("-input s.txt -gaussian_filter 1e-7", "-gaussian_filter ... 1e-7"),
    ("-input s.txt -mitchell_filter nan", "-mitchell_filter ... nan"),
    ("-input s.txt -box_filter 1 -tent_filter 1", "-box_filter ... -tent_filter"),
    ("-input s.txt -render_samples 4 s.tga", "-render_samples ... s.tga"),
    ("-input s.txt -render_samples s.jpg 4", "-render_samples ... s.jpg"),
    ("-input s.txt -render_filter f.tga 0", "-render_filter ... 0"),
    ("-input s.txt -render_samples s.tga 656", "-render_samples"),
    ("-input s.txt -size 1 4369 -render_filter f.tga 15", "-render_filter"),
    ("-compare a.tga", "-input ... -reference"),
    ("-compare a.jpg -reference b.tga", "-compare ... a.jpg"),
    ("-convert a.PSD -output a.png", "-convert ... a.PSD ... convert it to PNG first"),
    ("-input s.txt -difference d.png", "-compare ... -reference"),
    ("-compare a.tga -reference b.tga -tolerance 256 0", "-tolerance ... 256"),
    ("-compare a.tga -reference b.tga -tolerance 0 -1", "-tolerance ... -1"),
    ("-input s.txt -cost_map heat o.tga", "-cost_map ... heat"),
    ("-input s.txt -json o.txt", "-json ... o.txt"),
    ("-input s.txt -render_samples a.tga 4 5", "'5'"),
    ("-input s.txt -output - jpg", "-output ... jpg"),
    ("-input s.txt -output -", "-output ... -"),
    ("-input s.txt -depth 1 2 -", "-depth ... -"),
    ("-input s.txt -output - tga -normals - png", "standard output"),
    ("-input s.txt -output - tga -depth 1 2 /dev/stdout png", "standard output"),
    ("-input s.txt -output - tga -json -", "-json ... standard output"),
    ("-merge a.tga b.exr -output c.tga", "-merge ... b.exr"),
    ("-merge a.tga -output c.pfm", "-output ... c.pfm"),
    ("-merge a.tga -output - exr", "-output ... .ppm"),
    ("-input s.txt -cost_map rays c.exr", "-cost_map ... c.exr"),
    ("-input s.txt -cost_map rays - pfm", "-cost_map ... .ppm"),
    ("-input s.txt -compare a.tga -difference d.pfm", "-difference ... d.pfm"),
    ("-input s.txt -commands c.txt", "-grade"),
    ("-input s.txt -report p.html", "-grade"),
    ("-input s.txt -student anna", "-grade"),
    ("-input s.txt -target 2 -output o.tga", "-error_report"),
    ("-input s.txt -progress -quiet", "-progress ... -quiet"),
    ("-input s.txt -tessellation 10 x", "-tessellation ... x"),
    ("-grade class", "-reference ... -commands"),
    ("-grade class -reference ref -report page.txt", "-report ... page.txt"),
    ("-grade class -reference ref -commands c.txt", "-reference ... -commands"),
    ("-grade class -reference ref -input s.txt", "-grade ... -input"),
    ("-grade class -reference ref -stats", "-grade ... -stats"),
    ("-grade class -reference ref -compare o.tga", "-grade ... -compare"),
    ("-error_report r", "-input"),
    ("-input s.txt -error_report r -stats", "-error_report ... -stats"),
    ("-input s.txt -error_report r -target -1", "-target ... -1"),
    ("-input s.txt -error_report r -output o.png", "-error_report ... -output"),
    ("-input s.txt -size 24 17 -pixel 24 0", "-pixel ... 0 to 23 ... 0 to 16"),
    ("-input s.txt -size 24 17 -pixel 0 17", "-pixel ... 0 to 23 ... 0 to 16"),
    ("-input s.txt -pixel -1 0", "-pixel ... -1"),
    ("-input s.txt -pixel 1 1 -grid 2 2 2 -visualize_grid", "-pixel ... -visualize_grid"),
    ("-compare a.tga -reference b.tga -pixel 1 1", "-input"),
];

#[test]
fn each_invalid_line_has_its_message() {
    let mut wrong = String::new();
    for (line, expected) in FAULTS {
        let shown = parse_line(line).map_err(|error| error.to_string());
        if !shown.as_ref().is_err_and(|message| says(message, expected)) {
            wrong += &format!("{line}\n  expected {expected}\n  actual   {shown:?}\n");
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn empty_arguments_are_errors() {
    let empty: [OsString; 0] = [];
    assert!(parse(empty).is_err_and(|error| error.to_string().contains("-input")));
    let shown = parse(["raytracer", "-input", "s", "-output", ""].map(OsString::from));
    let shown = shown.map_err(|error| error.to_string());
    assert!(shown.is_err_and(|message| message.contains("''") && message.contains("-output")));
}

#[test]
fn a_message_and_its_hint_are_a_line_each_whatever_the_argument_contains() {
    for word in ["-a\nb\x1b[1m", "a\nb\r", "shadows\n"] {
        let argv = ["raytracer", "-input", "s.txt", word].map(OsString::from);
        let error = parse(argv).unwrap_err();
        let lines = [Some(error.message), error.hint].map(Option::unwrap_or_default);
        assert!(lines.iter().all(|line| !line.contains(char::is_control)), "{lines:?}");
    }
}

#[cfg(unix)]
#[test]
fn flags_and_numbers_must_be_utf_8() {
    let shown = |words: &[&[u8]]| {
        let words = words.iter().map(|word| OsString::from_vec(word.to_vec()));
        parse(words).map_err(|error| error.to_string())
    };
    let flag = shown(&[b"raytracer", b"-z\xff"]);
    assert!(flag.is_err_and(|message| message.contains("-z\u{fffd}")));
    let size = shown(&[b"raytracer", b"-input", b"s.txt", b"-size", b"\xff", b"1"]);
    assert!(size.is_err_and(|message| message.contains("UTF-8")));
}
