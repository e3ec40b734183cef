//! Reads lists whose length the scene announces.

use super::error::{Problem, SceneError};
use super::reader::{Parsed, Reader};

/// The announced length of a list, to compare with the actual one.
pub struct Announced {
    field: &'static str,
    /// None if the text gives no usable number, which has been recorded.
    length: Option<u64>,
    /// The first item that is too many, as an error without the final count.
    first_surplus: Option<SceneError>,
}

impl Announced {
    /// Reads `field` and the length.
    pub fn parse(reader: &mut Reader<'_>, field: &'static str) -> Parsed<Self> {
        reader.keyword(field)?;
        Ok(Self { field, length: reader.whole(field)?, first_surplus: None })
    }

    /// Whether no further item is expected after `found` of them.
    pub fn is_reached(&self, found: usize) -> bool {
        self.length.is_some_and(|length| found as u64 >= length)
    }

    /// Notes that an item starts at the next word, of which there are `found` already.
    pub fn next_item(&mut self, reader: &Reader<'_>, found: usize) {
        if let Some(announced) = self.length
            && found as u64 == announced
            && self.first_surplus.is_none()
        {
            let problem = Problem::TooMany { field: self.field, announced, found: None };
            self.first_surplus = Some(SceneError::new(reader.peek().at, problem));
        }
    }

    /// Records that the list is longer than announced, where its end was not reached.
    pub fn give_up(&mut self, reader: &mut Reader<'_>) {
        if let Some(error) = self.first_surplus.take() {
            reader.report(error);
        }
    }

    /// Compares the length with the `found` items of a list that ends at the next word.
    pub fn end(&mut self, reader: &mut Reader<'_>, found: usize) {
        let Some(announced) = self.length else { return };
        let (field, found) = (self.field, found as u64);
        if let Some(error) = self.first_surplus.take() {
            let problem = Problem::TooMany { field, announced, found: Some(found) };
            reader.report(SceneError { problem, ..error });
        } else if found < announced {
            let problem = Problem::TooFew { field, announced, found };
            reader.report(SceneError::new(reader.peek().at, problem));
        }
    }
}

/// Reads the rest of a block `name { field N item^N }` from `field` on, up to its closing brace.
///
/// `item` reads one item, given those before it, and `kinds` are the words that start one. An item with an
/// error is recorded, and `instead` stands in its place. A length other than the announced one is recorded
/// too. The list grows as items are read, so that an absurd announced length allocates nothing.
pub fn counted_list<T: Clone>(
    reader: &mut Reader<'_>,
    name: &str,
    field: &'static str,
    kinds: &[&str],
    instead: &T,
    mut item: impl FnMut(&mut Reader<'_>, &[T]) -> Parsed<T>,
) -> Parsed<Vec<T>> {
    let mut announced = Announced::parse(reader, field)?;
    let mut items = Vec::new();
    while !reader.is_at("}") && (reader.is_at_any(kinds) || !announced.is_reached(items.len())) {
        announced.next_item(reader, items.len());
        let outer = reader.depth;
        let next = item(reader, &items).or_else(|error| {
            let recovered = reader.recover(error, outer);
            if recovered.is_err() {
                announced.give_up(reader);
            }
            recovered.map(|()| instead.clone())
        })?;
        items.push(next);
    }
    if !reader.is_at("}") {
        announced.give_up(reader);
    }
    let closed = reader.is_at("}");
    if closed {
        announced.end(reader, items.len());
    }
    reader.close(name)?;
    Ok(items)
}
