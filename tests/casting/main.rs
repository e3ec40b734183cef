//! Rays through whole worlds: every grid and every instruction set gives the same hits as testing every
//! primitive.

mod bad_scenes;
mod fuzz_findings;
mod instructions;
mod random_scenes;
mod strategies;
mod support;
mod uneven_scenes;
