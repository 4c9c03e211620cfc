//! Bounds against the cells they stand for.

use super::super::height::{RowMut, Samples};
use super::super::lattice::{Lattice, Wrap};
use super::*;

fn noise(k: usize) -> u32 {
    let mut x = (k as u32).wrapping_mul(0x9E37_79B9) ^ 0x85EB_CA6B;
    x ^= x >> 16;
    x = x.wrapping_mul(0x7FEB_352D);
    x ^ (x >> 15)
}

pub(super) fn maps() -> Vec<HeightMap> {
    let mut maps = Vec::new();
    for (w, h) in [(2, 2), (5, 3), (17, 16), (70, 33), (65, 64)] {
        for lattice in [Lattice::Vertex, Lattice::Texel] {
            for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
                let n = w * h;
                let codes = Samples::U16((0..n).map(|k| noise(k) as u16).collect());
                let floats = (0..n).map(|k| noise(k) as f32 * 1e-6 - 1500.0).collect();
                let floats = Samples::F32(floats);
                // So far from 0 that many codes stand for one value.
                let coarse = (0..n).map(|k| 3e6 + (noise(k) % 8) as f32 / 4.0).collect();
                let coarse = Samples::F32(coarse);
                for samples in [codes, floats, coarse] {
                    let map = HeightMap::new(w as u32, h as u32, samples, lattice, wrap);
                    maps.push(map.unwrap());
                }
            }
        }
    }
    maps
}

/// Exact range of the corners of a block, cell by cell.
fn range(map: &HeightMap, level: u32, bx: u32, by: u32) -> (f32, f32) {
    let side = 4u32 << (2 * level);
    let mut range = (f32::INFINITY, f32::NEG_INFINITY);
    for cy in by * side..((by + 1) * side).min(map.y().cells()) {
        for cx in bx * side..((bx + 1) * side).min(map.x().cells()) {
            for h in map.stored_corners(cx, cy) {
                range = (range.0.min(h), range.1.max(h));
            }
        }
    }
    range
}

#[test]
fn bounds_are_those_of_the_cells_and_tight() {
    for (map, layout) in maps().iter().flat_map(|map| Layout::ALL.map(|layout| (map, layout))) {
        let pyramid = Pyramid::build_as(map, layout);
        assert_eq!(pyramid.bytes(), Pyramid::predicted_bytes(pyramid.cells(), layout));
        for level in 0..pyramid.levels() {
            let [nx, ny] = pyramid.blocks(level);
            for (bx, by) in (0..ny).flat_map(|by| (0..nx).map(move |bx| (bx, by))) {
                let (lo, hi) = pyramid.bounds(level, bx, by);
                let (want_lo, want_hi) = range(map, level, bx, by);
                assert!(lo <= want_lo && hi >= want_hi, "block cuts the surface");
                let node = (by / 4 * pyramid.nodes(level)[0] + bx / 4) as usize;
                let step = match pyramid.node(level, node) {
                    NodeBounds::Wide { .. } => 1.0,
                    NodeBounds::Tiny { step, .. } => step,
                };
                let slack = pyramid.code().step * (step + 0.001);
                assert!(want_lo - lo <= slack && hi - want_hi <= slack, "bound is loose");
                if matches!(map.samples(), Samples::U16(_)) && layout == Layout::Default {
                    assert_eq!((lo, hi), (want_lo, want_hi));
                }
            }
        }
        assert_eq!(pyramid.verify(map), Ok(()));
    }
}

#[test]
fn a_flat_float_map_has_a_pyramid() {
    let samples = Samples::F32(vec![-3.25; 6]);
    let map = HeightMap::new(2, 3, samples, Lattice::Vertex, Wrap::Clamp).unwrap();
    for layout in Layout::ALL {
        assert_eq!(Pyramid::build_as(&map, layout).bounds(0, 0, 0), (-3.25, -3.25));
    }
}

#[test]
fn a_texel_of_a_large_map_takes_a_quarter_of_a_byte_or_less() {
    for (layout, most) in [(Layout::Default, 0.27), (Layout::Tiny, 0.15)] {
        let bytes = Pyramid::predicted_bytes([4096; 2], layout);
        assert!((bytes as f64) < most * 4096.0 * 4096.0, "{layout}: {bytes}");
    }
}

/// The longest axis there is: a spike at its far end, before and after an edit.
#[test]
fn the_longest_map_is_bounded_to_its_end() {
    let n = 1u32 << 24;
    let mut codes = vec![7; 2 * n as usize];
    codes[2 * n as usize - 1] = 262;
    let mut map = HeightMap::new(n, 2, Samples::U16(codes), Lattice::Texel, Wrap::Clamp).unwrap();
    let mut pyramid = Pyramid::build_as(&map, Layout::Tiny);
    let last = map.x().cells() - 1;
    assert_eq!(pyramid.blocks(0)[0], last / 4 + 1);
    assert_eq!(pyramid.bounds(0, last / 4, 0), (7.0, 262.0));
    assert_eq!(pyramid.bounds(0, (n - 4) / 4 - 1, 0), (7.0, 7.0));
    let rect = [n - 1..n, 0..2];
    map.edit(rect.clone(), |_, row| {
        if let RowMut::U16(row) = row {
            row.fill(90);
        }
    })
    .unwrap();
    pyramid.update(&map, rect);
    assert_eq!(pyramid.bounds(0, last / 4, 0), (90.0, 90.0));
    let top = pyramid.levels() - 1;
    assert_eq!([0, 1].map(|bx| pyramid.bounds(top, bx, 0)), [(7.0, 90.0), (90.0, 90.0)]);
    assert_eq!(pyramid, Pyramid::build_as(&map, Layout::Tiny));
}
