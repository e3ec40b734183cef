//! What a ray hits: the planes, then the grid's cells or, without a grid, everything.

use crate::grid::build::{Grid, GridTooLarge};
use crate::grid::march::March;
use crate::math::aabb::Aabb;
use crate::math::ray::{Hit, Ray};
use crate::primitive::triangle::Shear;
use crate::stats::Probe;
use crate::world::{Primitive, World};

/// Casts rays into a world.
#[derive(Debug)]
pub struct Caster<'w> {
    pub world: &'w World,
    grid: Option<Grid>,
}

impl<'w> Caster<'w> {
    /// With a grid of so many cells along each axis, or none. No grid is built where there is
    /// nothing finite to put into it.
    pub fn new(world: &'w World, cells: Option<[usize; 3]>) -> Result<Self, GridTooLarge> {
        let finite = (world.finite_count() > 0).then_some(());
        let build = |cells| {
            let boxes: Vec<Aabb> = world.boxes().collect();
            let bounds = boxes.iter().fold(world.bounds, |all, &b| all.union(b));
            Grid::new(bounds, cells, &boxes)
        };
        Ok(Self { world, grid: cells.filter(|_| finite.is_some()).map(build).transpose()? })
    }

    /// The nearest hit on the ray.
    pub fn closest<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Hit> {
        let mut search = Search::new(self.world, ray);
        self.run::<P, false>(&mut search, probe);
        search.best
    }

    /// Whether anything stands on the ray.
    pub fn any<P: Probe>(&self, ray: &Ray, probe: &mut P) -> bool {
        let mut search = Search::new(self.world, ray);
        self.run::<P, true>(&mut search, probe);
        search.best.is_some()
    }

    fn run<P: Probe, const ANY: bool>(&self, search: &mut Search, probe: &mut P) {
        let world = self.world;
        let planes = world.first_plane();
        // The course's program looks for the nearest hit also where any would do.
        let stop_early = ANY && !P::COUNTS;
        search.test_all(planes..planes + world.planes.len() as u32, stop_early, probe);
        if stop_early && search.best.is_some() {
            return;
        }
        match &self.grid {
            Some(grid) if is_near(&search.ray, grid) => march(grid, search, stop_early, probe),
            _ => search.test_all(0..planes, stop_early, probe),
        }
    }
}

/// Whether the ray begins near enough for the marcher's proof: farther out, the rounding of the
/// origin alone exceeds the padding of the cells, and everything is tested instead.
fn is_near(ray: &Ray, grid: &Grid) -> bool {
    let bounds = &grid.lattice.bounds;
    let farthest = ray.origin.abs().max(bounds.min.abs()).max(bounds.max.abs()).max_element();
    farthest <= grid.farthest_origin
}

/// Tests the cells along the ray until no nearer hit can follow.
fn march<P: Probe>(grid: &Grid, search: &mut Search, stop_early: bool, probe: &mut P) {
    let Some(mut march) = March::new(&grid.lattice, &search.ray) else { return };
    loop {
        search.test_all(grid.items(march.cell).iter().copied(), stop_early, probe);
        let exit = march.exit();
        // A hit on the far face may have an equal in the next cell; the margin lets it compete.
        let past = |hit: Hit| stop_early || hit.t <= exit - 1e-12 * exit.abs();
        if search.best.is_some_and(past) || exit > search.ray.t_max {
            return;
        }
        probe.cell();
        if !march.step() {
            return;
        }
    }
}

/// The best hit so far along one ray.
struct Search<'w> {
    world: &'w World,
    ray: Ray,
    shear: Shear,
    best: Option<Hit>,
}

impl<'w> Search<'w> {
    fn new(world: &'w World, ray: &Ray) -> Self {
        Self { world, ray: *ray, shear: Shear::new(ray), best: None }
    }

    fn test_all<P: Probe>(&mut self, primitives: impl Iterator<Item = u32>, stop_early: bool, probe: &mut P) {
        for primitive in primitives {
            probe.intersections(1);
            self.test(primitive);
            if stop_early && self.best.is_some() {
                return;
            }
        }
    }

    fn test(&mut self, primitive: u32) {
        let world = self.world;
        let t = match world.primitive(primitive) {
            Primitive::Triangle(i) => {
                self.shear.intersect(world.corners(i)).map(|c| c.t).filter(|&t| self.ray.covers(t))
            }
            Primitive::Sphere(i) => world.spheres[i].intersect(&self.ray),
            Primitive::Ellipsoid(i) => world.ellipsoids[i].intersect(&self.ray),
            Primitive::Plane(i) => world.planes[i].intersect(&self.ray),
        };
        let Some(t) = t else { return };
        let hit = Hit { t, primitive };
        if self.best.is_none_or(|best| world.precedes(hit, best)) {
            self.best = Some(hit);
        }
    }
}
