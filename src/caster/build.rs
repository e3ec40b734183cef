//! Building the acceleration structure of the finite primitives: a list, a uniform grid or a tree.

use crate::caster::blocks::triangle8::{Block, Frame};
use crate::caster::cell_contents::CellContents;
use crate::caster::choose::Layout;
use crate::caster::error::GridTooLarge;
use crate::caster::grid::cell_table::CellTable;
use crate::caster::grid::insertion::{CellRule, bounds_of, cell_lists};
use crate::caster::grid::lattice::Lattice;
use crate::caster::ray_aabb::SimdAabb;
use crate::caster::reach::max_origin_distance;
use crate::caster::tree::Tree;
use crate::math::aabb::Aabb;
use crate::world::World;
use bytemuck::allocation::zeroed_vec;

/// The acceleration structure of the finite primitives.
#[derive(Debug)]
pub struct AccelerationStructure {
    /// Rays are tested only in this box.
    pub simd_bounds: SimdAabb,
    /// How the blocks that a ray meets are found.
    pub order: Order,
    /// The primitives of the cells, or those of the leaves; a list counts as one cell.
    pub cells: CellContents,
    /// The blocks of the cells or the leaves.
    pub blocks: Vec<Block>,
    /// The proofs of filter and DDA hold for rays whose origin is at most this far from the centre along each
    /// axis. For other rays every primitive is tested.
    pub max_origin_distance: f64,
}

/// How the blocks that a ray meets are found.
// There is one of it, and a box around the table would be another step for every ray.
#[allow(clippy::large_enum_variant)]
#[derive(Debug)]
pub enum Order {
    /// A ray meets all of them.
    List,
    /// By the entries of the cells along the ray.
    Grid(CellTable),
    /// By the boxes that the ray meets.
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

impl AccelerationStructure {
    /// The structure of all finite primitives of a world. An error when it does not fit into memory.
    pub fn new(world: &World, layout: Layout) -> Result<Self, GridTooLarge> {
        let bounds = bounds_of(world);
        let mut structure = match layout {
            // A tree needs something to divide.
            Layout::List | Layout::Tree if layout == Layout::List || world.hittable_count() == 0 => {
                Ok(Self::list(world, &bounds, true))
            }
            Layout::List | Layout::Tree => Self::tree(world, &bounds),
            Layout::Grid(cells) => Self::grid(world, bounds, cells, CellRule::Exact),
            Layout::Course(None) => Ok(Self::list(world, &bounds, false)),
            Layout::Course(Some(cells)) => Self::grid(world, bounds, cells, CellRule::Course),
        }?;
        structure.blocks = zeroed_vec(structure.cells.block_count());
        structure.cells.fill(world, &mut structure.blocks);
        Ok(structure)
    }

    /// The entries of the grid's cells, if it is a grid.
    #[inline(always)]
    pub fn table(&self) -> Option<&CellTable> {
        match &self.order {
            Order::Grid(table) => Some(table),
            Order::List | Order::Tree(_) => None,
        }
    }

    /// The size of the structure.
    pub fn size(&self) -> StructureSize {
        StructureSize {
            cells: match &self.order {
                Order::List => 1,
                Order::Grid(table) => table.lattice().index_count(),
                Order::Tree(tree) => tree.nodes.len(),
            },
            references: CellContents::references(&self.blocks),
            blocks: self.blocks.len(),
        }
    }

    /// A list of all finite primitives of a world with these bounds, or only of those that rays may hit.
    fn list(world: &World, bounds: &Aabb, hittable: bool) -> Self {
        Self::over(bounds, Order::List, CellContents::all(world, Frame::new(bounds), hittable))
    }

    fn tree(world: &World, bounds: &Aabb) -> Result<Self, GridTooLarge> {
        let (tree, leaves) = Tree::new(world, &Frame::new(bounds))?;
        let cells = CellContents::of_leaves(world, &leaves)?;
        Ok(Self::over(bounds, Order::Tree(tree), cells))
    }

    fn over(bounds: &Aabb, order: Order, cells: CellContents) -> Self {
        let max_origin_distance = max_origin_distance(bounds, f64::INFINITY);
        Self { simd_bounds: SimdAabb::new(bounds), order, cells, blocks: vec![], max_origin_distance }
    }

    fn grid(world: &World, bounds: Aabb, cells: [usize; 3], rule: CellRule) -> Result<Self, GridTooLarge> {
        let lattice = Lattice::new(bounds, cells);
        let cell_lists = cell_lists(world, &lattice, rule)?;
        let mut cells = CellContents::new(world, &lattice, &cell_lists)?;
        drop(cell_lists);
        let max_origin_distance = max_origin_distance(&lattice.bounds, lattice.cell_size.min_element());
        let simd_bounds = SimdAabb::new(&lattice.bounds);
        let order = Order::Grid(CellTable::new(lattice, cells.take_entries())?);
        Ok(Self { simd_bounds, order, cells, blocks: vec![], max_origin_distance })
    }
}

#[cfg(test)]
mod tests;
