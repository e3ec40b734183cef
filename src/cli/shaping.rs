//! What shapes the colour picture of a scene, for the runs that render it in ways of their own.

use super::flags::{self, Flag};

/// The flags that shape the colour picture of the scene.
pub(super) const SHAPING: [&Flag; 17] = [
    &flags::SIZE,
    &flags::SHADE_BACK,
    &flags::SHADOWS,
    &flags::TRANSPARENT_SHADOWS,
    &flags::BOUNCES,
    &flags::WEIGHT,
    &flags::RANDOM_SAMPLES,
    &flags::UNIFORM_SAMPLES,
    &flags::JITTERED_SAMPLES,
    &flags::ADAPTIVE_SAMPLES,
    &flags::SEED,
    &flags::BOX_FILTER,
    &flags::TENT_FILTER,
    &flags::GAUSSIAN_FILTER,
    &flags::MITCHELL_FILTER,
    &flags::GRID,
    &flags::NO_SHADOWS,
];
