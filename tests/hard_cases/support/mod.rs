//! Shared by all cases: random numbers, the tiers, exact arithmetic, the textbook's methods and the
//! records.

pub mod all_scenes;
pub mod brute;
pub mod double_double;
pub mod exact;
pub mod exact_triangle;
pub mod leaks;
pub mod measure;
pub mod placed;
pub mod meshes;
pub mod occlusion;
pub mod product_grid;
pub mod record;
pub mod rng;
pub mod scenes;
pub mod secondary;
pub mod spheres;
pub mod textbook;
pub mod textbook_grid;
pub mod textbook_noise;
pub mod textbook_offsets;
#[cfg(feature = "fast")]
pub mod views;

/// Without `HARD_CASES`, one of this many inputs of the ordinary tier is tried.
pub const SAMPLE: usize = 8;

/// Returns true if all inputs of the ordinary tier are tried: `HARD_CASES` is set, or the measurements are recorded.
pub fn is_whole() -> bool {
    ["HARD_CASES", "ACCURACY_DIR"].iter().any(|name| std::env::var_os(name).is_some())
}

/// The number of rays, or of other inputs, of a case: the first argument in the ordinary tier, the second in the long
/// one, and a part of the first in a sample. If `HARD_CASES` is a number, it is an upper bound on the long tier.
pub fn rays(ordinary: u64, long: u64) -> u64 {
    match std::env::var("HARD_CASES") {
        Ok(tier) if tier == "long" => long,
        Ok(most) => most.parse().map_or(ordinary, |most| long.min(most)),
        Err(_) if is_whole() => ordinary,
        Err(_) => ordinary.div_ceil(SAMPLE as u64),
    }
}

/// The bits of a float in hexadecimal, as Rust source for a regression test.
pub fn hex(x: f64) -> String {
    format!("f64::from_bits({:#018x})", x.to_bits())
}

/// The message of a failed input, with the bits of the ray that `(seed, index)` gives.
pub fn failed_ray(case: u32, seed: u64, index: u64, origin: glam::DVec3, direction: glam::DVec3) -> String {
    let bits = |v: glam::DVec3| v.to_array().map(hex).join(", ");
    format!(
        "case {case}, seed {seed}, index {index}: origin [{}], direction [{}]",
        bits(origin),
        bits(direction)
    )
}
