//! No stored bound cuts the surface: pyramid bounds hold every sample, distances stay below the
//! true distance to the continuous surface.
//!
//! The distance here is the smallest to any of many points *of the surface*, refined around the
//! best one. It is never below the true distance, so a value above it is surely unsafe.

use proptest::prelude::*;
use rilievo::map::{
    DistanceBits, DistanceKind, DistanceMap, DistanceOptions, HeightMap, Lattice, Layout, Metric,
    Pyramid, Wrap,
};
use rilievo_tests::maps::Shape;
use rilievo_tests::random::Random;

fn lattices() -> impl Strategy<Value = (Lattice, Wrap)> {
    let lattice = prop_oneof![Just(Lattice::Vertex), Just(Lattice::Texel)];
    (lattice, prop_oneof![Just(Wrap::Repeat), Just(Wrap::Clamp), Just(Wrap::Mirror)])
}

fn maps() -> impl Strategy<Value = HeightMap> {
    let shape = prop_oneof![
        (0..1000u64).prop_map(Shape::White),
        (0..1000u64).prop_map(Shape::Fbm),
        (1..6u32).prop_map(Shape::Studs),
        Just(Shape::Step),
        Just(Shape::Spike),
        Just(Shape::Ramp(-3.0, 700.0)),
    ];
    (shape, 2..40u32, 2..40u32, lattices(), any::<bool>()).prop_map(
        |(shape, w, h, (lattice, wrap), codes)| {
            if codes {
                shape.codes([w, h], lattice, wrap)
            } else {
                shape.floats([w, h], lattice, wrap)
            }
        },
    )
}

/// Raw value at stored-cell coordinates.
fn stored_raw(map: &HeightMap, x: f64, y: f64) -> f64 {
    let cell = |c: f64, cells: u32| (c.floor() as u32).min(cells - 1);
    let (cx, cy) = (cell(x, map.x().cells()), cell(y, map.y().cells()));
    let h = map.stored_corners(cx, cy).map(f64::from);
    let (fx, fy) = (x - f64::from(cx), y - f64::from(cy));
    h[0] * (1.0 - fx) * (1.0 - fy)
        + h[1] * fx * (1.0 - fy)
        + h[2] * (1.0 - fx) * fy
        + h[3] * fx * fy
}

/// Smallest distance from `p` to points of the surface.
fn distance_from_above(map: &HeightMap, metric: &Metric, p: [f64; 3]) -> f64 {
    let ends = [f64::from(map.x().cells()), f64::from(map.y().cells())];
    let distance = |x: f64, y: f64| {
        let (x, y) = (x.clamp(0.0, ends[0]), y.clamp(0.0, ends[1]));
        let (dx, dy) = (metric.x * (x - p[0]), metric.y * (y - p[1]));
        dx.hypot(dy).hypot(metric.z * (stored_raw(map, x, y) - p[2]))
    };
    let mut best = (f64::INFINITY, [0.0; 2]);
    for j in 0..=map.y().cells() * 4 {
        for i in 0..=map.x().cells() * 4 {
            let (x, y) = (f64::from(i) / 4.0, f64::from(j) / 4.0);
            let d = distance(x, y);
            if d < best.0 {
                best = (d, [x, y]);
            }
        }
    }
    let mut step = 0.125;
    for _ in 0..24 {
        for (a, b) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.7, 0.7), (-0.7, 0.7)] {
            let at = [best.1[0] + a * step, best.1[1] + b * step];
            let d = distance(at[0], at[1]);
            if d < best.0 {
                best = (d, at);
            }
        }
        step *= 0.6;
    }
    best.0
}

fn options(map: &HeightMap, size: [u32; 3], depth: f64, bits: DistanceBits) -> DistanceOptions {
    let (low, high) = map.raw_range();
    let metric = Metric {
        x: 1.0 / f64::from(map.x().cells()),
        y: 1.3 / f64::from(map.y().cells()),
        z: depth / f64::from(high - low).max(1e-6),
    };
    DistanceOptions { size, metric, bits }
}

fn point(map: &HeightMap, random: &mut Random) -> [f64; 3] {
    let (low, high) = map.raw_range();
    let side = |cells: u32, random: &mut Random| random.range(0.0, f64::from(cells));
    [
        side(map.x().cells(), random),
        side(map.y().cells(), random),
        random.range(f64::from(low), f64::from(high)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn pyramid_bounds_hold_every_corner_of_their_cells(map in maps(), tiny in any::<bool>()) {
        let layout = if tiny { Layout::Tiny } else { Layout::Default };
        let pyramid = Pyramid::build_as(&map, layout);
        for level in 0..pyramid.levels() {
            let side = 4u32 << (2 * level);
            for cy in 0..map.y().cells() {
                for cx in 0..map.x().cells() {
                    let (low, high) = pyramid.bounds(level, cx / side, cy / side);
                    for h in map.stored_corners(cx, cy) {
                        prop_assert!(low <= h && h <= high, "level {level}, cell {cx} {cy}");
                    }
                }
            }
        }
    }

    #[test]
    fn safe_distances_stay_below_the_true_distance(
        map in maps(),
        size in [2..12u32, 2..12u32, 2..9u32],
        depth in 0.01..3.0f64,
        (kind, bits) in (
            prop_oneof![Just(DistanceKind::Boxes), Just(DistanceKind::Corrected)],
            prop_oneof![Just(DistanceBits::U8), Just(DistanceBits::U16)],
        ),
        seed in 0..1000u64,
    ) {
        let options = options(&map, size, depth, bits);
        let distances = DistanceMap::from_height(&map, kind, &options).unwrap();
        let mut random = Random::new(&[seed]);
        for _ in 0..60 {
            let p = point(&map, &mut random);
            let (safe, above) =
                (distances.safe_distance(p), distance_from_above(&map, &options.metric, p));
            prop_assert!(safe >= 0.0 && safe <= above * (1.0 + 1e-12), "{p:?}: {safe} > {above}");
        }
    }
}

#[test]
fn distances_are_of_use_where_the_surface_is_far() {
    let map = Shape::Gaussian.codes([33, 33], Lattice::Vertex, Wrap::Clamp);
    for kind in [DistanceKind::Boxes, DistanceKind::Corrected] {
        let options = options(&map, [32, 32, 16], 0.5, DistanceBits::U16);
        let distances = DistanceMap::from_height(&map, kind, &options).unwrap();
        let corner = [0.5, 0.5, 60_000.0];
        let true_distance = distance_from_above(&map, &options.metric, corner);
        let safe = distances.safe_distance(corner);
        assert!(safe > 0.6 * true_distance, "{kind:?}: {safe} of {true_distance}");
    }
}
