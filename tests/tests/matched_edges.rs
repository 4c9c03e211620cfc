//! Maps baked towards equal heights at seams: steps fall, and little else changes.

use std::sync::Arc;

use rilievo::map::{HeightMap, Lattice, Samples, Wrap};
use rilievo::relief::{Displacement, Edges, MeshOptions, Relief, ReliefMesh};
use rilievo_tests::maps::Shape;
use rilievo_tests::meshes::Base;

fn laid(base: Base, map: HeightMap, edges: Edges) -> ReliefMesh {
    let displacement = Displacement { scale: 0.05, ..Displacement::default() };
    let options = MeshOptions { displacement, edges, ..MeshOptions::default() };
    ReliefMesh::new(&base.mesh(), Arc::new(Relief::new(map)), options).expect("valid")
}

/// Changes of all samples, row by row.
fn changes(before: &HeightMap, after: &HeightMap) -> Vec<f64> {
    let raw = |map: &HeightMap| match map.samples() {
        Samples::U16(v) => v.iter().map(|&x| f64::from(x)).collect::<Vec<_>>(),
        Samples::F32(v) => v.iter().map(|&x| f64::from(x)).collect(),
    };
    raw(before).iter().zip(raw(after)).map(|(a, b)| b - a).collect()
}

#[test]
fn steps_at_seams_fall_and_heights_keep_their_range() {
    let (texel, vertex) = (Lattice::Texel, Lattice::Vertex);
    for (name, base, map, share) in [
        ("spot", Base::Spot, Shape::Fbm(1).codes([512, 512], texel, Wrap::Repeat), 0.1),
        ("spot, coarse", Base::Spot, Shape::Fbm(2).floats([96, 96], texel, Wrap::Clamp), 0.2),
        ("spot, white", Base::Spot, Shape::White(3).codes([256, 256], texel, Wrap::Repeat), 0.2),
        ("cube", Base::Cube, Shape::Fbm(4).floats([33, 33], vertex, Wrap::Mirror), 0.01),
    ] {
        let before = laid(base, map.clone(), Edges::Shared);
        let heights = before.matched_heights(8);
        assert_eq!((heights.x(), heights.y()), (map.x(), map.y()));
        let (low, high) = map.raw_range();
        let (new_low, new_high) = heights.raw_range();
        assert!(low <= new_low && new_high <= high, "{name}");
        let after = laid(base, heights, Edges::Shared);
        let (was, is) = (before.seam_steps(), after.seam_steps());
        assert!(was.mean > 0.01, "{name}: {was:?}");
        assert!(is.mean < share * was.mean && is.largest <= was.largest, "{name}: {was:?} {is:?}");
    }
}

#[test]
fn texels_far_from_seams_stay_and_changes_are_soft() {
    let map = Shape::Fbm(5).codes([512, 512], Lattice::Texel, Wrap::Repeat);
    let mesh = laid(Base::Spot, map.clone(), Edges::Shared);
    let hard = changes(&map, &mesh.matched_heights(0));
    let soft = changes(&map, &mesh.matched_heights(6));
    let touched = |all: &[f64]| all.iter().filter(|&&change| change != 0.0).count();
    assert!(touched(&hard) > 0 && touched(&hard) < touched(&soft));
    assert!(touched(&soft) < map.samples().len() / 2, "{}", touched(&soft));
    for (j, i) in (0..512usize).flat_map(|j| (0..512usize).map(move |i| (j, i))) {
        let near = |reach: usize| {
            let rows = j.saturating_sub(reach)..(j + reach + 1).min(512);
            rows.flat_map(move |y| {
                let columns = i.saturating_sub(reach)..(i + reach + 1).min(512);
                columns.map(move |x| y * 512 + x)
            })
        };
        let at = j * 512 + i;
        if hard[at] != 0.0 {
            assert_eq!(hard[at], soft[at]);
        } else if soft[at] != 0.0 {
            // A mean of those around it, and not more than the largest of the seam.
            let most = near(7).map(|k| hard[k].abs()).fold(0.0, f64::max);
            assert!(soft[at].abs() <= most + 1.0, "{i} {j}");
        }
    }
}

#[test]
fn maps_without_seams_and_meshes_as_authored_change_nothing() {
    // The torus shows the map once across and twice around: whole tiles.
    for (base, edges) in [(Base::Torus(12, 8), Edges::Shared), (Base::Cube, Edges::AsAuthored)] {
        let map = Shape::Fbm(6).codes([48, 32], Lattice::Texel, Wrap::Repeat);
        let mesh = laid(base, map.clone(), edges);
        assert_eq!(mesh.seam_steps().largest, 0.0);
        assert_eq!(mesh.matched_heights(8), map);
    }
}
