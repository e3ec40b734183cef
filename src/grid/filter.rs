//! Eight triangles at once in single precision: which of them the ray may hit.
//!
//! The filter decides nothing by itself unless it can prove it. It says of each triangle that the
//! ray surely misses it, surely hits it, or that double precision must decide.
//!
//! It is Moeller and Trumbore's test without the division, ordered so that a product of the edges can
//! be stored. With s from the ray's origin to the triangle's first corner, e1 from the second corner
//! to the first, e2 from the first to the third, n = e1 x e2, q = d x s and the determinant n.d, the
//! ray hits where u = e2.q, v = e1.q and w = det - u - v have the determinant's sign, at
//! t = n.s / det.
//!
//! *Error bound.* Let r = 2^-24, the relative rounding of single precision, b the largest coordinate
//! of the block's edges and c the least power of two that is no less than 1 and than any coordinate of
//! its corners. In the block's [`Frame`](super::triangle8::Frame) the ray's origin, which is moved along the
//! ray to where it enters the box, has coordinates of at most 1, the direction's largest is 1, and
//! b <= 2 c. Stored numbers are rounded once. Sums of three products are determinants, and one whose
//! numbers are at most 1 is at most 4: it is linear in each of them, so that none is larger than one of
//! numbers that are all 1 or -1. Where the ray meets the triangle, p from the first corner, s = t d - p;
//! so q = p x d, and that is small where the triangle is. With terms of less than r / 10 left out:
//!
//! | quantity | at most | error at most, portable | with fused multiplication and addition |
//! |---|---|---|---|
//! | s | 2 c | 2 r c: corner and origin r c / 2 each, their difference r c | |
//! | n | 2 b^2 | 2 r b^2 | |
//! | det = n.d | 4 b^2 | 18 r b^2: n 4, d 2, rounding 3 * 4 | 16 |
//! | q = d x s | 2 b | by its own rounding 2 r c of the products and 2 r b | 1; 2 |
//! | u = e2.q | 4 b^2 | 18 r b c: d 4, s 8, q 6; 20 r b^2: e2 4, q 4, rounding 3 * 4 | 15; 18 |
//! | v = e1.q | 4 b^2 | as u | |
//! | w | 4 b^2 | 36 r b c of u and v; 66 r b^2: u and v 40, det 18, rounding 8 | 30; 60 |
//! | n.s | 8 b^2 c | 40 r b^2 c: n 8, s 8, rounding 3 * 8 | 36 |
//! | n.s - t det | | 113 r b^2 c for 0 <= t <= 2.5, see [`Verdict::depths`] | 104 |
//!
//! `proofs/filter_portable.g` and `proofs/filter_fma.g` let a machine check these sums, with the terms of
//! second order and the double-precision test's own error of a few 2^-53 of the way from the ray's
//! origin, which stays below 2 r for origins up to 2^20 boxes away; farther ones do not come here. They
//! also say why a wrong sign of det does no harm, and why that holds for misses that are nearly hits.
//! [`FilterErrorBounds`] rounds the bounds up, and adds what may be lost to underflow.

use super::triangle8::{Block, FilterErrorBounds, LANES};
use crate::math::f64x4::{F64x4, Scalar};
use crate::math::instructions::{Instructions, Portable};

/// No hit lies farther along the ray: the box is 2 wide. Larger values are cut to this.
pub const MAX_DEPTH: f64 = 2.5;

/// A ray as the filter wants it, in the coordinates of a frame. Its origin lies in the box, its
/// direction's largest coordinate is 1.
#[derive(Clone, Copy, Debug)]
pub struct FilterRay {
    /// With a spare place, as below.
    pub origin: [f32; 4],
    /// Its largest absolute coordinate is 1.
    pub direction: [f32; 4],
    /// How far along the ray a hit still counts.
    pub max_depth: f32,
}

/// What the filter says of a block. Sets of lanes have bit 0 for the first.
#[derive(Clone, Copy, Debug)]
pub struct Verdict {
    /// All others surely miss.
    pub possible: u32,
    /// Surely hit, before the farthest t asked for.
    pub certain: u32,
    /// n.s and the determinant of each lane, both turned so that the determinant is not negative;
    /// only where a hit is possible.
    depth: [f32; LANES],
    det: [f32; LANES],
}

impl Verdict {
    const NONE: Self = Self { possible: 0, certain: 0, depth: [0.0; LANES], det: [0.0; LANES] };

    /// The filter's t where a lane that is certain is hit: not less, and not more than these.
    ///
    /// Of the bound the error of n.s takes 40 r b^2 c and that of t det 45; the roundings of these
    /// quotients take 20, and 8 are left for what is made of them in double precision.
    #[inline(always)]
    pub fn depths(&self, lane: usize, block: &Block) -> [f32; 2] {
        let (depth, det, padding) = (self.depth[lane], self.det[lane], block.error_bounds.depth);
        [(depth + padding) / det, (depth - padding) / det]
    }
}

/// One way to run the inner loop: the proof that the processor has its instructions. What its filter
/// says of a lane may differ between kernels, what is true not.
pub(crate) trait Kernel: Copy {
    type F64x4: F64x4<Proof = Self>;
    /// Tests a block against a ray.
    fn test(self, block: &Block, ray: &FilterRay) -> Verdict;
}

/// Tests a block against a ray with some instructions; for tests of the filter by itself.
pub fn test(instructions: Instructions, block: &Block, ray: &FilterRay) -> Verdict {
    match instructions {
        Instructions::Portable => Portable.test(block, ray),
        #[cfg(target_arch = "x86_64")]
        Instructions::Avx2(avx2) => avx2.test(block, ray),
    }
}

impl Kernel for Portable {
    type F64x4 = Scalar;

    #[inline(always)]
    fn test(self, block: &Block, ray: &FilterRay) -> Verdict {
        let FilterErrorBounds { edge: edge_error_bound, depth: depth_error_bound } = block.error_bounds;
        let mut verdict = Verdict::NONE;
        for lane in 0..LANES {
            let [e1, e2] = block.edges.map(|edge| edge.map(|c| c[lane]));
            let n = block.normal.map(|c| c[lane]);
            let [dx, dy, dz, _] = ray.direction;
            let s: [f32; 3] = std::array::from_fn(|axis| block.corner[axis][lane] - ray.origin[axis]);
            let q = cross([dx, dy, dz], s);
            let (det, u, v, depth) = (dot(n, [dx, dy, dz]), dot(e2, q), dot(e1, q), dot(n, s));
            // Signs turned so that the determinant counts as positive.
            let (u, v, depth) = if det < 0.0 { (-u, -v, -depth) } else { (u, v, depth) };
            let det = det.abs();
            let w = det - (u + v);
            let inside = u.min(v).min(w);
            let before = ray.max_depth * det - depth;
            // NaN lanes fail the comparisons; `min` would hide the NaN of a single operand, but an
            // empty lane has three.
            let possible =
                inside >= edge_error_bound && depth >= depth_error_bound && before >= depth_error_bound;
            let certain =
                inside > -edge_error_bound && depth > -depth_error_bound && before > -depth_error_bound;
            verdict.possible |= (possible as u32) << lane;
            verdict.certain |= (certain as u32) << lane;
            verdict.depth[lane] = depth;
            verdict.det[lane] = det;
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
mod avx2 {
    //! Eight lanes in one register each.

    use super::*;
    use crate::math::avx::Avx;
    use crate::math::instructions::Avx2;
    use std::arch::x86_64::*;

    impl Kernel for Avx2 {
        type F64x4 = Avx;

        #[inline(always)]
        fn test(self, block: &Block, ray: &FilterRay) -> Verdict {
            // SAFETY: `self` proves that the processor has AVX2 and FMA.
            unsafe { test(block, ray) }
        }
    }

    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn load(lanes: &[f32; LANES]) -> __m256 {
        bytemuck::cast(*lanes)
    }

    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn store(lanes: __m256) -> [f32; LANES] {
        bytemuck::cast(lanes)
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
    fn test(block: &Block, ray: &FilterRay) -> Verdict {
        let [o, d] = [ray.origin, ray.direction].map(|[x, y, z, _]| [x, y, z].map(|x| _mm256_set1_ps(x)));
        let three = |axes: &[[f32; LANES]; 3]| [load(&axes[0]), load(&axes[1]), load(&axes[2])];
        let corner = three(&block.corner);
        let [e1, e2] = [three(&block.edges[0]), three(&block.edges[1])];
        let n = three(&block.normal);
        let s = [0, 1, 2].map(|axis| _mm256_sub_ps(corner[axis], o[axis]));
        let q = cross(d, s);
        let (det, u, v, depth) = (dot(n, d), dot(e2, q), dot(e1, q), dot(n, s));
        // Signs turned so that the determinant counts as positive.
        let minus = _mm256_set1_ps(-0.0);
        let sign = _mm256_and_ps(det, minus);
        let det = _mm256_andnot_ps(minus, det);
        let [u, v, depth] = [u, v, depth].map(|x| _mm256_xor_ps(x, sign));
        let w = _mm256_sub_ps(det, _mm256_add_ps(u, v));
        let inside = _mm256_min_ps(_mm256_min_ps(u, v), w);
        let before = _mm256_fmsub_ps(_mm256_set1_ps(ray.max_depth), det, depth);
        let within = _mm256_min_ps(depth, before);
        let [edge, deep] =
            [&block.error_bounds.edge, &block.error_bounds.depth].map(|x| _mm256_broadcast_ss(x));
        let possible = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_GE_OQ>(inside, edge),
            _mm256_cmp_ps::<_CMP_GE_OQ>(within, deep),
        );
        let possible = _mm256_movemask_ps(possible) as u32;
        if possible == 0 {
            return Verdict::NONE;
        }
        let certain = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_GT_OQ>(inside, _mm256_xor_ps(edge, minus)),
            _mm256_cmp_ps::<_CMP_GT_OQ>(within, _mm256_xor_ps(deep, minus)),
        );
        let certain = _mm256_movemask_ps(certain) as u32;
        Verdict { possible, certain, depth: store(depth), det: store(det) }
    }
}
