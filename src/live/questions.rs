//! What the page asks, in JSON.

use crate::render::Cost;
use serde::Deserialize;

/// A view of a scene, as the controls and the hand have set it.
#[derive(Clone, Debug, Deserialize)]
pub struct PageView {
    /// The scene's revision.
    pub scene: u64,
    /// Flags with their values.
    pub words: Vec<String>,
    /// The camera's block of scene text; none for the scene's own.
    pub camera: Option<String>,
    /// What is shown.
    pub show: Show,
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Show {
    /// Colours.
    Color,
    /// What each pixel costs, in rays.
    Rays,
    /// In tests.
    Tests,
    /// In cells of the grid.
    Cells,
}

impl Show {
    /// The cost that is shown, if it is one.
    pub fn cost(self) -> Option<Cost> {
        match self {
            Self::Color => None,
            Self::Rays => Some(Cost::Rays),
            Self::Tests => Some(Cost::Tests),
            Self::Cells => Some(Cost::Cells),
        }
    }
}

/// A picture. Of the requests of one page, those with a lower turn are overtaken.
#[derive(Clone, Debug, Deserialize)]
pub struct Wanted {
    /// A random number of the page.
    pub page: u64,
    /// Grows with each request.
    pub turn: u64,
    pub view: PageView,
    /// Width and height in pixels of a sketch with one ray through each centre, in place of the whole picture.
    pub sketch: Option<[usize; 2]>,
}

/// A scene's text, in place of the one on the page.
#[derive(Clone, Debug, Deserialize)]
pub struct Edited {
    pub text: String,
}

/// The pixel whose rays are traced, by column and row from the top left.
#[derive(Clone, Debug, Deserialize)]
pub struct TracedPixel {
    pub view: PageView,
    pub pixel: [usize; 2],
}
