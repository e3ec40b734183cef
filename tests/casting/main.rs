//! Rays through whole worlds: every grid and every instruction set gives the hits that testing everything
//! gives.

mod bad_scenes;
mod fuzz_findings;
mod instructions;
mod random_scenes;
mod strategies;
mod uneven_scenes;
