use super::*;
use crate::base::patience::Endless;
use crate::caster::block::NONE;
use crate::caster::box8::PADDING;
use crate::caster::division::Bounds;
use crate::math::aabb::Aabb;
use crate::world::test_worlds::world_of_triangles;
use glam::DVec3;

/// Returns a world of triangles. `triangle` gives the corner and the size of each by its number.
fn world(count: u32, triangle: impl Fn(u32) -> (DVec3, f64)) -> World {
    let corners =
        |(corner, size): (DVec3, f64)| [DVec3::ZERO, DVec3::X, DVec3::Y].map(|side| corner + size * side);
    world_of_triangles((0..count).map(triangle).map(corners), &[])
}

/// A tree with the contents of its leaves.
type Grown = (Tree, Contents);

fn grown(world: &World) -> Grown {
    Tree::new(world, (0..world.triangles.len() as u32).collect(), frame(), &Endless).unwrap()
}

/// Appends the ids in the leaves of a branch, and returns the number of levels of nodes.
fn ids_under(grown: &Grown, branch: Branch, ids: &mut Vec<u32>) -> usize {
    if branch >= LEAF {
        let leaf = grown.1.blocks[(branch - LEAF) as usize].ids;
        assert!(leaf.is_sorted());
        ids.extend(leaf.into_iter().filter(|&id| id != NONE));
        return 0;
    }
    if branch >= SMALL {
        return ids_under(grown, grown.0.small[(branch - SMALL) as usize].branch, ids);
    }
    let node = &grown.0.nodes[branch as usize];
    // The root is no other node's child.
    let levels = node.children.into_iter().filter(|&child| child != 0).map(|branch| {
        let mut below = vec![];
        let levels = ids_under(grown, branch, &mut below);
        assert!(!below.is_empty());
        ids.extend(below);
        levels
    });
    1 + levels.max().unwrap_or(0)
}

fn frame() -> Frame {
    Frame::new(&Aabb { min: DVec3::ZERO, max: DVec3::ONE })
}

/// Checks that every primitive is in one leaf, and returns the number of levels and of primitives per leaf.
fn shape(world: &World) -> (usize, f64) {
    let all: Vec<u32> = (0..world.triangles.len() as u32).collect();
    let grown = grown(world);
    let mut ids = vec![];
    let levels = ids_under(&grown, grown.0.root, &mut ids);
    ids.sort_unstable();
    assert_eq!(ids, all);
    (levels, all.len() as f64 / grown.1.blocks.len() as f64)
}

fn scattered(i: u32) -> (DVec3, f64) {
    ((DVec3::new(0.618, 0.754, 0.569) * f64::from(i)).fract(), 0.01)
}

#[test]
fn every_primitive_is_in_one_leaf_and_leaves_are_more_than_half_full() {
    for count in [1, 8, 9, 64, 65, 1000, 5000] {
        let (levels, per_leaf) = shape(&world(count, scattered));
        let least = (0..).find(|&levels| LANES.pow(levels + 1) >= count as usize).unwrap() as usize;
        assert!((least..least + 4).contains(&levels), "{count}: {levels}");
        assert!(count < 100 || per_leaf > 4.0, "{count}: {per_leaf}");
    }
}

/// No plane divides identical primitives, and a plane divides off only a few of the shrinking ones.
#[test]
fn the_depth_is_bounded_whatever_the_primitives_are() {
    let identical = world(1000, |_| (DVec3::splat(0.25), 0.5));
    let shrinking = world(1000, |i| (DVec3::ZERO, libm::exp2(-f64::from(i) / 4.0)));
    for (name, world) in [("identical", identical), ("shrinking", shrinking)] {
        let (levels, per_leaf) = shape(&world);
        assert!(levels <= 12 && per_leaf > 4.0, "{name}: {levels} levels, {per_leaf} per leaf");
    }
}

#[test]
fn a_branch_of_small_primitives_has_a_frame_of_its_own() {
    let two_sizes = world(2000, |i| match i % 2 {
        0 => (0.6 + 1e-5 * scattered(i).0, 1e-7),
        _ => scattered(i),
    });
    let grown = grown(&two_sizes);
    let mut ids = vec![];
    for small in &grown.0.small {
        assert!(small.region.frame.scale > 1000.0);
        ids_under(&grown, small.branch, &mut ids);
    }
    assert!(ids.iter().filter(|&id| id % 2 == 0).count() > 950, "{}", ids.len());
    assert!(ids.iter().filter(|&id| id % 2 == 1).count() < 10);
    for (i, block) in grown.1.blocks.iter().enumerate() {
        // All primitives are triangles, so each leaf has a block.
        let is_around = grown.0.small.iter().any(|small| small.leaves.contains(&i));
        assert_eq!(is_around, ids.contains(&block.ids[0]), "{i}");
        // The coordinates are at most 1 in the frame.
        let largest = block.corner.as_flattened().iter().fold(0.0f32, |largest, x| largest.max(x.abs()));
        assert!(largest <= 1.0, "{largest}");
    }
    assert!(self::grown(&world(2000, scattered)).0.small.is_empty());
}

#[test]
fn items_have_padded_boxes_in_the_frame() {
    let bounds = Aabb { min: DVec3::new(0.25, 0.0, 0.5), max: DVec3::new(0.5, 0.75, 1.0) };
    let Item { bounds: Bounds { min, max }, id } = Item::new(&frame(), &bounds, 7);
    let padding = PADDING as f32;
    // The frame's middle is the unit cube's, and its unit is the cube's side.
    assert_eq!(min.to_array(), [-0.25 - padding, -0.5 - padding, -padding]);
    assert_eq!(max.to_array(), [padding, 0.25 + padding, 0.5 + padding]);
    assert_eq!(id, 7);
}
