//! Reads the small parts of the grammar, each with its checks: braces, keywords, numbers and vectors.

use super::Position;
use super::edition::{Edition, editions_of};
use super::keyword::{is_keyword, nearest};
use super::lexer::{Lexer, Word};
use super::limits::{BRIGHTEST, LARGEST};
use super::texels::ImageFile;
use crate::diagnostic::{Diagnostic, limited};
use crate::picture::Color;
use glam::DVec3;
use std::collections::HashMap;

pub type Parsed<T> = Result<T, Diagnostic>;

/// Reads the words of a scene with one word of lookahead.
///
/// A word that does not fit the grammar, or a value that breaks a rule, is the error that a method returns. Nobody reads
/// on behind one, so that every loop over words either takes a word or ends.
pub struct Reader<'a> {
    lexer: Lexer<'a>,
    ahead: Word<'a>,
    /// The last word taken that is no number, and how many numbers were taken after it.
    values: (&'a str, usize),
    /// Warnings about blocks that replace earlier ones.
    pub(super) replaced: Vec<Diagnostic>,
    /// A warning about the first colour above 1, and the number of the others.
    bright: Option<(Diagnostic, usize)>,
    /// The edition whose words are read.
    pub(super) edition: Edition,
    /// The pictures that have been named, each once.
    pub(super) images: Vec<ImageFile>,
    image_indices: HashMap<String, usize>,
}

impl<'a> Reader<'a> {
    #[cfg(test)]
    pub fn new(text: &'a str) -> Self {
        Self::of(Edition::Y2004, text)
    }

    pub fn of(edition: Edition, text: &'a str) -> Self {
        let mut lexer = Lexer::new(text);
        let ahead = lexer.next_word();
        Self {
            lexer,
            ahead,
            values: ("", 0),
            replaced: vec![],
            bright: None,
            edition,
            images: vec![],
            image_indices: HashMap::new(),
        }
    }

    /// The index of the picture with this name, which the scene names here.
    pub fn image(&mut self, name: String, at: Position) -> usize {
        *self.image_indices.entry(name).or_insert_with_key(|name| {
            self.images.push(ImageFile { name: name.clone(), at, ..ImageFile::default() });
            self.images.len() - 1
        })
    }

    /// Takes the name of a file or a folder, the value of `field`.
    pub fn file_name(&mut self, field: &str) -> Parsed<Word<'a>> {
        if self.ahead.is_end() || matches!(self.ahead.text, "{" | "}") {
            return Err(self.unexpected(&format!("a file name for `{field}`"), &[]));
        }
        Ok(self.take())
    }

    /// The next word, without taking it.
    pub fn peek(&self) -> Word<'a> {
        self.ahead
    }

    /// Takes the next word.
    pub fn take(&mut self) -> Word<'a> {
        self.values = (self.ahead.text, 0);
        std::mem::replace(&mut self.ahead, self.lexer.next_word())
    }

    /// Takes the next word, which is a number.
    fn take_number(&mut self) {
        let (field, count) = self.values;
        self.take();
        self.values = (field, count + 1);
    }

    /// Whether the next word is `keyword`.
    pub fn is_at(&self, keyword: &str) -> bool {
        is_keyword(self.ahead.text, keyword)
    }

    /// Whether the next word is one of `keywords`.
    pub fn is_at_any(&self, keywords: &[&str]) -> bool {
        keywords.iter().any(|keyword| self.is_at(keyword))
    }

    /// Takes the next word if it is `keyword`, and returns whether it was.
    pub fn accept(&mut self, keyword: &str) -> bool {
        let is_next = self.is_at(keyword);
        if is_next {
            self.take();
        }
        is_next
    }

    /// The error that the next word is not `what`. The hint suggests the nearest of `keywords`, or lists them
    /// all.
    pub fn unexpected(&self, what: &str, keywords: &[&str]) -> Diagnostic {
        let found = self.ahead.text;
        let message = format!("expected {what}, found {}", self.ahead.quoted());
        let error = Diagnostic::error(message).at(self.ahead.at);
        if found.starts_with("/*") {
            return error.with_hint("a comment starts with `#` or `//` and ends with the line");
        }
        if let Some(hint) = self.one_more() {
            return error.with_hint(hint);
        }
        let keywords: Vec<&str> =
            keywords.iter().copied().filter(|word| !self.is_of_other_edition(word)).collect();
        match nearest(found, &keywords) {
            _ if self.is_of_other_edition(found) => {
                let editions = editions_of(found).unwrap_or_default();
                let names: Vec<_> = editions.iter().map(|edition| format!("`-edition {edition}`")).collect();
                error.with_hint(format!("`{found}` is a word of other editions: {}", names.join(", ")))
            }
            Some(keyword) => error.with_hint(format!("did you mean `{keyword}`?")),
            None if keywords.len() > 1 => error.with_hint(format!("possible here: {}", keywords.join(", "))),
            None => error,
        }
    }

    fn is_of_other_edition(&self, word: &str) -> bool {
        editions_of(word).is_some_and(|editions| !editions.contains(&self.edition))
    }

    /// What to say of a number that follows the last one of a field.
    fn one_more(&self) -> Option<String> {
        let (field, count) = self.values;
        let is_one_more =
            count > 0 && field.starts_with(char::is_alphabetic) && parse_number(self.ahead.text).is_some();
        let numbers = if count == 1 { "one number".to_owned() } else { format!("{count} numbers") };
        is_one_more.then(|| format!("`{field}` takes {numbers}, and this is one more"))
    }

    /// Takes `keyword`, which the grammar requires here.
    pub fn keyword(&mut self, keyword: &str) -> Parsed<Word<'a>> {
        if !self.is_at(keyword) {
            return Err(self.unexpected(&format!("`{keyword}`"), &[keyword]));
        }
        Ok(self.take())
    }

    /// Takes the keyword of a block, which the caller has checked, and the opening brace.
    pub fn open(&mut self) -> Parsed<Word<'a>> {
        let name = self.take();
        if !self.accept("{") {
            return Err(self.unexpected(&format!("`{{` after `{}`", name.text), &[]));
        }
        Ok(name)
    }

    /// Takes the closing brace of the block called `name`.
    pub fn close(&mut self, name: &str) -> Parsed<()> {
        if !self.accept("}") {
            return Err(self.unexpected(&format!("`}}` at the end of `{name}`"), &[]));
        }
        Ok(())
    }

    /// Takes a number, the value of `field`. Its magnitude must be at most [`LARGEST`].
    pub fn number(&mut self, field: &str) -> Parsed<f64> {
        let word = self.ahead;
        let number = parse_number(word.text).ok_or_else(|| self.not_a_number("a number", field))?;
        if number.abs() > LARGEST {
            let message = format!("the number {} is too large: the largest is 1e100", word.quoted());
            return Err(Diagnostic::error(message).at(word.at));
        }
        self.take_number();
        Ok(number)
    }

    /// Takes a number for which `holds` is true; `rule` describes the condition, as in "must be positive".
    pub fn number_that(&mut self, field: &str, rule: &str, holds: impl Fn(f64) -> bool) -> Parsed<f64> {
        let word = self.ahead;
        let number = self.number(field)?;
        if holds(number) { Ok(number) } else { Err(bad_value(word, field, rule)) }
    }

    /// Takes a non-negative integer below 2^64.
    pub fn whole(&mut self, field: &str) -> Parsed<u64> {
        let word = self.ahead;
        let digits = word.text.strip_prefix('+').unwrap_or(word.text);
        if is_digits(digits)
            && let Ok(number) = digits.parse()
        {
            self.take_number();
            return Ok(number);
        }
        let rule = match parse_number(word.text) {
            Some(_) if is_digits(digits) => "must be below 2^64",
            Some(number) if number < 0.0 => "must not be negative",
            Some(_) => "must be a whole number",
            None => return Err(self.not_a_number("a whole number", field)),
        };
        Err(bad_value(word, field, rule))
    }

    /// Takes three numbers.
    pub fn vector(&mut self, field: &str) -> Parsed<DVec3> {
        Ok(DVec3::new(self.component(field)?, self.component(field)?, self.component(field)?))
    }

    /// Takes a colour's three channels.
    pub fn color(&mut self, field: &str) -> Parsed<Color> {
        let at = self.ahead;
        let color = self.vector(field)?;
        if color.abs().max_element() > BRIGHTEST {
            return Err(bad_value(at, field, "must be at most 1e30 in each channel"));
        }
        Ok(color)
    }

    /// Takes the colour of a surface or of the background. Above 1 it is brighter than any picture shows.
    pub fn shown_color(&mut self, field: &str) -> Parsed<Color> {
        let at = self.ahead.at;
        let color = self.color(field)?;
        self.warn_if_above_one(at, field, color);
        Ok(color)
    }

    /// Records a colour above 1.
    pub fn warn_if_above_one(&mut self, at: Position, field: &str, color: Color) {
        if color.max_element() <= 1.0 {
            return;
        }
        match &mut self.bright {
            Some((_, others)) => *others += 1,
            None => {
                let message = format!("`{field}` is above 1, the brightest that a picture shows");
                let hint = is_byte_like(color).then(|| "is it meant as 0 to 255?".to_owned());
                self.bright = Some((Diagnostic { hint, ..Diagnostic::warning(message) }.at(at), 0));
            }
        }
    }

    /// Returns the warnings about what was read.
    pub fn into_warnings(self) -> Vec<Diagnostic> {
        let bright = self.bright.map(|(mut first, others)| {
            first.message += &match others {
                0 => String::new(),
                1 => "; so is another colour".into(),
                _ => format!("; so are {others} more colours"),
            };
            first
        });
        limited(self.replaced).into_iter().chain(bright).collect()
    }

    /// Takes three numbers that are not all zero.
    pub fn nonzero_vector(&mut self, field: &str) -> Parsed<DVec3> {
        let at = self.ahead.at;
        let vector = self.vector(field)?;
        if vector == DVec3::ZERO {
            return Err(Diagnostic::error(format!("`{field}` must not be the zero vector")).at(at));
        }
        Ok(vector)
    }

    /// Takes `field` and its three numbers.
    pub fn vector_field(&mut self, field: &str) -> Parsed<DVec3> {
        self.keyword(field)?;
        self.vector(field)
    }

    /// Takes `field` and its three numbers, which are not all zero.
    pub fn direction_field(&mut self, field: &str) -> Parsed<DVec3> {
        self.keyword(field)?;
        self.nonzero_vector(field)
    }

    /// Takes `field` and a number greater than zero.
    pub fn positive_field(&mut self, field: &str) -> Parsed<f64> {
        self.keyword(field)?;
        self.number_that(field, "must be positive", |number| number > 0.0)
    }

    /// Takes `field` and a number.
    pub fn number_field(&mut self, field: &str) -> Parsed<f64> {
        self.keyword(field)?;
        self.number(field)
    }

    fn component(&mut self, field: &str) -> Parsed<f64> {
        self.number(field).map_err(|error| match error.hint {
            None if parse_number(self.ahead.text).is_none() => {
                error.with_hint(format!("`{field}` takes three numbers"))
            }
            _ => error,
        })
    }

    fn not_a_number(&self, kind: &str, field: &str) -> Diagnostic {
        let error = self.unexpected(&format!("{kind} for `{field}`"), &[]);
        let word = self.ahead.text;
        if word.contains('#') || word.contains("//") {
            return error.with_hint("a comment must be separated from the word before it by a blank");
        }
        match word.strip_suffix(['f', 'F']) {
            Some(number) if parse_number(number).is_some() => error.with_hint(format!("write `{number}`")),
            _ if parse_number(&word.replace(',', "")).is_some() => {
                error.with_hint("numbers have blanks between them and a point before decimals, and no commas")
            }
            _ => error,
        }
    }
}

/// The error that the value `word` of `field` violates `rule`.
pub fn bad_value(word: Word<'_>, field: &str, rule: &str) -> Diagnostic {
    Diagnostic::error(format!("`{field}` {rule}, found {}", word.quoted())).at(word.at)
}

/// Whether a colour has whole numbers up to 255.
pub fn is_byte_like(color: Color) -> bool {
    color.to_array().iter().all(|channel| (0.0..=255.0).contains(channel) && channel.fract() == 0.0)
}

/// A number in the syntax of C's scanf: `1`, `+1`, `-.3`, `0.` or `1e-3`, but not `inf` or `nan`. A number
/// that overflows becomes infinite.
fn parse_number(word: &str) -> Option<f64> {
    let starts_well =
        word.starts_with(|first: char| first.is_ascii_digit() || matches!(first, '+' | '-' | '.'));
    let has_digit = word.bytes().any(|byte| byte.is_ascii_digit());
    if starts_well && has_digit { word.parse().ok() } else { None }
}

fn is_digits(word: &str) -> bool {
    !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_scanf_reads_them() {
        let good = [
            ("1", 1.0),
            ("+1", 1.0),
            ("-.3", -0.3),
            ("0.", 0.0),
            ("1e-3", 1e-3),
            (".5E2", 50.0),
            ("-0", 0.0),
        ];
        for (word, value) in good {
            assert_eq!(Reader::new(word).number("x").unwrap(), value, "{word}");
        }
    }

    #[test]
    fn other_words_are_not_numbers() {
        for word in [
            "", "}", ".", "+", "-", "e5", "1e", "inf", "-inf", "nan", "NaN", "+nan", "0x10", "1,5", "1f",
            "--1",
        ] {
            assert!(Reader::new(word).number("x").is_err(), "{word}");
        }
    }

    #[test]
    fn numbers_beyond_the_largest_are_refused() {
        for word in ["1e999", "-1e999", "1.01e100", "-1.01e100"] {
            let error = Reader::new(word).number("x").unwrap_err();
            assert!(error.message.contains(word) && error.message.contains("too large"), "{error}");
        }
        assert_eq!(Reader::new("1e100").number("x").unwrap(), 1e100);
        assert_eq!(Reader::new("1e-999").number("x").unwrap(), 0.0);
    }

    #[test]
    fn whole_numbers() {
        for (word, value) in [("0", 0), ("+7", 7), ("007", 7), ("18446744073709551615", u64::MAX)] {
            assert_eq!(Reader::new(word).whole("x").unwrap(), value, "{word}");
        }
        let error = Reader::new("18446744073709551616").whole("x").unwrap_err().to_string();
        assert!(error.contains("must be below 2^64"), "{error}");
        let error = Reader::new("x").whole("x").unwrap_err().to_string();
        assert!(error.contains("expected a whole"), "{error}");
    }

    #[test]
    fn a_word_that_causes_an_error_is_not_taken() {
        let mut reader = Reader::new("radius }");
        assert!(reader.keyword("center").is_err() && reader.number("center").is_err());
        assert_eq!(reader.keyword("radius").unwrap().text, "radius");
    }

    #[test]
    fn a_comment_stuck_to_a_number_is_explained() {
        let error = Reader::new("1#one").number("x").unwrap_err();
        assert!(error.hint.unwrap().contains("comment"));
    }

    #[test]
    fn numbers_as_other_languages_write_them_are_explained() {
        let hint = |text| Reader::new(text).vector("center").unwrap_err().hint.unwrap();
        assert!(["0, 1.5, 8", "0,1.5,8", "0 1,5 8"].map(hint).iter().all(|hint| hint.contains("no commas")));
        assert_eq!([hint("1.0f 2 3"), hint("1 -2F 3")], ["write `1.0`", "write `-2`"]);
        assert!(["/* x */ 1", "0 /*x*/"].map(hint).iter().all(|hint| hint.starts_with("a comment starts")));
    }

    #[test]
    fn a_number_after_the_last_one_of_its_field_is_explained() {
        let hint = |text, keyword| {
            let mut reader = Reader::new(text);
            reader.vector_field("center").unwrap();
            reader.keyword(keyword).unwrap_err().hint
        };
        assert_eq!(
            hint("center 1 2 3 4", "radius"),
            Some("`center` takes 3 numbers, and this is one more".into())
        );
        assert_eq!(hint("center 1 2 3 radios", "radius"), Some("did you mean `radius`?".into()));
        let mut reader = Reader::new("radius 1 2");
        reader.number_field("radius").unwrap();
        assert_eq!(
            reader.close("Sphere").unwrap_err().hint,
            Some("`radius` takes one number, and this is one more".into())
        );
    }

    #[test]
    fn where_several_words_are_possible_they_are_named() {
        let hint = |keywords| Reader::new("0").unexpected("a word", keywords).hint;
        assert_eq!((hint(&[]), hint(&["center"])), (None, None));
        assert_eq!(hint(&["center", "radius"]), Some("possible here: center, radius".into()));
    }

    #[test]
    fn fractional_and_negative_numbers_have_different_errors() {
        let message = |word| Reader::new(word).whole("x").unwrap_err().message;
        assert!(["-1", "-0.5"].iter().all(|word| message(word).contains("negative")));
        assert!(["0.0", "-0", "2.5"].iter().all(|word| message(word).contains("whole number")));
    }

    #[test]
    fn a_vector_keeps_the_hint_of_its_number_if_there_is_one() {
        let hint = |text| Reader::new(text).vector("center").unwrap_err().hint.unwrap();
        assert_eq!(hint("1 2 }"), "`center` takes three numbers");
        assert!(hint("1 2#3").contains("comment"));
    }
}
