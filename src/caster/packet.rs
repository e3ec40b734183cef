//! Packets: rays that are cast together. They are set up four at a time, and then each ray advances to its
//! first cell that is not empty and prefetches the triangles there, so that memory latency overlaps with the
//! work for the others.

use super::{Caster, Left};
use crate::caster::blocks::triangle8::NONE;
use crate::caster::build::AccelerationStructure;
use crate::caster::cell_contents::CellContents;
use crate::caster::descent::DescentKernel;
use crate::caster::grid::cell_table::{BORDER, CellCursor, CellTable};
use crate::caster::grid::dda4::Dda4;
use crate::caster::packet_setup::PacketSetup;
use crate::caster::query::RayQuery;
use crate::math::f64x4::{F64x4, LANES};
#[cfg(target_arch = "x86_64")]
use crate::math::instructions::Avx2;
use crate::math::instructions::{Instructions, Portable};
use crate::math::lanes::lanes;
use crate::math::prefetch::prefetch;
use crate::math::ray::{Ray, Visible};
use crate::shortcut::Shortcut;
use crate::stats::Quiet;
use arrayvec::ArrayVec;

/// The number of rays in a packet: so many that the triangles of the first ray have been loaded when it is
/// tested, and so few that they all stay in the cache.
pub const PACKET_SIZE: usize = 16;

/// A ray of a packet, and the destination of its result.
pub trait PacketRay {
    /// Whether it is one that leaves a surface, rather than a camera ray. Such rays differ more, so that their ways
    /// through the grid are not prepared in advance.
    const LEAVES_A_SURFACE: bool = false;
    /// The ray.
    fn ray(&self) -> &Ray;
    /// The primitive that it leaves, if it leaves a surface.
    #[inline(always)]
    fn leaves(&self) -> Option<u32> {
        None
    }
    /// Receives the result that [`Caster::nearest`] has for the ray. It is called at least once, and the last
    /// call counts.
    fn set_visible(&mut self, visible: Option<Visible>);
}

impl<R: PacketRay> PacketRay for &mut R {
    const LEAVES_A_SURFACE: bool = R::LEAVES_A_SURFACE;

    #[inline(always)]
    fn ray(&self) -> &Ray {
        (**self).ray()
    }

    #[inline(always)]
    fn leaves(&self) -> Option<u32> {
        (**self).leaves()
    }

    #[inline(always)]
    fn set_visible(&mut self, visible: Option<Visible>) {
        (**self).set_visible(visible);
    }
}

impl Caster<'_> {
    /// Finds the same primitive as [`nearest`](Self::nearest) for each of any number of rays.
    pub fn nearest_of_packet(&self, rays: &mut [impl PacketRay]) {
        let grid = self.structure.as_ref().and_then(|grid| Some((grid, grid.table()?)));
        let Some((grid, table)) = grid.filter(|_| Shortcut::Packets.is_taken()) else {
            return rays.iter_mut().for_each(|ray| self.cast_alone(ray));
        };
        for rays in rays.chunks_mut(PACKET_SIZE) {
            match self.instructions {
                #[cfg(target_arch = "x86_64")]
                Instructions::Avx2(avx2) => {
                    // SAFETY: `avx2` proves that the processor has all that the function is compiled for.
                    unsafe { trace_packet_avx2(avx2, self, grid, table, rays) }
                }
                Instructions::Portable => self.trace_packet(Portable, grid, table, rays),
            }
        }
    }

    /// Casts one of the rays by itself.
    fn cast_alone(&self, ray: &mut impl PacketRay) {
        let visible = self.nearest(ray.ray(), ray.leaves(), &mut Quiet);
        ray.set_visible(visible);
    }

    /// Casts up to [`PACKET_SIZE`] rays.
    #[inline(always)]
    fn trace_packet<K: DescentKernel, Q: PacketRay>(
        &self,
        kernel: K,
        grid: &AccelerationStructure,
        table: &CellTable,
        rays: &mut [Q],
    ) {
        if Q::LEAVES_A_SURFACE {
            for four in rays.chunks_mut(LANES) {
                self.trace_four(kernel, grid, table, four);
            }
            return;
        }
        // An array of empty set-ups would have to be written first.
        let mut setups = ArrayVec::<PacketSetup, { PACKET_SIZE / LANES }>::new();
        let (mut passing, mut too_far) = (0, 0);
        for (i, four) in rays.chunks(LANES).enumerate() {
            let setup = set_up::<K::F64x4>(kernel, grid, table, four);
            passing |= setup.passing << (LANES * i);
            too_far |= setup.too_far << (LANES * i);
            setups.push(setup);
        }
        // All of them are reset, because the branches of a loop over some of them would be mispredicted.
        rays.iter_mut().for_each(|ray| ray.set_visible(None));
        let mut cursors: [Option<CellCursor>; PACKET_SIZE] = [None; PACKET_SIZE];
        let mut pending = 0;
        for i in lanes(passing) {
            cursors[i] = first_occupied_cell(grid, table, &setups[i / LANES].dda4, i % LANES);
            pending |= u32::from(cursors[i].is_some()) << i;
        }
        for i in lanes(too_far) {
            self.cast_alone(&mut rays[i]);
        }
        if !self.world.planes.is_empty() {
            // Every ray may hit a plane.
            pending = ((1 << rays.len()) - 1) & !too_far;
        }
        for i in lanes(pending) {
            let ray = rays[i].ray();
            let mut query = RayQuery::new(self.world, ray, NONE);
            query.test_planes(ray, &mut Quiet);
            if let Some(cursor) = cursors[i] {
                let filter_state = setups[i / LANES].filter_state(i % LANES, query.end::<false>());
                grid.traverse_cells::<K, _, false>(kernel, cursor, filter_state, &mut query, &mut Quiet);
            }
            let visible = self.seen(&query, Left::for_good(NONE));
            rays[i].set_visible(visible);
        }
    }

    /// Casts up to four rays that leave surfaces.
    #[inline(always)]
    fn trace_four<K: DescentKernel, Q: PacketRay>(
        &self,
        kernel: K,
        grid: &AccelerationStructure,
        table: &CellTable,
        rays: &mut [Q],
    ) {
        let is_round = |ray: &Q| self.is_round(ray.leaves().unwrap_or(NONE));
        if rays.iter().all(is_round) {
            return rays.iter_mut().for_each(|ray| self.cast_alone(ray));
        }
        let setup = set_up::<K::F64x4>(kernel, grid, table, rays);
        for (i, ray) in rays.iter_mut().enumerate() {
            if setup.too_far >> i & 1 != 0 || is_round(ray) {
                self.cast_alone(ray);
                continue;
            }
            let mut query = RayQuery::new(self.world, ray.ray(), ray.leaves().unwrap_or(NONE));
            query.test_planes(ray.ray(), &mut Quiet);
            if setup.passing >> i & 1 != 0 {
                let filter_state = setup.filter_state(i, query.end::<false>());
                // A cursor that is passed on would be written to memory and read again in other parts.
                grid.traverse_cells::<K, _, false>(
                    kernel,
                    table.cursor_of(&setup.dda4, i),
                    filter_state,
                    &mut query,
                    &mut Quiet,
                );
            }
            let left = Left::for_good(ray.leaves().unwrap_or(NONE));
            let visible = self.seen(&query, left);
            ray.set_visible(visible);
        }
    }
}

/// The set-up of up to four rays.
#[inline(always)]
fn set_up<F: F64x4>(
    proof: F::Proof,
    grid: &AccelerationStructure,
    table: &CellTable,
    rays: &[impl PacketRay],
) -> PacketSetup {
    let four = match rays {
        // Constant indices are faster than computed ones.
        [a, b, c, d] => [a.ray(), b.ray(), c.ray(), d.ray()],
        _ => [0, 1, 2, 3].map(|i: usize| rays[i.min(rays.len() - 1)].ray()),
    };
    PacketSetup::new::<F>(proof, grid, table.lattice(), four, rays.len())
}

/// The first cell along one of four rays that is not empty; none if the ray leaves the grid before it. The cell's first
/// block is prefetched.
#[inline(always)]
fn first_occupied_cell<'t>(
    grid: &AccelerationStructure,
    table: &'t CellTable,
    dda4: &Dda4,
    ray: usize,
) -> Option<CellCursor<'t>> {
    let mut cursor = table.cursor_of(dda4, ray);
    cursor.skip();
    if cursor.entry() == BORDER {
        return None;
    }
    if let Some(block) = CellContents::first_block_of(&grid.blocks, cursor.entry()) {
        prefetch(block);
    }
    Some(cursor)
}

/// The same compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn trace_packet_avx2<Q: PacketRay>(
    avx2: Avx2,
    caster: &Caster,
    grid: &AccelerationStructure,
    table: &CellTable,
    rays: &mut [Q],
) {
    caster.trace_packet(avx2, grid, table, rays);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caster::choose::Layout;
    use crate::scene::parser::parse;
    use crate::stats::Quiet;
    use crate::world::World;
    use glam::DVec3;

    /// A ray, which leaves a surface or not.
    struct TestRay<const LEAVES: bool> {
        ray: Ray,
        visible: Option<Visible>,
    }

    impl<const LEAVES: bool> PacketRay for TestRay<LEAVES> {
        const LEAVES_A_SURFACE: bool = LEAVES;

        fn ray(&self) -> &Ray {
            &self.ray
        }

        fn set_visible(&mut self, visible: Option<Visible>) {
            self.visible = visible;
        }
    }

    #[test]
    fn a_ray_from_too_far_is_answered_at_any_place_of_a_packet() {
        is_answered_at_any_place::<false>();
        is_answered_at_any_place::<true>();
    }

    fn is_answered_at_any_place<const LEAVES: bool>() {
        let text = "OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }
             Group { numObjects 2 Material { }
             Triangle { vertex0 -1 -1 0 vertex1 1 -1 0 vertex2 0 1 0 }
             Triangle { vertex0 -1 -1 1 vertex1 1 -1 1 vertex2 0 0.5 1 } }";
        let world = World::new(&parse(text).unwrap(), &[]).unwrap();
        for instructions in Instructions::available() {
            let caster = Caster::with(&world, Layout::Grid([3; 3]), instructions).unwrap();
            for (count, far) in (1..=PACKET_SIZE + 3).flat_map(|count| (0..count).map(move |i| (count, i))) {
                let asked = |i| {
                    let origin = DVec3::new(0.0, 0.75 - 0.1 * i as f64, if i == far { 1e9 } else { 3.0 });
                    TestRay { ray: Ray::new(origin, DVec3::NEG_Z), visible: None }
                };
                let mut rays: Vec<TestRay<LEAVES>> = (0..count).map(asked).collect();
                caster.nearest_of_packet(&mut rays);
                for TestRay { ray, visible } in &rays {
                    let expected = caster.nearest(ray, None, &mut Quiet);
                    assert_eq!(visible.map(|v| v.primitive), expected.map(|v| v.primitive), "{ray:?}");
                }
            }
        }
    }
}
