//! The program as a user meets it: command lines, scenes and the errors in them, files, statistics, and
//! what the README says.

mod command_line;
mod comparison;
mod cost_map;
mod command_line_errors;
mod course;
mod image_files;
mod malformed_scenes;
mod proofs;
mod readme;
mod runs;
mod sampling;
mod scene_errors;
mod scene_robustness;
mod special_scenes;
mod statistics;
mod support;
