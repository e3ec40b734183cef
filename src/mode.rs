//! The mode of tracing: whether only the work is done that the picture needs, or all that the course's
//! program does.

use std::fmt::Debug;

/// The mode of tracing, which is chosen when a scene is prepared. Pictures are the same in every mode.
///
/// It is a type, so that the loops are compiled for each mode and do not test it at run time.
pub trait Mode: Copy + Debug + Default + Send + Sync + 'static {
    /// Whether every step of the course's program is taken, so that the counters can be compared with its
    /// own: a shadow ray for every light, the nearest hit even for a shadow ray, and every cell one by one.
    const AS_COURSE: bool;
}

/// Leaves out whatever cannot change the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fast;

impl Mode for Fast {
    const AS_COURSE: bool = false;
}

/// Takes every step that the course's program takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Course;

impl Mode for Course {
    const AS_COURSE: bool = true;
}
