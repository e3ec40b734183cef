//! The flags about the live page.

use super::error::CliError;
use super::flags;
use super::raw::Raw;
use super::shaping::SHAPING;
use super::values::wholes;
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
        let port = wholes(raw, &flags::PORT, (0, u32::from(u16::MAX)))?.map(|[port]| port as u16);
        if raw.given(&flags::GUI) {
            let shaping = SHAPING.into_iter().chain([&flags::VISUALIZE_GRID]);
            let words = shaping.flat_map(|flag| raw.words_of(flag)).collect();
            return Ok(Some(Self { port, browser: !raw.given(&flags::NO_BROWSER), words }));
        }
        match [&flags::PORT, &flags::NO_BROWSER].into_iter().find(|flag| raw.given(flag)) {
            Some(flag) => Err(CliError::GuiNeeded { flag: flag.name }),
            None => Ok(None),
        }
    }
}
