//! Reads lists whose length the scene announces.

use super::error::{Problem, SceneError};
use super::reader::{Parsed, Reader};
use crate::memory;

/// Reads the rest of a block `name { field N item^N }` from `field` on, up to its closing brace.
///
/// `item` reads one item, given those before it, and `kinds` are the words that start one. Errors: a length
/// other than the announced one, and those of `item`. The list grows as items are read, so that an absurd
/// announced length allocates nothing.
pub fn counted_list<T>(
    reader: &mut Reader<'_>,
    name: &str,
    field: &'static str,
    kinds: &[&str],
    mut item: impl FnMut(&mut Reader<'_>, &[T]) -> Parsed<T>,
) -> Parsed<Vec<T>> {
    reader.keyword(field)?;
    let announced = reader.whole(field)?;
    let mut items = Vec::new();
    while (items.len() as u64) < announced && !reader.is_at("}") {
        let next = item(reader, &items)?;
        memory::push(&mut items, next)?;
    }
    end_of_list(reader, field, kinds, announced, items.len())?;
    reader.close(name)?;
    Ok(items)
}

/// Checks that a list of `found` items ends at the next word, as its announced length requires.
pub fn end_of_list(
    reader: &Reader<'_>,
    field: &'static str,
    kinds: &[&str],
    announced: u64,
    found: usize,
) -> Parsed<()> {
    let found = found as u64;
    let at = reader.peek().at;
    if found < announced {
        return Err(SceneError::new(at, Problem::TooFew { field, announced, found }));
    }
    if reader.is_at_any(kinds) {
        return Err(SceneError::new(at, Problem::TooMany { field, announced }));
    }
    Ok(())
}
