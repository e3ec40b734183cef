//! The program: command line in, pictures and statistics out.

mod allocator;

use raytracer::command;
use std::ffi::OsString;
use std::process::ExitCode;

fn main() -> ExitCode {
    let argv: Vec<OsString> = std::env::args_os().collect();
    command::run(&argv)
}
