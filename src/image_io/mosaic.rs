//! Rectangles that cover another.

use crate::render::Window;

/// The first part of `target` that none of the tiles covers, by rows from the top and then from the left: the columns
/// that lack, in as many rows as lack them all.
pub fn first_gap(tiles: &[Window], target: Window) -> Option<Window> {
    let bottom = target.y + target.height;
    // Between two of these rows, the same tiles cover all rows.
    let mut bounds: Vec<usize> = tiles.iter().flat_map(|tile| [tile.y, tile.y + tile.height]).collect();
    bounds.extend([target.y, bottom]);
    bounds.retain(|y| (target.y..=bottom).contains(y));
    bounds.sort_unstable();
    bounds.dedup();
    let mut bands = bounds.windows(2).map(|band| (band[0], band[1]));
    let (y, [x, end], first_end) =
        bands.find_map(|(y, end)| Some((y, columns_that_lack(tiles, target, y)?, end)))?;
    let lacks_all = |y: usize| tiles.iter().all(|tile| !covers(tile, y) || tile.x >= end || right(tile) <= x);
    let last = bands.take_while(|&(y, _)| lacks_all(y)).last();
    let bottom = last.map_or(first_end, |(_, end)| end);
    Some(Window { x, y, width: end - x, height: bottom - y })
}

/// The first columns of row `y` that no tile covers.
fn columns_that_lack(tiles: &[Window], target: Window, y: usize) -> Option<[usize; 2]> {
    let mut row: Vec<&Window> = tiles.iter().filter(|tile| covers(tile, y)).collect();
    row.sort_unstable_by_key(|tile| tile.x);
    let mut x = target.x;
    for tile in row {
        if tile.x > x {
            return Some([x, tile.x.min(right(&target))]).filter(|[x, end]| x < end);
        }
        x = x.max(right(tile));
    }
    (x < right(&target)).then(|| [x, right(&target)])
}

fn covers(tile: &Window, y: usize) -> bool {
    (tile.y..tile.y + tile.height).contains(&y)
}

fn right(tile: &Window) -> usize {
    tile.x + tile.width
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window([x, y, width, height]: [usize; 4]) -> Window {
        Window { x, y, width, height }
    }

    #[test]
    fn the_first_gap_is_as_large_as_it_can_be() {
        for (tiles, target, gap) in [
            (&[][..], [0, 0, 9, 7], Some([0, 0, 9, 7])),
            (&[[0, 0, 9, 7]], [0, 0, 9, 7], None),
            (&[[0, 0, 9, 3], [0, 3, 9, 4]], [0, 0, 9, 7], None),
            (&[[0, 4, 9, 3], [0, 0, 9, 3]], [0, 0, 9, 7], Some([0, 3, 9, 1])),
            (&[[0, 0, 4, 7], [5, 0, 4, 7]], [0, 0, 9, 7], Some([4, 0, 1, 7])),
            (&[[0, 0, 4, 7], [5, 0, 4, 4], [3, 5, 6, 2]], [0, 0, 9, 7], Some([4, 0, 1, 5])),
            (&[[0, 0, 9, 2], [0, 2, 3, 5], [6, 2, 3, 5], [3, 4, 1, 1]], [0, 0, 9, 7], Some([3, 2, 3, 2])),
            (&[[0, 0, 9, 5], [0, 3, 9, 4]], [0, 0, 9, 7], None),
            (&[[0, 0, 9, 7]], [2, 2, 9, 3], Some([9, 2, 2, 3])),
            (&[[0, 0, 2, 9], [20, 0, 2, 9]], [3, 2, 4, 3], Some([3, 2, 4, 3])),
            (&[[3, 2, 4, 3]], [3, 2, 4, 3], None),
            (&[[0, 0, 8, 7]], [0, 0, 9, 7], Some([8, 0, 1, 7])),
            (&[[0, 0, 9, 3], [0, 6, 9, 1]], [0, 0, 9, 7], Some([0, 3, 9, 3])),
        ] {
            let tiles: Vec<Window> = tiles.iter().copied().map(window).collect();
            assert_eq!(first_gap(&tiles, window(target)), gap.map(window), "{tiles:?}");
        }
    }
}
