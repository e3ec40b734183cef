//! The fuzz target of the OBJ reader.
#![no_main]

#[path = "../checks.rs"]
#[allow(dead_code)]
mod checks;
#[path = "../words.rs"]
mod words;

use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

const WORDS: [&str; 20] = [
    "v", "f", "\nv", "\nf", "vt", "vn", "o", "g", "usemtl", "mtllib", "s", "l", "p", "#", "\\\n", "1/1/1",
    "1//1", "-1", "2/", "\n",
];
const NUMBERS: [&str; 14] =
    ["0", "1", "2", "3", "4", "-1", "-4", "0.5", "1e308", "1e999", "nan", "inf", "4294967296", "-0"];

fuzz_target!(|data: &[u8]| checks::check_obj(data));

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let text = std::str::from_utf8(&data[..size]).ok().filter(|_| seed % 4 != 0);
    let Some(text) = text else { return fuzzer_mutate(data, size, max_size) };
    let changed = words::changed(text, seed, &WORDS, &NUMBERS);
    let length = changed.len().min(max_size);
    data[..length].copy_from_slice(&changed.as_bytes()[..length]);
    length
});
