//! Tests of the program from outside: command lines, scenes and their errors, files, statistics, and the
//! commands of the README.

mod broken_rules;
mod cases;
mod causes;
mod check_your_own;
mod command_line;
mod comparison;
mod cost_map;
mod command_line_errors;
mod course;
mod error_report;
mod grade;
mod image_files;
mod json;
mod json_form;
mod json_numbers;
mod little_memory;
mod malformed_scenes;
mod partial_causes;
mod pixel;
mod pixel_scenes;
mod pixel_text;
mod proofs;
mod readme;
mod runs;
mod sampling;
mod scene_errors;
mod scene_robustness;
mod special_scenes;
mod statistics;
mod support;
