//! Rays that are cast together. Their ways into the grid are computed four at a time; then each goes on to
//! its first cell that is not empty, whose triangles the memory is asked for while the others do the same.

use super::build::Structure;
use super::cell_table::{BORDER, Walk, Words};
use super::cells::Cells;
use super::query::{Filtered, Search, lanes, place};
use super::traverse::Nest;
use super::triangle8::NONE;
use super::{Caster, Instructions};
use crate::grid::Lattice;
use crate::grid::dda4::Marches;
use crate::grid::ray_aabb::clip_packet;
use crate::math::four::Four;
#[cfg(target_arch = "x86_64")]
use crate::math::instructions::Avx2;
use crate::math::instructions::Portable;
use crate::math::packet::Packet;
use crate::math::prefetch::prefetch;
use crate::math::ray::{Hit, Ray};
use crate::stats::Probe;

/// So many rays go together: enough that the memory has answered when it is the first one's turn, and few
/// enough to stay near.
pub const STREAM: usize = 16;

/// What asks for the nearest hit on a ray.
pub trait Query {
    /// The ray.
    fn ray(&self) -> &Ray;
    /// Takes the nearest hit, as [`Caster::nearest`] gives it; called at least once, and the last call counts.
    fn answer(&mut self, hit: Option<Hit>);
}

/// So many rays are set up together.
const FOUR: usize = 4;

/// Four rays before their march through a grid.
#[derive(Clone, Copy, Debug, Default)]
struct Setup {
    /// The rays that meet the grid, bit 0 for the first, and those that start too far from it.
    passing: u32,
    too_far: u32,
    marches: Marches,
    /// The filter's rays, axis by axis, and its t, as in [`Filtered`].
    origins: [[f32; 4]; 3],
    directions: [[f32; 4]; 3],
    entry: [f64; 4],
    per_t: [f64; 4],
    unit: [f64; 4],
}

impl Setup {
    /// Of up to four rays.
    #[inline(always)]
    fn new<F: Four>(
        proof: F::Proof,
        structure: &Structure,
        lattice: &Lattice,
        queries: &[impl Query],
    ) -> Self {
        let splat = |x| F::splat(proof, x);
        let rays = match queries {
            // Four known places are faster than four looked for.
            [a, b, c, d] => [a.ray(), b.ray(), c.ray(), d.ray()],
            _ => [0, 1, 2, 3].map(|i: usize| queries[i.min(queries.len() - 1)].ray()),
        };
        let packet = &Packet::<F>::new(proof, rays);
        let passages = clip_packet(&structure.slab, packet);
        let frame = &structure.cells.frame;
        let [x, y, z] = &packet.axes;
        let (cx, cy, cz) = (splat(frame.center[0]), splat(frame.center[1]), splat(frame.center[2]));
        let farthest = splat(structure.farthest);
        let is_near = (x.origin - cx).abs().at_most(farthest)
            & (y.origin - cy).abs().at_most(farthest)
            & (z.origin - cz).abs().at_most(farthest);
        let scale = splat(frame.scale);
        let (entry, used) = (passages.entry, (1 << queries.len()) - 1);
        let largest = x.direction.abs().max(y.direction.abs()).max(z.direction.abs());
        let inverse = x.inverse.abs().min(y.inverse.abs()).min(z.inverse.abs());
        Self {
            passing: passages.set & is_near & used,
            too_far: !is_near & used,
            marches: Marches::new(lattice, packet, &passages),
            origins: [
                place(x, cx, entry, scale).single(),
                place(y, cy, entry, scale).single(),
                place(z, cz, entry, scale).single(),
            ],
            directions: [
                (x.direction * inverse).single(),
                (y.direction * inverse).single(),
                (z.direction * inverse).single(),
            ],
            entry: entry.places(),
            per_t: (largest * scale).places(),
            unit: (inverse * splat(frame.unit)).places(),
        }
    }

    #[inline(always)]
    fn filtered(&self, i: usize, last: f64) -> Filtered {
        let [ox, oy, oz] = &self.origins;
        let [dx, dy, dz] = &self.directions;
        let ray = [[ox[i], oy[i], oz[i], 0.0], [dx[i], dy[i], dz[i], 0.0]];
        Filtered::new(ray, self.entry[i], self.per_t[i], self.unit[i], last)
    }
}

impl Caster<'_> {
    /// Answers each query, of which there may be any number, as [`nearest`](Self::nearest) does.
    pub fn nearest_each<P: Probe>(&self, queries: &mut [impl Query], probe: &mut P) {
        let grid = self.structure.as_ref().and_then(|grid| Some((grid, grid.words.as_ref()?)));
        let Some((grid, words)) = grid.filter(|_| !P::COUNTS) else {
            return queries.iter_mut().for_each(|query| self.answer(query, probe));
        };
        for queries in queries.chunks_mut(STREAM) {
            match self.instructions {
                #[cfg(target_arch = "x86_64")]
                Instructions::Avx2(avx2) => {
                    // SAFETY: `avx2` proves that the processor has all that the function is compiled for.
                    unsafe { stream_avx2(avx2, self, grid, words, queries, probe) }
                }
                Instructions::Portable => self.stream(Portable, grid, words, queries, probe),
            }
        }
    }

    /// Answers a query by itself.
    fn answer<P: Probe>(&self, query: &mut impl Query, probe: &mut P) {
        let hit = self.nearest(query.ray(), None, probe);
        query.answer(hit);
    }

    /// Answers up to [`STREAM`] queries.
    #[inline(always)]
    fn stream<K: Nest, Q: Query, P: Probe>(
        &self,
        kernel: K,
        grid: &Structure,
        words: &Words,
        queries: &mut [Q],
        probe: &mut P,
    ) {
        let blocks = grid.cells.blocks.as_slice();
        let mut setups = [Setup::default(); STREAM / FOUR];
        let (mut passing, mut too_far) = (0, 0);
        for (i, (setup, four)) in setups.iter_mut().zip(queries.chunks(FOUR)).enumerate() {
            *setup = Setup::new::<K::Four>(kernel, grid, words.lattice(), four);
            passing |= setup.passing << (FOUR * i);
            too_far |= setup.too_far << (FOUR * i);
        }
        // All of them, since a loop over some would be guessed wrongly.
        queries.iter_mut().for_each(|query| query.answer(None));
        let mut walks: [Option<Walk>; STREAM] = [None; STREAM];
        let mut waiting = 0;
        for i in lanes(passing) {
            let mut walk = words.walk_of(&setups[i / FOUR].marches, i % FOUR);
            walk.skip();
            let word = walk.word();
            if word != BORDER {
                if let Some(block) = Cells::first_block(blocks, word) {
                    prefetch(block);
                }
                walks[i] = Some(walk);
                waiting |= 1 << i;
            }
        }
        for i in lanes(too_far) {
            self.answer(&mut queries[i], probe);
        }
        if !self.world.planes.is_empty() {
            // Every ray may meet a plane.
            waiting = ((1 << queries.len()) - 1) & !too_far;
        }
        for i in lanes(waiting) {
            let ray = queries[i].ray();
            let mut search = Search::new(self.world, ray, NONE);
            search.test_planes(ray, probe);
            if let Some(walk) = walks[i] {
                let mut filtered = setups[i / FOUR].filtered(i % FOUR, search.best.t);
                grid.march::<K, P, false>(kernel, walk, blocks, &mut filtered, &mut search, probe);
            }
            let hit = search.hit();
            queries[i].answer(hit);
        }
    }
}

/// A stream compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn stream_avx2<Q: Query, P: Probe>(
    avx2: Avx2,
    caster: &Caster,
    grid: &Structure,
    words: &Words,
    queries: &mut [Q],
    probe: &mut P,
) {
    caster.stream(avx2, grid, words, queries, probe);
}
