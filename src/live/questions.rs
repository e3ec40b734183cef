//! What the page asks, in JSON.

use super::http::Refusal;
use crate::render::Cost;
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// A view of a scene, as the controls and the hand have set it.
#[derive(Debug, Deserialize)]
pub struct PageView {
    /// The scene's revision.
    pub scene: u64,
    /// Flags with their values.
    pub words: Vec<String>,
    /// The camera's block of scene text; none for the scene's own.
    pub camera: Option<String>,
    pub show: Show,
}

/// What a picture shows: colours, or what each pixel costs.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Show {
    Color,
    Rays,
    Tests,
    Cells,
}

impl Show {
    pub fn cost(self) -> Option<Cost> {
        match self {
            Self::Color => None,
            Self::Rays => Some(Cost::Rays),
            Self::Tests => Some(Cost::Tests),
            Self::Cells => Some(Cost::Cells),
        }
    }
}

/// A picture.
#[derive(Debug, Deserialize)]
pub struct Wanted {
    pub view: PageView,
    /// Width and height in pixels of a sketch with one ray through each centre, in place of the whole picture.
    pub sketch: Option<[usize; 2]>,
}

/// A scene's text, in place of the one on the page.
#[derive(Debug, Deserialize)]
pub struct Edited {
    pub text: String,
    /// The flags, which may name the edition in which it is read.
    #[serde(default)]
    pub words: Vec<String>,
}

/// The pixel whose rays are traced, by column and row from the top left.
#[derive(Debug, Deserialize)]
pub struct TracedPixel {
    pub view: PageView,
    pub pixel: [usize; 2],
}

/// Where a question comes from. It overtakes those of the same page and kind with a lower turn.
#[derive(Debug, Default, Deserialize)]
pub struct Asked {
    /// A random number of the page.
    pub page: Option<u64>,
    /// Grows with each picture.
    pub turn: Option<u64>,
}

/// Reads the question in the body of a request.
pub fn understood<Q: DeserializeOwned>(body: &[u8]) -> Result<Q, Refusal> {
    serde_json::from_slice(body).map_err(|error| Refusal::new(400, format!("not a question: {error}")))
}
