//! Access to the internals of the program's grid, for all cases.

use raytracer::caster::bounds::widened;
use raytracer::caster::dda::{Dda, face_error_bound};
use raytracer::caster::lattice::Lattice;
use raytracer::math::ray::Ray;
use raytracer::world::World;

/// The lattice by which the program divides the world into cells.
pub fn lattice(world: &World, cells: [usize; 3]) -> Lattice {
    Lattice::new(widened(world.bounds), cells)
}

/// The error bound of the program's DDA, in cells.
pub fn dda_error_bound(lattice: &Lattice) -> f64 {
    face_error_bound(lattice)
}

/// A cell by its indices along the axes, and the t at which the ray leaves it.
pub type Step = ([usize; 3], f64);

/// The t at which the ray enters the lattice, and the cells along it.
pub fn steps(lattice: &Lattice, ray: &Ray) -> (f64, Vec<Step>) {
    let Some((mut dda, [entry, exit])) = Dda::of_ray(lattice, ray) else { return (0.0, vec![]) };
    // The interval in the lattice is 2^29 fixed-point units long.
    let t_per_unit = (exit - entry) / 2f64.powi(29);
    let mut steps = vec![];
    loop {
        let cell = lattice.cell_of(dda.index()).to_array();
        if (0..3).any(|axis| cell[axis] < 0.0 || cell[axis] >= lattice.cells()[axis] as f64) {
            return (entry, steps);
        }
        steps.push((cell.map(|i| i as usize), entry + dda.exit() as f64 * t_per_unit));
        dda.step();
    }
}
