//! Building a [`Bvh`]: surface area heuristic \[Wald2007, binned\], top down.
//!
//! Each range of items is cut on the axis and at the bin border where the expected cost of a ray
//! is least. Where areas are not finite or centres coincide the range is halved by count instead,
//! which also bounds the depth. Ranges above [`PARALLEL`] items build their halves as two tasks;
//! the halves are then joined in order, so the tree does not depend on which ran first.

use glam::DVec3;

use super::{Aabb, Bvh, GROWTH, Node, SAH_DEPTH};

/// Bins along each axis.
const BINS: usize = 16;

/// Smaller ranges are built in one task.
const PARALLEL: usize = 4096;

/// Cost of visiting an inner node, in item tests.
const NODE_COST: f64 = 1.0;

#[derive(Clone, Copy)]
struct Item {
    bounds: Aabb,
    centre: DVec3,
    index: u32,
}

impl Bvh {
    /// Builds a tree over `boxes`; item `i` is `boxes[i]`. A leaf holds up to `leaf_items` items,
    /// at least 1.
    ///
    /// # Panics
    /// If there are `2^31` boxes or more.
    pub fn build(boxes: &[Aabb], leaf_items: u32) -> Self {
        assert!(boxes.len() < 1 << 31, "{} boxes", boxes.len());
        let item = |(index, bounds): (usize, &Aabb)| Item {
            bounds: bounds.grown(GROWTH * bounds.largest_coordinate()),
            centre: bounds.centre(),
            index: index as u32,
        };
        let mut items: Vec<Item> = boxes.iter().enumerate().map(item).collect();
        let mut nodes = Vec::new();
        if !items.is_empty() {
            let range = Range { first: 0, depth: 0, leaf_items: leaf_items.max(1) as usize };
            range.build(&mut items, &mut nodes);
        }
        Self { nodes, items: items.iter().map(|item| item.index).collect() }
    }
}

/// Where a slice of items stands in the whole.
#[derive(Clone, Copy)]
struct Range {
    first: usize,
    depth: usize,
    leaf_items: usize,
}

impl Range {
    /// Appends the subtree over `items` to `nodes`; node indices count from the start of `nodes`.
    fn build(self, items: &mut [Item], nodes: &mut Vec<Node>) {
        let bounds = items.iter().fold(Aabb::EMPTY, |b, item| b.union(item.bounds));
        let at = nodes.len();
        let Some(middle) = self.split(items, &bounds) else {
            nodes.push(Node { bounds, first: self.first as u32, count: items.len() as u32 });
            return;
        };
        nodes.push(Node { bounds, first: 0, count: 0 });
        let left = Self { depth: self.depth + 1, ..self };
        let right = Self { first: self.first + middle, ..left };
        let parallel = items.len() >= PARALLEL;
        let (low, high) = items.split_at_mut(middle);
        if parallel {
            let (mut low_nodes, mut high_nodes) = (Vec::new(), Vec::new());
            rayon::join(|| left.build(low, &mut low_nodes), || right.build(high, &mut high_nodes));
            append(nodes, low_nodes);
            nodes[at].first = nodes.len() as u32;
            append(nodes, high_nodes);
        } else {
            left.build(low, nodes);
            nodes[at].first = nodes.len() as u32;
            right.build(high, nodes);
        }
    }

    /// Orders `items` so that they can be cut in two, and says where; `None` makes a leaf.
    fn split(self, items: &mut [Item], bounds: &Aabb) -> Option<usize> {
        if items.len() == 1 {
            return None;
        }
        let centres = Aabb::around(items.iter().map(|item| item.centre));
        if self.depth < SAH_DEPTH
            && let Some(cut) = Cut::best(items, &centres)
        {
            let area = bounds.surface_area();
            let leaf_cost = items.len() as f64 * area;
            if items.len() <= self.leaf_items && leaf_cost <= NODE_COST * area + cut.cost {
                return None;
            }
            return Some(partition(items, |item| cut.bin(item, &centres) < cut.border));
        }
        if items.len() <= self.leaf_items {
            return None;
        }
        let middle = items.len() / 2;
        let axis = (0.5 * centres.max - 0.5 * centres.min).max_position();
        items.select_nth_unstable_by(middle, |a, b| {
            a.centre[axis].total_cmp(&b.centre[axis]).then(a.index.cmp(&b.index))
        });
        Some(middle)
    }
}

/// A plane between two bins.
#[derive(Clone, Copy)]
struct Cut {
    axis: usize,
    /// First bin of the upper side.
    border: usize,
    /// Sum over both sides of area times count.
    cost: f64,
}

impl Cut {
    /// The cheapest cut with finite cost and items on both sides.
    fn best(items: &[Item], centres: &Aabb) -> Option<Self> {
        let mut best: Option<Self> = None;
        for axis in 0..3 {
            if centres.min[axis] >= centres.max[axis] {
                continue;
            }
            let mut bins = [(0usize, Aabb::EMPTY); BINS];
            for item in items {
                let (count, bounds) = &mut bins[bin(item, axis, centres)];
                *count += 1;
                *bounds = bounds.union(item.bounds);
            }
            let mut below = [0.0; BINS];
            let (mut count, mut bounds) = (0, Aabb::EMPTY);
            for border in 1..BINS {
                count += bins[border - 1].0;
                bounds = bounds.union(bins[border - 1].1);
                below[border] = count as f64 * bounds.surface_area();
            }
            (count, bounds) = (0, Aabb::EMPTY);
            for border in (1..BINS).rev() {
                count += bins[border].0;
                bounds = bounds.union(bins[border].1);
                let cost = below[border] + count as f64 * bounds.surface_area();
                let splits = count > 0 && count < items.len();
                if splits && cost.is_finite() && best.is_none_or(|b| cost < b.cost) {
                    best = Some(Self { axis, border, cost });
                }
            }
        }
        best
    }

    fn bin(self, item: &Item, centres: &Aabb) -> usize {
        bin(item, self.axis, centres)
    }
}

/// The bin of an item; halves are taken first so that nothing overflows.
fn bin(item: &Item, axis: usize, centres: &Aabb) -> usize {
    let low = 0.5 * centres.min[axis];
    let extent = 0.5 * centres.max[axis] - low;
    let fraction = (0.5 * item.centre[axis] - low) / extent;
    ((fraction * BINS as f64) as usize).min(BINS - 1)
}

/// Moves the items that satisfy `low` to the front and returns their number.
fn partition(items: &mut [Item], low: impl Fn(&Item) -> bool) -> usize {
    let mut middle = 0;
    for i in 0..items.len() {
        if low(&items[i]) {
            items.swap(i, middle);
            middle += 1;
        }
    }
    middle
}

/// Appends a finished subtree, moving its node indices.
fn append(nodes: &mut Vec<Node>, subtree: Vec<Node>) {
    let base = nodes.len() as u32;
    nodes.extend(subtree.into_iter().map(|node| match node.count {
        0 => Node { first: node.first + base, ..node },
        _ => node,
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::random::Random;

    fn boxes(count: usize, seed: u64) -> Vec<Aabb> {
        let mut random = Random(seed);
        let around = |centre: DVec3, half: DVec3| Aabb { min: centre - half, max: centre + half };
        (0..count).map(|_| around(random.cube(), random.cube().abs() * 0.05)).collect()
    }

    fn check(boxes: &[Aabb]) {
        for leaf_items in [0, 1, 4] {
            let tree = Bvh::build(boxes, leaf_items);
            tree.validate(boxes, leaf_items.max(1)).expect("well formed");
            assert_eq!(tree.len(), boxes.len());
        }
    }

    #[test]
    fn builds_well_formed_trees() {
        for count in [0, 1, 2, 3, 5, 100, 10_000] {
            check(&boxes(count, 3));
        }
        assert!(Bvh::build(&[], 1).is_empty());
        assert_eq!(Bvh::build(&[], 1).bounds(), Aabb::EMPTY);
    }

    #[test]
    fn builds_over_degenerate_boxes() {
        let one = boxes(1, 5)[0];
        check(&vec![one; 1000]);
        let all = Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };
        check(&vec![all; 100]);
        check(&vec![Aabb::EMPTY; 100]);
        let huge = Aabb { min: DVec3::splat(-f64::MAX), max: DVec3::splat(f64::MAX) };
        let far = Aabb { min: DVec3::splat(1e300), max: DVec3::splat(f64::MAX) };
        let half = Aabb { min: DVec3::ZERO, max: DVec3::INFINITY };
        let mut mixed = boxes(500, 7);
        mixed.extend([all, huge, far, half, Aabb::EMPTY]);
        check(&mixed);
        // Points whose distances shrink by halves: bins cut off one at a time.
        let points = (0..900).map(|k| DVec3::splat(2f64.powi(-k)));
        check(&points.map(|p| Aabb { min: p, max: p }).collect::<Vec<_>>());
    }

    #[test]
    fn the_number_of_threads_does_not_matter() {
        let boxes = boxes(40_000, 11);
        let build = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("threads").install(|| Bvh::build(&boxes, 4))
        };
        let one = build(1);
        assert!(one == build(2) && one == build(7));
    }
}
