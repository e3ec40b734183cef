use super::*;
use crate::base::patience::Endless;
use crate::world::test_worlds::world_of_triangles;
use glam::DVec3;

/// Returns a world of triangles, each given by its lower corner and its side.
fn world(triangles: impl Iterator<Item = (DVec3, f64)>) -> World {
    let corners = |(corner, side): (DVec3, f64)| {
        [DVec3::new(1.0, 1.0, 0.0), DVec3::Z, DVec3::ZERO].map(|offset| corner + side * offset)
    };
    world_of_triangles(triangles.map(corners), &[])
}

/// Divides all triangles of a world in the frame of a cube around the origin.
fn divided(world: &World, level: usize) -> Division {
    let frame = Frame::new(&Aabb { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) });
    Division::new((world, &Endless), (0..world.triangles.len() as u32).collect(), &frame, level).unwrap()
}

/// The numbers of nodes, of small branches, of levels, and the ids in the leaves.
fn shape(division: &Division) -> (usize, usize, usize, Vec<u32>) {
    match division {
        Division::Leaf(ids) => (0, 0, 0, ids.to_vec()),
        Division::Small(inner) => {
            let (nodes, small, levels, ids) = shape(&inner.1);
            (nodes, small + 1, levels, ids)
        }
        Division::Node(branches) => {
            assert!((2..=LANES).contains(&branches.len()));
            let (mut nodes, mut small, mut levels, mut ids) = (1, 0, 0, vec![]);
            for (_, branch) in branches {
                let (more_nodes, more_small, below, more_ids) = shape(branch);
                (nodes, small, levels) = (nodes + more_nodes, small + more_small, levels.max(below));
                ids.extend(more_ids);
            }
            (nodes, small, levels + 1, ids)
        }
    }
}

#[test]
fn of_many_small_items_a_branch_is_small_unless_there_are_too_many_levels_above_it() {
    let near = (0..100).map(|k| DVec3::splat(0.5) + 1e-5 * DVec3::new(f64::from(k), f64::from(k % 7), 0.0));
    let far = (0..100).map(|k| DVec3::new(-0.5, -0.5, 0.005 * f64::from(k)));
    let world = world(near.chain(far).map(|corner| (corner, 1e-6)));
    for (level, is_small) in [(0, true), (HEURISTIC_LEVELS - 2, true), (HEURISTIC_LEVELS, false)] {
        assert_eq!(shape(&divided(&world, level)).1 > 0, is_small, "{level}");
    }
}

/// The heuristic would divide off the items that are far from the others.
#[test]
fn below_the_levels_of_the_heuristic_items_are_divided_by_their_number() {
    let point = |k: u32| match k {
        0..4 => DVec3::splat(0.9),
        _ => DVec3::new(0.0, 0.0, 1e-3 * f64::from(k)),
    };
    let world = world((0..512).map(|k| (point(k), 0.01)));
    for (level, is_even) in [(0, false), (HEURISTIC_LEVELS, true)] {
        let division = divided(&world, level);
        let Division::Node(branches) = &division else { panic!("there is a node") };
        let leaves = |branch: &(Bounds, Division)| branch.1.leaves();
        assert_eq!(branches.iter().all(|branch| leaves(branch) == LANES), is_even, "{level}");
        assert_eq!((shape(&division).2, division.leaves()) == (2, 64), is_even, "{level}");
    }
}
