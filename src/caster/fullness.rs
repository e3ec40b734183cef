//! How the primitives are spread over the cells of a grid.

use crate::caster::build::AccelerationStructure;
use crate::caster::cell_contents::CellContents;
use crate::caster::grid::cell_table::EMPTY;

/// How full the cells of a grid are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fullness {
    /// The fullest cells, by their indices along the axes, each with its number of primitives. Of equally full cells
    /// those with the smaller indices come first, along z before y before x.
    pub fullest: Vec<([usize; 3], usize)>,
    /// Cells without a primitive.
    pub empty: usize,
    /// All cells.
    pub cells: usize,
}

impl AccelerationStructure {
    /// The fullness of the grid's cells; none of a list or a tree.
    pub fn fullness(&self, fullest: usize) -> Option<Fullness> {
        let table = self.table()?;
        let lattice = table.lattice();
        let [nx, ny, nz] = lattice.cells();
        let mut fullness = Fullness { fullest: vec![], empty: 0, cells: nx * ny * nz };
        for cell in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))) {
            let count = self.primitives_in(table.entry(lattice.index(cell)));
            if count == 0 {
                fullness.empty += 1;
            } else {
                let place = fullness.fullest.partition_point(|&(_, other)| other >= count);
                fullness.fullest.insert(place, (cell, count));
                fullness.fullest.truncate(fullest);
            }
        }
        Some(fullness)
    }

    fn primitives_in(&self, entry: u32) -> usize {
        match entry {
            EMPTY => 0,
            _ => CellContents::references(CellContents::blocks_of(&self.blocks, entry)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caster::Caster;
    use crate::scene::parser::parse;
    use crate::world::World;

    /// Three crossed triangles near the origin and one triangle far away, with a small sphere beside it.
    fn world() -> World {
        let triangle =
            |p: &str, q: &str, r: &str| format!("Triangle {{ vertex0 {p} vertex1 {q} vertex2 {r} }}");
        let objects = [
            triangle("0.1 0.1 0.1", "0.4 0.1 0.1", "0.1 0.4 0.1"),
            triangle("0.1 0.1 0.1", "0.4 0.1 0.1", "0.1 0.1 0.4"),
            triangle("0.1 0.1 0.1", "0.1 0.4 0.1", "0.1 0.1 0.4"),
            triangle("3.6 3.6 3.6", "3.9 3.6 3.6", "3.6 3.9 3.9"),
            "Sphere { center 3.8 3.8 3.8 radius 0.1 }".into(),
        ];
        let text = format!(
            "OrthographicCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 0 size 5 }}
             Materials {{ numMaterials 1 Material {{ }} }}
             Group {{ numObjects 5 MaterialIndex 0 {} }}",
            objects.join(" ")
        );
        World::new(&parse(&text).unwrap(), &[]).unwrap()
    }

    #[test]
    fn the_fullest_cells_come_first() {
        let world = world();
        let of = |caster: &Caster, most| caster.fullness(most).unwrap();
        let uniform = Caster::new(&world, Some([4, 4, 4])).unwrap();
        let expected = Fullness { fullest: vec![([0; 3], 3), ([3; 3], 2)], empty: 62, cells: 64 };
        assert_eq!(of(&uniform, 5), expected);
        assert_eq!(of(&uniform, 1), Fullness { fullest: vec![([0; 3], 3)], ..expected.clone() });
        assert_eq!(Caster::new(&world, None).unwrap().fullness(5), None);
    }
}
