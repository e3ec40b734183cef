//! The fuzz target from scene text to a small picture.
#![no_main]

#[path = "../checks.rs"]
#[allow(dead_code)]
mod checks;
#[path = "../words.rs"]
mod words;

use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

const WORDS: [&str; 61] = [
    "{",
    "}",
    "#",
    "OrthographicCamera",
    "PerspectiveCamera",
    "Background",
    "Lights",
    "Materials",
    "Group",
    "numObjects",
    "numLights",
    "numMaterials",
    "DirectionalLight",
    "PointLight",
    "Material",
    "PhongMaterial",
    "Checkerboard",
    "Noise",
    "Marble",
    "Wood",
    "MaterialIndex",
    "materialIndex",
    "Sphere",
    "Plane",
    "Triangle",
    "TriangleMesh",
    "Box",
    "Grid",
    "numCells",
    "rasterizeSphere",
    "Transform",
    "Translate",
    "Scale",
    "UniformScale",
    "XRotate",
    "YRotate",
    "ZRotate",
    "Rotate",
    "Matrix",
    "center",
    "radius",
    "normal",
    "offset",
    "vertex0",
    "vertex1",
    "vertex2",
    "obj_file",
    "a.obj",
    "min",
    "max",
    "direction",
    "up",
    "angle",
    "size",
    "color",
    "attenuation",
    "diffuseColor",
    "reflectiveColor",
    "transparentColor",
    "indexOfRefraction",
    "octaves",
];
const NUMBERS: [&str; 34] = [
    "0",
    "1",
    "-1",
    "0.5",
    "1e-3",
    "1e3",
    "1e-9",
    "1e9",
    "1e-30",
    "1e30",
    "1e-160",
    "1e160",
    "1e-300",
    "1e-150",
    "1e-105",
    "1e-100",
    "1e-77",
    "1e-20",
    "1e20",
    "1e77",
    "1e100",
    "1e300",
    "1e-323",
    "1.7e308",
    "-1e308",
    "1e999",
    "0.1",
    "3",
    "90",
    "180",
    "-45",
    "179.99999999",
    "4294967296",
    "64",
];

fuzz_target!(|data: &[u8]| {
    if let Ok(text) = std::str::from_utf8(data) {
        checks::check_scene(text);
    }
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let text = std::str::from_utf8(&data[..size]).ok().filter(|_| seed % 4 != 0);
    let Some(text) = text else { return fuzzer_mutate(data, size, max_size) };
    let changed = words::changed(text, seed, &WORDS, &NUMBERS);
    let length = changed.len().min(max_size);
    data[..length].copy_from_slice(&changed.as_bytes()[..length]);
    length
});
