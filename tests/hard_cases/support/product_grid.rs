//! The only place that knows the insides of the program's grid.

use raytracer::grid::Lattice;
use raytracer::grid::build::Grid;
use raytracer::grid::march::March;
use raytracer::math::ray::Ray;
use raytracer::world::World;

/// How the program cuts the world into cells.
pub fn lattice(world: &World, cells: [usize; 3]) -> Lattice {
    Grid::new(world.bounds, cells, &[]).expect("a grid without contents").lattice
}

/// A cell by its indices along the axes, and the t at which the ray leaves it.
pub type Step = ([usize; 3], f64);

/// The cells along a ray.
pub fn steps(lattice: &Lattice, ray: &Ray) -> Vec<Step> {
    let [nx, ny, _] = lattice.cells;
    let place = |i: usize| [i % nx, i / nx % ny, i / nx / ny];
    let Some(mut march) = March::new(lattice, ray) else { return vec![] };
    let mut steps = vec![(place(march.cell), march.exit())];
    while march.step() {
        steps.push((place(march.cell), march.exit()));
    }
    steps
}
