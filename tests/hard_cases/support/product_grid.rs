//! The only place that knows the insides of the program's grid.

use raytracer::grid::Lattice;
use raytracer::grid::cell_lists::widened;
use raytracer::grid::dda::{Dda, face_error_bound};
use raytracer::math::ray::Ray;
use raytracer::world::World;

/// How the program cuts the world into cells.
pub fn lattice(world: &World, cells: [usize; 3]) -> Lattice {
    Lattice::new(widened(world.bounds), cells)
}

/// By how much of a cell the program widens cells for the march's sake.
pub fn margin(lattice: &Lattice) -> f64 {
    face_error_bound(lattice)
}

/// A cell by its indices along the axes, and the t at which the ray leaves it.
pub type Step = ([usize; 3], f64);

/// The t at which the ray enters the lattice, and the cells along it.
pub fn steps(lattice: &Lattice, ray: &Ray) -> (f64, Vec<Step>) {
    let Some((mut march, [entry, exit])) = Dda::of_ray(lattice, ray) else { return (0.0, vec![]) };
    // The whole passage takes 2^29 ticks.
    let per_tick = (exit - entry) / 2f64.powi(29);
    let mut steps = vec![];
    loop {
        let cell = lattice.cell_of(march.index()).to_array();
        if (0..3).any(|axis| cell[axis] < 0.0 || cell[axis] >= lattice.cells()[axis] as f64) {
            return (entry, steps);
        }
        steps.push((cell.map(|i| i as usize), entry + march.exit() as f64 * per_tick));
        march.step();
    }
}
