//! The acceleration structure of the finite primitives: a list, a uniform grid or a tree.

use crate::caster::block::{Frame, NONE};
use crate::caster::bounds::Region;
use crate::caster::choose::Layout;
use crate::caster::contents::{Contents, Ids};
use crate::caster::dda::{CellTable, EMPTY};
use crate::caster::insertion::{bounds_of, references};
use crate::caster::lattice::{GridTooLarge, Lattice};
use crate::caster::tree::Tree;
use crate::math::aabb::Aabb;
use crate::world::World;
use std::cmp::Reverse;

/// The acceleration structure of the finite primitives.
#[derive(Debug)]
pub struct AccelerationStructure {
    /// The box in which rays are tested.
    pub region: Region,
    /// How to find the blocks that a ray meets.
    pub order: Order,
    /// The primitives of the cells or leaves; a list counts as one cell.
    pub contents: Contents,
}

/// How to find the blocks that a ray meets.
// There is only one instance, and boxing the table would add a pointer dereference for every ray.
#[allow(clippy::large_enum_variant)]
#[derive(Debug)]
pub enum Order {
    /// A ray meets all blocks.
    List,
    /// Through the entries of the cells along the ray.
    Grid(CellTable),
    /// Through the boxes that the ray meets.
    Tree(Tree),
}

/// The size of an acceleration structure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StructureSize {
    /// Cells, including the border, or nodes of the tree; a list counts as one cell.
    pub cells: usize,
    /// References to primitives in all cells; a primitive counts once for each cell that lists it.
    pub references: usize,
    /// Blocks of eight triangles.
    pub blocks: usize,
}

/// How full the cells of a grid are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fullness {
    /// The fullest cells by their indices along the axes, each with its number of primitives. Equally full cells are in
    /// ascending order of their indices, along z before y before x.
    pub fullest: Vec<([usize; 3], usize)>,
    /// Cells without a primitive.
    pub empty: usize,
    /// All cells.
    pub cells: usize,
}

impl AccelerationStructure {
    /// Builds the structure of all finite primitives of a world. Returns an error if it does not fit into memory.
    pub fn new(world: &World, layout: Layout) -> Result<Self, GridTooLarge> {
        let bounds = bounds_of(world);
        match layout {
            Layout::Tree => Self::tree(world, &bounds),
            Layout::List => Self::list(world, &bounds, |id| world.may_be_hit(id)),
            Layout::Grid(cells) => Self::grid(world, bounds, cells, false),
            Layout::Course(None) => Self::list(world, &bounds, |_| true),
            Layout::Course(Some(cells)) => Self::grid(world, bounds, cells, true),
        }
    }

    fn list(world: &World, bounds: &Aabb, is_listed: impl Fn(u32) -> bool) -> Result<Self, GridTooLarge> {
        let all = 0..world.finite_count() as u32;
        let listed: Vec<u32> = all.filter(|&id| !world.is_triangle(id) || is_listed(id)).collect();
        let mut ids = Ids::new(world, 0)?;
        ids.push(&listed);
        let region = Region::new(bounds, f64::INFINITY);
        let contents = ids.fill(&[(0, region.frame)]);
        Ok(Self { region, order: Order::List, contents })
    }

    fn tree(world: &World, bounds: &Aabb) -> Result<Self, GridTooLarge> {
        let region = Region::new(bounds, f64::INFINITY);
        let (tree, leaves) = Tree::new(world, &region.frame)?;
        let mut ids = Ids::new(world, leaves.ids.len())?;
        for leaf in &leaves.ids {
            ids.push(leaf.split(|&id| id == NONE).next().unwrap_or_default());
        }
        Ok(Self { region, order: Order::Tree(tree), contents: ids.fill(&leaves.frames) })
    }

    fn grid(world: &World, bounds: Aabb, cells: [usize; 3], as_course: bool) -> Result<Self, GridTooLarge> {
        let lattice = Lattice::new(bounds, cells);
        let references = references(world, &lattice, as_course)?;
        let (ids, entries) = Ids::of_cells(world, &lattice, references)?;
        let contents = ids.fill(&[(0, Frame::new(&bounds))]);
        let region = Region::new(&bounds, lattice.cell_size.min_element());
        Ok(Self { region, order: Order::Grid(CellTable::new(lattice, entries)?), contents })
    }

    /// Returns the entries of the grid's cells, if this is a grid.
    pub fn table(&self) -> Option<&CellTable> {
        match &self.order {
            Order::Grid(table) => Some(table),
            Order::List | Order::Tree(_) => None,
        }
    }

    /// Returns the size of the structure.
    pub fn size(&self) -> StructureSize {
        StructureSize {
            cells: match &self.order {
                Order::List => 1,
                Order::Grid(table) => table.lattice().index_count(),
                Order::Tree(tree) => tree.nodes.len(),
            },
            references: Contents::references(&self.contents.blocks),
            blocks: self.contents.blocks.len(),
        }
    }

    /// Returns the fullness of the grid's cells, with this number of the fullest; `None` for a list or a tree.
    pub fn fullness(&self, fullest: usize) -> Option<Fullness> {
        let table = self.table()?;
        let [nx, ny, nz] = table.lattice().cells();
        let all = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        let full = all.filter_map(|cell| {
            let entry = Some(table.entry(table.lattice().index(cell))).filter(|&entry| entry != EMPTY)?;
            Some((cell, Contents::references(self.contents.blocks_of(entry))))
        });
        let (mut full, cells) = (full.collect::<Vec<_>>(), nx * ny * nz);
        let empty = cells - full.len();
        full.sort_by_key(|&(_, count)| Reverse(count));
        full.truncate(fullest);
        Some(Fullness { fullest: full, empty, cells })
    }
}

#[cfg(test)]
mod tests;
