//! The flags about the live page.

use super::error::CliError;
use super::flag::Run;
use super::flags;
use super::raw::Raw;
use serde::Serialize;

/// The live page that `-gui` asks for.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LivePage {
    /// The port to serve it at, where 0 is any free one; `None` for any free port, and only on a terminal.
    pub port: Option<u16>,
    /// Whether a browser is opened.
    pub browser: bool,
    /// The flags of the command line that shape the colour picture, with their values. No word is the name of a file.
    #[serde(skip)]
    pub words: Vec<String>,
}

impl LivePage {
    /// The page that the flags ask for.
    pub(super) fn from_raw(raw: &Raw) -> Result<Option<Self>, CliError> {
        let port = raw.read(&flags::PORT)?;
        if !raw.given(&flags::GUI) {
            return raw.refuse_without(&flags::GUI).map(|()| None);
        }
        Ok(Some(Self { port, browser: !raw.given(&flags::NO_BROWSER), words: raw.words_for(Run::Page) }))
    }
}
