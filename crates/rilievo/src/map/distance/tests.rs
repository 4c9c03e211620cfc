//! Distance maps: that they are safe, and what they refuse.

use super::fixtures::{Random, cases, noise};
use super::*;
use crate::map::{Lattice, Wrap};

const KINDS: [DistanceKind; 3] =
    [DistanceKind::Published, DistanceKind::Boxes, DistanceKind::Corrected];

#[test]
fn parts_make_the_same_map_again() {
    let (heights, metric) = cases().swap_remove(0);
    for kind in KINDS {
        for bits in [DistanceBits::U8, DistanceBits::U16] {
            let options = DistanceOptions { size: [3, 4, 5], metric, bits };
            let map = DistanceMap::from_height(&heights, kind, &options).unwrap();
            assert_eq!(DistanceMap::from_parts(map.to_parts()).unwrap(), map);
            assert!(map.fits(&heights));
            assert_eq!(u128::from(map.bytes()), DistanceMap::predicted_bytes([3, 4, 5], bits));
        }
    }
}

#[test]
fn bad_sizes_metrics_and_parts_are_refused() {
    let (heights, metric) = cases().swap_remove(0);
    let bits = DistanceBits::U8;
    let make = |kind, size, metric| {
        let options = DistanceOptions { size, metric, bits };
        DistanceMap::from_height(&heights, kind, &options)
    };
    for (kind, size) in [
        (DistanceKind::Boxes, [1, 0, 1]),
        (DistanceKind::Corrected, [2, 1, 2]),
        (DistanceKind::Published, [u32::MAX; 3]),
        (DistanceKind::Boxes, [1 << 11, 1 << 11, (1 << 9) + 1]),
    ] {
        let least = kind.least_size();
        let error = make(kind, size, metric).unwrap_err();
        assert_eq!(error, DistanceMapError::Size { size, least });
    }
    for z in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e200, 1e-300] {
        let metric = Metric { x: 1e-300, y: 1e-300, z };
        let error = make(DistanceKind::Boxes, [2; 3], metric).unwrap_err();
        assert!(matches!(error, DistanceMapError::Metric { .. }), "{z}");
    }
    let parts = make(DistanceKind::Boxes, [2; 3], metric).unwrap().to_parts();
    let refused = |change: fn(&mut DistanceParts)| {
        let mut parts = parts.clone();
        change(&mut parts);
        DistanceMap::from_parts(parts).unwrap_err()
    };
    let size = refused(|p| p.size = [2, 2, 3]);
    assert_eq!(size, DistanceMapError::Count { size: [2, 2, 3], found: 8 });
    for quantum in [refused(|p| p.quantum = 0.0), refused(|p| p.quantum = f64::NAN)] {
        assert!(matches!(quantum, DistanceMapError::Quantum { .. }));
    }
    for domain in [refused(|p| p.cells = [0, 3]), refused(|p| p.raw_range = (2.0, 1.0))] {
        assert!(matches!(domain, DistanceMapError::Domain { .. }));
    }
}

#[test]
fn voxels_hold_their_points_and_points_outside_use_the_nearest() {
    let mut random = Random(5);
    for (heights, metric) in cases() {
        for kind in KINDS {
            let size = [5, 7, 3];
            let options = DistanceOptions { size, metric, bits: DistanceBits::U16 };
            let map = DistanceMap::from_height(&heights, kind, &options).unwrap();
            let (low, high) = (map.domain.low(), map.domain.high());
            for _ in 0..50 {
                let p = random.point((low, high));
                let (a, b) = map.voxel_bounds(map.voxel_of(p));
                assert!((0..3).all(|k| a[k] - 1e-9 <= p[k] && p[k] <= b[k] + 1e-9));
            }
            let above = [1.5, 2.5, high[2] + 1e6];
            assert_eq!(map.safe_distance(above), map.safe_distance([1.5, 2.5, high[2]]));
            let below = [-7.0, 2.5, low[2] - 1e6];
            assert_eq!(map.safe_distance(below), map.safe_distance([0.0, 2.5, low[2]]));
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_map() {
    let heights = noise([23, 17], Lattice::Texel, Wrap::Repeat);
    let metric = Metric::of_face(&heights, [1.0, 0.8], 0.3);
    let options = DistanceOptions { size: [19, 20, 6], metric, bits: DistanceBits::U16 };
    for kind in KINDS {
        let maps = [1, 2, 7].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| DistanceMap::from_height(&heights, kind, &options).unwrap())
        });
        assert!(maps[0] == maps[1] && maps[1] == maps[2], "{kind:?}");
    }
}
