use super::*;
use crate::caster::blocks::triangle8::NONE;
use crate::caster::grid::cell_lists::widened;
use crate::caster::grid::voxelize;
use crate::math::aabb::Aabb;
use crate::scene::parser::parse;
use bytemuck::Zeroable;

#[test]
fn blocks_hold_the_primitives_of_the_cell_lists() {
    let objects: String = (0..50)
        .map(|i| {
            format!("Triangle {{ vertex0 {i} 0 0 vertex1 {} 1 0 vertex2 {} 0 {} }}", i + 3, i + 1, i % 7)
        })
        .chain((0..5).map(|i| format!("Sphere {{ center {} 0 0 radius 2 }}", i * 9)))
        .collect();
    let text = format!(
        "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
         Group {{ numObjects 55 Material {{ }} {objects} }}"
    );
    let world = World::new(&parse(&text).unwrap(), &[]).unwrap();
    let lattice = Lattice::new(widened(world.bounds), [5, 2, 4]);
    let triangles = (0..50).map(|i| Aabb::around(world.corners(i)));
    let boxes: Vec<_> = triangles.chain(world.boxes()).collect();
    let cell_lists =
        CellLists::new(&lattice, 55, |i, out| voxelize::of_box(&lattice, &boxes[i], 1e-6, out)).unwrap();
    let mut cells = CellContents::new(&world, &lattice, &cell_lists).unwrap();
    let mut blocks = vec![Block::zeroed(); cells.block_count()];
    cells.fill(&world, &mut blocks);
    assert_eq!(CellContents::references(&blocks), cell_lists.references());
    let mut expected_blocks = 0;
    for index in 0..lattice.index_count() {
        let mut found: Vec<u32> = vec![];
        match cells.entries[index] {
            EMPTY => {}
            entry => {
                let own = CellContents::blocks_of(&blocks, entry);
                found.extend(own.iter().flat_map(|b| b.index.ids).filter(|&n| n != NONE));
                let [start, end] = own[own.len() - 1].index.non_triangles.map(|i| i as usize);
                found.extend(&cells.non_triangles[start..end]);
            }
        }
        let expected: Vec<u32> =
            (0..55).filter(|&n| cell_lists.cells_of(n as usize).contains(&(index as u32))).collect();
        assert_eq!(found, expected);
        assert_eq!(cells.entries[index] == EMPTY, expected.is_empty(), "{index}");
        let triangles = expected.iter().filter(|&&n| n < 50).count();
        expected_blocks += triangles.div_ceil(LANES).max(usize::from(!expected.is_empty()));
    }
    assert_eq!(blocks.len(), expected_blocks);
}

#[test]
fn a_cell_has_as_many_blocks_as_it_needs_however_many() {
    for count in [8, 111, 112, 113, 120, 121, 400] {
        let objects = "Triangle { vertex0 0 0 0 vertex1 1 0 0 vertex2 0 1 0 }".repeat(count);
        let text = format!(
            "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
             Group {{ numObjects {count} Material {{ }} {objects} }}"
        );
        let world = World::new(&parse(&text).unwrap(), &[]).unwrap();
        let lattice = Lattice::new(widened(world.bounds), [1; 3]);
        let cell = lattice.index([0; 3]) as u32;
        let cell_lists = CellLists::new(&lattice, count, |_, out| out.push(cell)).unwrap();
        let mut cells = CellContents::new(&world, &lattice, &cell_lists).unwrap();
        let mut blocks = vec![Block::zeroed(); cells.block_count()];
        cells.fill(&world, &mut blocks);
        let own = CellContents::blocks_of(&blocks, cells.entries[cell as usize]);
        assert_eq!(own.len(), count.div_ceil(LANES), "{count}");
    }
}
