//! The primitives that stood between surfaces and lights last.
//!
//! Rays from one primitive to one light often meet the same primitive: those from inside of a glass object meet its
//! surface, and those from a floor meet what stands on it. So this one is tested before all others. It never changes
//! whether a light is visible.

use crate::world::SurfacePoint;

/// The number of places in the table. A place is shared where there are more surfaces and lights.
const PLACES: usize = 1 << PLACE_BITS;
const PLACE_BITS: u32 = 10;

/// For each primitive, side and light the occluder that was found last.
#[derive(Debug, Default)]
pub struct Occluders {
    /// None until the first shadow ray.
    table: Option<Box<[Option<u32>; PLACES]>>,
}

/// One side of a primitive.
#[derive(Clone, Copy, Debug)]
pub struct Side(u32);

impl Side {
    /// The side of a surface that is lit.
    #[inline(always)]
    pub fn new(surface: &SurfacePoint, is_inside: bool) -> Self {
        Self(2u32.wrapping_mul(surface.primitive.unwrap_or(0)).wrapping_add(is_inside.into()))
    }

    /// Whether it is the inner side.
    #[inline(always)]
    pub fn is_inner(self) -> bool {
        self.0 & 1 != 0
    }
}

impl Occluders {
    /// The place of what stood last between this side of a primitive and the light with this index, or of none.
    #[inline(always)]
    pub fn place(&mut self, Side(side): Side, light: usize) -> &mut Option<u32> {
        let table = self.table.get_or_insert_with(|| Box::new([None; PLACES]));
        // Fibonacci hashing (Knuth, The Art of Computer Programming, volume 3, section 6.4).
        let hash = side.wrapping_add((light as u32) << 24).wrapping_mul(0x9E37_79B9);
        &mut table[(hash >> (u32::BITS - PLACE_BITS)) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn each_side_of_a_primitive_has_a_place_for_each_light() {
        let mut occluders = Occluders::default();
        let side = |primitive, is_inside| {
            let (position, normal) = (DVec3::ZERO, DVec3::Y);
            let surface = SurfacePoint { position, normal, material: 0, primitive, triangle: None };
            Side::new(&surface, is_inside)
        };
        let sides: Vec<Side> = (0..20).flat_map(|i| [side(Some(i), false), side(Some(i), true)]).collect();
        let rays = || sides.iter().flat_map(|side| (0..3).map(move |light| (*side, light)));
        for ((side, light), occluder) in rays().zip(0..) {
            assert_eq!(*occluders.place(side, light), None, "{side:?} {light}");
            *occluders.place(side, light) = Some(occluder);
        }
        for ((side, light), occluder) in rays().zip(0..) {
            assert_eq!(*occluders.place(side, light), Some(occluder), "{side:?} {light}");
        }
        // Any primitive and any light has a place.
        for primitive in [None, Some(u32::MAX - 1), Some(1 << 31)] {
            *occluders.place(side(primitive, true), usize::MAX) = None;
        }
    }
}
