//! What may stand for a value of a flag, as completions offer it.

use super::flags::{FLAGS, Flag};

/// What is offered for a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Offer {
    /// Files whose names end like this after the dot, and folders on the way to them.
    Files(&'static [&'static str]),
    /// Folders.
    Folders,
    /// One of these words.
    Words(Vec<&'static str>),
    /// A number or another word that nobody can guess.
    Nothing,
}

/// Pictures of bytes, and those of all formats.
const BYTES: &[&str] = &["tga", "png"];
const PICTURES: &[&str] = &["tga", "png", "pfm", "exr"];

/// What is offered for the value of a flag with this index.
pub(super) fn offer(flag: &Flag, index: usize) -> Offer {
    match (flag.name, flag.values[index]) {
        ("input" | "commands", _) => Offer::Files(&["txt"]),
        ("json", _) => Offer::Files(&["json"]),
        ("report", _) => Offer::Files(&["html"]),
        ("grid", "nx") => Offer::Words(vec!["auto", "none"]),
        ("cost_map", "kind") => Offer::Words(vec!["rays", "tests", "cells"]),
        ("help", _) => Offer::Words(FLAGS.iter().map(|flag| flag.name).collect()),
        ("merge" | "difference" | "cost_map", _) => Offer::Files(BYTES),
        (_, "file") => Offer::Files(PICTURES),
        (_, "folder") => Offer::Folders,
        _ => Offer::Nothing,
    }
}

/// All values of all flags, each with its flag and index. That of a flag with any number of values stands for all
/// of them.
pub(super) fn values() -> impl Iterator<Item = (&'static Flag, usize, Offer)> {
    FLAGS.iter().flat_map(|flag| (0..flag.values.len()).map(|index| (*flag, index, offer(flag, index))))
}

/// Whether a flag takes any number of values.
pub(super) fn takes_any_number(flag: &Flag) -> bool {
    flag.values.iter().any(|value| value.ends_with("..."))
}

/// The first sentence of what a flag does.
pub(super) fn summary(flag: &Flag) -> &'static str {
    let end = flag.doc.find(". ").unwrap_or(flag.doc.len());
    flag.doc[..end].trim_end_matches('.')
}
