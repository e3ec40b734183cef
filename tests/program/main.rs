//! Tests of the program from outside: command lines, scenes and their errors, files, statistics, and the
//! documents.

mod broken_rules;
mod cases;
mod causes;
mod command_line;
mod convert;
mod comparison;
mod cost_map;
mod command_line_errors;
mod course;
mod course_page;
#[cfg(unix)]
mod distinct_files;
#[cfg(unix)]
mod documents;
mod edition_pictures;
mod editions;
mod error_report;
mod floats;
mod foreign_pictures;
mod front_plot;
mod farm;
#[cfg(unix)]
mod grade;
mod image_files;
mod json;
mod json_form;
mod little_memory;
#[cfg(feature = "gui")]
mod live;
#[cfg(feature = "gui")]
mod live_attacks;
#[cfg(feature = "gui")]
mod live_editions;
#[cfg(feature = "gui")]
mod live_scenes;
#[cfg(feature = "gui")]
mod live_server;
mod markdown;
mod meshes;
mod partial_causes;
mod pipes;
mod pixel;
mod pixel_scenes;
mod pixel_text;
mod proofs;
mod readme;
mod region;
mod runs;
mod sampling;
mod scene_errors;
mod scene_robustness;
mod scene_words;
mod first_error;
mod shell_files;
mod signals;
mod special_scenes;
mod statistics;
mod support;
#[cfg(unix)]
mod terminal;
mod waits;
mod warnings;
