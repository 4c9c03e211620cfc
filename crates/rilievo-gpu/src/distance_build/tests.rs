//! Distance maps made on a device beside those of the CPU, code for code. Without an adapter nothing is tried; the suites
//! in `tests` say so.

use rilievo::map::{Lattice, Metric, NodeSearch, Procedural, Pyramid, Wrap};
use rilievo_tests::random::Random;
use rilievo_tests::scenes;

use super::*;

/// Hills and a little noise on a range, in a sample type; a map of one height where the range is empty.
fn map(
    random: &mut Random,
    [width, height]: [u32; 2],
    floats: Option<[f32; 2]>,
    (lattice, wrap): (Lattice, Wrap),
) -> HeightMap {
    let mut hills = |at: u32| {
        let [x, y] = [at % width, at / width].map(f64::from);
        0.45 + 0.4 * (0.5 * x).sin() * (0.3 * y).cos() + random.range(0.0, 0.1)
    };
    let all = 0..width * height;
    let samples = match floats {
        None => Samples::U16(all.map(|at| (hills(at) * 65535.0) as u16).collect()),
        Some([low, high]) => {
            Samples::F32(all.map(|at| low + (high - low) * hills(at) as f32).collect())
        }
    };
    HeightMap::new(width, height, samples, lattice, wrap).unwrap()
}

/// Maps of all lattices, wraps and sample types with options for a map of a kind, and what they are.
fn cases(kind: DistanceKind) -> Vec<(HeightMap, DistanceOptions, String)> {
    let mut random = Random::new(&[11]);
    let ranges =
        [None, Some([-3.0, 5.5]), Some([1e-30, 1.7e-30]), Some([0.25, 0.25]), Some([-1e9, 1e9])];
    let sizes = [[3, 4, 5], [17, 13, 9], [1, 1, 3], [40, 9, 2], [8, 70, 4]];
    let mut cases = Vec::new();
    for (k, unfolding) in scenes::UNFOLDINGS.into_iter().enumerate() {
        for (m, floats) in ranges.into_iter().enumerate() {
            let sides = [2, 3].map(|least| least + random.integer(0, 30) as u32);
            let map = map(&mut random, sides, floats, unfolding);
            // Flat faces, deep ones and stretched ones.
            let (sides, scale) =
                [([1.0, 1.0], 0.3), ([3.0, 0.5], 1.5), ([1.0, 4.0], 0.02)][(k + m) % 3];
            let range = f64::from(map.raw_range().1) - f64::from(map.raw_range().0);
            let scale = if range > 0.0 { scale / (range * map.unit()) } else { scale };
            let options = DistanceOptions {
                size: sizes[(2 * k + m) % 5].map(|n| n.max(kind.least_size())),
                metric: Metric::of_face(&map, sides, scale),
                bits: if k == 3 { DistanceBits::U8 } else { DistanceBits::U16 },
            };
            let what = format!("{kind:?}, {unfolding:?}, {floats:?}, {options:?}");
            cases.push((map, options, what));
        }
    }
    cases
}

#[test]
fn codes_made_on_the_device_are_the_cpus() {
    let Ok(gpu) = Gpu::open() else { return };
    for kind in [DistanceKind::Boxes, DistanceKind::Corrected, DistanceKind::Published] {
        let (mut count, mut above) = (0, 0);
        for (map, options, what) in cases(kind) {
            let want = DistanceMap::from_height(&map, kind, &options).unwrap();
            let found = gpu.distance_map(&map, kind, &options).unwrap();
            let codes = |map: &DistanceMap| {
                (0..map.codes().len()).map(|at| map.codes().get(at)).collect::<Vec<_>>()
            };
            let (a, b) = (codes(&want), codes(&found));
            let wrong = a.iter().zip(&b).position(|(a, b)| a != b);
            assert_eq!(wrong.map(|at| (at, a[at], b[at])), None, "{what}");
            assert!(found == want, "{what}");
            count += a.len();
            above += a.iter().filter(|&&code| code > 0).count();
        }
        assert!(
            above * 5 > count,
            "{above} of {count} codes are above 0: too few to mean anything"
        );
    }
}

/// Of studs, whose tops and floors lie whole numbers of steps from nodes, of noise, and of a map with heights far from 0.
#[test]
fn the_cpu_is_asked_for_few_nodes() {
    let Ok(gpu) = Gpu::open() else { return };
    let (lattice, wrap) = (Lattice::Texel, Wrap::Repeat);
    let mut random = Random::new(&[13]);
    let noise = map(&mut random, [33, 40], None, (lattice, wrap));
    let lifted = map(&mut random, [33, 40], Some([700.0, 709.0]), (lattice, Wrap::Clamp));
    let studs = Procedural::Studded { studs: [3, 2] }.height_map([36, 30], lattice, wrap).unwrap();
    for map in [noise, lifted, studs] {
        for kind in [DistanceKind::Corrected, DistanceKind::Published] {
            let range = f64::from(map.raw_range().1) - f64::from(map.raw_range().0);
            let metric = Metric::of_face(&map, [1.0, 1.0], 0.2 / (range * map.unit()));
            let options = DistanceOptions { size: [21, 20, 16], metric, bits: DistanceBits::U16 };
            let pyramid = Pyramid::build(&map);
            let search = NodeSearch::new(&map, &pyramid, kind, &options).unwrap();
            let (codes, unknown) =
                nearest::codes(&gpu, (&map, &pyramid), &search, &options).unwrap();
            assert!(unknown.len() * 1000 <= codes.len(), "{kind:?}: {} unknown", unknown.len());
        }
    }
}

#[test]
fn slabs_in_batches_are_those_at_once_and_what_does_not_fit_is_refused() {
    let Ok(gpu) = Gpu::open() else { return };
    let mut random = Random::new(&[12]);
    let map = map(&mut random, [33, 21], None, (Lattice::Texel, Wrap::Repeat));
    let metric = Metric::of_face(&map, [1.0, 0.7], 0.4);
    let options = DistanceOptions { size: [31, 20, 7], metric, bits: DistanceBits::U16 };
    let want = DistanceMap::from_height(&map, DistanceKind::Boxes, &options).unwrap();
    assert!(gpu.distance_map(&map, DistanceKind::Boxes, &options).unwrap() == want);
    // Columns of so many cells are the CPU's.
    let wide = self::map(&mut random, [300, 5], None, (Lattice::Texel, Wrap::Mirror));
    let metric = Metric::of_face(&wide, [1.0, 0.1], 0.2);
    let size = [2, 3, 4];
    let few = DistanceOptions { size, metric, ..options };
    let want = DistanceMap::from_height(&wide, DistanceKind::Boxes, &few).unwrap();
    assert!(gpu.distance_map(&wide, DistanceKind::Boxes, &few).unwrap() == want);
    let size = [130, 120, 9];
    let options = DistanceOptions { size, ..options };
    let want = DistanceMap::from_height(&map, DistanceKind::Boxes, &options).unwrap();
    // No more than the table of codes at once: slabs go in batches of four.
    let gpu = gpu.with_largest_binding(8 * (65_535 + 10) + 512);
    assert!(gpu.distance_map(&map, DistanceKind::Boxes, &options).unwrap() == want);
    let options = DistanceOptions { size: [400, 400, 2], ..options };
    let error =
        gpu.distance_map(&map, DistanceKind::Boxes, &options).expect_err("too large").to_string();
    assert!(error.contains("slabs of a distance map"), "{error}");
    let none = DistanceOptions { size: [0, 4, 4], ..options };
    let error =
        gpu.distance_map(&map, DistanceKind::Boxes, &none).expect_err("no voxels").to_string();
    assert!(error.contains("at least 1"), "{error}");
}
