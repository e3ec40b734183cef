use super::*;
use glam::DVec2;

const WIDTH: usize = 200;
const STRIDE: usize = WIDTH + LANES;

const SCREEN: Screen = Screen {
    middle: DVec2::new(99.5, 40.5),
    width: WIDTH,
    reach: 0.0,
    nothing: 0.0,
    same_place: ErrorBound::NONE,
};

/// Returns an inverse depth with this value at a pixel and these slopes. It may be 0 outside the picture.
fn inv_depth(value: f64, [x, y]: [f64; 2], per_pixel: [f64; 2]) -> InvDepthPlane {
    let [per_x, per_y] = per_pixel;
    let inv_depth = Affine { constant: value - per_x * x - per_y * y, per_x, per_y };
    InvDepthPlane { inv_depth, error_bound: ErrorBound([0.0; 3]) }
}

/// Checks that the tile knows each of these pixels, and holds an interval there that contains the inverse depth.
fn check_intervals(tile: &Tile, plane: &InvDepthPlane, columns: Range<usize>, rows: Range<usize>) {
    let middle = tile.screen.middle;
    for (i, j) in rows.flat_map(|j| columns.clone().map(move |i| (i, j))) {
        let exact = plane.inv_depth.at(i as f64 - middle.x, j as f64 - middle.y);
        let k = (j - tile.rows.start) * STRIDE + i;
        let [min, max] = [tile.min_inv_depths[k], tile.max_inv_depths[k]].map(f64::from);
        assert_eq!(tile.visible_ids[k], 7, "{i} {j}");
        assert!(min < exact && exact < max, "{i} {j}: {min} {exact} {max}");
    }
}

/// The error bound of single precision depends on the values inside the triangle, at any distance from the middle of
/// the picture.
#[test]
fn the_inverse_depth_of_a_triangle_is_within_its_interval_wherever_it_is() {
    for (k, per_pixel) in (1..400).zip([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]].into_iter().cycle())
    {
        let (i, j) = (37 * k % (WIDTH - 2), 32 + 7 * k % 31);
        let [x, y] = [i as f64 - 99.5, j as f64 - 40.5];
        // Zero at points that a wrong sign would use: (-x, y), (x, -y), and the point opposite the middle.
        let per_pixel = per_pixel.map(|p: f64| p * (0.37 + 0.01 * k as f64));
        let quotients = [0.5 * (x - i as f64 / 99.5).abs(), 0.5 * (y - j as f64 / 40.5).abs()];
        for value in [[99.5, 40.5], [199.0, 81.0], [x.abs(), y.abs()], quotients].map(|[across, up]| {
            (per_pixel[0].abs() * 2.0 * across + per_pixel[1].abs() * 2.0 * up)
                .max(2.0 * per_pixel[0].abs())
                .max(0.5)
        }) {
            let plane = inv_depth(value, [x, y], per_pixel);
            let edges = [Affine { constant: 1.0, per_x: 0.0, per_y: 0.0 }; 3];
            let mut visible_ids = vec![UNSURE; 32 * STRIDE];
            let mut tile = Tile::new(SCREEN, 32, STRIDE, &mut visible_ids);
            let edge_functions = EdgeFunctions { edges, edge_error_bound: 0.0, inv_depth_plane: plane };
            tile.rasterize(&edge_functions, i..i + 2, j..j + 1, 7);
            check_intervals(&tile, &edge_functions.inv_depth_plane, i..i + 2, j..j + 1);
        }
    }
}

/// The pictures are so high that the rows are far from the middle.
#[test]
fn the_inverse_depth_of_a_plane_is_within_its_interval_in_every_row() {
    let middle = 4000.0;
    let screen = Screen { middle: DVec2::new(99.5, middle), ..SCREEN };
    for (k, first_row) in (1..40).zip([0, 1600, 3200, 4800, 7968].into_iter().cycle()) {
        let y = first_row as f64 - middle;
        // Zero on a row that a bound would be taken from if a sign or an operator were wrong.
        for zero in [y + 2.0 * middle, -y, first_row as f64 / middle, 0.0] {
            let per_y = (0.37 + 0.01 * f64::from(k)) * (y - zero).signum();
            let plane = inv_depth(per_y * (y - zero), [0.0, y], [1e-3, per_y]);
            if per_y * (y + 31.0 - zero) < 1.0 || per_y * (y - zero) < 1.0 {
                continue;
            }
            let mut visible_ids = vec![UNSURE; 32 * STRIDE];
            let mut tile = Tile::new(screen, first_row, STRIDE, &mut visible_ids);
            tile.fill(&plane, 7);
            check_intervals(&tile, &plane, 0..WIDTH, first_row..first_row + 32);
        }
    }
}
