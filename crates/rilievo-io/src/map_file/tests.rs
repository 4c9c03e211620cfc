//! Baked maps come back as they were written; damaged ones are errors.

use rilievo::map::{DistanceKind, DistanceOptions, Layout, NormalKind, Procedural, Pyramid};

use super::*;

const LIMITS: Limits = Limits { max_bytes: 1 << 20 };

fn heights(lattice: Lattice, wrap: Wrap) -> HeightMap {
    let fbm = Procedural::Fbm { octaves: 3, seed: 7 };
    fbm.height_map([37, 21], lattice, wrap).unwrap()
}

/// One map of every kind.
fn all(heights: &HeightMap) -> Vec<BakedMap> {
    let source = MapSource::of(heights);
    let metric = Metric { x: 0.1, y: 0.2, z: 3e-5 };
    let distance = |kind, size, bits| {
        let options = DistanceOptions { size, metric, bits };
        BakedContent::Distances(DistanceMap::from_height(heights, kind, &options).unwrap())
    };
    let normals = NormalMap::from_height(heights, NormalKind::Smooth, metric);
    let texels = normals.to_texels(NormalConvention::OpenGl);
    let bounds = |layout| {
        let pyramid = Pyramid::build_as(heights, layout);
        let levels = (0..pyramid.levels()).map(|l| pyramid.level(l).clone()).collect();
        BakedContent::MinMax(levels)
    };
    [
        BakedContent::Normals(BakedNormals { metric, texels }),
        distance(DistanceKind::Published, [9, 6, 4], DistanceBits::U8),
        distance(DistanceKind::Boxes, [7, 5, 3], DistanceBits::U8),
        distance(DistanceKind::Corrected, [6, 5, 3], DistanceBits::U16),
        bounds(Layout::Default),
        bounds(Layout::Tiny),
    ]
    .map(|content| BakedMap { source, content })
    .into()
}

fn file(map: &BakedMap) -> Vec<u8> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.rlv");
    map.write(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(BakedMap::read(&path, &LIMITS).unwrap(), *map);
    bytes
}

fn read(bytes: &[u8]) -> Result<BakedMap> {
    BakedMap::read_bytes(bytes, Path::new("a.rlv"), &LIMITS)
}

#[test]
fn maps_come_back_bit_for_bit() {
    for lattice in [Lattice::Vertex, Lattice::Texel] {
        for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
            let heights = heights(lattice, wrap);
            for map in all(&heights) {
                let bytes = file(&map);
                let back = read(&bytes).unwrap();
                assert_eq!(back, map);
                assert_eq!(file(&back), bytes);
                assert_eq!(back.source, MapSource::of(&heights));
                match &back.content {
                    BakedContent::MinMax(levels) => {
                        let pyramid = Pyramid::from_levels(levels.clone(), &heights).unwrap();
                        assert_eq!(pyramid, Pyramid::build_as(&heights, pyramid.layout()));
                    }
                    BakedContent::Distances(map) => assert!(map.fits(&heights)),
                    BakedContent::Normals(normals) => {
                        let map = normals.normal_map(&back.source).unwrap();
                        assert_eq!(
                            map.to_texels(NormalConvention::OpenGl).len(),
                            normals.texels.len()
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn every_truncation_and_every_changed_bit_is_an_error() {
    for map in all(&heights(Lattice::Texel, Wrap::Repeat)) {
        let bytes = file(&map);
        for length in 0..bytes.len() {
            assert!(read(&bytes[..length]).is_err(), "cut to {length}");
        }
        assert!(read(&[&bytes[..], &[0]].concat()).is_err());
        let mut bad = bytes.clone();
        for bit in (0..header::BYTES * 8).chain((header::BYTES * 8..bytes.len() * 8).step_by(7)) {
            bad[bit / 8] ^= 1 << (bit % 8);
            assert!(read(&bad).is_err(), "bit {bit}");
            bad[bit / 8] = bytes[bit / 8];
        }
    }
}

#[test]
fn fields_out_of_range_are_named_even_with_a_right_checksum() {
    let maps = all(&heights(Lattice::Texel, Wrap::Repeat));
    let change = |map: &BakedMap, at: usize, value: &[u8]| {
        let mut bytes = file(map);
        bytes[at..at + value.len()].copy_from_slice(value);
        let mut sum = Checksum::default();
        sum.add(&bytes[..120]);
        bytes[120..128].copy_from_slice(&sum.finish().to_le_bytes());
        read(&bytes).unwrap_err().to_string()
    };
    let most = u32::MAX.to_le_bytes();
    let nan = f64::NAN.to_le_bytes();
    for (map, at, value, want) in [
        (0, 0, &most[..], "first bytes"),
        (0, 8, &most, "version: 4294967295; allowed: 1 or 2"),
        (0, 12, &most, "kind"),
        (0, 16, &most, "size"),
        (1, 16, &most, "payload bytes"),
        (1, 28, &[9], "bits: 9"),
        (0, 28, &[8], "bits: 8"),
        (0, 32, &[1, 0, 0, 0], "samples of the height map"),
        (0, 36, &most, "samples of the height map"),
        (0, 40, &[2], "lattice"),
        (0, 44, &[3], "wrap"),
        (2, 48, &nan, "metric"),
        (2, 72, &nan, "quantum"),
        (2, 72, &[0; 8], "quantum"),
        (2, 80, &f32::NAN.to_le_bytes(), "raw heights"),
        (3, 96, &most, "payload bytes"),
        (4, 104, &[0; 8], "payload checksum"),
        (4, 112, &[1], "spare field: 1; allowed: 0"),
        (4, 24, &[9], "size"),
        (4, 28, &[8], "version: 1; allowed: 2"),
        (4, 28, &[9], "bits: 9"),
        (5, 8, &[1], "version: 1; allowed: 2"),
        (5, 28, &[16], "payload bytes"),
    ] {
        let error = change(&maps[map], at, value);
        assert!(error.contains(want), "{at}: {error}");
    }
}

#[test]
fn declared_sizes_are_limited_before_anything_is_allocated() {
    let map = &all(&heights(Lattice::Texel, Wrap::Repeat))[2];
    let bytes = file(map);
    let small = Limits { max_bytes: 7 * 5 * 3 - 1 };
    let error = BakedMap::read_bytes(&bytes, Path::new("a"), &small).unwrap_err();
    assert!(matches!(error, Error::Limit { needed: 105, allowed: 104, .. }), "{error}");
}

#[test]
fn content_that_is_not_of_its_source_is_not_written() {
    let maps = all(&heights(Lattice::Texel, Wrap::Repeat));
    let dir = tempfile::tempdir().unwrap();
    let mut map = maps[0].clone();
    map.source.samples = [38, 21];
    assert!(map.write(&dir.path().join("a")).is_err());
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
}
