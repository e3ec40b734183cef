//! Reads the basic elements of the grammar and checks them: keywords, braces, numbers, vectors and lists.

use super::edition::{Edition, editions_of};
use super::lexer::{Lexer, Word, is_keyword, nearest};
use super::limits::{BRIGHTEST, LARGEST};
use super::mesh::NamedFile;
use crate::base::patience::{Patience, Steps};
use crate::diagnostic::Position;
use crate::diagnostic::{Diagnostic, limited};
use crate::picture::Color;
use glam::DVec3;
use std::collections::HashMap;

pub type Parsed<T> = Result<T, Diagnostic>;

/// The steps of work that a field or the name of a block counts for.
const STEPS_PER_FIELD: usize = 4;

/// Reads the words of a scene with one word of lookahead.
///
/// Methods return an error if a word does not fit the grammar or a value breaks a rule. An error ends the reading, so
/// every loop over words either takes a word or ends.
pub struct Reader<'a> {
    lexer: Lexer<'a>,
    ahead: Word<'a>,
    /// The field whose values are read: the last word taken that starts with a letter.
    field: &'a str,
    /// The number of numbers taken directly after the field. `None` after any other word.
    values: Option<usize>,
    /// Warnings about blocks that replace earlier ones.
    pub(super) replaced: Vec<Diagnostic>,
    /// A warning about the first colour above 1, and the number of other such colours.
    bright: Option<(Diagnostic, usize)>,
    /// The edition whose keywords are read.
    pub(super) edition: Edition,
    /// The pictures named so far.
    pub(super) images: NamedFiles,
    /// The files named so far that are not read, each with its kind.
    pub(super) unread: Vec<NamedFile>,
    steps: Steps<'a>,
}

impl<'a> Reader<'a> {
    pub fn new(edition: Edition, text: &'a str, patience: &'a dyn Patience) -> Self {
        let mut lexer = Lexer::new(text);
        let ahead = lexer.next_word();
        let (replaced, bright, images, unread) = Default::default();
        let steps = Steps::new(patience);
        Self { lexer, ahead, field: "", values: None, replaced, bright, edition, images, unread, steps }
    }

    /// Returns the next word without taking it.
    pub fn peek(&self) -> Word<'a> {
        self.ahead
    }

    /// Takes the next word.
    pub fn take(&mut self) -> Word<'a> {
        let word = std::mem::replace(&mut self.ahead, self.lexer.next_word());
        self.values = None;
        if word.text.starts_with(char::is_alphabetic) {
            (self.field, self.values) = (word.text, Some(0));
        }
        word
    }

    fn take_number(&mut self) {
        self.ahead = self.lexer.next_word();
        self.values = self.values.map(|count| count + 1);
    }

    /// Returns true if the next word is `keyword`.
    pub fn is_at(&self, keyword: &str) -> bool {
        is_keyword(self.ahead.text, keyword)
    }

    /// Returns true if the next word is one of `keywords`.
    pub fn is_at_any(&self, keywords: &[&str]) -> bool {
        keywords.iter().any(|keyword| self.is_at(keyword))
    }

    /// Takes the next word if it is `keyword`. Returns true if it was.
    pub fn accept(&mut self, keyword: &str) -> bool {
        let is_next = self.is_at(keyword);
        if is_next {
            self.take();
        }
        is_next
    }

    /// Takes `keyword`, which the grammar requires here.
    pub fn keyword(&mut self, keyword: &'static str) -> Parsed<&mut Self> {
        if !self.is_at(keyword) {
            return Err(self.unexpected(&format!("`{keyword}`"), &[keyword]));
        }
        self.take();
        self.steps.take(STEPS_PER_FIELD)?;
        Ok(self)
    }

    /// Reads a block `name { ... }` and passes the name to `body`. The caller has checked the name.
    pub fn block<T>(&mut self, body: impl FnOnce(&mut Self, &'a str) -> Parsed<T>) -> Parsed<T> {
        let name = self.open()?.text;
        let content = body(self, name)?;
        self.close(name)?;
        Ok(content)
    }

    /// Takes the name of a block and the opening brace. The caller has checked the name.
    pub fn open(&mut self) -> Parsed<Word<'a>> {
        self.steps.take(STEPS_PER_FIELD)?;
        let name = self.take();
        self.open_brace(name.text)?;
        Ok(name)
    }

    /// Takes the opening brace of the block called `name`.
    pub fn open_brace(&mut self, name: &str) -> Parsed<()> {
        if self.accept("{") { Ok(()) } else { Err(self.unexpected(&format!("`{{` after `{name}`"), &[])) }
    }

    /// Takes the closing brace of the block called `name`.
    pub fn close(&mut self, name: &str) -> Parsed<()> {
        if self.accept("}") {
            Ok(())
        } else {
            Err(self.unexpected(&format!("`}}` at the end of `{name}`"), &[]))
        }
    }

    /// Reads fields in any order up to the closing brace, but not the brace itself. A repeated field replaces the
    /// earlier one.
    ///
    /// `value` reads the values of a field. `expected` describes the words allowed here.
    pub fn fields(
        &mut self,
        expected: &str,
        fields: &[&'static str],
        mut value: impl FnMut(&mut Self, &'static str) -> Parsed<()>,
    ) -> Parsed<()> {
        let find = |reader: &Self| {
            fields.iter().find(|field| reader.is_at(field) && !reader.is_of_other_edition(field)).copied()
        };
        while let Some(field) = find(self) {
            value(self.keyword(field)?, field)?;
        }
        if self.is_at("}") { Ok(()) } else { Err(self.unexpected(expected, fields)) }
    }

    /// Reads a block `name { field N item^N }`, and returns each item with its position.
    ///
    /// `item` reads one item and is given its index. `kinds` are the keywords that start an item. The list grows as
    /// items are read, so a huge announced length allocates nothing.
    pub fn list<T>(
        &mut self,
        field: &'static str,
        kinds: &[&str],
        mut item: impl FnMut(&mut Self, usize) -> Parsed<T>,
    ) -> Parsed<Vec<(T, Position)>> {
        let name = self.open()?.text;
        let mut announced = Announced::parse(self, field)?;
        let mut items = vec![];
        while !self.is_at("}") && (self.is_at_any(kinds) || !announced.is_reached()) {
            let at = announced.next_item(self);
            items.push((item(self, items.len())?, at));
        }
        announced.close(self, name)?;
        Ok(items)
    }

    /// Takes the name of a file or a folder.
    pub fn file_name(&mut self) -> Parsed<Word<'a>> {
        if self.ahead.is_end() || matches!(self.ahead.text, "{" | "}") {
            return Err(self.unexpected(&format!("a file name for `{}`", self.field), &[]));
        }
        Ok(self.take())
    }

    /// Takes a number. Its magnitude must be at most [`LARGEST`].
    pub fn number(&mut self) -> Parsed<f64> {
        let word = self.ahead;
        let number = parse_number(word.text).ok_or_else(|| self.not_a_number("a number"))?;
        if number.abs() > LARGEST {
            let message = format!("the number {} is too large: the largest is 1e100", word.quoted());
            return Err(Diagnostic::error(message).at(word.at));
        }
        self.steps.take(1)?;
        self.take_number();
        Ok(number)
    }

    /// Takes a number for which `holds` is true. `rule` states the condition, such as "must be positive".
    pub fn number_that(&mut self, rule: &str, holds: impl Fn(f64) -> bool) -> Parsed<f64> {
        let word = self.ahead;
        let number = self.number()?;
        if holds(number) { Ok(number) } else { Err(self.bad_value(word, rule)) }
    }

    /// Takes a number that is not negative.
    pub fn nonnegative(&mut self) -> Parsed<f64> {
        self.number_that("must not be negative", |number| number >= 0.0)
    }

    /// Takes a number greater than zero.
    pub fn positive(&mut self) -> Parsed<f64> {
        self.number_that("must be positive", |number| number > 0.0)
    }

    /// Takes a non-negative integer below 2^64.
    pub fn whole(&mut self) -> Parsed<u64> {
        let word = self.ahead;
        let digits = word.text.strip_prefix('+').unwrap_or(word.text);
        let is_digits = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
        if is_digits && let Ok(number) = digits.parse() {
            self.steps.take(1)?;
            self.take_number();
            return Ok(number);
        }
        Err(match parse_number(word.text) {
            Some(_) if is_digits => self.bad_value(word, "must be below 2^64"),
            Some(number) if number < 0.0 => self.bad_value(word, "must not be negative"),
            Some(_) => self.bad_value(word, "must be a whole number"),
            None => self.not_a_number("a whole number"),
        })
    }

    /// Takes three numbers.
    pub fn vector(&mut self) -> Parsed<DVec3> {
        let mut component = || {
            self.number().map_err(|error| match error.hint {
                None if parse_number(self.ahead.text).is_none() => {
                    error.with_hint(format!("`{}` takes three numbers", self.field))
                }
                _ => error,
            })
        };
        Ok(DVec3::new(component()?, component()?, component()?))
    }

    /// Takes three numbers that are not all zero.
    pub fn direction(&mut self) -> Parsed<DVec3> {
        let at = self.ahead.at;
        let vector = self.vector()?;
        if vector == DVec3::ZERO {
            return Err(Diagnostic::error(format!("`{}` must not be the zero vector", self.field)).at(at));
        }
        Ok(vector)
    }

    /// Takes a colour's three channels.
    pub fn color(&mut self) -> Parsed<Color> {
        let word = self.ahead;
        let color = self.vector()?;
        if color.abs().max_element() > BRIGHTEST {
            return Err(self.bad_value(word, "must be at most 1e30 in each channel"));
        }
        Ok(color)
    }

    /// Takes the colour of a surface or of the background. Warns above 1, which is brighter than any picture can show.
    pub fn shown_color(&mut self) -> Parsed<Color> {
        let at = self.ahead.at;
        let color = self.color()?;
        self.warn_if_above_one(at, self.field, color);
        Ok(color)
    }

    /// Records a warning if the colour is above 1.
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

    /// Returns the warnings about the text read.
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

    /// Returns the error that the next word is not `expected`. The hint suggests the nearest of `keywords`, or lists
    /// this edition's keywords.
    pub fn unexpected(&self, expected: &str, keywords: &[&str]) -> Diagnostic {
        let found = self.ahead.text;
        let message = format!("expected {expected}, found {}", self.ahead.quoted());
        let error = Diagnostic::error(message).at(self.ahead.at);
        if found.starts_with("/*") {
            return error.with_hint("a comment starts with `#` or `//` and ends with the line");
        }
        if let Some(count) = self.values.filter(|&count| count > 0)
            && parse_number(found).is_some()
        {
            let numbers = if count == 1 { "one number".to_owned() } else { format!("{count} numbers") };
            return error.with_hint(format!("`{}` takes {numbers}, and this is one more", self.field));
        }
        if let Some(editions) = editions_of(found).filter(|editions| !editions.contains(&self.edition)) {
            let names: Vec<_> = editions.iter().map(|edition| format!("`-edition {edition}`")).collect();
            return error.with_hint(format!("`{found}` is a word of other editions: {}", names.join(", ")));
        }
        let mut keywords = keywords.to_vec();
        keywords.retain(|word| !self.is_of_other_edition(word));
        match nearest(found, &keywords) {
            Some(keyword) => error.with_hint(format!("did you mean `{keyword}`?")),
            None if keywords.len() > 1 => error.with_hint(format!("possible here: {}", keywords.join(", "))),
            None => error,
        }
    }

    /// Returns true if the word exists only in other editions.
    pub fn is_of_other_edition(&self, word: &str) -> bool {
        editions_of(word).is_some_and(|editions| !editions.contains(&self.edition))
    }

    /// Returns the error that the value `word` violates `rule`.
    pub fn bad_value(&self, word: Word<'_>, rule: &str) -> Diagnostic {
        Diagnostic::error(format!("`{}` {rule}, found {}", self.field, word.quoted())).at(word.at)
    }

    fn not_a_number(&self, kind: &str) -> Diagnostic {
        let error = self.unexpected(&format!("{kind} for `{}`", self.field), &[]);
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

/// A list whose length the scene announces.
pub struct Announced {
    field: &'static str,
    length: u64,
    /// The number of items found so far.
    found: u64,
    /// The position of the first surplus item.
    first_surplus: Option<Position>,
}

impl Announced {
    /// Reads `field` and the length.
    pub fn parse(reader: &mut Reader<'_>, field: &'static str) -> Parsed<Self> {
        let length = reader.keyword(field)?.whole()?;
        Ok(Self { field, length, found: 0, first_surplus: None })
    }

    /// Returns true if no further item is expected.
    pub fn is_reached(&self) -> bool {
        self.found >= self.length
    }

    /// Counts the item that starts at the next word, and returns its position.
    pub fn next_item(&mut self, reader: &Reader<'_>) -> Position {
        let at = reader.peek().at;
        if self.is_reached() {
            self.first_surplus.get_or_insert(at);
        }
        self.found += 1;
        at
    }

    /// Reads the closing brace of the block `name` that holds the list. Fails if the length differs from the announced
    /// one.
    pub fn close(&self, reader: &mut Reader<'_>, name: &str) -> Parsed<()> {
        let Self { field, length, found, first_surplus } = *self;
        let end = reader.peek().at;
        reader.close(name)?;
        let (only, at) = match first_surplus {
            Some(at) => ("", at),
            None if found < length => ("only ", end),
            None => return Ok(()),
        };
        Err(Diagnostic::error(format!("`{field}` announces {length}, but {only}{found} found")).at(at))
    }
}

/// The files of one kind that a scene names, without duplicates, with the position of the first mention.
#[derive(Default)]
pub struct NamedFiles {
    pub list: Vec<(String, Position)>,
    indices: HashMap<String, usize>,
}

impl NamedFiles {
    /// Returns the index of the file with this name, which the scene names at `at`.
    pub fn index(&mut self, name: String, at: Position) -> usize {
        *self.indices.entry(name).or_insert_with_key(|name| {
            self.list.push((name.clone(), at));
            self.list.len() - 1
        })
    }
}

/// Returns true if all channels are whole numbers from 0 to 255.
pub fn is_byte_like(color: Color) -> bool {
    color.to_array().iter().all(|channel| (0.0..=255.0).contains(channel) && channel.fract() == 0.0)
}

/// Parses a number in the syntax of C's scanf: `1`, `+1`, `-.3`, `0.` or `1e-3`, but not `inf` or `nan`. A number that
/// overflows becomes infinite.
fn parse_number(word: &str) -> Option<f64> {
    let starts_well =
        word.starts_with(|first: char| first.is_ascii_digit() || matches!(first, '+' | '-' | '.'));
    let has_digit = word.bytes().any(|byte| byte.is_ascii_digit());
    if starts_well && has_digit { word.parse().ok() } else { None }
}

#[cfg(test)]
mod tests;
