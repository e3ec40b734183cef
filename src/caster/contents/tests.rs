use super::*;
use crate::base::patience::Endless;
use crate::caster::bounds::widened;
use crate::scene::parser::parse;

fn world(objects: &str, count: usize) -> World {
    let text = format!(
        "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
         Group {{ numObjects {count} Material {{ }} {objects} }}"
    );
    World::new(&parse(&text).unwrap(), &[]).unwrap()
}

#[test]
fn a_cell_has_as_many_blocks_as_it_needs_however_many() {
    for count in [8, 111, 112, 113, 120, 121, 400] {
        let world = world(&"Triangle { vertex0 0 0 0 vertex1 1 0 0 vertex2 0 1 0 }".repeat(count), count);
        let lattice = Lattice::new(widened(world.bounds), [1; 3]);
        let cell = lattice.index([0; 3]) as u32;
        let references = vec![(0..count as u32).map(|id| [cell, id]).collect()];
        let contents = Contents::of_cells(&world, &lattice, references, &Endless).unwrap();
        let (blocks, _) = contents.cell(cell as usize).unwrap();
        assert_eq!(blocks.len(), count.div_ceil(LANES), "{count}");
    }
}
