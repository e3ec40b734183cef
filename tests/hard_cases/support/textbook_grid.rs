//! The uniform grid of the textbooks: the t of the next face is accumulated step by step in a chosen
//! precision, cells are not padded, and the traversal ends at the first cell with a hit.

use super::textbook::{V, lower};
use glam::DVec3;
use num_traits::Float;
use raytracer::caster::lattice::Lattice;
use raytracer::math::aabb::Aabb;
use raytracer::math::ray::Ray;
use raytracer::world::World;
use raytracer::world::triangle::Shear;
use std::collections::HashMap;

fn float<T: Float>(x: f64) -> T {
    T::from(x).expect("a float fits into a float")
}

/// Calls `visit` with each cell along the ray, and the t at which the ray leaves it, until `visit` returns
/// false or the ray leaves the lattice.
pub fn traverse<T: Float>(lattice: &Lattice, ray: &Ray, mut visit: impl FnMut([usize; 3], f64) -> bool) {
    let (o, d): (V<T>, V<T>) = (lower(ray.origin), lower(ray.direction));
    let (low, size): (V<T>, V<T>) = (lower(lattice.bounds.min), lower(lattice.cell_size));
    let Some(entry) = clip(&lower(lattice.bounds.min), &lower(lattice.bounds.max), &o, &d) else { return };
    let mut cell = [0; 3];
    let (mut next, mut between) = ([T::infinity(); 3], [T::infinity(); 3]);
    for i in 0..3 {
        let place = (o[i] + entry * d[i] - low[i]) / size[i];
        cell[i] = place.max(T::zero()).to_usize().unwrap_or(0).min(lattice.cells()[i] - 1);
        if d[i] != T::zero() {
            let face = cell[i] + (d[i] > T::zero()) as usize;
            next[i] = (low[i] + size[i] * float(face as f64) - o[i]) / d[i];
            between[i] = size[i] / d[i].abs();
        }
    }
    loop {
        let axis = (0..3).fold(0, |best, i| if next[i] < next[best] { i } else { best });
        if !visit(cell, next[axis].to_f64().unwrap_or(f64::NAN)) || next[axis].is_infinite() {
            return;
        }
        let after = if d[axis] > T::zero() { Some(cell[axis] + 1) } else { cell[axis].checked_sub(1) };
        match after.filter(|&c| c < lattice.cells()[axis]) {
            Some(after) => cell[axis] = after,
            None => return,
        }
        next[axis] = next[axis] + between[axis];
    }
}

/// The point at which the ray enters the box, or its origin if that is inside.
fn clip<T: Float>(low: &V<T>, high: &V<T>, o: &V<T>, d: &V<T>) -> Option<T> {
    let (mut entry, mut exit) = (T::zero(), T::infinity());
    for i in 0..3 {
        let (a, b) = ((low[i] - o[i]) / d[i], (high[i] - o[i]) / d[i]);
        // For a ray in the plane of a face t is NaN, for which the comparisons are false.
        entry = if a.min(b) > entry { a.min(b) } else { entry };
        exit = if a.max(b) < exit { a.max(b) } else { exit };
    }
    (entry <= exit).then_some(entry)
}

/// A grid with each triangle in all cells that its bounds touch.
pub struct TextbookGrid<'w> {
    world: &'w World,
    pub lattice: Lattice,
    cells: HashMap<[usize; 3], Vec<u32>>,
}

impl<'w> TextbookGrid<'w> {
    pub fn new(world: &'w World, cells: [usize; 3]) -> Self {
        Self::over(world, Lattice::new(world.bounds, cells))
    }

    pub fn over(world: &'w World, lattice: Lattice) -> Self {
        let mut cells: HashMap<[usize; 3], Vec<u32>> = HashMap::new();
        for i in 0..world.triangles.len() {
            let b = Aabb::around(world.corners(i));
            let place = |v: DVec3, axis: usize| {
                let place = (v[axis] - lattice.bounds.min[axis]) / lattice.cell_size[axis];
                (place as usize).min(lattice.cells()[axis] - 1)
            };
            let range = |axis| place(b.min, axis)..=place(b.max, axis);
            for x in range(0) {
                for y in range(1) {
                    for z in range(2) {
                        cells.entry([x, y, z]).or_default().push(i as u32);
                    }
                }
            }
        }
        Self { world, lattice, cells }
    }

    /// The triangle that the textbook's traversal finds.
    pub fn first_hit<T: Float>(&self, ray: &Ray) -> Option<u32> {
        let shear = Shear::new(ray);
        let mut found = None;
        traverse::<T>(&self.lattice, ray, |cell, _| {
            let mut nearest = f64::INFINITY;
            for &i in self.cells.get(&cell).map_or(&[][..], |list| list) {
                let t = shear.intersect(self.world.corners_in_place(i as usize));
                if let Some(t) = t.filter(|&t| ray.covers(t) && t < nearest) {
                    (nearest, found) = (t, Some(i));
                }
            }
            found.is_none()
        });
        found
    }
}
