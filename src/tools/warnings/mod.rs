//! What a run asks for, or a scene says, that is no error but hardly meant.
//!
//! Everything here follows from the scene, its meshes and the flags, except for [`nothing_visible`], which
//! looks once more at a picture that shows nothing but its background.

mod filter;
mod idle;
mod lights;
mod message;
mod rays;
mod triangles;
mod view;

pub use filter::too_narrow as narrow_filter;
pub use idle::{colors_not_asked_for, sampling_without_effect};
pub use lights::without_effect as lights_without_effect;
pub use message::{Severity, render_all};
pub use rays::too_many as too_many_rays;
pub use rays::{black_inside, not_followed as rays_not_followed, without_effect as rays_without_effect};
pub use triangles::without_area as triangles_without_area;
pub use view::nothing_visible;

use crate::sampling::filter::Filter;
use crate::scene::Position;
use crate::scene::warning::SceneWarning;
use filter::Lost;
use idle::Idle;
use lights::Reason;
use rays::Remedy;
use view::Sight;

/// A warning. It is shown by [`Warning::render`].
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// A doubtful place in the scene's text.
    Text(SceneWarning),
    /// A scene whose words leave open which edition is meant: the problem and a hint.
    OpenEdition([String; 2]),
    /// A scene without lights.
    NoLights,
    /// A command line that writes and prints nothing.
    NoPicture,
    /// Triangles whose area is exactly zero.
    FlatTriangles {
        /// The first of them, or the name of the mesh.
        at: Option<Position>,
        /// How many there are.
        count: usize,
        /// Of how many triangles of the mesh; none for triangles in the scene's text.
        of: Option<usize>,
    },
    /// A light that no picture shows.
    IdleLight {
        /// The light.
        at: Option<Position>,
        /// Why it lights nothing.
        reason: Reason,
    },
    /// Flags that change nothing.
    IdleFlags {
        /// The flags with their values.
        flags: Vec<String>,
        /// Why they change nothing.
        reason: Idle,
    },
    /// A filter so narrow that pixels get no samples, or samples whose weights cancel.
    NarrowFilter {
        /// The filter.
        filter: Filter,
        /// The pixels that are wrong.
        lost: Lost,
        /// The smallest filter of its kind with which none is.
        smallest: Filter,
    },
    /// A material that reflects or transmits light, where no ray bounces.
    NoBounces {
        /// The material.
        at: Option<Position>,
        /// Whether it transmits light, or else reflects it.
        transmits: bool,
    },
    /// A material that transmits light, whose surface is black from inside.
    BlackInside {
        /// The material.
        at: Option<Position>,
    },
    /// So many bounces that the rays of a pixel may never end.
    ManyRays {
        /// The material that both reflects and transmits.
        at: Option<Position>,
        /// The value of `-bounces`.
        bounces: u32,
        /// What would end them.
        remedy: Remedy,
    },
    /// A picture in which no ray hits anything.
    NothingVisible {
        /// The camera.
        at: Option<Position>,
        /// The reason, if it can be told.
        sight: Sight,
    },
    /// Pixels whose colours are not numbers, and are black.
    NotNumbers {
        /// How many there are.
        pixels: u64,
    },
    /// Pixels whose colours are not numbers, in a file that holds such.
    NanInFile {
        /// How many there are.
        pixels: u64,
    },
    /// Pixels with numbers that a file of single precision does not hold.
    BeyondSingle {
        /// How many there are.
        pixels: u64,
    },
}

/// A position in the text, unless a program made the scene.
fn known(at: Option<&Position>) -> Option<Position> {
    at.copied().filter(|at| at.line > 0)
}
