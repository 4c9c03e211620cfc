//! Image files, sound and damaged: known values, refusals, truncations, random damage.

use std::fs;
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use rilievo::map::{HeightMap, Lattice, Samples, Wrap};
use rilievo_io::image::{ChannelImage, HeightOptions, ImageFormat, SampleKind};
use rilievo_io::image::{read_colour, read_colour_bytes, read_image_info, write_png_grey16};
use rilievo_io::{Error, Limits};

/// 16 MiB: what a damaged header may ask for in these tests.
const LIMITS: Limits = Limits { max_bytes: 16 << 20 };

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data").join(name)
}

fn files(folder: &str) -> Vec<PathBuf> {
    let mut all: Vec<_> = fs::read_dir(data(folder)).unwrap().map(|e| e.unwrap().path()).collect();
    all.sort();
    assert!(!all.is_empty());
    all
}

fn height(name: &str) -> HeightMap {
    HeightOptions::default().read(&data(name), &LIMITS).unwrap()
}

/// The raw samples, top row of the file first.
fn from_top(map: &HeightMap) -> Vec<f32> {
    let row = |y: u32| (0..map.width()).map(move |x| map.raw(x, map.height() - 1 - y));
    (0..map.height()).flat_map(row).collect()
}

#[test]
fn every_sound_file_is_read_and_every_damaged_one_refused() {
    for format in ["png", "tiff", "exr", "jpeg"] {
        for path in files(&format!("{format}/valid")) {
            let map = HeightOptions::default().read(&path, &LIMITS);
            let map = map.unwrap_or_else(|e| panic!("{e}"));
            let info = read_image_info(&path, &LIMITS).unwrap();
            assert_eq!((info.width, info.height), (map.width(), map.height()), "{path:?}");
            assert_eq!(info.format.to_string().to_lowercase().replace("open", ""), format);
            let codes = matches!(map.samples(), Samples::U16(_));
            assert_eq!(codes, info.sample != SampleKind::F32, "{path:?}");
        }
        for path in files(&format!("{format}/invalid")) {
            let error = HeightOptions::default().read(&path, &LIMITS).unwrap_err();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            assert!(error.to_string().contains(&name), "{error}");
            assert!(!matches!(error, Error::Io { .. }), "{error}");
        }
    }
}

#[test]
fn png_samples_are_scaled_to_sixteen_bits() {
    // PngSuite draws the same ramps at each depth, interlaced or not.
    let ramp = from_top(&height("png/valid/basn0g08.png"));
    assert!(ramp[..256].iter().enumerate().all(|(k, &h)| h == (k * 257) as f32));
    let sixteen = from_top(&height("png/valid/basn0g16.png"));
    assert_eq!(&sixteen[..3], &[0.0, 2304.0, 4608.0]);
    for pair in [["basi0g04", "basn0g04"], ["basi0g08", "basn0g08"], ["basi0g16", "basn0g16"]] {
        let [a, b] = pair.map(|n| from_top(&height(&format!("png/valid/{n}.png"))));
        assert_eq!(a, b, "{pair:?}");
    }
    for (name, bits) in [("basn0g01", 1), ("basn0g02", 2), ("basn0g04", 4)] {
        let step = 65535 / ((1 << bits) - 1);
        let values = from_top(&height(&format!("png/valid/{name}.png")));
        assert!(values.iter().all(|h| (*h as u32).is_multiple_of(step)), "{name}");
        assert!(values.iter().any(|h| *h > 0.0));
    }
}

#[test]
fn tiff_samples_of_every_kind_hold_the_sequence() {
    for path in files("tiff/valid") {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let Some(kind) = name.strip_prefix("seq-1c-") else { continue };
        let want = |k: usize| match kind.split('-').next().unwrap() {
            "8b" => (k * 257) as f32,
            "16b" => k as f32,
            "32f" | "64f" => k as f32 / 255.0,
            _ => k as f32 - 128.0,
        };
        let map = HeightOptions::default().read(&path, &LIMITS).unwrap();
        let found = from_top(&map);
        assert_eq!(found.len(), 256);
        for (k, &h) in found.iter().enumerate() {
            assert!((h - want(k)).abs() <= 1e-7, "{name} sample {k}: {h}");
        }
    }
}

#[test]
fn grey_stored_as_colour_keeps_its_values_and_alpha_is_ignored() {
    let dir = tempfile::tempdir().unwrap();
    let codes: Vec<u16> = (0..64).map(|k| k * 1040).collect();
    let path = dir.path().join("grey.png");
    write_png_grey16(&path, [8, 8], &codes).unwrap();
    let grey = HeightOptions::default().read(&path, &LIMITS).unwrap();
    let same = |file: &str, channels: u32| {
        let info = read_image_info(&data(file), &LIMITS).unwrap();
        assert_eq!(info.channels, channels, "{file}");
    };
    same("png/valid/basn4a16.png", 2);
    same("png/valid/basn6a08.png", 4);
    same("png/valid/basn3p08.png", 3);
    // A palette whose entries are grey: the height is the entry itself.
    let palette = from_top(&height("png/valid/s02n3p01.png"));
    assert!(palette.windows(2).all(|p| p[0] == p[1]));
    let inverted = HeightOptions { invert: true, ..HeightOptions::default() };
    let inverted = inverted.read(&path, &LIMITS).unwrap();
    for (a, b) in from_top(&grey).iter().zip(from_top(&inverted)) {
        assert_eq!(a + b, 65535.0);
    }
}

/// A portable float map of `values`, given top row first.
fn pfm(width: usize, values: &[f32], little: bool) -> Vec<u8> {
    let height = values.len() / width;
    let scale = if little { "-1.0" } else { "1.0" };
    let mut bytes = format!("Pf\n{width} {height}\n{scale}\n").into_bytes();
    for value in values.chunks(width).rev().flatten() {
        bytes.extend(if little { value.to_le_bytes() } else { value.to_be_bytes() });
    }
    bytes
}

#[test]
fn pfm_rows_run_upwards_in_both_byte_orders() {
    let values = [1.5, -2.0, 3.0, 4.0, 5.0, -6.25];
    for little in [true, false] {
        let bytes = pfm(3, &values, little);
        let options = HeightOptions { lattice: Lattice::Vertex, wrap: Wrap::Clamp, invert: false };
        let map = options.read_bytes(&bytes, Path::new("a.pfm"), &LIMITS).unwrap();
        assert_eq!(from_top(&map), values);
        assert_eq!(map.height_at(0.0, 1.0), 1.5);
        assert_eq!(map.height_at(1.0, 0.0), -6.25);
    }
    let mut colour = b"PF 2 2 -1\n".to_vec();
    colour.extend([0.25_f32; 12].iter().flat_map(|v| v.to_le_bytes()));
    let read = HeightOptions::default().read_bytes(&colour, Path::new("a.pfm"), &LIMITS);
    assert_eq!(from_top(&read.unwrap()), [0.25; 4]);
}

#[test]
fn samples_that_are_not_finite_are_named_from_the_top_left() {
    let mut values = [0.0; 12];
    values[7] = f32::NAN;
    let bytes = pfm(4, &values, true);
    let e = HeightOptions::default().read_bytes(&bytes, Path::new("a.pfm"), &LIMITS).unwrap_err();
    let want = "a.pfm: sample (3, 1) from the top left: height: NaN; allowed: finite numbers below 1e18 in size";
    assert_eq!(e.to_string(), want);
    let e = read_colour(&data("exr/invalid/oom_exr"), &LIMITS).unwrap_err();
    assert!(e.to_string().contains("oom_exr"));
}

#[test]
fn headers_that_ask_for_too_much_are_refused_before_anything_is_allocated() {
    // A 2^31-1 square of 16-bit RGBA in 57 bytes; the checksum is right.
    let mut png =
        b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\x7f\xff\xff\xff\x7f\xff\xff\xff\x10\x06\0\0\0".to_vec();
    png.extend(crc(&png[12..]).to_be_bytes());
    png.extend(b"\0\0\0\0IDAT\x35\xaf\x06\x1e\0\0\0\0IEND\xae\x42\x60\x82");
    let pfm = b"Pf 4000000000 4000000000 -1\n".to_vec();
    for (name, bytes) in [("a.png", png), ("a.pfm", pfm)] {
        for limits in [Limits::default(), Limits { max_bytes: u64::MAX }] {
            let e = HeightOptions::default().read_bytes(&bytes, Path::new(name), &limits);
            assert!(e.is_err(), "{name}");
        }
        let e = HeightOptions::default().read_bytes(&bytes, Path::new(name), &LIMITS).unwrap_err();
        assert!(matches!(e, Error::Limit { allowed: 16777216, .. }), "{e}");
    }
    let small = Limits { max_bytes: 32 * 32 * 2 - 1 };
    let e = HeightOptions::default().read(&data("png/valid/basn0g16.png"), &small).unwrap_err();
    assert!(matches!(e, Error::Limit { needed: 2048, allowed: 2047, .. }), "{e}");
}

/// CRC-32 of a PNG chunk, bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    let step = |c: u32| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 };
    !bytes.iter().fold(u32::MAX, |c, &b| (0..8).fold(c ^ u32::from(b), |c, _| step(c)))
}

/// A small file of each format.
fn specimens() -> Vec<(&'static str, Vec<u8>)> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.exr");
    let names = ["R", "G", "B", "Z"];
    let channels = names
        .iter()
        .map(|name| rilievo_io::image::Channel {
            name: (*name).to_owned(),
            samples: (0..20).map(|k| k as f32 / 7.0).collect(),
        })
        .collect();
    let image = ChannelImage { width: 5, height: 4, channels, attributes: Vec::new() };
    image.picture().write_exr(&path).unwrap();
    vec![
        ("a.png", fs::read(data("png/valid/basn0g16.png")).unwrap()),
        ("i.png", fs::read(data("png/valid/basi3p08.png")).unwrap()),
        ("a.tiff", fs::read(data("tiff/valid/seq-1c-8b-lzw-20f3db0c.tiff")).unwrap()),
        ("t.tiff", fs::read(data("tiff/valid/seq-1c-8b-tiled-deflate-20f3db0c.tiff")).unwrap()),
        ("a.jpg", fs::read(data("jpeg/valid/cyan.jpg")).unwrap()),
        ("a.exr", fs::read(&path).unwrap()),
        ("s.exr", fs::read(data("exr/valid/stripes.exr")).unwrap()),
        ("a.pfm", pfm(3, &[1.0; 12], true)),
    ]
}

#[test]
fn every_truncation_is_an_error() {
    for (name, bytes) in specimens() {
        let read = |b: &[u8]| HeightOptions::default().read_bytes(b, Path::new(name), &LIMITS);
        assert!(read(&bytes).is_ok(), "{name}");
        for length in 0..bytes.len() {
            assert!(read(&bytes[..length]).is_err(), "{name} cut to {length} of {}", bytes.len());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damage_anywhere_never_panics(pick in 0..8_usize, changes in prop::collection::vec((any::<u16>(), any::<u8>()), 1..5)) {
        let (name, mut bytes) = specimens().swap_remove(pick);
        for (at, value) in changes {
            let at = usize::from(at) % bytes.len();
            bytes[at] = value;
        }
        let name = Path::new(name);
        if let Ok(map) = HeightOptions::default().read_bytes(&bytes, name, &LIMITS) {
            prop_assert!(map.bytes() <= LIMITS.max_bytes);
        }
        let _ = read_colour_bytes(&bytes, name, &LIMITS);
        let _ = ChannelImage::read_bytes(&bytes, name, &LIMITS);
    }
}

#[test]
fn formats_are_told_from_content() {
    assert_eq!(ImageFormat::of(b"PF\n1 1"), Some(ImageFormat::Pfm));
    assert_eq!(ImageFormat::of(b"P5\n1 1"), None);
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("really.exr");
    fs::copy(data("png/valid/basn0g08.png"), &path).unwrap();
    assert_eq!(read_image_info(&path, &LIMITS).unwrap().format, ImageFormat::Png);
    assert!(matches!(read_image_info(dir.path(), &LIMITS), Err(Error::Io { .. })));
}
