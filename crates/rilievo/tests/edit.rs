//! Edits: a relief that was edited is the relief of the edited map.

use std::ops::Range;
use std::sync::Arc;

use proptest::prelude::*;
use rilievo::glam::DVec3;
use rilievo::map::{
    DistanceKind, DistanceMap, DistanceOptions, HeightMap, HeightMapError, Lattice, Layout, Metric,
    Pyramid, RowMut, Samples, Wrap,
};
use rilievo::relief::{Displacement, FaceError, FaceOptions, Method, Relief, ReliefFace};
use rilievo::{Hit, Ray};

/// A sample as both kinds of maps take it.
fn raw(codes: bool, value: u16) -> f32 {
    if codes { f32::from(value) } else { f32::from(value) * 0.37 - 900.0 }
}

/// What a map is made of: size, lattice, wrap, codes or floats, a seed.
type Shape = ([u32; 2], Lattice, Wrap, bool, u32);

fn shapes() -> impl Strategy<Value = Shape> {
    let size = prop_oneof![[2..9u32, 2..9u32], [2..150u32, 2..150u32]];
    let lattice = prop_oneof![Just(Lattice::Vertex), Just(Lattice::Texel)];
    let wrap = prop_oneof![Just(Wrap::Repeat), Just(Wrap::Clamp), Just(Wrap::Mirror)];
    (size, lattice, wrap, any::<bool>(), any::<u32>())
}

fn noise(seed: u32, k: u32) -> u16 {
    let x = (seed ^ k.wrapping_mul(0x9E37_79B9)).wrapping_mul(0x7FEB_352D);
    ((x ^ (x >> 15)).wrapping_mul(0x846C_A68B) >> 16) as u16
}

fn map(([w, h], lattice, wrap, codes, seed): Shape) -> HeightMap {
    let values = (0..w * h).map(|k| noise(seed, k));
    let samples = if codes {
        Samples::U16(values.collect())
    } else {
        Samples::F32(values.map(|v| raw(false, v)).collect())
    };
    HeightMap::new(w, h, samples, lattice, wrap).unwrap()
}

/// A part of `0..size` by two shares of 65536.
fn part(size: u32, [from, length]: [u16; 2]) -> Range<u32> {
    let start = (u32::from(from) * size) >> 16;
    start..start + 1 + ((u32::from(length) * (size - start)) >> 16)
}

/// Sets a rectangle to noise between `low` and `high`, ends included.
fn scribble(relief: &mut Relief, rect: [Range<u32>; 2], (seed, low, high): (u32, u16, u16)) {
    let value = |j: u32, k: usize| match noise(seed, j * 7919 + k as u32) {
        n if n % 3 == 0 => low,
        n if n % 3 == 1 => high,
        n => low + ((u32::from(n) * u32::from(high - low)) >> 16) as u16,
    };
    let outcome = relief.edit(rect, |j, row| match row {
        RowMut::U16(row) => row.iter_mut().enumerate().for_each(|(k, v)| *v = value(j, k)),
        RowMut::F32(row) => {
            row.iter_mut().enumerate().for_each(|(k, v)| *v = raw(false, value(j, k)));
        }
    });
    outcome.unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Ranges grow, shrink and stay; rectangles touch every border.
    #[test]
    fn any_edits_leave_what_a_new_relief_would_be(
        shape in shapes(),
        tiny in any::<bool>(),
        edits in prop::collection::vec(
            (any::<[[u16; 2]; 2]>(), any::<u32>(), any::<u16>(), any::<u16>()),
            1..6,
        ),
    ) {
        let layout = if tiny { Layout::Tiny } else { Layout::Default };
        let mut relief = Relief::with_layout(map(shape), layout);
        let [w, h] = shape.0;
        for (rect, seed, a, b) in edits {
            let rect = [part(w, rect[0]), part(h, rect[1])];
            scribble(&mut relief, rect, (seed, a.min(b), a.max(b)));
            let samples = relief.heights().samples().clone();
            let new = HeightMap::new(w, h, samples, shape.1, shape.2).unwrap();
            prop_assert_eq!(relief.heights(), &new);
            prop_assert!(relief.pyramid() == &Pyramid::build_as(&new, layout));
        }
    }
}

/// One sample after the other, everywhere in a map of several levels.
#[test]
fn single_samples_reach_every_node_above_them() {
    for lattice in [Lattice::Vertex, Lattice::Texel] {
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
            let shape = ([70, 67], lattice, wrap, true, 5);
            let mut relief = Relief::with_layout(map(shape), Layout::Tiny);
            for k in 0..70 {
                let (i, j) = (k, k * 66 / 69);
                scribble(&mut relief, [i..i + 1, j..j + 1], (k, 0, 65535));
                let fresh = Pyramid::build_as(relief.heights(), Layout::Tiny);
                assert!(relief.pyramid() == &fresh, "{lattice:?} {wrap:?} sample {i} {j}");
            }
        }
    }
}

#[test]
fn a_refused_edit_leaves_the_relief_as_it_was() {
    let mut relief = Relief::new(map(([20, 20], Lattice::Texel, Wrap::Repeat, false, 1)));
    let before = (relief.heights().clone(), relief.pyramid().clone());
    let error = relief.edit([3..5, 3..5], |_, row| {
        if let RowMut::F32(row) = row {
            row.fill(f32::INFINITY);
        }
    });
    assert!(matches!(error, Err(HeightMapError::NotFinite { i: 3, j: 3, .. })));
    let error = relief.edit([3..21, 3..5], |_, _| {});
    assert!(matches!(error, Err(HeightMapError::NotInside { .. })));
    assert!((relief.heights(), relief.pyramid()) == (&before.0, &before.1));
}

const CORNERS: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];

fn options(scale: f64) -> FaceOptions {
    let displacement =
        Displacement { scale, zero: 0.25, tile: [2.0, 1.0], ..Displacement::default() };
    FaceOptions { displacement, ..FaceOptions::default() }
}

fn hits(face: &ReliefFace) -> Vec<Option<Hit>> {
    let ray = |k: u32| {
        let from = DVec3::new(f64::from(k % 17) / 16.0, -0.3, 0.9);
        Ray::new(from, DVec3::new(0.1, 0.4 + f64::from(k) / 300.0, -0.5))
    };
    (0..200).map(|k| face.closest(&ray(k), &mut ())).collect()
}

fn assert_same(a: &ReliefFace, b: &ReliefFace) {
    assert_eq!(a.bounds(), b.bounds());
    let (a, b) = (hits(a), hits(b));
    assert!(a.iter().flatten().count() > 50);
    assert_eq!(format!("{a:?}"), format!("{b:?}"));
}

#[test]
fn another_displacement_is_a_new_face_over_the_same_relief() {
    let relief = Arc::new(Relief::new(map(([33, 33], Lattice::Texel, Wrap::Repeat, true, 3))));
    let face = ReliefFace::new(CORNERS, Arc::clone(&relief), options(0.1)).unwrap();
    let deeper = face.with_displacement(options(0.3).displacement).unwrap();
    assert!(Arc::ptr_eq(deeper.relief(), &relief));
    assert_same(&deeper, &ReliefFace::new(CORNERS, relief, options(0.3)).unwrap());
    let flat = Displacement { scale: 0.0, ..Displacement::default() };
    let refused = face.with_displacement(flat).unwrap_err();
    assert!(matches!(refused, FaceError::Displacement { key: "scale", .. }));
}

#[test]
fn a_live_edit_shows_in_faces_made_again() {
    let shape = ([40, 40], Lattice::Texel, Wrap::Repeat, true, 3);
    let mut relief = Arc::new(Relief::new(map(shape)));
    let face = ReliefFace::new(CORNERS, Arc::clone(&relief), options(0.2)).unwrap();
    // The face in use keeps the old relief, the copy is edited.
    scribble(Arc::make_mut(&mut relief), [5..30, 8..20], (9, 0, 65535));
    let edited = face.with_relief(Arc::clone(&relief)).unwrap();
    assert_ne!(format!("{:?}", hits(&edited)), format!("{:?}", hits(&face)));
    let fresh = Arc::new(Relief::new(relief.heights().clone()));
    assert_same(&edited, &ReliefFace::new(CORNERS, fresh, options(0.2)).unwrap());
}

#[test]
fn an_edit_drops_distance_maps() {
    let heights = map(([12, 12], Lattice::Texel, Wrap::Repeat, true, 3));
    let metric = Metric { x: 0.1, y: 0.1, z: 1e-6 };
    let wanted = DistanceOptions::by_default(&heights, DistanceKind::Boxes, metric);
    let boxes = DistanceMap::from_height(&heights, DistanceKind::Boxes, &wanted).unwrap();
    let mut relief = Relief::new(heights).with_distance(boxes).unwrap();
    scribble(&mut relief, [5..6, 5..6], (1, 3, 4));
    assert!(relief.distance(DistanceKind::Boxes).is_none());
    let options = FaceOptions { method: Method::Distance, ..options(0.1) };
    let refused = ReliefFace::new(CORNERS, Arc::new(relief), options).unwrap_err();
    assert!(matches!(refused, FaceError::NoDistanceMap { .. }));
}
