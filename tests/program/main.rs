//! The program as a user meets it: command lines, scenes and the errors in them, files, statistics, and
//! what the README says.

mod command_line;
mod comparison;
mod cost_map;
mod course;
mod image_files;
mod proofs;
mod readme;
mod runs;
mod sampling;
mod scene_errors;
mod scene_robustness;
mod statistics;
mod support;
