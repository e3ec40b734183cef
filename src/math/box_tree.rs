//! A tree of boxes in any number of dimensions: finds those that may meet something, without a look at all of them.

/// A closed box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extents<const D: usize> {
    pub min: [f64; D],
    pub max: [f64; D],
}

impl<const D: usize> Extents<D> {
    const EMPTY: Self = Self { min: [f64::INFINITY; D], max: [f64::NEG_INFINITY; D] };

    /// Returns the smallest box that contains both.
    fn union(self, other: Self) -> Self {
        Self {
            min: std::array::from_fn(|k| self.min[k].min(other.min[k])),
            max: std::array::from_fn(|k| self.max[k].max(other.max[k])),
        }
    }

    /// Returns the box that reaches this much farther to all sides.
    pub fn widened(self, by: f64) -> Self {
        Self { min: self.min.map(|x| x - by), max: self.max.map(|x| x + by) }
    }

    /// Returns true if two boxes have a common point.
    pub fn meets(&self, other: &Self) -> bool {
        (0..D).all(|k| self.min[k] <= other.max[k] && other.min[k] <= self.max[k])
    }
}

/// A node of a tree, or a leaf.
#[derive(Clone, Debug)]
pub struct Node<const D: usize> {
    /// Contains the boxes below the node.
    pub bounds: Extents<D>,
    /// The least index of a box below the node.
    pub first: u32,
    parent: u32,
    below: Below,
}

#[derive(Clone, Debug)]
enum Below {
    /// The start and the end of the leaf's boxes in the list.
    Leaf([u32; 2]),
    /// The two children.
    Children([u32; 2]),
}

/// The tree.
#[derive(Clone, Debug)]
pub struct BoxTree<const D: usize> {
    nodes: Vec<Node<D>>,
    /// The indices of the boxes, leaf by leaf.
    list: Vec<u32>,
    /// The leaf of each box.
    leaves: Vec<u32>,
}

/// The largest number of boxes in a leaf. A leaf with one box is tested like this box.
const MOST_IN_LEAF: usize = 1;

impl<const D: usize> BoxTree<D> {
    /// Builds the tree of some boxes in O(n log n).
    pub fn new(boxes: &[Extents<D>]) -> Self {
        let mut tree =
            Self { nodes: vec![], list: (0..boxes.len() as u32).collect(), leaves: vec![0; boxes.len()] };
        if !boxes.is_empty() {
            tree.add(boxes, [0, boxes.len()], 0);
        }
        tree
    }

    /// Adds the node of a part of the list, and returns its index.
    fn add(&mut self, boxes: &[Extents<D>], [start, end]: [usize; 2], parent: u32) -> u32 {
        let own = &mut self.list[start..end];
        let bounds = own.iter().fold(Extents::EMPTY, |all, &index| all.union(boxes[index as usize]));
        let first = own.iter().copied().min().unwrap_or(u32::MAX);
        let id = self.nodes.len() as u32;
        let below = Below::Leaf([start as u32, end as u32]);
        self.nodes.push(Node { bounds, first, parent, below });
        if end - start <= MOST_IN_LEAF {
            own.iter().for_each(|&index| self.leaves[index as usize] = id);
            return id;
        }
        // Halve the boxes along the axis on which they are spread most.
        let extent = |&k: &usize| bounds.max[k] - bounds.min[k];
        let axis = (0..D).max_by(|i, j| extent(i).total_cmp(&extent(j))).unwrap_or(0);
        let middle = own.len() / 2;
        let center =
            |&index: &u32| 0.5 * boxes[index as usize].min[axis] + 0.5 * boxes[index as usize].max[axis];
        own.select_nth_unstable_by(middle, |one, other| center(one).total_cmp(&center(other)));
        let parts = [[start, start + middle], [start + middle, end]];
        self.nodes[id as usize].below = Below::Children(parts.map(|part| self.add(boxes, part, id)));
        id
    }

    /// Returns the nodes. The root is the first one.
    pub fn nodes(&self) -> &[Node<D>] {
        &self.nodes
    }

    /// Returns the nodes that contain a box, from its leaf up to the root.
    pub fn nodes_of(&self, index: u32) -> impl Iterator<Item = usize> + '_ {
        let mut next = self.leaves.get(index as usize).copied();
        std::iter::from_fn(move || {
            let id = next?;
            next = Some(self.nodes[id as usize].parent).filter(|_| id > 0);
            Some(id as usize)
        })
    }

    /// Calls `take` for the boxes below all nodes for which `enters` returns true. Of two children, the one with the
    /// lower index comes first. Returns the number of nodes and boxes that were looked at.
    pub fn visit(&self, mut enters: impl FnMut(usize, &Node<D>) -> bool, mut take: impl FnMut(u32)) -> usize {
        let (mut steps, mut waiting) = (0, vec![]);
        waiting.extend((!self.nodes.is_empty()).then_some(0));
        while let Some(id) = waiting.pop() {
            steps += 1;
            let node = &self.nodes[id as usize];
            if !enters(id as usize, node) {
                continue;
            }
            match node.below {
                Below::Leaf([start, end]) => {
                    steps += (end - start) as usize;
                    self.list[start as usize..end as usize].iter().for_each(|&index| take(index));
                }
                Below::Children([a, b]) => {
                    let is_ordered = self.nodes[a as usize].first < self.nodes[b as usize].first;
                    waiting.extend(if is_ordered { [b, a] } else { [a, b] });
                }
            }
        }
        steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boxes(count: usize) -> Vec<Extents<2>> {
        let number = |i: usize, step: f64| (i as f64 * step).fract();
        let of = |i: usize| {
            let min = [number(i, 2f64.sqrt()), number(i, 3f64.sqrt())];
            Extents { min, max: [min[0] + 0.02, min[1] + 0.1 * number(i, 5f64.sqrt())] }
        };
        (0..count).map(of).collect()
    }

    #[test]
    fn all_boxes_that_meet_another_are_found_with_few_steps() {
        for count in [0, 1, 4, 5, 9, 100, 1000] {
            let boxes = boxes(count);
            let tree = BoxTree::new(&boxes);
            for wanted in self::boxes(30) {
                let mut found = vec![];
                let steps = tree.visit(
                    |_, node| node.bounds.meets(&wanted),
                    |index| found.extend(boxes[index as usize].meets(&wanted).then_some(index)),
                );
                found.sort_unstable();
                let expected = (0..count as u32).filter(|&i| boxes[i as usize].meets(&wanted));
                assert!(found.iter().copied().eq(expected));
                assert!(steps <= 40 + count / 2, "{count}: {steps}");
            }
        }
    }

    #[test]
    fn a_box_lies_in_the_nodes_from_its_leaf_to_the_root() {
        let boxes = boxes(100);
        let tree = BoxTree::new(&boxes);
        for (index, own) in boxes.iter().enumerate() {
            let nodes: Vec<usize> = tree.nodes_of(index as u32).collect();
            assert!(nodes.len() > 4 && nodes.last() == Some(&0));
            let contains = |&id: &usize| {
                let node = &tree.nodes[id];
                node.bounds == node.bounds.union(*own) && node.first <= index as u32
            };
            assert!(nodes.iter().all(contains));
        }
    }

    #[test]
    fn equal_boxes_make_a_tree_that_is_not_deep() {
        let tree = BoxTree::new(&vec![Extents { min: [1.0], max: [1.0] }; 1000]);
        assert!((0..1000).all(|index| tree.nodes_of(index).count() <= 11));
    }
}
