//! Reads lists whose length the scene announces.

use super::Position;
use super::reader::{Parsed, Reader};
use crate::diagnostic::Diagnostic;

/// The announced length of a list, to compare with the actual one.
pub struct Announced {
    field: &'static str,
    length: u64,
    /// The place of the first item that is too many.
    first_surplus: Option<Position>,
}

impl Announced {
    /// Reads `field` and the length.
    pub fn parse(reader: &mut Reader<'_>, field: &'static str) -> Parsed<Self> {
        reader.keyword(field)?;
        Ok(Self { field, length: reader.whole(field)?, first_surplus: None })
    }

    /// Whether no further item is expected after `found` of them.
    pub fn is_reached(&self, found: usize) -> bool {
        found as u64 >= self.length
    }

    /// Notes that an item starts at the next word, of which there are `found` already.
    pub fn next_item(&mut self, reader: &Reader<'_>, found: usize) {
        if self.is_reached(found) {
            self.first_surplus.get_or_insert(reader.peek().at);
        }
    }

    /// Reads the closing brace of the block `name` that holds the list of `found` items. Errors: another length than the
    /// announced one.
    pub fn close(&self, reader: &mut Reader<'_>, name: &str, found: usize) -> Parsed<()> {
        let end = reader.peek().at;
        reader.close(name)?;
        let (only, at) = match self.first_surplus {
            Some(at) => ("", at),
            None if (found as u64) < self.length => ("only ", end),
            None => return Ok(()),
        };
        let message = format!("`{}` announces {}, but {only}{found} found", self.field, self.length);
        Err(Diagnostic::error(message).at(at))
    }
}

/// Reads the rest of a block `name { field N item^N }` from `field` on, up to its closing brace.
///
/// `item` reads one item, given those before it, and `kinds` are the words that start one. The list grows as items are
/// read, so that an absurd announced length allocates nothing.
pub fn counted_list<T>(
    reader: &mut Reader<'_>,
    name: &str,
    field: &'static str,
    kinds: &[&str],
    mut item: impl FnMut(&mut Reader<'_>, &[T]) -> Parsed<T>,
) -> Parsed<Vec<T>> {
    let mut announced = Announced::parse(reader, field)?;
    let mut items = Vec::new();
    while !reader.is_at("}") && (reader.is_at_any(kinds) || !announced.is_reached(items.len())) {
        announced.next_item(reader, items.len());
        let next = item(reader, &items)?;
        items.push(next);
    }
    announced.close(reader, name, items.len())?;
    Ok(items)
}
