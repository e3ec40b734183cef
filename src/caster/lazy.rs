//! A caster whose structure is built when rays need it.

use crate::base::patience::Patience;
use crate::caster::choose::Layout;
use crate::caster::lattice::NotBuilt;
use crate::caster::structure::AccelerationStructure;
use crate::caster::{Caster, Fullness};
use std::sync::{Arc, OnceLock};

/// A caster whose structure is built when rays need it. Rasterization may leave no ray to cast.
#[derive(Debug)]
pub struct LazyCaster<'w> {
    /// The caster without a structure.
    planes: Caster<'w>,
    layout: Layout,
    structure: OnceLock<Option<Arc<AccelerationStructure>>>,
}

impl<'w> LazyCaster<'w> {
    /// Returns a caster that builds this structure. `planes` is the caster of the planes alone.
    pub fn new(planes: Caster<'w>, layout: Layout) -> Self {
        Self { planes, layout, structure: OnceLock::new() }
    }

    /// Returns the caster, which searches as long as there is patience. Builds the structure unless it is built.
    pub fn built<'a>(&'a self, patience: &'a dyn Patience) -> Result<Caster<'a>, NotBuilt> {
        if self.structure.get().is_none() {
            let build = |layout| AccelerationStructure::of_world(self.planes.world, layout, patience);
            let structure = match build(self.layout) {
                // A tree was not asked for. A list is slower, but fits.
                Err(NotBuilt::TooLarge) if self.layout == Layout::Tree => build(Layout::List),
                structure => structure,
            };
            // Two threads may build it. They do not wait for each other, since building runs on all threads.
            let _ = self.structure.set(structure?);
        }
        Ok(self.so_far(patience))
    }

    /// Returns the caster with the structure if it is built, and otherwise the caster of the planes alone. It searches as
    /// long as there is patience.
    pub fn so_far<'a>(&'a self, patience: &'a dyn Patience) -> Caster<'a> {
        let structure = self.structure.get().cloned().flatten();
        Caster { structure, patience, ..self.planes.clone() }
    }

    /// Returns how full the cells are for which steps are counted, with up to this number of the fullest.
    pub fn fullness(&self, fullest: usize) -> Option<Fullness> {
        self.planes.counts.as_ref().map(|counts| counts.fullness(fullest))
    }
}

impl<'w> From<Caster<'w>> for LazyCaster<'w> {
    fn from(caster: Caster<'w>) -> Self {
        let structure = OnceLock::from(caster.structure.clone());
        Self { planes: Caster { structure: None, ..caster }, layout: Layout::List, structure }
    }
}
