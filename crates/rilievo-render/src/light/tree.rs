//! [`LightTree`]: which of many lights to sample, and how probable that was.
//!
//! A binary tree over the lights \[Conty2018\]. From the root down a child is taken in proportion to
//! what its bounds say it brings to the receiver: intensity over the squared distance, times bounds of
//! the cosines at both ends. The probability of a light is the product along its way, found again from
//! the stored way without a search; it takes as many steps as the tree is deep, about the logarithm of
//! the number of lights. Built by sorting into bins and splitting where the cost of \[Conty2018\] is least.
//!
//! A light whose bounds exclude the receiver has the probability 0: paths that meet it by chance count
//! it in full. A single light is always taken.

use glam::DVec3;

use super::Receiver;
use super::bounds::LightBounds;

/// Bins along an axis.
const BINS: usize = 12;

/// From this depth on nodes are halved, so that no way is longer than 64 steps.
const HALVED: u32 = 32;

/// No light.
const NONE: u64 = u64::MAX;

/// A node: its bounds, in single precision, and what is below it.
#[derive(Clone, Copy, Debug)]
struct Node {
    min: [f32; 3],
    max: [f32; 3],
    axis: [f32; 3],
    intensity: f32,
    cos_normals: f32,
    cos_emission: f32,
    held: f32,
    most: f32,
    /// Of an inner node its second child; the first follows it. Of a leaf its light.
    next: u32,
    leaf: bool,
}

/// A tree over lights.
#[derive(Clone, Debug, Default)]
pub(super) struct LightTree {
    nodes: Vec<Node>,
    /// For each light the way to it, a bit a step from the lowest up, 1 for the second child.
    ways: Vec<u64>,
}

impl LightTree {
    /// The tree over lights with these bounds; lights without intensity are left out.
    pub(super) fn new(bounds: &[LightBounds]) -> Self {
        let some = |light: &u32| bounds[*light as usize].intensity > 0.0;
        let mut lights: Vec<u32> = (0..bounds.len() as u32).filter(some).collect();
        let mut tree = Self {
            nodes: Vec::with_capacity((2 * lights.len()).saturating_sub(1)),
            ways: vec![NONE; bounds.len()],
        };
        if !lights.is_empty() {
            tree.add(bounds, &mut lights, 0, 0);
        }
        tree
    }

    /// Number of lights.
    pub(super) fn len(&self) -> usize {
        self.nodes.len().div_ceil(2)
    }

    /// Whether there is no light.
    pub(super) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The nodes: bounds, and of an inner node its second child, of a leaf its light.
    pub(super) fn nodes(&self) -> impl ExactSizeIterator<Item = (LightBounds, u32, bool)> {
        self.nodes.iter().map(|node| (node.bounds(), node.next, node.leaf))
    }

    /// For each light the way to it, a bit a step from the lowest up; all ones where it is left out.
    pub(super) fn ways(&self) -> &[u64] {
        &self.ways
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> u64 {
        (size_of_val(self.nodes.as_slice()) + size_of_val(self.ways.as_slice())) as u64
    }

    /// A light for `u` in `[0, 1)`, its probability, above 0, and a number of the same kind that is left of
    /// `u`; nothing where no light reaches the receiver.
    pub(super) fn choose(&self, at: &Receiver, mut u: f64) -> Option<(u32, f64, f64)> {
        let (mut index, mut probability) = (0, 1.0);
        loop {
            let node = self.nodes.get(index)?;
            if node.leaf {
                return Some((node.next, probability, u));
            }
            let second = node.next as usize;
            let share = self.first_share(index, at)?;
            if u < share {
                u /= share;
                probability *= share;
                index += 1;
            } else {
                u = ((u - share) / (1.0 - share)).min(1.0 - f64::EPSILON);
                probability *= 1.0 - share;
                index = second;
            }
        }
    }

    /// The probability of [`Self::choose`] for a light.
    pub(super) fn probability(&self, at: &Receiver, light: u32) -> f64 {
        let Some(&way) = self.ways.get(light as usize) else { return 0.0 };
        if way == NONE {
            return 0.0;
        }
        let (mut index, mut rest, mut probability) = (0, way, 1.0);
        while !self.nodes[index].leaf {
            let Some(share) = self.first_share(index, at) else { return 0.0 };
            (index, probability) = match rest & 1 {
                0 => (index + 1, probability * share),
                _ => (self.nodes[index].next as usize, probability * (1.0 - share)),
            };
            rest >>= 1;
        }
        probability
    }

    /// The probability of the first child of an inner node; nothing where neither reaches.
    fn first_share(&self, index: usize, at: &Receiver) -> Option<f64> {
        let importance = |index: usize| self.nodes[index].bounds().importance(at);
        let first = importance(index + 1);
        let second = importance(self.nodes[index].next as usize);
        let sum = first + second;
        if !sum.is_finite() {
            return Some(0.5);
        }
        (sum > 0.0).then(|| first / sum)
    }

    /// Adds the nodes over `lights`, at least one.
    fn add(&mut self, bounds: &[LightBounds], lights: &mut [u32], way: u64, depth: u32) {
        let all = lights.iter().map(|&light| bounds[light as usize]);
        let Some(around) = all.reduce(|a, b| a.union(&b)) else { return };
        let place = self.nodes.len();
        if let [light] = *lights {
            self.nodes.push(Node::new(&around, light, true));
            self.ways[light as usize] = way;
            return;
        }
        self.nodes.push(Node::new(&around, 0, false));
        let middle = split(bounds, lights, &around, depth >= HALVED);
        let (first, second) = lights.split_at_mut(middle);
        self.add(bounds, first, way, depth + 1);
        self.nodes[place].next = self.nodes.len() as u32;
        self.add(bounds, second, way | 1 << depth, depth + 1);
    }
}

/// Sorts `lights`, two or more, into two groups; gives the size of the first.
fn split(bounds: &[LightBounds], lights: &mut [u32], around: &LightBounds, halved: bool) -> usize {
    let middle = |light: u32| {
        let LightBounds { min, max, .. } = bounds[light as usize];
        min.midpoint(max)
    };
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &light in lights.iter() {
        (low, high) = (low.min(middle(light)), high.max(middle(light)));
    }
    let side = around.max - around.min;
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in 0..3 {
        if halved || high[axis] <= low[axis] {
            continue;
        }
        let mut bins: [Option<LightBounds>; BINS] = [None; BINS];
        for &light in lights.iter() {
            let bin = &mut bins[bin_of(middle(light)[axis], low[axis], high[axis])];
            let own = &bounds[light as usize];
            *bin = Some(bin.map_or(*own, |bin| bin.union(own)));
        }
        let gathered = |bins: &[Option<LightBounds>]| {
            bins.iter().flatten().copied().reduce(|a, b| a.union(&b))
        };
        let stretch = side.max_element() / side[axis];
        for cut in 1..BINS {
            let (first, second) = bins.split_at(cut);
            if let (Some(first), Some(second)) = (gathered(first), gathered(second)) {
                let cost = first.cost(stretch) + second.cost(stretch);
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, axis, cut));
                }
            }
        }
    }
    let Some((_, axis, cut)) = best else {
        // All in one place, or deep: halves along the longest side.
        let spread = high - low;
        let axis = (0..3).max_by(|&a, &b| spread[a].total_cmp(&spread[b])).unwrap_or(0);
        let half = lights.len() / 2;
        lights.select_nth_unstable_by(half, |&a, &b| {
            middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(&b))
        });
        return half;
    };
    let in_first = |light: u32| bin_of(middle(light)[axis], low[axis], high[axis]) < cut;
    // Stable, so that the tree is the same whatever the sort.
    lights.sort_by_key(|&light| !in_first(light));
    lights.partition_point(|&light| in_first(light))
}

fn bin_of(x: f64, low: f64, high: f64) -> usize {
    (((x - low) / (high - low) * BINS as f64) as usize).min(BINS - 1)
}

impl Node {
    fn new(bounds: &LightBounds, next: u32, leaf: bool) -> Self {
        let down = |v: DVec3| v.to_array().map(|x| (x as f32).next_down());
        let up = |v: DVec3| v.to_array().map(|x| (x as f32).next_up());
        Self {
            min: down(bounds.min),
            max: up(bounds.max),
            axis: bounds.axis.to_array().map(|x| x as f32),
            intensity: bounds.intensity as f32,
            cos_normals: bounds.cos_normals as f32,
            cos_emission: bounds.cos_emission as f32,
            held: bounds.held as f32,
            most: bounds.most as f32,
            next,
            leaf,
        }
    }

    #[inline]
    fn bounds(&self) -> LightBounds {
        let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        LightBounds {
            min: wide(self.min),
            max: wide(self.max),
            intensity: f64::from(self.intensity),
            axis: wide(self.axis),
            cos_normals: f64::from(self.cos_normals),
            cos_emission: f64::from(self.cos_emission),
            held: f64::from(self.held),
            most: f64::from(self.most),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::chi_square::{chi_square_z, independent_points};

    /// Small lights strewn over a square, facing this way and that.
    fn strewn(count: u32) -> Vec<LightBounds> {
        let places = independent_points(2 * count).collect::<Vec<_>>();
        places
            .chunks_exact(2)
            .enumerate()
            .map(|(k, pair)| {
                let axis = DVec3::new(pair[1].x - 0.5, pair[1].y - 0.5, 0.1).normalize();
                let all = k % 3 == 0;
                LightBounds {
                    min: (10.0 * pair[0]).extend(0.0),
                    max: (10.0 * pair[0] + 0.1).extend(0.1),
                    intensity: if k % 5 == 4 { 0.0 } else { 1.0 + pair[1].x },
                    axis,
                    cos_normals: if all { -1.0 } else { 0.9 },
                    cos_emission: 0.0,
                    held: 0.0,
                    most: 0.0,
                }
            })
            .collect()
    }

    fn receivers() -> [Receiver; 4] {
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        [
            Receiver {
                position: at(5.0, 5.0, 1.0),
                normal: Some(-DVec3::Z),
                both_sides: false,
                time: 0.0,
            },
            Receiver {
                position: at(5.0, 5.0, 1.0),
                normal: Some(DVec3::X),
                both_sides: false,
                time: 0.0,
            },
            Receiver {
                position: at(-9.0, 2.0, 0.05),
                normal: Some(DVec3::X),
                both_sides: true,
                time: 0.0,
            },
            Receiver { position: at(3.0, 3.0, 0.05), normal: None, both_sides: false, time: 0.0 },
        ]
    }

    #[test]
    fn lights_are_drawn_as_probable_as_told() {
        for count in [1, 2, 7, 300] {
            let bounds = strewn(count);
            let tree = LightTree::new(&bounds);
            for at in receivers() {
                let mut observed = vec![0.0; count as usize];
                let mut missed = 0.0;
                for u in independent_points(100_000) {
                    let Some((light, probability, _)) = tree.choose(&at, u.x) else {
                        missed += 1.0;
                        continue;
                    };
                    assert!((probability / tree.probability(&at, light) - 1.0).abs() < 1e-12);
                    assert!(bounds[light as usize].intensity > 0.0);
                    observed[light as usize] += 1.0;
                }
                let shares = (0..count).map(|light| tree.probability(&at, light));
                let expected: Vec<f64> = shares.map(|share| share * 100_000.0).collect();
                let total: f64 = expected.iter().sum::<f64>() + missed;
                assert!((total - 1e5).abs() < 5.0 * f64::sqrt(missed) + 1e-3, "{count}: {total}");
                if count > 7 {
                    let z = chi_square_z(&observed, &expected);
                    assert!(z < 4.0, "{count}: {z}");
                }
            }
        }
    }

    #[test]
    fn near_lights_are_preferred() {
        let bounds = strewn(1000);
        let tree = LightTree::new(&bounds);
        let at = Receiver {
            position: DVec3::new(2.0, 3.0, 0.5),
            normal: None,
            both_sides: false,
            time: 0.0,
        };
        let distance = |light: u32| bounds[light as usize].min.distance(at.position);
        let lights = independent_points(10_000).filter_map(|u| tree.choose(&at, u.x));
        let near = lights.filter(|&(light, ..)| distance(light) < 2.0).count();
        // An eighth of them by number.
        assert!(near > 4000, "{near}");
    }

    #[test]
    fn lights_in_one_place_make_no_deep_tree() {
        let bounds = vec![LightBounds { intensity: 1.0, ..strewn(1)[0] }; 5000];
        let tree = LightTree::new(&bounds);
        assert_eq!(tree.nodes.len(), 9999);
        let at = receivers()[3];
        let total: f64 = (0..5000).map(|light| tree.probability(&at, light)).sum();
        assert!((total - 1.0).abs() < 1e-9, "{total}");
        assert!(LightTree::new(&[]).choose(&at, 0.5).is_none());
    }
}
