//! Parts of a picture that fit into a core's cache.

use super::Flip;
use super::filter::{Convolution, LANES};
use glam::{DVec2, DVec3};

/// The largest side of a tile in pixels, a multiple of [`LANES`]. The filters read a border around each tile, which
/// makes smaller tiles slow. With larger tiles, fewer can be skipped because both pictures are equal there.
const LARGEST: usize = 64;

/// A rectangle of a picture, with coordinates from the top left.
#[derive(Clone, Copy, Debug)]
pub struct PictureTile {
    x: usize,
    y: usize,
    pub width: usize,
    pub height: usize,
}

/// Returns tiles of nearly equal size that cover a picture, row by row.
pub fn tiles(width: usize, height: usize) -> impl Iterator<Item = PictureTile> {
    parts(height)
        .flat_map(move |(y, height)| parts(width).map(move |(x, width)| PictureTile { x, y, width, height }))
}

/// Returns the start and length of each part of a side. Parts start at multiples of the number of SIMD lanes, so only
/// the last one may have a remainder.
fn parts(side: usize) -> impl Iterator<Item = (usize, usize)> {
    let count = side.div_ceil(LARGEST);
    let start =
        move |part: usize| if part < count { (side * part / count).next_multiple_of(LANES) } else { side };
    (0..count).map(move |part| (start(part), start(part + 1) - start(part)))
}

/// A tile with the pixels within a radius around it. Beyond the border, the outermost pixels repeat.
#[derive(Debug, PartialEq)]
pub struct PaddedTile {
    radius: usize,
    width: usize,
    pixels: Vec<[u8; 3]>,
}

impl PictureTile {
    /// Returns the tile's part of a picture of this width.
    pub fn window(&self, picture_width: usize, pixels: &[[u8; 3]], radius: usize) -> PaddedTile {
        let around = |start: usize, length: usize, side: usize| {
            (start..start + length + 2 * radius).map(move |at| at.saturating_sub(radius).min(side - 1))
        };
        let rows = around(self.y, self.height, pixels.len() / picture_width);
        let pixels = rows.flat_map(|y| {
            let row = &pixels[y * picture_width..][..picture_width];
            around(self.x, self.width, picture_width).map(|x| row[x])
        });
        PaddedTile { radius, width: self.width + 2 * radius, pixels: pixels.collect() }
    }
}

/// The filtered signals of a tile: planes of one number per pixel.
pub struct FilteredTile {
    /// Y and Cx, and two parts whose sum is Cz.
    colors: [Vec<f64>; 4],
    /// The horizontal and vertical derivatives, of first and second order.
    derivatives: [[Vec<f64>; 2]; 2],
}

impl FilteredTile {
    /// Returns the colour of a pixel in YCxCz.
    pub fn color(&self, pixel: usize) -> DVec3 {
        let [y, cx, cz, more_cz] = self.colors.each_ref().map(|plane| plane[pixel]);
        DVec3::new(y, cx, cz + more_cz)
    }

    /// Returns the strengths of a pixel's edge and point features.
    pub fn features(&self, pixel: usize) -> DVec2 {
        let magnitude = |[across, down]: &[Vec<f64>; 2]| DVec2::new(across[pixel], down[pixel]).length();
        DVec2::from_array(self.derivatives.each_ref().map(magnitude))
    }
}

impl Flip {
    /// Filters the middle of a window.
    pub fn filtered(&self, window: &PaddedTile, tile: &PictureTile) -> FilteredTile {
        let colors: Vec<DVec3> = window.pixels.iter().map(|&rgb| self.colors.to_ycxcz(rgb)).collect();
        let plane = |value: fn(&DVec3) -> f64| colors.iter().map(value).collect::<Vec<f64>>();
        let [y, cx, cz] = [plane(|color| color.x), plane(|color| color.y), plane(|color| color.z)];
        let luminance = plane(|color| (color.x + 16.0) / 116.0);
        let filtered = |plane: &[f64], across: &Convolution, down: &Convolution| {
            separable(plane, window, tile, [across, down])
        };
        let ([for_y, for_cx], [for_cz, for_more_cz]) = (&self.spatial.gaussians, &self.spatial.blue_yellow);
        let gaussian = &self.features.gaussian;
        FilteredTile {
            colors: [(&y, for_y), (&cx, for_cx), (&cz, for_cz), (&cz, for_more_cz)]
                .map(|(plane, kernel)| filtered(plane, kernel, kernel)),
            derivatives: self.features.derivatives.each_ref().map(|derivative| {
                [filtered(&luminance, derivative, gaussian), filtered(&luminance, gaussian, derivative)]
            }),
        }
    }
}

/// Applies a filter along rows and one along columns to the tile's pixels.
fn separable(
    plane: &[f64],
    window: &PaddedTile,
    tile: &PictureTile,
    [across, down]: [&Convolution; 2],
) -> Vec<f64> {
    let [left, top] = [across, down].map(|kernel| window.radius - kernel.radius());
    let mut rows = vec![0.0; tile.width * (tile.height + 2 * down.radius())];
    let windows = plane[top * window.width..].chunks_exact(window.width);
    for (row, values) in rows.chunks_exact_mut(tile.width).zip(windows) {
        across.convolve(&values[left..], 1, row);
    }
    let mut filtered = vec![0.0; tile.width * tile.height];
    for (row, y) in filtered.chunks_exact_mut(tile.width).zip(0..) {
        down.convolve(&rows[y * tile.width..], tile.width, row);
    }
    filtered
}
