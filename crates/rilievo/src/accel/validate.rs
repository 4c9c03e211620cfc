//! The check that a tree is well formed.

use thiserror::Error;

use super::{Aabb, Bvh, MAX_DEPTH};

/// What is wrong with a tree.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum BvhError {
    /// A child index points outside the nodes or not forwards.
    #[error("node {0} names a child that does not follow it")]
    Child(u32),
    /// A leaf names a range outside the items, or has too many.
    #[error("leaf {0} has a bad range of items")]
    Leaf(u32),
    /// A box is not inside the box of its parent.
    #[error("the box of node {0} does not hold its content")]
    Bounds(u32),
    /// An item is missing, or named twice.
    #[error("item {0} is not named exactly once")]
    Item(u32),
    /// A node is named by no parent or by two.
    #[error("node {0} is not reached exactly once")]
    Node(u32),
    /// The tree is deeper than traversal can hold.
    #[error("node {0} is too deep")]
    Depth(u32),
}

impl Bvh {
    /// Checks that every item is in exactly one leaf, every node holds its children or items, the
    /// order is depth first, leaves hold at most `leaf_items` items, and the depth is bounded.
    /// `boxes` are those the tree was built from.
    ///
    /// # Errors
    /// The first violation met.
    pub fn validate(&self, boxes: &[Aabb], leaf_items: u32) -> Result<(), BvhError> {
        let mut named = vec![false; boxes.len()];
        let mut reached = vec![false; self.nodes.len()];
        let mut waiting = Vec::new();
        if !self.nodes.is_empty() {
            waiting.push((0u32, 0usize));
        }
        while let Some((index, depth)) = waiting.pop() {
            let node = &self.nodes[index as usize];
            if std::mem::replace(&mut reached[index as usize], true) {
                return Err(BvhError::Node(index));
            }
            if depth > MAX_DEPTH {
                return Err(BvhError::Depth(index));
            }
            if node.count == 0 {
                for child in [index + 1, node.first] {
                    let Some(below) = self.nodes.get(child as usize).filter(|_| child > index)
                    else {
                        return Err(BvhError::Child(index));
                    };
                    if !node.bounds.contains(&below.bounds) {
                        return Err(BvhError::Bounds(index));
                    }
                    waiting.push((child, depth + 1));
                }
                continue;
            }
            let first = node.first as usize;
            let items = self.items.get(first..first + node.count as usize);
            let Some(items) = items.filter(|items| items.len() <= leaf_items as usize) else {
                return Err(BvhError::Leaf(index));
            };
            for &item in items {
                match named.get_mut(item as usize) {
                    Some(seen) if !*seen => *seen = true,
                    _ => return Err(BvhError::Item(item)),
                }
                if !node.bounds.contains(&boxes[item as usize]) {
                    return Err(BvhError::Bounds(index));
                }
            }
        }
        match (named.iter().position(|seen| !seen), reached.iter().position(|seen| !seen)) {
            (Some(item), _) => Err(BvhError::Item(item as u32)),
            (_, Some(node)) => Err(BvhError::Node(node as u32)),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn sound() -> (Vec<Aabb>, Bvh) {
        let boxes: Vec<Aabb> = (0..8)
            .map(|i| f64::from(i) * DVec3::X)
            .map(|p| Aabb { min: p, max: p + 0.5 })
            .collect();
        let tree = Bvh::build(&boxes, 1);
        (boxes, tree)
    }

    #[test]
    fn every_kind_of_damage_is_found() {
        let (boxes, tree) = sound();
        assert_eq!(tree.validate(&boxes, 1), Ok(()));
        let leaf = tree.nodes.iter().position(|n| n.count > 0).expect("a leaf");
        let damaged = |damage: &dyn Fn(&mut Bvh)| {
            let mut bad = tree.clone();
            damage(&mut bad);
            bad.validate(&boxes, 1).expect_err("damaged")
        };
        assert_eq!(damaged(&|b| b.nodes[0].first = 99), BvhError::Child(0));
        assert_eq!(damaged(&|b| b.nodes[0].first = 0), BvhError::Child(0));
        assert_eq!(damaged(&|b| b.nodes[leaf].count = 2), BvhError::Leaf(leaf as u32));
        assert_eq!(damaged(&|b| b.nodes[leaf].first = 99), BvhError::Leaf(leaf as u32));
        assert!(matches!(damaged(&|b| b.items[0] = b.items[1]), BvhError::Item(_)));
        assert!(matches!(damaged(&|b| b.items.swap(0, 7)), BvhError::Bounds(_)));
        assert!(matches!(damaged(&|b| b.nodes[leaf].bounds.max.x -= 0.3), BvhError::Bounds(_)));
        assert!(matches!(damaged(&|b| b.nodes[0].first = 1), BvhError::Node(_)));
        assert_eq!(tree.validate(&boxes[..7], 1), Err(BvhError::Item(7)));
        let bad = Bvh { nodes: tree.nodes.clone(), items: vec![0; 8] };
        assert!(bad.validate(&[boxes[0].union(boxes[7]); 8], 1).is_err());
    }
}
