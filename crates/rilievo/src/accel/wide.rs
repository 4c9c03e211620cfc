//! [`WideBvh`]: a hierarchy of sixteen children a node, for shapes in a frame of their own.
//!
//! It is made from a [`Bvh`] of one item a leaf (`opened`). Boxes are `f32` and tested all at once.
//!
//! **Tried and dropped**: boxes along axes of each node's own, by the mean direction in which its columns rise. On Spot and a
//! torus a ray enters a fifth to a third fewer prisms then, and turning rays costs as much.
//!
//! **Rounding.** With coordinates of boxes and of the ray's start up to `reach` and `u = 2^-24`: rounding a box, the
//! start and the direction moves a point of the ray against a face by at most `4 u reach` each for
//! parameters that stay in the frame; the computed parameter of a face is the exact one of a face moved by `4 u` of its distance,
//! at most `8 u reach`; a component of the direction below `2^-30` of the largest is taken for that, which
//! moves points by less. So boxes are grown by `32 u reach`. Parameters are compared with a limit that is
//! rounded up.

use super::{Aabb, Bvh};
use crate::probe::Probe;
use crate::ray::Ray;
use crate::simd::{Lanes, WIDTH};

/// Marks a child that is an item.
const ITEM: u32 = 1 << 31;

/// A child that is not there.
const NONE: u32 = u32::MAX;

/// By how much boxes are grown, as a share of the reach.
const GROWN: f64 = 32.0 / (1 << 24) as f64;

/// Sixteen children, side by side.
#[derive(Clone, Debug)]
struct Node {
    /// Smallest corners by axis.
    low: [[f32; WIDTH]; 3],
    /// Largest corners by axis.
    high: [[f32; WIDTH]; 3],
    children: [u32; WIDTH],
}

/// A hierarchy of sixteen children a node.
#[derive(Clone, Debug, Default)]
pub(crate) struct WideBvh {
    nodes: Vec<Node>,
    bounds: Option<Aabb>,
}

/// What happens at an item.
pub(crate) trait Visit<P> {
    /// Says that an item may be visited soon. Must be `#[inline(always)]`.
    #[inline(always)]
    fn approach<L: Lanes>(&self, _item: u32) {}

    /// Visits an item; the new limit of the parameter, or none to end the walk. Must be
    /// `#[inline(always)]`.
    fn visit<L: Lanes>(&mut self, item: u32, probe: &mut P) -> Option<f64>;
}

impl WideBvh {
    /// A tree over items, numbers below `2^31`, in boxes, whose coordinates, and those of rays' starts, are at most `reach`.
    ///
    /// # Panics
    /// If there are `2^31` boxes or more.
    pub fn build(items: &[(u32, Aabb)], reach: f64) -> Self {
        let boxes: Vec<Aabb> = items.iter().map(|&(_, bounds)| bounds).collect();
        let tree = Bvh::build(&boxes, 1);
        let mut wide = Self { nodes: Vec::new(), bounds: None };
        if tree.nodes.is_empty() {
            return wide;
        }
        wide.bounds = Some(tree.bounds());
        let grown = GROWN * reach;
        // Places in `nodes` beside the binary nodes they are made from.
        wide.nodes.push(Node::EMPTY);
        let mut waiting = vec![(0usize, 0u32)];
        while let Some((place, from)) = waiting.pop() {
            let children = opened(&tree, from);
            for (lane, &child) in children.iter().enumerate() {
                let node = &tree.nodes[child as usize];
                let bounds = node.bounds.grown(grown);
                for axis in 0..3 {
                    let out = &mut wide.nodes[place];
                    out.low[axis][lane] = (bounds.min[axis] as f32).next_down();
                    out.high[axis][lane] = (bounds.max[axis] as f32).next_up();
                }
                wide.nodes[place].children[lane] = if node.count > 0 {
                    ITEM | items[tree.items[node.first as usize] as usize].0
                } else {
                    waiting.push((wide.nodes.len(), child));
                    wide.nodes.push(Node::EMPTY);
                    wide.nodes.len() as u32 - 1
                };
            }
        }
        wide
    }

    /// The box around everything; empty for an empty tree.
    pub fn bounds(&self) -> Aabb {
        self.bounds.unwrap_or(Aabb::EMPTY)
    }

    /// Memory held, in bytes.
    pub fn bytes(&self) -> u64 {
        size_of_val(self.nodes.as_slice()) as u64
    }

    /// Visits items whose boxes the ray may meet within `[0, t_max]`, nearer nodes first, until a
    /// visit ends the walk or lowers the limit so that nothing is left.
    #[inline(always)]
    pub fn walk<L: Lanes, P: Probe>(&self, ray: &Ray, visitor: &mut impl Visit<P>, probe: &mut P) {
        if self.nodes.is_empty() {
            return;
        }
        let largest = ray.direction.abs().max_element();
        let least = largest / f64::from(1 << 30);
        let (mut start, mut inverse) = ([0.0f32; 3], [0.0f32; 3]);
        for axis in 0..3 {
            let d = ray.direction[axis];
            // In lengths of the largest component, so that no scale overflows.
            let d = (if d.abs() < least { least } else { d }) / largest;
            start[axis] = ray.origin[axis] as f32;
            inverse[axis] = 1.0 / d as f32;
        }
        // Above what rounding may take away.
        let rounded =
            |t: f64| (t * largest) as f32 * (1.0 + 2.0 * f32::EPSILON) + f32::MIN_POSITIVE;
        let mut t_max = ray.t_max;
        let mut limit = rounded(t_max);
        let line = Line { start, inverse };
        if let [only] = self.nodes.as_slice() {
            probe.node();
            let (mut hits, near) = only.entered::<L>(&line, limit);
            while hits != 0 {
                let lane = nearest(hits, &near);
                if near[lane] > limit {
                    return;
                }
                hits &= !(1 << lane);
                match visitor.visit::<L>(only.children[lane] & !ITEM, probe) {
                    Some(t_max) => limit = rounded(t_max),
                    None => return,
                }
            }
            return;
        }
        let mut waiting = Waiting { near: [Entry::NONE; NEAR], len: 0, rest: Vec::new() };
        let mut index = 0;
        loop {
            if index & ITEM != 0 {
                match visitor.visit::<L>(index & !ITEM, probe) {
                    Some(lower) => t_max = if lower < t_max { lower } else { t_max },
                    None => return,
                }
                limit = rounded(t_max);
            } else {
                probe.node();
                let node = &self.nodes[index as usize];
                let (mut hits, near) = node.entered::<L>(&line, limit);
                let count = hits.count_ones() as usize;
                let mut four = [Entry::NONE; 4];
                for entry in &mut four {
                    let lane = hits.trailing_zeros() as usize % WIDTH;
                    let child = node.children[lane];
                    // Of no use for a child that is no item, but to jump over it would cost more.
                    visitor.approach::<L>(child & !ITEM);
                    *entry = Entry::new(child, near[lane]).only_if(hits != 0);
                    hits &= hits.wrapping_sub(1);
                }
                let first = waiting.push(four, count);
                while hits != 0 {
                    let lane = hits.trailing_zeros() as usize % WIDTH;
                    hits &= hits - 1;
                    let child = node.children[lane];
                    visitor.approach::<L>(child & !ITEM);
                    waiting.insert(first, Entry::new(child, near[lane]));
                }
            }
            index = loop {
                match waiting.pop() {
                    Some(entry) if entry.t() <= limit => break entry.child(),
                    Some(_) => {}
                    None => return,
                }
            };
        }
    }
}

/// Children kept without memory of their own; at least twice [`WIDTH`].
const NEAR: usize = 64;

/// A child and where its box is entered, as one number: the larger, the farther. Bits of floats that
/// are not negative are in order.
#[derive(Clone, Copy)]
struct Entry(u64);

impl Entry {
    /// None; less than any other.
    const NONE: Self = Self(0);

    #[inline(always)]
    fn new(child: u32, t: f32) -> Self {
        Self(u64::from(t.to_bits()) << 32 | u64::from(child))
    }

    /// Itself or [`Entry::NONE`], without a jump.
    #[inline(always)]
    fn only_if(self, is: bool) -> Self {
        Self(self.0 & u64::from(is).wrapping_neg())
    }

    #[inline(always)]
    fn child(self) -> u32 {
        self.0 as u32
    }

    #[inline(always)]
    fn t(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }
}

/// The larger first.
#[inline(always)]
fn falling(a: Entry, b: Entry) -> (Entry, Entry) {
    (Entry(a.0.max(b.0)), Entry(a.0.min(b.0)))
}

/// Children still to visit, the next one last.
struct Waiting {
    near: [Entry; NEAR],
    len: usize,
    /// Those that come after all in `near`.
    rest: Vec<Entry>,
}

impl Waiting {
    /// Adds up to four children of a node of `count`, in order, the nearest last; says where they begin. There is
    /// room for the others. It compares without jumps, which would be guessed wrong every other time.
    #[inline(always)]
    fn push(&mut self, [a, b, c, d]: [Entry; 4], count: usize) -> usize {
        if self.len + WIDTH > NEAR {
            self.rest.extend_from_slice(&self.near[..self.len]);
            self.len = 0;
        }
        let ((a, b), (c, d)) = (falling(a, b), falling(c, d));
        let ((a, c), (b, d)) = (falling(a, c), falling(b, d));
        let (b, c) = falling(b, c);
        let first = self.len;
        for (k, entry) in [a, b, c, d].into_iter().enumerate() {
            self.near[(first + k) % NEAR] = entry;
        }
        self.len = first + count.min(4);
        first
    }

    /// Inserts a child so that those from `first` on are in order, the nearest last.
    #[inline(always)]
    fn insert(&mut self, first: usize, entry: Entry) {
        let mut nearer = entry;
        for at in first..self.len {
            let (farther, other) = falling(self.near[at % NEAR], nearer);
            (self.near[at % NEAR], nearer) = (farther, other);
        }
        self.near[self.len % NEAR] = nearer;
        self.len += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Entry> {
        match self.len.checked_sub(1) {
            Some(last) => {
                self.len = last;
                Some(self.near[last % NEAR])
            }
            None => self.rest.pop(),
        }
    }
}

/// A ray in single precision.
struct Line {
    start: [f32; 3],
    /// Of the direction in lengths of its largest component.
    inverse: [f32; 3],
}

/// The lane of least entry among those whose bits are set, at least one.
#[inline(always)]
fn nearest(hits: u16, near: &[f32; WIDTH]) -> usize {
    let mut lane = hits.trailing_zeros() as usize % WIDTH;
    let mut rest = hits & hits.wrapping_sub(1);
    while rest != 0 {
        let other = rest.trailing_zeros() as usize % WIDTH;
        rest &= rest - 1;
        if near[other] < near[lane] {
            lane = other;
        }
    }
    lane
}

impl Node {
    /// No children: boxes that no ray meets.
    const EMPTY: Self =
        Self { low: [[f32::MAX; WIDTH]; 3], high: [[f32::MIN; WIDTH]; 3], children: [NONE; WIDTH] };

    /// A bit for each child that a ray may meet up to `limit`, and where it enters them.
    #[inline(always)]
    fn entered<L: Lanes>(&self, line: &Line, limit: f32) -> (u16, [f32; WIDTH]) {
        let mut near = L::splat(0.0);
        let mut far = L::splat(limit);
        for axis in 0..3 {
            let (start, inverse) = (L::splat(line.start[axis]), L::splat(line.inverse[axis]));
            let forward = line.inverse[axis] >= 0.0;
            let (low, high) = (&self.low[axis], &self.high[axis]);
            let (enter, leave) = if forward { (low, high) } else { (high, low) };
            near = near.larger(L::load(enter).minus(start).times(inverse));
            far = far.smaller(L::load(leave).minus(start).times(inverse));
        }
        (L::bits(near.at_most(far)), near.store())
    }
}

/// Up to sixteen nodes that together make a binary node. Those of more than sixteen items are opened
/// first, those with the largest surface before others; then what fits is opened whole, the smallest
/// first, so that few nodes are nearly empty.
fn opened(tree: &Bvh, from: u32) -> Vec<u32> {
    let mut open = vec![from];
    let is_item = |node: u32| tree.nodes[node as usize].count > 0;
    let area = |node: u32| tree.nodes[node as usize].bounds.surface_area();
    while open.len() < WIDTH {
        let large = (0..open.len()).filter(|&at| tree.below(open[at]).len() > WIDTH);
        let Some(at) = large.max_by(|&a, &b| area(open[a]).total_cmp(&area(open[b]))) else {
            break;
        };
        let child = open[at];
        open[at] = child + 1;
        open.push(tree.nodes[child as usize].first);
    }
    loop {
        let small = (0..open.len()).filter(|&at| !is_item(open[at]));
        let least = small.min_by_key(|&at| tree.below(open[at]).len());
        let Some(at) = least.filter(|&at| open.len() - 1 + tree.below(open[at]).len() <= WIDTH)
        else {
            return open;
        };
        let mut inner = vec![open.swap_remove(at)];
        while let Some(node) = inner.pop() {
            match is_item(node) {
                true => open.push(node),
                false => inner.extend([tree.nodes[node as usize].first, node + 1]),
            }
        }
    }
}

#[cfg(test)]
mod tests;
