//! Every box that a ray meets is visited, once.

use glam::DVec3;

use super::*;
use crate::accel::SlabRay;
use crate::accel::random::Random;
use crate::simd::{Kernel, SimdLevel, run};

/// Notes what it is shown.
struct Notes(Vec<u32>);

impl Visit<()> for Notes {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, item: u32, (): &mut ()) -> Option<f64> {
        self.0.push(item);
        Some(f64::INFINITY)
    }
}

struct Walk<'a>(&'a WideBvh, &'a Ray, &'a mut Notes);

impl Kernel for Walk<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.0.walk::<L, ()>(self.1, self.2, &mut ());
    }
}

#[test]
fn every_box_that_is_met_is_visited() {
    let mut random = Random(61);
    for count in [0, 1, 2, 16, 17, 300, 2000] {
        let boxes: Vec<(u32, Aabb)> = (0..count)
            .map(|item| {
                let (at, half) = (random.cube(), 0.05 * random.cube().abs());
                (3 * item, Aabb { min: at - half, max: at + half })
            })
            .collect();
        let tree = WideBvh::build(&boxes, 4.0);
        assert_eq!(tree.bounds().is_empty(), count == 0);
        for case in 0..300 {
            let mut ray = Ray::new(2.0 * random.cube(), random.direction());
            if case % 3 == 0 {
                ray.direction[case % 2] = 0.0;
            }
            if let (1, Some(aimed)) = (case % 2, boxes.first()) {
                // At a corner, and in strange lengths.
                ray.direction = 1e30 * (aimed.1.max - ray.origin);
            }
            let mut notes = Notes(Vec::new());
            run(SimdLevel::detect(), Walk(&tree, &ray, &mut notes));
            let slab = SlabRay::new(&ray);
            for (item, bounds) in &boxes {
                let met = slab.entry(bounds, f64::INFINITY).is_some();
                assert!(!met || notes.0.contains(item), "{ray:?} {bounds:?}");
            }
            notes.0.sort_unstable();
            assert!(notes.0.windows(2).all(|two| two[0] < two[1]), "twice");
        }
    }
    let all = WideBvh::build(&[(5, Aabb { min: DVec3::ZERO, max: DVec3::ONE }); 40], 1.0);
    let mut notes = Notes(Vec::new());
    run(SimdLevel::detect(), Walk(&all, &Ray::new(DVec3::NEG_X, DVec3::X), &mut notes));
    assert_eq!(notes.0.len(), 40);
}

#[test]
fn nodes_are_not_nearly_empty() {
    let mut random = Random(62);
    let boxes: Vec<(u32, Aabb)> = (0..5000)
        .map(|item| {
            let at = random.cube();
            (item, Aabb { min: at, max: at + 0.05 })
        })
        .collect();
    let nodes = WideBvh::build(&boxes, 4.0).nodes.len();
    assert!(nodes < 5000 / 6, "{nodes}");
}
