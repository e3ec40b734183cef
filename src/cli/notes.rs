//! What the help tells of each flag beside its line in the table of flags: the default, an example, and the
//! details for `-help flag`.

use super::flags::{self, Flag};

/// What there is to tell about a flag.
pub(super) struct Notes {
    /// What happens without the flag; empty if the flag is only there for its effect.
    pub default: &'static str,
    /// The flag with values; empty if it takes none.
    pub example: &'static str,
    /// The rest of a command line on which the flag makes sense.
    pub with: &'static str,
    /// Sentences that only the full help has.
    pub details: &'static str,
}

impl Notes {
    const fn new(default: &'static str, example: &'static str) -> Self {
        Self { default, example, with: "-input scene.txt -output picture.png", details: "" }
    }

    const fn with(mut self, with: &'static str) -> Self {
        self.with = with;
        self
    }

    const fn details(mut self, details: &'static str) -> Self {
        self.details = details;
        self
    }
}

/// The command line of two pictures that are compared.
const COMPARED: &str = "-compare mine.tga -reference theirs.png";
const GRADED: &str = "-grade class -commands commands.txt";

/// The notes of a flag. A flag without an entry has no default and no example.
pub(super) fn of(flag: &Flag) -> Notes {
    match flag.name {
        "input" => Notes::new("", "-input scene.txt").with("-output picture.png").details(
            "Mesh files that the scene names are looked for in the working directory and then beside the scene.",
        ),
        "output" => Notes::new("none", "-output picture.png").with("-input scene.txt").details(
            "The file appears under its name when it is complete.",
        ),
        "size" => Notes::new("100 100", "-size 200 200").details(
            "The longer side spans the camera's view, which the shorter side crops around the middle. The form 200x200 is understood too.",
        ),
        "region" => Notes::new("the whole picture", "-region 0 0 100 50"),
        "merge" => Notes::new("", "-merge top.png bottom.png").with("-output whole.png"),
        "depth" => Notes::new("none", "-depth 8 20 depth.png").with("-input scene.txt"),
        "normals" => Notes::new("none", "-normals normals.png").with("-input scene.txt"),
        "shade_back" => Notes::new("off", "").details(
            "Scenes with glass need it, because a ray inside the glass sees its surface from behind.",
        ),
        "shadows" => Notes::new("off", "").details("Transparent objects cast them too."),
        "no_shadows" => Notes::new("", ""),
        "transparent_shadows" => Notes::new("off", "").details(
            "The light is multiplied by the transparent colour to the power of the distance inside the object.",
        ),
        "bounces" => Notes::new("0", "-bounces 5").details(
            "Where a material both reflects and transmits, each bounce can double the number of rays; -weight ends those that hardly count.",
        ),
        "weight" => Notes::new("0", "-weight 0.01").with("-input scene.txt -output picture.png -bounces 5").details(
            "A ray's weight is the product of the lengths of the reflective and transparent colours along its path.",
        ),
        "random_samples" => Notes::new("1, the centre", "-random_samples 16"),
        "uniform_samples" => Notes::new("1, the centre", "-uniform_samples 9"),
        "jittered_samples" => Notes::new("1, the centre", "-jittered_samples 16"),
        "adaptive_samples" => Notes::new("off", "-adaptive_samples 256 2").details(
            "Flat pixels keep four samples and edges get many. A level is one of 255 steps of a byte.",
        ),
        "seed" => Notes::new("the course's sequence", "-seed 7")
            .with("-input scene.txt -output picture.png -random_samples 16"),
        "box_filter" => Notes::new("0.5", "-box_filter 1")
            .with("-input scene.txt -output picture.png -jittered_samples 16"),
        "tent_filter" => Notes::new("off", "-tent_filter 1")
            .with("-input scene.txt -output picture.png -jittered_samples 16"),
        "gaussian_filter" => Notes::new("off", "-gaussian_filter 0.4")
            .with("-input scene.txt -output picture.png -jittered_samples 16"),
        "mitchell_filter" => Notes::new("off", "-mitchell_filter 2")
            .with("-input scene.txt -output picture.png -jittered_samples 16"),
        "render_samples" => Notes::new("none", "-render_samples samples.png 10")
            .with("-input scene.txt -size 9 9 -jittered_samples 9"),
        "render_filter" => Notes::new("none", "-render_filter filter.png 10")
            .with("-input scene.txt -size 9 9 -tent_filter 2"),
        "grid" => Notes::new("what is fastest", "-grid 20 20 20").details(
            "With -stats, -cost_map or -pixel the default is none, as in the course. auto chooses about one cubic cell per primitive, and subdivides crowded cells.",
        ),
        "visualize_grid" => Notes::new("off", "")
            .with("-input scene.txt -output cells.png -grid 20 20 20")
            .details("The colours tell the number of primitives in each cell: white for 1, red for 17 or more."),
        "compare" => Notes::new("the rendered picture", "-compare mine.tga")
            .with("-reference theirs.png")
            .details("With a scene too, the likely cause of a difference is looked for."),
        "reference" => Notes::new("the rendered picture", "-reference theirs.png").with("-compare mine.tga"),
        "difference" => Notes::new("none", "-difference difference.png").with(COMPARED),
        "tolerance" => Notes::new("none", "-tolerance 1 20").with(COMPARED),
        "grade" => Notes::new("", "-grade class").with("-commands commands.txt -report page.html"),
        "commands" => Notes::new("none", "-commands commands.txt").with("-grade class").details(
            "The file has a command line on every line; empty lines and those that start with # are skipped.",
        ),
        "report" => Notes::new("none", "-report page.html").with(GRADED),
        "error_report" => Notes::new("", "-error_report folder").with("-input scene.txt -size 60 60 -shadows"),
        "target" => Notes::new("none", "-target 2").with("-input scene.txt -size 60 60 -error_report folder"),
        "stats" => Notes::new("off", "").with("-input scene.txt").details(
            "The program then does and counts what the course's program does, so that the counters compare.",
        ),
        "cost_map" => Notes::new("none", "-cost_map tests cost.png").with("-input scene.txt -grid 20 20 20"),
        "pixel" => Notes::new("none", "-pixel 100 160").with("-input scene.txt -size 200 200 -shadows"),
        "json" => Notes::new("none", "-json run.json").with("-input scene.txt -stats"),
        "threads" => Notes::new("all cores", "-threads 4").details(
            "Without it, one thread begins what looks like little work, and the others start if it lasts.",
        ),
        "strict" => Notes::new("off", ""),
        "progress" | "quiet" => Notes::new("off", ""),
        "gui" => Notes::new("off", ""),
        "port" => Notes::new("any free port", "-port 8080").with("-input scene.txt -gui"),
        "no_browser" => Notes::new("off", "").with("-input scene.txt -gui"),
        "gouraud" => Notes::new("", ""),
        "tessellation" => Notes::new("", "-tessellation 10 5"),
        "help" => Notes::new("", "-help size").with(""),
        "version" => Notes::new("", "").with(""),
        _ => Notes { default: "", example: "", with: "", details: "" },
    }
}

impl Flag {
    /// A whole command line with this flag; none if its notes have none.
    pub fn command(&self) -> String {
        let Notes { example, with, .. } = of(self);
        let own = if example.is_empty() { self.usage() } else { example.to_owned() };
        // The scene comes first, and what is asked of it last.
        let (before, after) = match self.name {
            "input" | "compare" | "grade" => ("", with),
            _ => (with, ""),
        };
        ["raytracer", before, &own, after]
            .into_iter()
            .filter(|words| !words.is_empty())
            .collect::<Vec<_>>()
            .join(" ")
    }

    /// The values as an error shows them: `-size 200 200`.
    pub fn example(&self) -> String {
        let example = of(self).example;
        if example.is_empty() { self.usage() } else { example.to_owned() }
    }

    /// The flags that this one cannot be combined with, in either order.
    pub fn excluded(&self) -> impl Iterator<Item = &'static Flag> {
        flags::FLAGS.iter().copied().filter(|other| self.conflicts_with(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::flags::FLAGS;

    #[test]
    fn every_flag_has_an_example_with_its_values() {
        for flag in FLAGS {
            let notes = of(flag);
            let counts = flag.value_counts();
            if flag.values.is_empty() {
                assert_eq!(notes.example, "", "-{}", flag.name);
                assert!(
                    !notes.default.is_empty()
                        || ["gui", "gouraud", "no_shadows", "version"].contains(&flag.name)
                );
            } else {
                let mut words = notes.example.split(' ');
                assert_eq!(words.next(), Some(format!("-{}", flag.name).as_str()));
                assert!(counts.contains(&words.count()), "{}", notes.example);
            }
        }
    }

    #[test]
    fn every_example_is_a_command_line() {
        for flag in FLAGS {
            let words = flag.command();
            let parsed = crate::cli::parse(words.split(' ').map(Into::into));
            assert!(parsed.is_ok(), "{words}: {parsed:?}");
        }
    }
}
