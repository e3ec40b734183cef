//! The editions of the course that are read: their names, their words, and what their scenes mean.

use super::lexer::Lexer;
use super::model::{Depths, FaceWeights, Highlight, MeshNormals, Model, NormalColors, Screen, Split};
use serde::{Serialize, Serializer};
use std::fmt;

/// An edition of the course.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Edition {
    /// Those of 2003 and 2004, assignments 1 to 7.
    #[default]
    Y2004,
    /// That of 2012, assignment 4.
    Y2012A4,
    /// That of 2012, assignment 5.
    Y2012A5,
    /// Those of 2016 to 2023, assignment 4.
    Y2019,
    /// That of Aalto University, whose scenes are those of 2004.
    Aalto,
}

use Edition::{Aalto, Y2004, Y2012A4, Y2012A5, Y2019};

/// The words that only some editions have.
const WORDS: [(&str, &[Edition]); 18] = [
    ("OrthographicCamera", &[Y2004, Aalto]),
    ("Checkerboard", &[Y2004, Aalto]),
    ("Marble", &[Y2004, Aalto]),
    ("Wood", &[Y2004, Aalto]),
    ("Matrix", &[Y2004, Aalto]),
    ("exponent", &[Y2004, Aalto]),
    ("reflectiveColor", &[Y2004, Aalto]),
    ("transparentColor", &[Y2004, Aalto]),
    ("indexOfRefraction", &[Y2004, Aalto]),
    ("attenuation", &[Y2004, Aalto]),
    ("shininess", &[Y2012A4, Y2012A5, Y2019]),
    ("Matrix4f", &[Y2012A4, Y2012A5, Y2019]),
    ("bump", &[Y2012A5, Y2019]),
    ("mipmap", &[Aalto]),
    ("linearInterpolation", &[Aalto]),
    ("textCoord0", &[Aalto]),
    ("textCoord1", &[Aalto]),
    ("textCoord2", &[Aalto]),
];
/// Those of them that are followed by what tells them from other uses of the word.
const LATER_WORDS: [(&str, &[Edition]); 4] = [
    ("refractionIndex", &[Y2012A5]),
    ("texture", &[Y2012A4, Y2012A5, Aalto]),
    ("falloff", &[Y2012A5, Y2019]),
    ("cubeMap", &[Y2012A5, Y2019]),
];

/// The editions that have a word which not all have; none for other words.
pub(super) fn editions_of(word: &str) -> Option<&'static [Edition]> {
    let mut words = WORDS.iter().chain(&LATER_WORDS);
    words.find(|(known, _)| *known == word).map(|(_, editions)| *editions)
}

/// What beside the words of a scene may tell its edition.
pub trait Clues {
    /// Whether there is a picture `right` with this ending for the cube map in this folder.
    fn has_face(&self, folder: &str, ending: &str) -> bool;
    /// Whether pictures with this ending are written.
    fn writes(&self, ending: &str) -> bool;
}

/// An edition, and what told it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choice {
    /// The edition.
    pub edition: Edition,
    /// The words of a sentence after `because of`; none if nobody had to find it out.
    pub because: Option<String>,
    /// The later editions that read the text too, and draw another picture, where nothing tells which one is meant.
    pub others: Vec<Edition>,
}

impl Choice {
    /// What is to be said of it, unless somebody has named it.
    pub fn note(&self) -> Option<String> {
        let (edition, because) = (self.edition, self.because.as_ref()?);
        Some(format!(
            "the scene is taken as one of the edition {edition}, because of {because}; `-edition` names another"
        ))
    }

    /// A warning and its hint if nothing tells which edition is meant.
    pub fn doubt(&self) -> Option<[String; 2]> {
        let flags: Vec<String> = self.others.iter().map(|edition| format!("`-edition {edition}`")).collect();
        let (last, rest) = flags.split_last()?;
        let flags = if rest.is_empty() { last.clone() } else { format!("{} or {last}", rest.join(", ")) };
        let problem = "nothing tells the scene's edition: it is taken as one of 2004, and is another picture in later ones";
        Some([problem.into(), format!("add {flags} if it is a later one, or `-edition 2004` if not")])
    }
}

impl Edition {
    /// All editions, in the order of their years.
    pub const ALL: [Self; 5] = [Y2004, Y2012A4, Y2012A5, Y2019, Aalto];
    /// Their names.
    pub const NAMES: [&'static str; 5] = ["2004", "2012a4", "2012a5", "2019", "aalto"];

    /// The name, as after `-edition`.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().zip(Self::NAMES).find(|(edition, _)| **edition == self).map_or("", |(_, name)| name)
    }

    /// The edition with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|edition| edition.name() == name)
    }

    /// Whether its scenes are written in the language of 2012 and later.
    pub fn is_later(self) -> bool {
        matches!(self, Y2012A4 | Y2012A5 | Y2019)
    }

    /// Whether files that a scene names are looked for beside the scene first, and in the working directory then.
    pub fn starts_beside_scene(self) -> bool {
        matches!(self, Y2019 | Aalto)
    }

    /// The ending of the pictures of a cube map.
    pub fn ending_of_faces(self) -> &'static str {
        if self == Y2019 { "png" } else { "bmp" }
    }

    /// Whether the texels of pictures are interpolated as bytes.
    pub fn divides_texels_last(self) -> bool {
        self != Y2019
    }

    /// How often a ray bounces where no `-bounces` says so.
    pub fn default_bounces(self) -> u32 {
        if self == Y2012A5 { 4 } else { 0 }
    }

    /// Secondary rays are traced whose weight is above this where no `-weight` says so.
    pub fn default_weight(self) -> f64 {
        if self == Aalto { 0.1 } else { 0.0 }
    }

    /// What its scenes mean.
    pub fn model(self) -> Model {
        const A4: Model = Model {
            screen: Screen::BothSides { up_as_written: false },
            highlight: Highlight::Phong,
            epsilon: Some(1e-3),
            normals: MeshNormals::Smooth { weights: FaceWeights::Area, flat_up_to: 0 },
            ..Model::COURSE
        };
        match self {
            Y2004 | Aalto => Model::COURSE,
            Y2012A4 => A4,
            Y2012A5 => Model {
                split: Split::Schlick,
                normals: MeshNormals::Smooth { weights: FaceWeights::Area, flat_up_to: 120 },
                ..A4
            },
            Y2019 => Model {
                screen: Screen::BothSides { up_as_written: true },
                epsilon: Some(1e-2),
                normals: MeshNormals::Smooth { weights: FaceWeights::Equal, flat_up_to: 0 },
                depths: Depths::NearBlack,
                normal_colors: NormalColors::Shifted,
                ..A4
            },
        }
    }

    /// The edition of a scene that is not one of 2004, by its words and by what is around them.
    pub fn of_words(text: &str, clues: &dyn Clues) -> Option<Choice> {
        let words = LaterWords::of(text)?;
        let choice = |edition, because: &str| {
            let mut because = because.to_owned();
            if let Some(word) = words.first.filter(|word| !because.contains(*word)) {
                because = format!("`{word}`, and {because}");
            }
            Some(Choice { edition, because: Some(because), others: vec![] })
        };
        let (first, map) = (words.first?, words.cube_map);
        if let Some(word) = words.of_2012a5 {
            return choice(Y2012A5, &format!("`{word}`"));
        }
        if let Some(folder) = map {
            let face = |ending| clues.has_face(folder, ending);
            match [face("png"), face("bmp")] {
                [true, false] => return choice(Y2019, "the cube map of PNG files"),
                [false, true] => return choice(Y2012A5, "the cube map of BMP files"),
                _ => {}
            }
        }
        if words.names_models {
            return choice(Y2019, "the meshes in `models/`");
        }
        let is_a5 = words.has_falloff || map.is_some();
        let of_2012 = if is_a5 { Y2012A5 } else { Y2012A4 };
        if clues.writes("bmp") {
            return choice(of_2012, "the picture in BMP");
        }
        if words.has_texture {
            return choice(of_2012, "`texture`");
        }
        if words.has_shininess && words.has_falloff {
            return choice(Y2019, "`shininess` with `falloff`");
        }
        if !is_a5 && clues.writes("png") {
            return choice(Y2019, "the picture in PNG");
        }
        choice(of_2012, &format!("`{first}`"))
    }
}

/// The words in a scene that tell editions apart.
#[derive(Default)]
struct LaterWords<'t> {
    /// The first that 2004 has not.
    first: Option<&'t str>,
    /// One that only assignment 5 of 2012 has.
    of_2012a5: Option<&'t str>,
    cube_map: Option<&'t str>,
    names_models: bool,
    has_falloff: bool,
    has_shininess: bool,
    has_texture: bool,
}

impl<'t> LaterWords<'t> {
    /// None if there is a word of 2004, or one that only Aalto has.
    fn of(text: &'t str) -> Option<Self> {
        let (mut found, mut lexer, mut depth) = (Self::default(), Lexer::new(text), 0u32);
        let mut before = "";
        loop {
            let word = lexer.next_word().text;
            match word {
                "" => return Some(found),
                "{" => depth += 1,
                "}" => depth = depth.saturating_sub(1),
                "falloff" => found.has_falloff = true,
                "shininess" => found.has_shininess = true,
                "texture" => found.has_texture = true,
                // In the materials of 2004 it is a material itself.
                "Noise" if depth >= 2 => found.of_2012a5 = Some(word),
                "Noise" => return None,
                _ => {}
            }
            match editions_of(word) {
                // A word of Aalto's is no later one either, whose flags have to say whose scene it is.
                Some(editions) if !editions.iter().any(|edition| edition.is_later()) => return None,
                Some(editions) => {
                    found.first = found.first.or(Some(word));
                    if editions == [Y2012A5] {
                        found.of_2012a5 = Some(word);
                    }
                }
                None => {}
            }
            match before {
                "cubeMap" => found.cube_map = Some(word),
                "obj_file" => found.names_models |= word.starts_with("models/"),
                _ => {}
            }
            before = word;
        }
    }
}

impl fmt::Display for Edition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Serialize for Edition {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube map with this ending is there, and pictures with this one are written.
    struct Around(&'static str, &'static str);

    impl Clues for Around {
        fn has_face(&self, folder: &str, ending: &str) -> bool {
            folder == "tex/sky" && ending == self.0
        }

        fn writes(&self, ending: &str) -> bool {
            ending == self.1
        }
    }

    fn found(text: &str, around: Around) -> Option<(Edition, String)> {
        let choice = Edition::of_words(text, &around)?;
        Some((choice.edition, choice.because.unwrap()))
    }

    #[test]
    fn words_and_what_is_around_them_tell_the_edition() {
        for (text, around, edition, because) in [
            ("shininess", Around("", ""), Y2012A4, "`shininess`"),
            ("shininess", Around("", "bmp"), Y2012A4, "`shininess`, and the picture in BMP"),
            ("shininess", Around("", "png"), Y2019, "`shininess`, and the picture in PNG"),
            ("falloff", Around("", "png"), Y2012A5, "`falloff`"),
            ("shininess falloff", Around("", ""), Y2019, "`shininess` with `falloff`"),
            ("shininess falloff", Around("", "bmp"), Y2012A5, "`shininess`, and the picture in BMP"),
            ("texture a.bmp", Around("", "png"), Y2012A4, "`texture`"),
            (
                "shininess refractionIndex falloff",
                Around("", ""),
                Y2012A5,
                "`shininess`, and `refractionIndex`",
            ),
            (
                "Materials { Material { Noise { } } Matrix4f",
                Around("", ""),
                Y2012A5,
                "`Matrix4f`, and `Noise`",
            ),
            ("cubeMap tex/sky", Around("png", "bmp"), Y2019, "`cubeMap`, and the cube map of PNG files"),
            ("cubeMap tex/sky", Around("bmp", "png"), Y2012A5, "`cubeMap`, and the cube map of BMP files"),
            ("cubeMap tex/none", Around("bmp", "png"), Y2012A5, "`cubeMap`"),
            (
                "shininess obj_file models/a.obj",
                Around("", ""),
                Y2019,
                "`shininess`, and the meshes in `models/`",
            ),
        ] {
            assert_eq!(found(text, around), Some((edition, because.to_owned())), "{text}");
        }
    }

    #[test]
    fn a_word_of_2004_or_no_word_at_all_tells_nothing() {
        for text in [
            "",
            "Sphere { radius 1 }",
            "shininess exponent",
            "Materials { Noise { falloff",
            "texture",
            "texture a.tga mipmap",
            "noise",
        ] {
            // A texture is a word of 2012 only.
            assert_eq!(found(text, Around("png", "bmp")).is_some(), text == "texture", "{text}");
        }
    }

    #[test]
    fn editions_have_names() {
        for (edition, name) in Edition::ALL.into_iter().zip(Edition::NAMES) {
            assert_eq!((edition.name(), Edition::named(name)), (name, Some(edition)));
        }
        assert_eq!(Edition::named("2005"), None);
    }
}
