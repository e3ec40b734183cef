use super::*;
use crate::caster::block::Frame;
use crate::math::aabb::Aabb;
use crate::math::worst_case::Rng;
use glam::DVec3;
use std::collections::HashMap;

/// Returns cubic items with this side. `corners` are their lower corners.
fn items(corners: impl Iterator<Item = DVec3>, side: f64) -> Vec<Item> {
    let frame = Frame::new(&Aabb { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) });
    corners.zip(0..).map(|(min, id)| Item::new(&frame, &Aabb { min, max: min + side }, id)).collect()
}

fn scattered(count: u32) -> Vec<Item> {
    let point = |k: u32| (DVec3::new(0.618_034, 0.754_878, 0.569_840_3) * f64::from(k)).fract();
    items((0..count).map(point), 0.01)
}

/// Returns the sum of half the areas of the nodes that are made from a branch, the number of these nodes, and the
/// number of their leaves.
fn nodes_of(tree: &BinaryTree, half: &Half) -> (f32, usize, usize) {
    let mut sums = (half.bounds.half_area(), 1, 0);
    let children = tree.children(half);
    assert!((2..=LANES).contains(&children.len()));
    let mut next = half.items.start;
    for child in children {
        assert_eq!(child.items.start, next);
        next = child.items.end;
        match child.content {
            BranchContent::Halves(_) => {
                let (area, nodes, leaves) = nodes_of(tree, child);
                sums = (sums.0 + area, sums.1 + nodes, sums.2 + leaves);
            }
            _ => sums.2 += 1,
        }
    }
    assert_eq!(next, half.items.end);
    sums
}

/// Returns the least sum of half the areas for the branch with this index, if `count` children may stand for it. Tries
/// every set of children, and stores the results in `known`.
fn least_area(tree: &BinaryTree, index: usize, count: usize, known: &mut Known) -> f32 {
    if let Some(&area) = known.get(&(index, count)) {
        return area;
    }
    let half = &tree.halves[index];
    let BranchContent::Halves([a, b]) = half.content else { return 0.0 };
    let mut among = |count: usize| {
        let mut area =
            |first: usize| least_area(tree, a, first, known) + least_area(tree, b, count - first, known);
        (1..count).map(&mut area).fold(f32::INFINITY, f32::min)
    };
    let least = among(count).min(half.bounds.half_area() + among(LANES));
    known.insert((index, count), least);
    least
}

type Known = HashMap<(usize, usize), f32>;

/// Boxes of random sizes, many of which overlap. In some of these trees a child that stands for both halves is better
/// than two.
#[test]
fn the_nodes_have_the_least_area_of_all_that_the_binary_tree_allows() {
    let rng = &mut Rng(1);
    let frame = Frame::new(&Aabb { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) });
    for count in (0..80).map(|k| 9 + 37 * k) {
        let mut item = |id: u32| {
            let min = 0.5 * rng.vector();
            let extent = DVec3::new(rng.unit(), rng.unit(), rng.unit());
            Item::new(&frame, &Aabb { min, max: min + 0.5 * extent * extent }, id)
        };
        let tree = BinaryTree::new(&mut (0..count).map(&mut item).collect::<Vec<_>>(), 0);
        let (area, ..) = nodes_of(&tree, tree.root());
        let least = least_area(&tree, tree.halves.len() - 1, 1, &mut Known::new());
        assert!((area - least).abs() <= 1e-5 * least, "{count}: {area} {least}");
    }
}

#[test]
fn nodes_are_more_than_half_full() {
    let tree = BinaryTree::new(&mut scattered(5000), 0);
    let (_, nodes, leaves) = nodes_of(&tree, tree.root());
    let children = (nodes - 1 + leaves) as f64 / nodes as f64;
    assert!(children > 5.5, "{children}");
}

#[test]
fn of_many_small_items_a_branch_is_small_unless_there_are_too_many_levels_above_it() {
    let near = (0..100).map(|k| DVec3::splat(0.5) + 1e-5 * DVec3::new(f64::from(k), f64::from(k % 7), 0.0));
    let far = (0..100).map(|k| DVec3::new(-0.5, -0.5, 0.005 * f64::from(k)));
    let mut items = items(near.chain(far), 1e-6);
    for (level, is_small) in [(0, true), (HEURISTIC_LEVELS - 2, true), (HEURISTIC_LEVELS, false)] {
        let tree = BinaryTree::new(&mut items, level);
        let small = tree
            .halves
            .iter()
            .filter(|half| matches!(half.content, BranchContent::Small { level: of } if of > level));
        assert_eq!(small.count() > 0, is_small, "{level}");
    }
}

/// Returns the number of levels below a branch.
fn levels(tree: &BinaryTree, half: &Half) -> usize {
    match half.content {
        BranchContent::Halves(halves) => {
            1 + halves.map(|index| levels(tree, &tree.halves[index])).into_iter().fold(0, usize::max)
        }
        _ => 0,
    }
}

/// The heuristic would divide off the items that are far from the others.
#[test]
fn below_the_levels_of_the_heuristic_items_are_divided_by_their_number() {
    let point = |k: u32| match k {
        0..4 => DVec3::splat(0.9),
        _ => DVec3::new(0.0, 0.0, 1e-3 * f64::from(k)),
    };
    for (level, first) in [(0, 4), (HEURISTIC_LEVELS - 1, 4), (HEURISTIC_LEVELS, 256)] {
        let tree = BinaryTree::new(&mut items((0..500).map(point), 0.01), level);
        let BranchContent::Halves(halves) = tree.root().content else { panic!("the root is not divided") };
        let lengths = halves.map(|index| tree.halves[index].items.len());
        assert_eq!(lengths.into_iter().min(), Some(first.min(500 - first)), "{level}: {lengths:?}");
        assert!(
            level < HEURISTIC_LEVELS || levels(&tree, tree.root()) == 6,
            "{}",
            levels(&tree, tree.root())
        );
    }
}

/// The centre of the large items' boxes is in the middle of the small ones.
#[test]
fn large_items_are_apart_from_small_ones_in_their_middle() {
    let mut items = items((0..500).map(|k| 1e-3 * scattered(k + 1)[k as usize].bounds.min.as_dvec3()), 1e-5);
    let frame = Frame::new(&Aabb { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) });
    let large = Aabb { min: DVec3::new(-0.9, 0.0, -0.9), max: DVec3::new(0.9, 0.0, 0.9) };
    items.extend([500, 501].map(|id| Item::new(&frame, &large, id)));
    let tree = BinaryTree::new(&mut items, 0);
    let BranchContent::Halves(halves) = tree.root().content else { panic!("the root is not divided") };
    let lengths = halves.map(|index| tree.halves[index].items.len());
    assert_eq!(lengths, [2, 500]);
}
