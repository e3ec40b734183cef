use super::*;
use crate::base::patience::Endless;
use crate::caster::bounds::widened;
use crate::world::test_worlds::world_of_triangles;
use glam::DVec3;

#[test]
fn a_cell_has_as_many_blocks_as_it_needs_however_many() {
    for count in [8, 111, 112, 113, 120, 121, 400] {
        let triangles = vec![[DVec3::ZERO, DVec3::X, DVec3::Y]; count];
        let world = world_of_triangles(triangles, &[]);
        let lattice = Lattice::new(widened(world.bounds), [1; 3]);
        let cell = lattice.index([0; 3]) as u32;
        let references = vec![(0..count as u32).map(|id| [cell, id]).collect()];
        let contents = Contents::of_cells(&world, &lattice, references, &Endless).unwrap();
        let (blocks, _) = contents.cell(cell as usize).unwrap();
        assert_eq!(blocks.len(), count.div_ceil(LANES), "{count}");
    }
}
