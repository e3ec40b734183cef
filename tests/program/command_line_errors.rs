//! Tables of invalid command lines, each with the exact message.

use super::command_line::parse_line;
use raytracer::cli::{CliError, parse};
use std::ffi::OsString;
#[cfg(unix)]
use std::os::unix::ffi::OsStringExt;

/// Invalid command lines and their messages. All of them have `-input s.txt`, unless the error is that it is
/// missing.
const FAULTS: &[(&str, &str)] = &[
    ("", "no scene: `-input file` is required (`-h` lists the usual flags)"),
    ("-output a.tga", "no scene: `-input file` is required (`-h` lists the usual flags)"),
    ("-input", "`-input` needs a value, as in `-input scene.txt`"),
    ("-input s.txt -shadow", "unknown flag `-shadow`; did you mean `-shadows`?"),
    ("-input s.txt -visualise_grid", "unknown flag `-visualise_grid`; did you mean `-visualize_grid`?"),
    ("-input s.txt --sise 3 3", "unknown flag `-sise`; did you mean `-size`?"),
    ("-input s.txt -Size 3 3", "unknown flag `-Size`; did you mean `-size`?"),
    ("-imput s.txt", "unknown flag `-imput`; did you mean `-input`?"),
    ("-input s.txt -qqq", "unknown flag `-qqq` (`-help` lists every flag)"),
    ("-input s.txt -qqq=3", "unknown flag `-qqq` (`-help` lists every flag)"),
    ("-input=s.txt", "`-input` takes its values as separate words, without `=`"),
    ("-input s.txt -shadows=yes", "`-shadows` takes its values as separate words, without `=`"),
    ("-input s.txt foo", "unexpected word `foo` (not the value of any flag)"),
    ("s.txt", "unexpected word `s.txt`; did you mean `-input s.txt`?"),
    ("-shadows scenes/a.TXT", "unexpected word `scenes/a.TXT`; did you mean `-input scenes/a.TXT`?"),
    ("-input s.txt t.txt", "unexpected word `t.txt` (not the value of any flag)"),
    ("-input s.txt -shadows o.tga", "unexpected word `o.tga`; did you mean `-output o.tga`?"),
    ("-help teapot", "unknown flag `-teapot` (`-help` lists every flag)"),
    ("-help shadwos", "unknown flag `-shadwos`; did you mean `-shadows`?"),
    ("-i s.txt", "unknown flag `-i`; did you mean `-input file`?"),
    ("-input s.txt -o a.png", "unknown flag `-o`; did you mean `-output file`?"),
    ("-input s.txt -w 200", "unknown flag `-w`; did you mean `-size w h`?"),
    ("-input s.txt --width 200", "unknown flag `-width`; did you mean `-size w h`?"),
    ("-input s.txt -j 4", "unknown flag `-j`; did you mean `-threads n`?"),
    ("-input s.txt -aa 4", "unknown flag `-aa`; did you mean `-jittered_samples n`?"),
    ("-input s.txt -AA 4", "unknown flag `-AA`; did you mean `-jittered_samples n`?"),
    ("-input s.txt -samples 16", "unknown flag `-samples`; did you mean `-jittered_samples n`?"),
    ("-input s.txt -samples=16", "unknown flag `-samples`; did you mean `-jittered_samples n`?"),
    ("-input s.txt -verbose", "unknown flag `-verbose`; did you mean `-stats`?"),
    ("-input s.txt -v", "unknown flag `-v`; did you mean `-stats`?"),
    ("-input s.txt -repeat 0", "`-repeat`: `0` is not between 1 and 10000"),
    ("-input s.txt -size 200", "`-size` takes 2 values, as in `-size 200 200`; 1 given"),
    ("-input s.txt -size 200x", "`-size`: `` is not a whole number"),
    ("-input s.txt -size 0x200", "`-size`: `0` is not between 1 and 65535"),
    ("-input s.txt -size 200x200 3", "`-size`: `200x200` is not a whole number"),
    ("-input s.txt -grid 3 none", "`-grid`: `none` stands alone, in place of the three numbers"),
    ("-input s.txt shadows", "unexpected word `shadows`; did you mean `-shadows`?"),
    ("-input s.txt -stats 3", "unexpected word `3` (not the value of any flag)"),
    ("-input s.txt -size 3 4 -5.5", "unexpected word `-5.5` (not the value of any flag)"),
    ("-input s.txt --", "unexpected word `--` (not the value of any flag)"),
    ("-input s.txt -", "unexpected word `-` (not the value of any flag)"),
    ("-input s.txt -output", "`-output` needs a value, as in `-output picture.png`"),
    ("-input s.txt -output -size 3 3", "`-output` needs a value, as in `-output picture.png`"),
    (
        "-input s.txt -output a.jpg",
        "`-output`: `a.jpg` ends in none of .tga, .png, .bmp, .ppm, .pfm and .exr",
    ),
    ("-input s.txt -output --", "`-output`: `--` ends in none of .tga, .png, .bmp, .ppm, .pfm and .exr"),
    ("-input s.txt -normals tga", "`-normals`: `tga` ends in none of .tga, .png, .bmp, .ppm, .pfm and .exr"),
    ("-input s.txt -size", "`-size` takes 2 values, as in `-size 200 200`; 0 given"),
    ("-input s.txt -size 3", "`-size` takes 2 values, as in `-size 200 200`; 1 given"),
    ("-input s.txt -size 3 -stats", "`-size` takes 2 values, as in `-size 200 200`; 1 given"),
    ("-input s.txt -size abc 3", "`-size`: `abc` is not a whole number"),
    ("-input s.txt -size 3 3.0", "`-size`: `3.0` is not a whole number"),
    ("-input s.txt -size 3 +", "`-size`: `+` is not a whole number"),
    ("-input s.txt -size 0 3", "`-size`: `0` is not between 1 and 65535"),
    ("-input s.txt -size 3 65536", "`-size`: `65536` is not between 1 and 65535"),
    ("-input s.txt -size -3 3", "`-size`: `-3` is not between 1 and 65535"),
    ("-input s.txt -depth 1 2", "`-depth` takes 3 values, as in `-depth 8 20 depth.png`; 2 given"),
    ("-input s.txt -depth d.tga 1 2", "`-depth`: `d.tga` is not a finite number"),
    ("-input s.txt -depth 1 nan d.tga", "`-depth`: `nan` is not a finite number"),
    ("-input s.txt -depth 1 1e999 d.tga", "`-depth`: `1e999` is not a finite number"),
    ("-input s.txt -depth 2 2 d.tga", "`-depth`: t0 must be less than t1, but 2 >= 2"),
    ("-input s.txt -depth 2 -2 d.tga", "`-depth`: t0 must be less than t1, but 2 >= -2"),
    ("-input s.txt -depth -1e308 1e308 d.tga", "`-depth`: t1 - t0 is too large for a number"),
    ("-input s.txt -depth 1 2 3", "`-depth`: `3` ends in none of .tga, .png, .bmp, .ppm, .pfm and .exr"),
    ("-input s.txt -depth 1 2 a.tga -depth 1 2 b.tga", "`-depth` given twice"),
    ("-input s.txt -port 80", "`-port` needs `-gui`"),
    ("-input s.txt -no_browser", "`-no_browser` needs `-gui`"),
    ("-input s.txt -gui -port 65536", "`-port`: `65536` is not between 0 and 65535"),
    ("-input s.txt -gui -port", "`-port` needs a value, as in `-port 8080`"),
    ("-input s.txt -input s.txt", "`-input` given twice"),
    ("-input s.txt -stats -stats", "`-stats` given twice"),
    ("-input s.txt -normals a.tga -normal b.tga", "`-normals` given twice"),
    ("-input s.txt -bounces x", "`-bounces`: `x` is not a whole number"),
    ("-input s.txt -bounces -1", "`-bounces`: `-1` is not between 0 and 2147483647"),
    ("-input s.txt -bounces 2147483648", "`-bounces`: `2147483648` is not between 0 and 2147483647"),
    ("-input s.txt -weight -0.1", "`-weight`: `-0.1` is negative"),
    ("-input s.txt -weight infinity", "`-weight`: `infinity` is not a finite number"),
    (
        "-input s.txt -grid 10",
        "`-grid` takes 3 values, as in `-grid 20 20 20`, or one, which is `auto` or `none`; 1 given",
    ),
    (
        "-input s.txt -grid 10 10",
        "`-grid` takes 3 values, as in `-grid 20 20 20`, or one, which is `auto` or `none`; 2 given",
    ),
    (
        "-input s.txt -grid",
        "`-grid` takes 3 values, as in `-grid 20 20 20`, or one, which is `auto` or `none`; 0 given",
    ),
    ("-input s.txt -grid auto 3 3", "`-grid`: `auto` stands alone, in place of the three numbers"),
    ("-input s.txt -grid 10 0 10", "`-grid`: `0` is not between 1 and 2147483647"),
    (
        "-input s.txt -grid 2048 1024 1024",
        "`-grid`: 2048 x 1024 x 1024 cells are too many, 2147483647 is the most",
    ),
    (
        "-input s.txt -grid 2147483647 2147483647 2147483647",
        "`-grid`: 2147483647 x 2147483647 x 2147483647 cells are too many, 2147483647 is the most",
    ),
    ("-input s.txt -region 1 2 3", "`-region` takes 4 values, as in `-region 0 0 100 50`; 3 given"),
    ("-input s.txt -region 1 2 3 x", "`-region`: `x` is not a whole number"),
    ("-input s.txt -region -1 2 3 4", "`-region`: `-1` is not between 0 and 65534"),
    ("-input s.txt -region 1 65535 3 4", "`-region`: `65535` is not between 0 and 65534"),
    ("-input s.txt -region 1 2 0 4", "`-region`: `0` is not between 1 and 65535"),
    ("-input s.txt -region 1 2 100 4", "`-region`: not within the picture of 100 x 100 pixels"),
    ("-input s.txt -size 9 8 -region 0 8 9 1", "`-region`: not within the picture of 9 x 8 pixels"),
    (
        "-input s.txt -region 1 2 3 4 -render_filter f.tga 5",
        "`-region` cannot be combined with `-render_filter`",
    ),
    ("-input s.txt -region 1 2 3 4 -cost_map rays c.tga", "`-region` cannot be combined with `-cost_map`"),
    ("-input s.txt -compare a.tga -region 1 2 3 4", "`-compare` cannot be combined with `-region`"),
    ("-merge a.tga b.png", "`-merge` needs `-output file`"),
    ("-merge -output a.tga", "`-merge` needs a value, as in `-merge top.png bottom.png`"),
    ("-merge a.tga b.jpg -output a.tga", "`-merge`: `b.jpg` ends in neither .tga nor .png, as parts do"),
    ("-merge a.tga -merge b.tga -output a.tga", "`-merge` given twice"),
    ("-merge a.tga -output a.tga -shadows", "`-merge` cannot be combined with `-shadows`"),
    ("-input s.txt -merge a.tga -output a.tga", "`-merge` cannot be combined with `-input`"),
    ("-input s.txt -visualize_grid", "`-visualize_grid` needs `-grid nx ny nz`"),
    ("-input s.txt -shadows -no_shadows", "`-shadows` cannot be combined with `-no_shadows`"),
    ("-input s.txt -no_shadows -shadows", "`-no_shadows` cannot be combined with `-shadows`"),
    (
        "-input s.txt -no_shadows -transparent_shadows",
        "`-no_shadows` cannot be combined with `-transparent_shadows`",
    ),
    (
        "-input s.txt -no_shadows -shadows -transparent_shadows",
        "`-no_shadows` cannot be combined with `-shadows`",
    ),
    ("-input s.txt -random_samples", "`-random_samples` needs a value, as in `-random_samples 16`"),
    ("-input s.txt -random_samples 0", "`-random_samples`: `0` is not between 1 and 65536"),
    ("-input s.txt -random_samples -4", "`-random_samples`: `-4` is not between 1 and 65536"),
    ("-input s.txt -adaptive_samples 3 1", "`-adaptive_samples`: `3` is not between 4 and 1024"),
    ("-input s.txt -adaptive_samples 1025 1", "`-adaptive_samples`: `1025` is not between 4 and 1024"),
    ("-input s.txt -adaptive_samples 16 -1", "`-adaptive_samples`: `-1` is negative"),
    ("-input s.txt -adaptive_samples 16 nan", "`-adaptive_samples`: `nan` is not a finite number"),
    (
        "-input s.txt -adaptive_samples 16 1 -jittered_samples 4",
        "`-adaptive_samples` cannot be combined with `-jittered_samples`",
    ),
    ("-input s.txt -uniform_samples 65537", "`-uniform_samples`: `65537` is not between 1 and 65536"),
    ("-input s.txt -jittered_samples 4.0", "`-jittered_samples`: `4.0` is not a whole number"),
    ("-input s.txt -jittered_samples 4 -jittered_samples 4", "`-jittered_samples` given twice"),
    (
        "-input s.txt -random_samples 4 -uniform_samples 4",
        "`-random_samples` cannot be combined with `-uniform_samples`",
    ),
    (
        "-input s.txt -jittered_samples 4 -random_samples 4",
        "`-jittered_samples` cannot be combined with `-random_samples`",
    ),
    (
        "-input s.txt -uniform_samples 4 -jittered_samples 4",
        "`-uniform_samples` cannot be combined with `-jittered_samples`",
    ),
    ("-input s.txt -uniform_sample 4", "unknown flag `-uniform_sample`; did you mean `-uniform_samples`?"),
    ("-input s.txt -seed", "`-seed` needs a value, as in `-seed 7`"),
    ("-input s.txt -seed -1", "`-seed`: `-1` is not between 0 and 4294967295"),
    ("-input s.txt -seed 4294967296", "`-seed`: `4294967296` is not between 0 and 4294967295"),
    ("-input s.txt -seed now", "`-seed`: `now` is not a whole number"),
    ("-input s.txt -box_filter", "`-box_filter` needs a value, as in `-box_filter 1`"),
    ("-input s.txt -box_filter 0", "`-box_filter`: `0` is not between 0.000001 and 1000000 pixels"),
    ("-input s.txt -box_filter -1", "`-box_filter`: `-1` is not between 0.000001 and 1000000 pixels"),
    ("-input s.txt -tent_filter 1e7", "`-tent_filter`: `1e7` is not between 0.000001 and 1000000 pixels"),
    (
        "-input s.txt -gaussian_filter 1e-7",
        "`-gaussian_filter`: `1e-7` is not between 0.000001 and 1000000 pixels",
    ),
    ("-input s.txt -mitchell_filter nan", "`-mitchell_filter`: `nan` is not a finite number"),
    ("-input s.txt -gaussian_filter wide", "`-gaussian_filter`: `wide` is not a finite number"),
    ("-input s.txt -box_filter 1 -tent_filter 1", "`-box_filter` cannot be combined with `-tent_filter`"),
    (
        "-input s.txt -gaussian_filter 1 -tent_filter 1",
        "`-gaussian_filter` cannot be combined with `-tent_filter`",
    ),
    (
        "-input s.txt -gaussian_filter 1 -mitchell_filter 1",
        "`-gaussian_filter` cannot be combined with `-mitchell_filter`",
    ),
    (
        "-input s.txt -mitchell_filter 1 -box_filter 1",
        "`-mitchell_filter` cannot be combined with `-box_filter`",
    ),
    (
        "-input s.txt -render_samples s.tga",
        "`-render_samples` takes 2 values, as in `-render_samples samples.png 10`; 1 given",
    ),
    ("-input s.txt -render_samples 4 s.tga", "`-render_samples`: `s.tga` is not a whole number"),
    (
        "-input s.txt -render_samples s.jpg 4",
        "`-render_samples`: `s.jpg` ends in none of .tga, .png, .bmp, .ppm, .pfm and .exr",
    ),
    ("-input s.txt -render_filter f.tga 0", "`-render_filter`: `0` is not between 1 and 65535"),
    (
        "-input s.txt -render_samples s.tga 656",
        "`-render_samples`: the enlarged picture would be above 65535 pixels a side",
    ),
    (
        "-input s.txt -size 1 4369 -render_filter f.tga 15",
        "`-render_filter`: the enlarged picture would be above 65535 pixels a side",
    ),
    (
        "-input s.txt -render_samples a.tga 4 -output a.tga",
        "`-output` and `-render_samples` both write `a.tga`",
    ),
    (
        "-input s.txt -render_samples a.tga 4 -render_filter ./a.tga 4",
        "`-render_samples` and `-render_filter` both write `a.tga`",
    ),
    ("-compare a.tga", "no scene: `-input file` is required (`-h` lists the usual flags)"),
    (
        "-compare a.jpg -reference b.tga",
        "`-compare`: `a.jpg` ends in none of .tga, .png, .bmp, .ppm, .pfm and .exr",
    ),
    ("-input s.txt -compare", "`-compare` needs a value, as in `-compare mine.tga`"),
    ("-input s.txt -difference d.png", "`-difference` needs a picture: `-compare file` or `-reference file`"),
    ("-input s.txt -tolerance 1 2", "`-tolerance` needs a picture: `-compare file` or `-reference file`"),
    (
        "-compare a.tga -reference b.tga -tolerance 1",
        "`-tolerance` takes 2 values, as in `-tolerance 1 20`; 1 given",
    ),
    ("-compare a.tga -reference b.tga -tolerance 256 0", "`-tolerance`: `256` is not between 0 and 255"),
    ("-compare a.tga -reference b.tga -tolerance 0 -1", "`-tolerance`: `-1` is not between 0 and 4294967295"),
    (
        "-input s.txt -output d.tga -compare a.tga -difference ./d.tga",
        "`-output` and `-difference` both write `d.tga`",
    ),
    ("-input s.txt -json", "`-json` needs a value, as in `-json run.json`"),
    ("-input s.txt -json o.txt", "`-json`: `o.txt` is neither - nor ends in .json"),
    ("-input s.txt -json json", "`-json`: `json` is neither - nor ends in .json"),
    ("-input s.txt -output a.tga shadows", "unexpected word `shadows`; did you mean `-shadows`?"),
    ("-input s.txt -output a.tga png", "unexpected word `png` (not the value of any flag)"),
    ("-input s.txt -render_samples a.tga 4 5", "unexpected word `5` (not the value of any flag)"),
    ("-input s.txt -output - jpg", "`-output`: `jpg` is none of the formats tga, png, bmp, ppm, pfm and exr"),
    (
        "-input s.txt -output a.jpg jpg",
        "`-output`: `jpg` is none of the formats tga, png, bmp, ppm, pfm and exr",
    ),
    ("-input s.txt -output -", "`-output`: `-` needs its format as the next word, as in `- png`"),
    ("-input s.txt -output - tga 3", "unexpected word `3` (not the value of any flag)"),
    ("-input s.txt -depth 1 2 -", "`-depth`: `-` needs its format as the next word, as in `- png`"),
    ("-input s.txt -output - tga -normals - png", "`-output` and `-normals` both write to standard output"),
    (
        "-input s.txt -output - tga -depth 1 2 /dev/stdout png",
        "`-output` and `-depth` both write to standard output",
    ),
    ("-input s.txt -output - tga -json -", "`-output` and `-json` both write to standard output"),
    ("-merge a.tga b.exr -output c.tga", "`-merge`: `b.exr` ends in neither .tga nor .png, as parts do"),
    ("-merge a.tga -output c.pfm", "`-output`: `c.pfm` ends in none of .tga, .png, .bmp and .ppm"),
    ("-merge a.tga -output - exr", "`-output`: `exr` ends in none of .tga, .png, .bmp and .ppm"),
    ("-input s.txt -cost_map rays c.exr", "`-cost_map`: `c.exr` ends in none of .tga, .png, .bmp and .ppm"),
    ("-input s.txt -cost_map rays - pfm", "`-cost_map`: `pfm` ends in none of .tga, .png, .bmp and .ppm"),
    (
        "-input s.txt -compare a.tga -difference d.pfm",
        "`-difference`: `d.pfm` ends in none of .tga, .png, .bmp and .ppm",
    ),
    ("-input s.txt -threads 0", "`-threads`: `0` is not between 1 and 4096"),
    ("-input s.txt -threads all", "`-threads`: `all` is not a whole number"),
    ("-input s.txt -tessellation 10", "`-tessellation` takes 2 values, as in `-tessellation 10 5`; 1 given"),
    ("-input s.txt -progress -quiet", "`-progress` cannot be combined with `-quiet`"),
    ("-input s.txt -tessellation 10 x", "`-tessellation`: `x` is not a whole number"),
    ("-input s.txt -output a.tga -normals a.tga", "`-output` and `-normals` both write `a.tga`"),
    ("-input s.txt -output ./a.tga -depth 1 2 a.tga", "`-output` and `-depth` both write `./a.tga`"),
    ("-input s.txt -depth 1 2 d/a.tga -normals d/./a.tga", "`-depth` and `-normals` both write `d/a.tga`"),
];

#[test]
fn each_invalid_line_has_its_message() {
    let mut wrong = String::new();
    for (line, expected) in FAULTS {
        let shown = parse_line(line).map_err(|error| error.to_string());
        if shown != Err(expected.to_string()) {
            wrong += &format!("{line}\n  expected {expected}\n  actual   {shown:?}\n");
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn empty_arguments_are_errors() {
    let empty: [OsString; 0] = [];
    assert_eq!(parse(empty), Err(CliError::InputNeeded));
    let shown = parse(["raytracer", "-input", "s", "-output", ""].map(OsString::from));
    let shown = shown.map_err(|error| error.to_string());
    assert_eq!(shown, Err("`-output`: `` ends in none of .tga, .png, .bmp, .ppm, .pfm and .exr".into()));
}

#[test]
fn a_message_is_one_line_whatever_the_argument_contains() {
    for word in ["-a\nb\x1b[1m", "a\nb\r", "shadows\n"] {
        let argv = ["raytracer", "-input", "s.txt", word].map(OsString::from);
        let shown = parse(argv).map_err(|error| error.to_string());
        assert!(shown.as_ref().is_err_and(|line| !line.contains(char::is_control)), "{shown:?}");
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
    assert_eq!(flag, Err("unknown flag `-z\u{fffd}` (`-help` lists every flag)".into()));
    let size = shown(&[b"raytracer", b"-input", b"s.txt", b"-size", b"\xff", b"1"]);
    assert_eq!(size, Err("`-size`: `\u{fffd}` is not a whole number".into()));
}
