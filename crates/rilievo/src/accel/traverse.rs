//! Walking a [`Bvh`] front to back.

use super::{Bvh, MAX_DEPTH, SlabRay};
use crate::probe::Probe;
use crate::ray::Ray;

/// Trees of so many nodes, four leaves, are not descended.
const LIST_NODES: usize = 7;

/// Nodes still to visit, and where the ray enters them. A walk holds at most one waiting node per
/// level.
struct Waiting {
    nodes: [(u32, f64); MAX_DEPTH + 1],
    len: usize,
}

impl Waiting {
    fn push(&mut self, node: u32, entry: f64) {
        self.nodes[self.len] = (node, entry);
        self.len += 1;
    }

    fn pop(&mut self) -> Option<(u32, f64)> {
        self.len = self.len.checked_sub(1)?;
        Some(self.nodes[self.len])
    }
}

impl Bvh {
    /// Calls `leaf(item, ray, probe)` for items whose boxes the ray may meet, nearer nodes first.
    /// The closure may lower `ray.t_max`; what lies beyond is then passed over, and what begins
    /// exactly there is not.
    pub fn closest<P: Probe>(
        &self,
        ray: &Ray,
        probe: &mut P,
        mut leaf: impl FnMut(u32, &mut Ray, &mut P),
    ) {
        let mut ray = *ray;
        self.walk(&mut ray, probe, |item, ray, probe| {
            leaf(item, ray, probe);
            false
        });
    }

    /// Whether `leaf(item, ray, probe)` is true for any item whose box the ray may meet; stops at
    /// the first.
    pub fn any<P: Probe>(
        &self,
        ray: &Ray,
        probe: &mut P,
        mut leaf: impl FnMut(u32, &Ray, &mut P) -> bool,
    ) -> bool {
        let mut ray = *ray;
        self.walk(&mut ray, probe, |item, ray, probe| leaf(item, ray, probe))
    }

    /// Visits items until `leaf` returns true, and says whether it did.
    #[inline]
    fn walk<P: Probe>(
        &self,
        ray: &mut Ray,
        probe: &mut P,
        mut leaf: impl FnMut(u32, &mut Ray, &mut P) -> bool,
    ) -> bool {
        if self.nodes.len() <= LIST_NODES {
            return self.walk_list(ray, probe, leaf);
        }
        let slab = SlabRay::new(ray);
        let mut waiting = Waiting { nodes: [(0, 0.0); MAX_DEPTH + 1], len: 0 };
        if let Some(root) = self.nodes.first()
            && let Some(entry) = slab.entry(&root.bounds, ray.t_max)
        {
            waiting.push(0, entry);
        }
        while let Some((mut index, entry)) = waiting.pop() {
            if entry > ray.t_max {
                continue;
            }
            loop {
                probe.node();
                let node = &self.nodes[index as usize];
                if node.count > 0 {
                    let first = node.first as usize;
                    for &item in &self.items[first..first + node.count as usize] {
                        if leaf(item, ray, probe) {
                            return true;
                        }
                    }
                    break;
                }
                let enter = |child: u32| slab.entry(&self.nodes[child as usize].bounds, ray.t_max);
                let (low, high) = (index + 1, node.first);
                index = match (enter(low), enter(high)) {
                    (None, None) => break,
                    (Some(_), None) => low,
                    (None, Some(_)) => high,
                    (Some(a), Some(b)) if b < a => {
                        waiting.push(low, a);
                        high
                    }
                    (Some(_), Some(b)) => {
                        waiting.push(high, b);
                        low
                    }
                };
            }
        }
        false
    }

    /// [`Bvh::walk`] of a tree so small that it is a list of leaves: all are tested, then visited in
    /// the order in which the ray enters them.
    #[inline]
    fn walk_list<P: Probe>(
        &self,
        ray: &mut Ray,
        probe: &mut P,
        mut leaf: impl FnMut(u32, &mut Ray, &mut P) -> bool,
    ) -> bool {
        probe.node();
        let slab = SlabRay::new(ray);
        let mut met = [(0.0, 0, 0); LIST_NODES];
        let mut count = 0;
        for node in &self.nodes {
            if node.count == 0 {
                continue;
            }
            let Some(entry) = slab.entry(&node.bounds, ray.t_max) else { continue };
            // Sorted as they come; leaves entered at the same parameter stay in order.
            let mut at = count;
            while at > 0 && met[at - 1].0 > entry {
                met[at] = met[at - 1];
                at -= 1;
            }
            met[at] = (entry, node.first as usize, node.count as usize);
            count += 1;
        }
        for &(entry, first, items) in &met[..count] {
            if entry > ray.t_max {
                break;
            }
            for &item in &self.items[first..first + items] {
                if leaf(item, ray, probe) {
                    return true;
                }
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::accel::random::Random;
    use crate::accel::{Aabb, GROWTH};
    use crate::probe::Counters;

    /// Entry into the smallest box number among the nearest, by the tree and one by one.
    fn compare(boxes: &[Aabb], leaf_items: u32, ray: &Ray) {
        let stored: Vec<Aabb> =
            boxes.iter().map(|b| b.grown(GROWTH * b.largest_coordinate())).collect();
        let slab = SlabRay::new(ray);
        let nearer = |best: Option<(f64, u32)>, new: (f64, u32)| {
            if best.is_some_and(|b| b < new) { best } else { Some(new) }
        };
        let mut brute = None;
        for (item, b) in stored.iter().enumerate() {
            if let Some(t) = slab.entry(b, ray.t_max) {
                brute = nearer(brute, (t, item as u32));
            }
        }
        let tree = Bvh::build(boxes, leaf_items);
        let mut best = None;
        tree.closest(ray, &mut (), |item, ray, _| {
            if let Some(t) = slab.entry(&stored[item as usize], ray.t_max) {
                best = nearer(best, (t, item));
                ray.t_max = t;
            }
        });
        assert_eq!(best, brute, "{ray:?}");
        let mut counters = Counters::default();
        let any = tree.any(ray, &mut counters, |item, ray, _| {
            slab.entry(&stored[item as usize], ray.t_max).is_some()
        });
        assert_eq!(any, brute.is_some(), "{ray:?}");
        assert!(!any || counters.nodes > 0);
    }

    fn random_ray(random: &mut Random) -> Ray {
        let mut ray = Ray::new(random.cube() * 2.0, random.direction() * 10.0);
        match random.below(4) {
            0 => ray.direction[random.below(3)] = 0.0,
            1 => {
                let axis = random.below(3);
                ray.direction = DVec3::AXES[axis] * if random.unit() < 0.5 { -1.0 } else { 1.0 };
            }
            2 => ray.t_max = 0.1 * random.unit(),
            _ => {}
        }
        ray
    }

    #[test]
    fn agrees_with_brute_force() {
        let mut random = Random(17);
        for case in 0..400 {
            let count = random.below(60);
            let size = [0.0, 0.1, 0.5][case % 3];
            let mut boxes = Vec::new();
            for _ in 0..count {
                // On a coarse lattice boxes coincide and rays run along their faces.
                let centre = (random.cube() * 4.0).round() / 4.0;
                let half = random.cube().abs() * size;
                boxes.push(Aabb { min: centre - half, max: centre + half });
            }
            if case % 5 == 0 {
                boxes.push(Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY });
                boxes.push(Aabb::EMPTY);
            }
            for _ in 0..50 {
                let mut ray = random_ray(&mut random);
                if case % 2 == 0 {
                    ray.origin = (ray.origin * 4.0).round() / 4.0;
                }
                compare(&boxes, 1 + case as u32 % 4, &ray);
            }
        }
    }

    #[test]
    fn visits_few_nodes_front_to_back() {
        let boxes: Vec<Aabb> = (0..1024)
            .map(|i| f64::from(i) * DVec3::X)
            .map(|p| Aabb { min: p, max: p + DVec3::new(0.5, 1.0, 1.0) })
            .collect();
        let tree = Bvh::build(&boxes, 1);
        let ray = Ray::new(DVec3::new(-1.0, 0.5, 0.5), DVec3::X);
        let mut counters = Counters::default();
        let mut first = None;
        tree.closest(&ray, &mut counters, |item, ray, _| {
            first.get_or_insert(item);
            ray.t_max = ray.t_max.min(1.0 + f64::from(item));
        });
        assert_eq!(first, Some(0));
        assert!(counters.nodes < 20, "{}", counters.nodes);
    }

    #[test]
    fn rays_that_are_no_rays_do_not_panic() {
        let boxes = [Aabb { min: DVec3::ZERO, max: DVec3::ONE }; 9];
        let tree = Bvh::build(&boxes, 1);
        for bad in [f64::NAN, f64::INFINITY, 0.0] {
            let ray = Ray::new(DVec3::splat(bad), DVec3::splat(bad));
            tree.closest(&ray, &mut (), |_, _, _| {});
        }
    }
}
