use super::*;
use crate::base::patience::Endless;
use crate::caster::bounds::widened;
use crate::caster::insertion::runs_of_box;
use crate::scene::parser::parse;
use glam::DVec3;

fn world(objects: &str, count: usize) -> World {
    let text = format!(
        "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
         Group {{ numObjects {count} Material {{ }} {objects} }}"
    );
    World::new(&parse(&text).unwrap(), &[]).unwrap()
}

#[test]
fn blocks_hold_the_primitives_of_the_cells() {
    let objects: String = (0..50)
        .map(|i| {
            format!("Triangle {{ vertex0 {i} 0 0 vertex1 {} 1 0 vertex2 {} 0 {} }}", i + 3, i + 1, i % 7)
        })
        .chain((0..5).map(|i| format!("Sphere {{ center {} 0 0 radius 2 }}", i * 9)))
        .collect();
    let world = world(&objects, 55);
    let lattice = Lattice::new(widened(world.bounds), [5, 2, 4]);
    let cells_of = |id: u32| {
        runs_of_box(&lattice, &world.box_of(id), 1e-6).flatten().map(|cell| cell as u32).collect::<Vec<_>>()
    };
    let references: Vec<Reference> =
        (0..55).flat_map(|id| cells_of(id).into_iter().map(move |cell| [cell, id])).collect();
    let mut contents = Contents::of_cells(&world, &lattice, vec![references.clone()], &Endless).unwrap();
    contents.fill(&world, &[(0, Frame::new(&lattice.bounds))], &Endless).unwrap();
    assert_eq!(contents.primitives_of(0..contents.len()).count(), references.len());
    assert_eq!(contents.len(), lattice.index_count());
    let mut expected_blocks = 0;
    for index in 0..contents.len() {
        let cell = lattice.cell_of(index);
        let is_border = cell.min_element() < 0.0 || cell.cmpge(DVec3::new(5.0, 2.0, 4.0)).any();
        assert_eq!(contents.cell(index).is_none(), is_border, "{index}");
        let found: Vec<u32> = contents.primitives_of(index..index + 1).collect();
        let listed = references.iter().filter(|[cell, _]| *cell == index as u32);
        let expected: Vec<u32> = listed.map(|&[_, id]| id).collect();
        assert_eq!(found, expected);
        expected_blocks += expected.iter().filter(|&&id| id < 50).count().div_ceil(LANES);
    }
    assert_eq!(contents.blocks.len(), expected_blocks);
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
