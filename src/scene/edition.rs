//! The editions of the course: their names, their keywords, and the meaning of their scenes.

use super::lexer::{Lexer, Word};
use super::model::{
    Depths, FaceWeights, Highlight, Lighting, MeasureColors, MeshNormals, NormalColors, Screen, Split,
};
use crate::diagnostic::Diagnostic;
use serde::{Serialize, Serializer};
use std::fmt;

/// An edition of the course.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Edition {
    /// The 2003 and 2004 editions, assignments 1 to 7.
    #[default]
    Y2004,
    /// The 2012 edition, assignment 4.
    Y2012A4,
    /// The 2012 edition, assignment 5.
    Y2012A5,
    /// The editions from 2016 to 2019, assignment 4. From 2020 on the course has another scene language.
    Y2019,
    /// The edition of Aalto University. It uses the scene language of 2004.
    Aalto,
}

use Edition::{Aalto, Y2004, Y2012A4, Y2012A5, Y2019};

/// The words that exist only in some editions.
const WORDS: [(&str, &[Edition]); 22] = [
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
    ("refractionIndex", &[Y2012A5]),
    ("texture", &[Y2012A4, Y2012A5, Aalto]),
    ("falloff", &[Y2012A5, Y2019]),
    ("cubeMap", &[Y2012A5, Y2019]),
];

/// Returns the editions that have `word`, or `None` if it is not limited to some editions.
pub(super) fn editions_of(word: &str) -> Option<&'static [Edition]> {
    WORDS.iter().find(|(known, _)| *known == word).map(|(_, editions)| *editions)
}

/// An edition, and the reason for choosing it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Choice {
    pub edition: Edition,
    /// The reason, as words to follow `because of`. `None` if the user named the edition, or if it is 2004.
    pub because: Option<String>,
    /// The other editions that have all words of the scene, if the words do not identify one edition.
    pub others: Vec<Edition>,
}

impl Choice {
    /// Returns a note if the words identified the edition, or a warning if they were ambiguous.
    pub fn remark(&self) -> Option<Diagnostic> {
        let (edition, because) = (self.edition, self.because.as_ref()?);
        let taken = format!("the scene is read as edition {edition}");
        if self.others.is_empty() {
            return Some(Diagnostic::note(format!(
                "{taken}, because of {because}; `-edition` chooses another"
            )));
        }
        let others: Vec<String> = self.others.iter().map(|other| format!("`-edition {other}`")).collect();
        let hint = format!("add `-edition {edition}`, or {} for another picture", others.join(" or "));
        Some(Diagnostic::warning(format!("{taken}, but {because} may belong to another")).with_hint(hint))
    }
}

impl Edition {
    /// All editions, in chronological order.
    pub const ALL: [Self; 5] = [Y2004, Y2012A4, Y2012A5, Y2019, Aalto];
    pub const NAMES: [&'static str; 5] = ["2004", "2012a4", "2012a5", "2019", "aalto"];

    /// Returns the name used with `-edition`.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().zip(Self::NAMES).find(|(edition, _)| **edition == self).map_or("", |(_, name)| name)
    }

    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|edition| edition.name() == name)
    }

    /// Returns true if the edition uses the scene language of 2012 and later.
    pub fn is_later(self) -> bool {
        matches!(self, Y2012A4 | Y2012A5 | Y2019)
    }

    /// Returns true if files are looked for first beside the scene, then in the working directory.
    pub fn starts_beside_scene(self) -> bool {
        matches!(self, Y2019 | Aalto)
    }

    /// Returns the file extension of a cube map's pictures.
    pub fn ending_of_faces(self) -> &'static str {
        if self == Y2019 { "png" } else { "bmp" }
    }

    /// Returns true if texels are interpolated as bytes and divided by 255 afterwards.
    pub fn divides_texels_last(self) -> bool {
        self != Y2019
    }

    /// Returns the number of bounces used without `-bounces`.
    pub fn default_bounces(self) -> u32 {
        if self == Y2012A5 { 4 } else { 0 }
    }

    /// Returns the threshold used without `-weight`. Secondary rays with a weight above it are traced.
    pub fn default_weight(self) -> f64 {
        if self == Aalto { 0.1 } else { 0.0 }
    }

    /// Returns how a perspective camera's angle maps to pixels.
    pub fn screen(self) -> Screen {
        match self {
            Y2004 | Aalto => Screen::LongerSide,
            Y2012A4 | Y2012A5 => Screen::BothSides { up_as_written: false },
            Y2019 => Screen::BothSides { up_as_written: true },
        }
    }

    pub fn lighting(self) -> Lighting {
        let later = |split, epsilon| Lighting { highlight: Highlight::Phong, split, epsilon: Some(epsilon) };
        match self {
            Y2004 | Aalto => Lighting::default(),
            Y2012A4 => later(Split::Colors, 1e-3),
            Y2012A5 => later(Split::Schlick, 1e-3),
            Y2019 => later(Split::Colors, 1e-2),
        }
    }

    pub fn mesh_normals(self) -> MeshNormals {
        let (weights, flat_up_to) = match self {
            Y2004 | Aalto => return MeshNormals::Flat,
            Y2012A4 => (FaceWeights::Area, 0),
            Y2012A5 => (FaceWeights::Area, 120),
            Y2019 => (FaceWeights::Equal, 0),
        };
        MeshNormals::Smooth { weights, flat_up_to }
    }

    pub fn measure_colors(self) -> MeasureColors {
        match self {
            Y2019 => MeasureColors { depths: Depths::NearBlack, normals: NormalColors::Shifted },
            _ => MeasureColors::default(),
        }
    }

    /// Identifies the edition of a scene that is not from 2004 by its words. `None` if a word exists only in 2004 or
    /// Aalto. The user has to name Aalto's edition.
    pub fn of_words(text: &str) -> Option<Choice> {
        let mut lexer = Lexer::new(text);
        let words = std::iter::from_fn(|| Some(lexer.next_word().text).filter(|word| !word.is_empty()));
        let words: Vec<&str> = words.collect();
        let has = |word| words.contains(&word);
        let mut possible = vec![Y2012A4, Y2012A5, Y2019];
        // The first word unknown to 2004, and the last word that excludes some later edition.
        let (mut first, mut telling) = (None, None);
        let mut depth = 0u32;
        for &word in &words {
            let editions: &[Edition] = match word {
                // In 2004 it is a material of its own.
                "Noise" if depth >= 2 => &[Y2012A5],
                "Noise" => return None,
                _ => editions_of(word).unwrap_or(&Self::ALL),
            };
            match word {
                "{" => depth += 1,
                "}" => depth = depth.saturating_sub(1),
                _ => {}
            }
            let is_possible = |edition: &Edition| editions.contains(edition);
            if !possible.iter().all(is_possible) {
                telling = Some(word);
            }
            possible.retain(is_possible);
            if !editions.contains(&Y2004) {
                first = first.or(Some(word));
            }
        }
        let first = first?;
        let mut because = format!("`{}`", telling.unwrap_or(first));
        let has_models = words.windows(2).any(|two| two[0] == "obj_file" && two[1].starts_with("models/"));
        if possible.len() > 1 && possible.contains(&Y2019) && has_models {
            (possible, because) = (vec![Y2019], "the meshes in `models/`".into());
        } else if possible.len() > 1 && has("shininess") && (has("falloff") || !has("cubeMap")) {
            // In 2012a5 it has no effect. That edition's own scenes have it without `falloff` and beside a cube map.
            possible.retain(|edition| *edition != Y2012A5);
            if has("falloff") {
                because = "`shininess` with `falloff`".into();
            }
        }
        if !because.contains(first) {
            because = format!("`{first}`, and {because}");
        }
        let (edition, others) = possible.split_first()?;
        Some(Choice { edition: *edition, because: Some(because), others: others.to_vec() })
    }
}

/// Returns the error for a text in the scene language of the course from 2020 on. It has the blocks `Camera`, `Scene`
/// and `Node`, which no other edition has.
pub fn newer_language(text: &str) -> Option<Diagnostic> {
    let mut lexer = Lexer::new(text);
    let words = std::iter::from_fn(|| Some(lexer.next_word()).filter(|word| !word.is_end()));
    let words: Vec<Word> = words.collect();
    let has = |word: &str| words.iter().any(|other| other.text == word);
    let is_block = |pair: &&[Word]| match (pair[0].text, pair[1].text) {
        ("Scene" | "Node", "{") => true,
        // Alone it is more likely a misspelt `PerspectiveCamera`.
        ("Camera", "{") => has("fov") || has("Scene") || has("Node"),
        (word, "{") => word.starts_with("Component<"),
        _ => false,
    };
    let first = words.windows(2).find(is_block)?[0];
    let message = format!(
        "{} belongs to the scene language that the course has had since 2020, which is not read",
        first.quoted()
    );
    let hint = "the languages of 2003 to 2019 are read: `Scene` and `Node` are `Group` and `Transform` there";
    Some(Diagnostic::error(message).at(first.at).with_hint(hint))
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

    #[test]
    fn words_tell_the_edition_or_leave_it_open() {
        let open =
            |edition, others: &[Edition], because: &str| (edition, others.to_vec(), because.to_owned());
        let told = |edition, because| open(edition, &[], because);
        for (text, expected) in [
            ("shininess", open(Y2012A4, &[Y2019], "`shininess`")),
            ("falloff", open(Y2012A5, &[Y2019], "`falloff`")),
            ("bump a.bmp", open(Y2012A5, &[Y2019], "`bump`")),
            ("texture a.bmp", open(Y2012A4, &[Y2012A5], "`texture`")),
            ("cubeMap tex/sky", open(Y2012A5, &[Y2019], "`cubeMap`")),
            ("cubeMap tex/sky shininess", open(Y2012A5, &[Y2019], "`cubeMap`")),
            ("cubeMap tex/sky shininess falloff", told(Y2019, "`cubeMap`, and `shininess` with `falloff`")),
            ("texture a.bmp shininess", told(Y2012A4, "`texture`")),
            ("shininess bump a.bmp", told(Y2019, "`shininess`, and `bump`")),
            ("texture a.bmp falloff", told(Y2012A5, "`texture`, and `falloff`")),
            ("shininess falloff", told(Y2019, "`shininess` with `falloff`")),
            ("shininess refractionIndex falloff", told(Y2012A5, "`shininess`, and `refractionIndex`")),
            ("Materials { Material { Noise { } } Matrix4f", told(Y2012A5, "`Noise`")),
            ("Matrix4f Materials { Material { Noise { } }", told(Y2012A5, "`Matrix4f`, and `Noise`")),
            ("shininess obj_file models/a.obj", told(Y2019, "`shininess`, and the meshes in `models/`")),
        ] {
            let choice = Edition::of_words(text).unwrap();
            assert_eq!((choice.edition, choice.others, choice.because.unwrap()), expected, "{text}");
        }
    }

    #[test]
    fn a_word_of_2004_or_no_word_at_all_tells_nothing() {
        for text in [
            "",
            "Sphere { radius 1 }",
            "obj_file models/a.obj",
            "shininess exponent",
            "Materials { Noise { falloff",
            "texture a.tga mipmap",
            "noise",
        ] {
            assert_eq!(Edition::of_words(text), None, "{text}");
        }
    }

    #[test]
    fn the_language_of_2020_is_known_by_its_blocks() {
        let at = |text: &str| newer_language(text).and_then(|error| error.position()).map(|at| at.column);
        for (text, column) in [
            ("Background { } Camera { fov 30 } Scene { }", Some(16)),
            ("Camera { center 0 0 9 } Scene { }", Some(1)),
            ("Materials { Material { } } Scene { Node { } }", Some(28)),
            ("Node { Component<Light> { } }", Some(1)),
            ("Component<Object> { type sphere }", Some(1)),
            ("Camera { center 0 0 9 angle 30 } Group { }", None),
            ("obj_file Scene.obj # Scene {", None),
            ("", None),
        ] {
            assert_eq!(at(text), column, "{text}");
        }
    }
}
