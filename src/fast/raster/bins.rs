//! Sorts the triangles into tiles, and draws all tiles.

use super::edge_functions::EdgeFunctions;
use super::tile::Tile;
use super::triangle_bounds::TriangleBounds;
use super::{NOTHING, Screen, TILE_ROWS};
use rayon::prelude::*;
use std::ops::Range;

/// The triangles of all tiles.
pub struct Bins {
    rows: Range<usize>,
    /// The bins of all tiles, for each part of the triangles separately, so that threads can fill them in parallel.
    parts: Vec<Vec<TileBin>>,
}

/// The triangles in one tile.
#[derive(Clone, Default)]
struct TileBin {
    /// The bounds of front and back faces. Front faces are drawn first: they hide most back faces, which then need not
    /// be drawn.
    sides: [Vec<TriangleBounds>; 2],
    /// The number of pixels in the bounds of the triangles whose first row is in this tile.
    pixels: usize,
}

const FRONTS: usize = 0;
const BACKS: usize = 1;

impl Bins {
    /// Sorts the triangles whose ids are below `count` into the tiles of these rows. `bounds_of` returns the bounds of
    /// a triangle, and true if it seems to be front-facing.
    pub fn new(
        rows: &Range<usize>,
        count: usize,
        bounds_of: impl Fn(u32) -> Option<(TriangleBounds, bool)> + Sync,
    ) -> Self {
        const TRIANGLES_PER_PART: usize = 1 << 14;
        let parts = (0..count.div_ceil(TRIANGLES_PER_PART)).into_par_iter();
        let parts = parts.map(|part| {
            let mut bins = vec![TileBin::default(); rows.len().div_ceil(TILE_ROWS)];
            for id in part * TRIANGLES_PER_PART..count.min((part + 1) * TRIANGLES_PER_PART) {
                if let Some((triangle_bounds, is_front)) = bounds_of(id as u32) {
                    let (side, covered) =
                        (if is_front { FRONTS } else { BACKS }, triangle_bounds.rows.range());
                    let [first, last] =
                        [covered.start, covered.end - 1].map(|j| (j - rows.start) / TILE_ROWS);
                    for bin in &mut bins[first..=last] {
                        bin.sides[side].push(triangle_bounds);
                    }
                    bins[first].pixels += triangle_bounds.pixels();
                }
            }
            bins
        });
        Self { rows: rows.clone(), parts: parts.collect() }
    }

    /// Returns the number of pixels in the bounds of all triangles.
    pub fn pixels(&self) -> usize {
        self.parts.iter().flatten().fold(0usize, |pixels, bin| pixels.saturating_add(bin.pixels))
    }

    /// Draws the triangles of each tile, then calls `finish` to draw the other primitives. Returns the id that each
    /// pixel shows. A row has [`Screen::stride`] ids.
    pub fn draw(
        &self,
        screen: Screen,
        edge_functions: impl Fn(u32) -> Option<EdgeFunctions> + Sync,
        finish: impl Fn(&mut Tile) + Sync,
    ) -> Vec<u32> {
        let stride = screen.stride();
        let mut visible_ids = vec![NOTHING; stride * self.rows.len()];
        let tiles = visible_ids.par_chunks_mut(TILE_ROWS * stride).enumerate();
        tiles.for_each(|(k, visible_ids)| {
            let mut tile = Tile::new(screen, self.rows.start + k * TILE_ROWS, stride, visible_ids);
            for side in [FRONTS, BACKS] {
                let all = self.parts.iter().flat_map(|bins| &bins[k].sides[side]);
                all.for_each(|bounds| tile.draw(bounds, || edge_functions(bounds.id)));
            }
            finish(&mut tile);
        });
        visible_ids
    }
}
