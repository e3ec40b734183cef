//! Eight triangles at once in single precision: which of them the ray may hit.
//!
//! The filter decides nothing by itself unless it can prove it. It says of each triangle that the
//! ray surely misses it, surely hits it, or that double precision must decide.
//!
//! It is Moeller and Trumbore's test without the division: with s from the first corner to the
//! ray's origin, e1 and e2 the edges, p = d x e2, q = s x e1 and the determinant e1.p, the ray hits
//! where u = s.p, v = d.q and w = det - u - v have the determinant's sign, at t = e2.q / det.
//!
//! *Error bound.* Let r = 2^-24, the relative rounding of single precision, and b the largest
//! coordinate of the block's edges. In the block's [`Frame`](super::block::Frame) every corner and
//! the ray's origin, which is moved along the ray to where it enters the box, have coordinates of at
//! most 1, the direction's largest is 1, and so b <= 2. Stored numbers are rounded once. To first
//! order, with sums of absolute values for the exact quantities:
//!
//! | quantity | at most | error at most |
//! |---|---|---|
//! | s | 2 | 4 r: origin and corner r each, their difference 2 r |
//! | p = d x e2 | 2 b | 8 r b: d and e2 4 r b, two products and a difference 4 r b |
//! | det = e1.p | 6 b^2 | 48 r b^2: e1 6, p 24, rounding 3 * 6 |
//! | u = s.p | 12 b | 108 r b: s 24, p 48, rounding 36 |
//! | q = s x e1 | 4 b | 20 r b: s 8, e1 4, rounding 8 |
//! | v = d.q | 12 b | 108 r b: d 12, q 60, rounding 36 |
//! | w | 24 b + 6 b^2 | 360 r b: det 96 (b <= 2), u and v 216, rounding 48 |
//! | e2.q | 12 b^2 | 108 r b^2: e2 12, q 60, rounding 36 |
//! | e2.q - t det | | 240 r b^2 for 0 <= t <= 2: 108 and 96, rounding 36 |
//!
//! Second-order terms are below 1e-5 of these. The double-precision test's own error, a few 2^-53 of
//! the way from the ray's origin, stays below r for origins up to 2^20 boxes away; farther ones do
//! not come here. [`Slack`] rounds the bounds up to cover both.

use super::block::{Block, LANES, Slack};
use glam::DVec3;

/// No hit lies farther along the ray: the box is 2 wide. Larger values are cut to this.
pub const FARTHEST: f64 = 2.5;

/// A ray as the filter wants it, in the coordinates of a frame. Its origin lies in the box, its
/// direction's largest coordinate is 1.
#[derive(Clone, Copy, Debug)]
pub struct FilterRay {
    pub origin: [f32; 3],
    pub direction: [f32; 3],
}

impl FilterRay {
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin: origin.as_vec3().to_array(), direction: direction.as_vec3().to_array() }
    }
}

/// Sets of lanes, bit 0 for the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// All others surely miss.
    pub possible: u32,
    /// Surely hit, before the farthest t asked for.
    pub certain: u32,
}

/// One way to run the filter; what it says of a lane may differ between kernels, what is true not.
pub trait Kernel {
    /// Tests a block against a ray up to `farthest`.
    fn test(block: &Block, ray: &FilterRay, farthest: f32) -> Verdict;
}

/// Runs on every machine.
#[derive(Debug)]
pub struct Portable;

impl Kernel for Portable {
    #[inline(always)]
    fn test(block: &Block, ray: &FilterRay, farthest: f32) -> Verdict {
        let Slack { edge: edge_slack, depth: depth_slack } = block.slack;
        let mut verdict = Verdict { possible: 0, certain: 0 };
        for lane in 0..LANES {
            let [e1, e2] = block.edges.map(|edge| edge.map(|c| c[lane]));
            let d = ray.direction;
            let s: [f32; 3] = std::array::from_fn(|axis| ray.origin[axis] - block.corner[axis][lane]);
            let (p, q) = (cross(d, e2), cross(s, e1));
            let (det, u, v, depth) = (dot(e1, p), dot(s, p), dot(d, q), dot(e2, q));
            // Signs turned so that the determinant counts as positive.
            let (u, v, depth) = if det < 0.0 { (-u, -v, -depth) } else { (u, v, depth) };
            let det = det.abs();
            let w = det - (u + v);
            let inside = u.min(v).min(w);
            let beyond = depth - farthest * det;
            // NaN lanes fail the first comparison; `min` would hide the NaN of a single operand,
            // but an empty lane has three.
            let possible = inside >= -edge_slack && depth >= -depth_slack && beyond <= depth_slack;
            let certain = inside > edge_slack && depth > depth_slack && beyond < -depth_slack;
            verdict.possible |= (possible as u32) << lane;
            verdict.certain |= (certain as u32) << lane;
        }
        verdict
    }
}

#[inline(always)]
fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(target_arch = "x86_64")]
pub use avx2::Avx2;

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::*;
    use std::arch::x86_64::*;

    /// Eight lanes in one register each. To be called only where AVX2 and FMA are present.
    #[derive(Debug)]
    pub struct Avx2;

    impl Kernel for Avx2 {
        #[inline(always)]
        fn test(block: &Block, ray: &FilterRay, farthest: f32) -> Verdict {
            // SAFETY: only `super::super::Caster` names this kernel, inside a function that is
            // itself compiled for these features and called after they were detected.
            unsafe { test(block, ray, farthest) }
        }
    }

    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn load(lanes: &[f32; LANES]) -> __m256 {
        // SAFETY: eight floats are readable there; no alignment is asked for.
        unsafe { _mm256_loadu_ps(lanes.as_ptr()) }
    }

    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn cross(a: [__m256; 3], b: [__m256; 3]) -> [__m256; 3] {
        [
            _mm256_fmsub_ps(a[1], b[2], _mm256_mul_ps(a[2], b[1])),
            _mm256_fmsub_ps(a[2], b[0], _mm256_mul_ps(a[0], b[2])),
            _mm256_fmsub_ps(a[0], b[1], _mm256_mul_ps(a[1], b[0])),
        ]
    }

    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn dot(a: [__m256; 3], b: [__m256; 3]) -> __m256 {
        _mm256_fmadd_ps(a[0], b[0], _mm256_fmadd_ps(a[1], b[1], _mm256_mul_ps(a[2], b[2])))
    }

    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn test(block: &Block, ray: &FilterRay, farthest: f32) -> Verdict {
        let d = ray.direction.map(|x| _mm256_set1_ps(x));
        let corner = [load(&block.corner[0]), load(&block.corner[1]), load(&block.corner[2])];
        let [e1, e2] = [&block.edges[0], &block.edges[1]].map(|e| [load(&e[0]), load(&e[1]), load(&e[2])]);
        let s = [0, 1, 2].map(|axis| _mm256_sub_ps(_mm256_set1_ps(ray.origin[axis]), corner[axis]));
        let p = cross(d, e2);
        let q = cross(s, e1);
        let det = dot(e1, p);
        let minus = _mm256_set1_ps(-0.0);
        let sign = _mm256_and_ps(det, minus);
        let det = _mm256_andnot_ps(minus, det);
        let u = _mm256_xor_ps(dot(s, p), sign);
        let v = _mm256_xor_ps(dot(d, q), sign);
        let depth = _mm256_xor_ps(dot(e2, q), sign);
        let w = _mm256_sub_ps(det, _mm256_add_ps(u, v));
        let inside = _mm256_min_ps(_mm256_min_ps(u, v), w);
        let beyond = _mm256_fnmadd_ps(_mm256_set1_ps(farthest), det, depth);
        // The least of inside + edge slack, and of the way to both ends in depth.
        let Slack { edge: edge_slack, depth: depth_slack } = block.slack;
        let edge = _mm256_set1_ps(edge_slack);
        let depth_margin = _mm256_min_ps(depth, _mm256_xor_ps(beyond, minus));
        let deep = _mm256_set1_ps(depth_slack);
        let possible = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_GE_OQ>(inside, _mm256_xor_ps(edge, minus)),
            _mm256_cmp_ps::<_CMP_GE_OQ>(depth_margin, _mm256_xor_ps(deep, minus)),
        );
        let possible = _mm256_movemask_ps(possible) as u32;
        if possible == 0 {
            return Verdict { possible, certain: 0 };
        }
        let certain = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_GT_OQ>(inside, edge),
            _mm256_cmp_ps::<_CMP_GT_OQ>(depth_margin, deep),
        );
        Verdict { possible, certain: _mm256_movemask_ps(certain) as u32 }
    }
}
