//! Terrain: heights of survey formats, their ground, and how a scene lays them out.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use rilievo::glam::DVec3;
use rilievo::map::{HeightMap, Samples};
use rilievo::surface::Surface;
use rilievo_io::Limits;
use rilievo_io::image::{HeightOptions, Terrain};
use rilievo_io::scene::{LoadOptions, SceneFile};
use tiff::encoder::{TiffEncoder, colortype};
use tiff::tags::Tag;

fn write(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) -> std::path::PathBuf {
    let path = folder.join(name);
    fs::write(&path, bytes).unwrap();
    path
}

fn heights(path: &Path) -> (HeightMap, u64) {
    HeightOptions::default().read_with_voids(path, &Limits::default()).unwrap()
}

fn floats(map: &HeightMap) -> &[f32] {
    match map.samples() {
        Samples::F32(all) => all,
        Samples::U16(_) => panic!("codes"),
    }
}

fn ground(path: &Path) -> Terrain {
    Terrain::read(path, &Limits::default()).unwrap().unwrap()
}

const GRID: &str = "ncols 3\nnrows 2\nxllcorner 500000\nyllcorner 4000000\ncellsize 30\n\
                    NODATA_value -9999\n10 20 -9999\n40 50\n60\n";

#[test]
fn an_ascii_grid_has_its_top_row_first_and_voids_become_the_lowest() {
    let dir = tempfile::tempdir().unwrap();
    let path = write(dir.path(), "a.asc", GRID);
    let (map, voids) = heights(&path);
    assert_eq!((floats(&map), voids), (&[40.0, 50.0, 60.0, 10.0, 20.0, 10.0][..], 1));
    assert_eq!(ground(&path), Terrain { cell: [30.0; 2], metre: 1.0, latitude: None });
    let degrees = GRID.replace("500000", "-105.5").replace("4000000", "40").replace(" 30", " 0.01");
    let found = ground(&write(dir.path(), "b.asc", degrees));
    assert!((found.latitude.unwrap() - 40.01).abs() < 1e-9 && found.cell[0] < found.cell[1]);
    for (from, to, want) in [
        ("ncols 3", "ncols 0", "ncols: 0"),
        ("ncols 3", "ncols x", "ncols: x; allowed: a number"),
        ("ncols 3", "ncols 4000000000", "needs"),
        ("cellsize", "cell", "key: cell"),
        ("60\n", "", "the file ends before its data"),
        ("40 50", "40 5o", "\"5o\" in row 1 is no number"),
        ("10 20 -9999\n40 50\n60", "-9999 -9999 -9999 -9999 -9999 -9999", "nothing but samples"),
    ] {
        assert!(GRID.contains(from));
        let path = write(dir.path(), "bad.asc", GRID.replace(from, to));
        let limits = Limits { max_bytes: 1 << 20 };
        let error = HeightOptions::default().read(&path, &limits).unwrap_err().to_string();
        assert!(error.contains(want), "{to}: {error}");
    }
}

#[test]
fn srtm_tiles_are_big_endian_metres_with_voids() {
    let dir = tempfile::tempdir().unwrap();
    let metres: [i16; 9] = [1, 2, 3, 4, -32768, 6, 7, -8, 900];
    let bytes: Vec<u8> = metres.iter().flat_map(|m| m.to_be_bytes()).collect();
    let path = write(dir.path(), "S05E012.hgt", &bytes);
    let (map, voids) = heights(&path);
    assert_eq!(floats(&map), [7.0, -8.0, 900.0, 4.0, -8.0, 6.0, 1.0, 2.0, 3.0]);
    assert_eq!(voids, 1);
    let found = ground(&path);
    assert!((found.latitude.unwrap() + 4.5).abs() < 0.5, "{found:?}");
    assert!((found.cell[1] / 55_288.0 - 1.0).abs() < 1e-3, "{found:?}");
    let path = write(dir.path(), "tile.hgt", &bytes);
    assert_eq!(Terrain::read(&path, &Limits::default()).unwrap(), None);
    let path = write(dir.path(), "short.hgt", &bytes[..16]);
    let error = HeightOptions::default().read(&path, &Limits::default()).unwrap_err().to_string();
    assert!(error.contains("16 bytes; allowed: twice a square"), "{error}");
}

#[test]
fn raw_samples_are_as_their_header_says() {
    let dir = tempfile::tempdir().unwrap();
    let header =
        "NROWS 2\r\nNCOLS 2\r\nNBITS 16\r\nBYTEORDER M\r\nSKIPBYTES 1\r\nXDIM 5\r\nYDIM 10\r\n";
    let bytes: Vec<u8> =
        [7].into_iter().chain([1_u16, 2, 3, 65535].iter().flat_map(|c| c.to_be_bytes())).collect();
    let path = write(dir.path(), "a.bil", &bytes);
    write(dir.path(), "a.hdr", header);
    let (map, _) = heights(&path);
    assert_eq!(*map.samples(), Samples::U16(vec![3, 65535, 1, 2]));
    assert_eq!(ground(&path).cell, [5.0, 10.0]);
    write(dir.path(), "a.hdr", format!("{header}PIXELTYPE SIGNEDINT\r\nNODATA -1\r\n"));
    let (map, voids) = heights(&path);
    assert_eq!((floats(&map), voids), (&[3.0, 1.0, 1.0, 2.0][..], 1));
    for (text, want) in [
        ("NROWS 2\n", "NCOLS: missing"),
        ("NROWS 2\nNCOLS 2\nNBITS 4\n", "PIXELTYPE: UNSIGNEDINT of 4 bits"),
        ("NROWS 2\nNCOLS 2\nBYTEORDER X\n", "BYTEORDER: X"),
        ("NROWS 2\nNCOLS 2\nNBANDS 3\n", "NBANDS: 3; allowed: 1"),
        ("NROWS 9\nNCOLS 2\n", "row 4"),
        ("NROWS 4000000000\nNCOLS 4000000000\n", "needs"),
    ] {
        write(dir.path(), "a.hdr", text);
        let error =
            HeightOptions::default().read(&path, &Limits::default()).unwrap_err().to_string();
        assert!(error.contains(want), "{text}: {error}");
    }
    // The fuzz target's seeds, as the target reads them: a header, a zero, the samples.
    let seeds = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds/raw_file");
    let limits = Limits { max_bytes: 1 << 20 };
    for (name, want) in [
        ("signed", None),
        ("floats", Some("finite numbers")),
        ("codes", None),
        ("flat_cells", None),
        ("huge", Some("needs")),
        ("wide", Some("needs")),
        ("short", Some("row 2")),
        ("skipped", Some("row 0")),
        ("bands", Some("NBANDS: 3")),
        ("bits", Some("of 4 bits")),
        ("all_void", Some("nothing but samples")),
        ("no_place", Some("XDIM: 1e999")),
        ("no_header", Some("NCOLS: missing")),
        ("letters", Some("NROWS: two")),
        ("endless_line", Some("NCOLS: 333")),
    ] {
        let seed = fs::read(seeds.join(name)).unwrap();
        let end = seed.iter().position(|&byte| byte == 0).unwrap();
        write(dir.path(), "a.hdr", &seed[..end]);
        let path = write(dir.path(), "a.bil", &seed[end + 1..]);
        match (HeightOptions::default().read(&path, &limits), want) {
            (Ok(map), None) => assert!(map.height_at(0.3, 0.7).is_finite(), "{name}"),
            (Err(error), Some(want)) => {
                assert!(error.to_string().contains(want), "{name}: {error}");
            }
            (found, _) => panic!("{name}: {found:?}"),
        }
    }
    fs::remove_file(dir.path().join("a.hdr")).unwrap();
    assert!(HeightOptions::default().read(&path, &Limits::default()).is_err());
}

/// A GeoTIFF of 3 x 2 metres with these keys and this size of a pixel.
fn geotiff(keys: &[u16], scale: f64) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
    let mut image = encoder.new_image::<colortype::Gray32Float>(3, 2).unwrap();
    let tags = image.encoder();
    tags.write_tag(Tag::Unknown(33550), &[scale, scale, 0.0][..]).unwrap();
    tags.write_tag(Tag::Unknown(33922), &[0.0, 0.0, 0.0, -105.0, 60.0, 0.0][..]).unwrap();
    tags.write_tag(Tag::Unknown(34735), keys).unwrap();
    tags.write_tag(Tag::Unknown(42113), "-9999").unwrap();
    image.write_data(&[1.0, 2.0, 3.0, -9999.0, 5.0, 6.0]).unwrap();
    bytes.into_inner()
}

#[test]
fn geotiffs_tell_their_ground_and_their_voids() {
    let dir = tempfile::tempdir().unwrap();
    let projected = write(dir.path(), "a.tif", geotiff(&[1, 1, 0, 1, 1024, 0, 1, 1], 30.0));
    let (map, voids) = heights(&projected);
    assert_eq!((floats(&map), voids), (&[1.0, 5.0, 6.0, 1.0, 2.0, 3.0][..], 1));
    assert_eq!(ground(&projected), Terrain { cell: [30.0; 2], metre: 1.0, latitude: None });
    let feet = [1, 1, 0, 3, 1024, 0, 1, 1, 3076, 0, 1, 9002, 4099, 0, 1, 9002];
    let found = ground(&write(dir.path(), "b.tif", geotiff(&feet, 100.0)));
    assert_eq!(found, Terrain { cell: [30.48; 2], metre: 0.3048, latitude: None });
    let degrees = ground(&write(dir.path(), "c.tif", geotiff(&[1, 1, 0, 1, 1024, 0, 1, 2], 0.01)));
    assert!((degrees.latitude.unwrap() - 59.99).abs() < 1e-9, "{degrees:?}");
    assert!((degrees.cell[0] / 558.0 - 1.0).abs() < 1e-3, "{degrees:?}");
}

#[test]
fn a_scene_lays_terrain_out_in_metres() {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), "a.asc", GRID);
    let scene = |map: &str, shape: &str| {
        let text = format!(
            "[camera]\nposition = [0, 0, 9]\nlook_at = [0, 1, 0]\n[maps.dem]\nfile = \"a.asc\"\n{map}\n\
             [[shapes]]\ntype = \"terrain\"\nmap = \"dem\"\n{shape}\n"
        );
        let file = SceneFile::parse(&text, &dir.path().join("scene.toml")).unwrap();
        file.load(&LoadOptions::default())
    };
    let loaded = scene("", "unit = 10\nexaggeration = 2\ncenter = [1, 2, 3]\nzero = 20").unwrap();
    let Surface::Face(face) = &loaded.scene.world().surfaces()[0] else { panic!("no relief") };
    let displacement = face.options().displacement;
    assert_eq!((displacement.scale, displacement.zero), (0.2, 20.0));
    let bounds = face.bounds();
    assert!((bounds.min - DVec3::new(1.0 - 4.5, 2.0 - 3.0, 3.0 - 2.0)).abs().max_element() < 1e-3);
    assert!((bounds.max - DVec3::new(1.0 + 4.5, 2.0 + 3.0, 3.0 + 8.0)).abs().max_element() < 1e-3);
    assert!(loaded.notes[0].contains("90 x 60 m") && loaded.notes[0].contains("1 samples without"));
    // On the vertex lattice the outer samples are the border; the lowest height is the zero.
    let loaded = scene("grid = \"vertex\"", "cell = [1, 2]").unwrap();
    let bounds = loaded.scene.world().bounds();
    assert!((bounds.max - DVec3::new(1.0, 1.0, 50.0)).abs().max_element() < 1e-3, "{bounds:?}");
}
