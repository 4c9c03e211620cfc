//! A bounding volume hierarchy over boxes.
//!
//! [`Bvh`] knows boxes and rays, not shapes: what happens at a box is a closure. It serves the
//! triangles of a mesh and the surfaces of a world alike.
//!
//! * `build`: surface area heuristic \[Wald2007, binned\], in parallel. Every decision depends on the
//!   boxes and their order alone, so the tree is the same for any number of threads.
//! * `traverse`: front to back, for the closest or for any hit.
//! * `wide`: the same with sixteen children a node, tested all at once.
//! * `validate`: the check that a tree is well formed.
//!
//! Boxes are stored grown by [`GROWTH`] of their largest coordinate. Leaf work may therefore
//! report points that lie outside its own box by rounding, and a ray that starts on a flat box,
//! to rounding, still visits it.

mod aabb;
mod build;
#[cfg(test)]
pub(crate) mod random;
pub(crate) mod rounding;
mod traverse;
mod validate;
mod wide;

pub use aabb::{Aabb, SlabRay};
pub use validate::BvhError;
pub(crate) use wide::{Visit, WideBvh};

/// By how much a box is grown, as a fraction of its largest coordinate.
pub const GROWTH: f64 = 128.0 * f64::EPSILON;

/// Beyond this depth ranges are halved by count.
const SAH_DEPTH: usize = 48;

/// No tree is deeper: halving 2^32 items takes 32 more levels.
const MAX_DEPTH: usize = SAH_DEPTH + 33;

/// A bounding volume hierarchy over numbered boxes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bvh {
    /// Depth first; the first child of an inner node follows it. The root is node 0.
    nodes: Vec<Node>,
    /// Item numbers, in the order in which leaves name them.
    items: Vec<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    bounds: Aabb,
    /// Inner node: index of the second child. Leaf: first place in `items`.
    first: u32,
    /// Number of items; 0 for an inner node.
    count: u32,
}

/// A node of a [`Bvh`], for backends that walk it in a way of their own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BvhNode<'a> {
    /// Two children, the first of which is the next node.
    Inner {
        /// Around both, grown by [`GROWTH`].
        bounds: Aabb,
        /// Place of the second child.
        second: u32,
    },
    /// Some items.
    Leaf {
        /// Around them, grown by [`GROWTH`].
        bounds: Aabb,
        /// Their numbers, at least one.
        items: &'a [u32],
    },
}

impl Bvh {
    /// The nodes, depth first; the root comes first.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = BvhNode<'_>> {
        self.nodes.iter().map(|&Node { bounds, first, count }| match count {
            0 => BvhNode::Inner { bounds, second: first },
            _ => BvhNode::Leaf { bounds, items: &self.items[first as usize..][..count as usize] },
        })
    }

    /// Number of items.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether there is nothing to hit.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// The box around everything, grown by [`GROWTH`]; empty for an empty tree.
    pub fn bounds(&self) -> Aabb {
        self.nodes.first().map_or(Aabb::EMPTY, |root| root.bounds)
    }

    /// Items under a node.
    fn below(&self, node: u32) -> &[u32] {
        let (mut first, mut last) = (node, node);
        while self.nodes[first as usize].count == 0 {
            first += 1;
        }
        while self.nodes[last as usize].count == 0 {
            last = self.nodes[last as usize].first;
        }
        let (first, last) = (&self.nodes[first as usize], &self.nodes[last as usize]);
        &self.items[first.first as usize..(last.first + last.count) as usize]
    }

    /// Memory held, in bytes.
    pub fn bytes(&self) -> u64 {
        (size_of_val(self.nodes.as_slice()) + size_of_val(self.items.as_slice())) as u64
    }
}
