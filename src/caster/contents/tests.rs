use super::*;
use crate::base::patience::Endless;
use crate::caster::bounds::widened;
use crate::caster::insertion::of_box;
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
        let mut cells = vec![];
        of_box(&lattice, &world.box_of(id), 1e-6, &mut cells);
        cells
    };
    let references: Vec<Reference> =
        (0..55).flat_map(|id| cells_of(id).into_iter().map(move |cell| [cell, id])).collect();
    let (mut cells, entries) =
        Contents::of_cells(&world, &lattice, vec![references.clone()], &Endless).unwrap();
    cells.fill(&world, &[(0, Frame::new(&lattice.bounds))], &Endless).unwrap();
    assert_eq!(cells.primitives_of(&cells.blocks).count(), references.len());
    let mut expected_blocks = 0;
    for (index, &entry) in entries.iter().enumerate() {
        let mut found: Vec<u32> = vec![];
        let cell = lattice.cell_of(index);
        let is_border = cell.min_element() < 0.0 || cell.cmpge(DVec3::new(5.0, 2.0, 4.0)).any();
        assert_eq!(entry == BORDER, is_border, "{index}");
        if entry != EMPTY && !is_border {
            let own = cells.blocks_of(entry);
            found.extend(own.iter().flat_map(|block| block.ids).filter(|&id| id != NONE));
            found.extend(cells.non_triangles_in(own));
        }
        let listed = references.iter().filter(|[cell, _]| *cell == index as u32);
        let expected: Vec<u32> = listed.map(|&[_, id]| id).collect();
        assert_eq!(found, expected);
        assert_eq!(entry == EMPTY || is_border, expected.is_empty(), "{index}");
        let triangles = expected.iter().filter(|&&id| id < 50).count();
        expected_blocks += triangles.div_ceil(LANES).max(usize::from(!expected.is_empty()));
    }
    assert_eq!(cells.blocks.len(), expected_blocks);
}

#[test]
fn a_cell_has_as_many_blocks_as_it_needs_however_many() {
    for count in [8, 111, 112, 113, 120, 121, 400] {
        let world = world(&"Triangle { vertex0 0 0 0 vertex1 1 0 0 vertex2 0 1 0 }".repeat(count), count);
        let lattice = Lattice::new(widened(world.bounds), [1; 3]);
        let cell = lattice.index([0; 3]) as u32;
        let references = vec![(0..count as u32).map(|id| [cell, id]).collect()];
        let (mut cells, entries) = Contents::of_cells(&world, &lattice, references, &Endless).unwrap();
        cells.fill(&world, &[(0, Frame::new(&lattice.bounds))], &Endless).unwrap();
        assert_eq!(cells.blocks_of(entries[cell as usize]).len(), count.div_ceil(LANES), "{count}");
    }
}
