//! `rilievo bake`, `info` and `check`.

use rilievo::map::{Lattice, Layout, LevelBounds, NormalConvention, Wrap};
use rilievo_io::Limits;
use rilievo_io::image::NormalOptions;
use rilievo_io::map_file::{BakedContent, BakedMap};
use serde_json::Value;

use crate::support::Folder;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect()
}

#[test]
fn every_kind_is_baked_told_and_found_safe() {
    let folder = Folder::new().with_scene();
    let kinds = [
        ("normal map.png -o a.map", "normal", [32.0, 32.0, 1.0]),
        ("bounds map.png -o a.map", "min-max", [32.0, 32.0, 2.0]),
        ("bounds map.png -o a.map --layout tiny", "min-max", [32.0, 32.0, 2.0]),
        ("distance map.png -o a.map", "boxes", [32.0, 32.0, 32.0]),
        ("distance map.png -o a.map --size 8,9,10 --bits 8", "boxes", [8.0, 9.0, 10.0]),
        (
            "distance map.png -o a.map --kind corrected --face 2x3 --depth 0.2 --size 9,9,5",
            "corrected",
            [9.0, 9.0, 5.0],
        ),
    ];
    for (words, kind, size) in kinds {
        let json = folder.run(&format!("bake {words} --json")).expect(0).json();
        assert_eq!((json["kind"].as_str(), numbers(&json["size"])), (Some(kind), size.to_vec()));
        assert!(json["bytes"].as_u64().unwrap() > 0);
        let info = folder.run("info a.map --json").expect(0).json();
        assert_eq!((info["kind"].as_str(), numbers(&info["size"])), (Some(kind), size.to_vec()));
        assert_eq!(info["bytes"], json["bytes"]);
        let check = folder.run("check a.map --map map.png --json").expect(0).json();
        assert_eq!(check["safe"].as_bool(), Some(true), "{words}");
        assert_eq!(check["same_source"].as_bool(), Some(true));
        let check = folder.run("check a.map --json").expect(0).json();
        assert!(check["safe"].is_null());
    }
}

#[test]
fn published_distances_are_counted_and_unsafe() {
    let folder = Folder::new().with_scene();
    folder.run("bake distance map.png -o a.map --kind published --depth 0.2").expect(0);
    let check = folder.run("check a.map --map map.png --json").expect(3).json();
    assert_eq!(check["safe"].as_bool(), Some(false));
    let (found, all) =
        (check["unsafe_values"].as_u64().unwrap(), check["values"].as_u64().unwrap());
    assert!(found > 0 && found < all, "{found} of {all}");
}

#[test]
fn a_bound_moved_by_one_step_is_found() {
    let folder = Folder::new().with_scene();
    for layout in Layout::ALL {
        folder.run(&format!("bake bounds map.png -o a.map --layout {layout}")).expect(0);
        let path = folder.path("a.map");
        let mut map = BakedMap::read(&path, &Limits::default()).unwrap();
        if let BakedContent::MinMax(levels) = &mut map.content {
            match &mut levels[0].bounds {
                LevelBounds::Wide { max, .. } => max[0][0] -= 1,
                LevelBounds::Tiny { max, .. } => max[0][0] -= 1,
            }
        }
        map.write(&path).unwrap();
        let run = folder.run("check a.map --map map.png").expect(3);
        assert!(run.stderr.contains("maximum"), "{}", run.stderr);
    }
}

#[test]
fn a_map_of_other_heights_is_not_safe() {
    let folder = Folder::new().with_scene();
    folder.run("bake distance map.png -o a.map").expect(0);
    let check = folder.run("check a.map --map map.png --invert --json").expect(3).json();
    assert_eq!(check["same_source"].as_bool(), Some(false));
}

#[test]
fn damaged_maps_cannot_be_read() {
    let folder = Folder::new().with_scene();
    folder.run("bake bounds map.png -o a.map").expect(0);
    let sound = folder.bytes("a.map");
    let mut flipped = sound.clone();
    flipped[200] ^= 1;
    for damaged in [&sound[..100], &sound[..sound.len() - 1], &flipped[..]] {
        std::fs::write(folder.path("a.map"), damaged).unwrap();
        folder.run("check a.map --map map.png").expect(1);
        folder.run("info a.map").expect(1);
    }
}

#[test]
fn normals_as_png_keep_their_convention() {
    let folder = Folder::new().with_scene();
    let bake = "bake normal map.png --face 2x2 --depth 0.5";
    folder.run(&format!("{bake} -o gl.png")).expect(0);
    folder.run(&format!("{bake} -o dx.png --convention directx")).expect(0);
    let read = |name: &str, convention| {
        let options = NormalOptions { convention, lattice: Lattice::Texel, wrap: Wrap::Repeat };
        options.read(&folder.path(name), &Limits::default()).unwrap()
    };
    let (gl, dx) =
        (read("gl.png", NormalConvention::OpenGl), read("dx.png", NormalConvention::DirectX));
    for (u, v) in [(0.1, 0.2), (0.6, 0.9)] {
        assert!((gl.normal_at(u, v) - dx.normal_at(u, v)).length() < 1e-4);
    }
    assert_ne!(folder.bytes("gl.png"), folder.bytes("dx.png"));
}

#[test]
fn info_of_a_height_map_tells_depth_range_levels_and_seams() {
    let folder = Folder::new().with_scene();
    let json = folder.run("info map.png --json --resolution 100x50").expect(0).json();
    assert_eq!((json["width"].as_u64(), json["file_bits"].as_u64()), (Some(32), Some(16)));
    let (range, raw) = (numbers(&json["range"]), numbers(&json["raw_range"]));
    assert!(range[0] < range[1] && (range[1] * 65535.0 - raw[1]).abs() < 1e-6);
    assert!(json["levels"].as_u64().unwrap() > 500);
    assert_eq!((json["tiles"].as_bool(), json["terraces"].as_bool()), (Some(true), Some(false)));
    for key in ["map_bytes", "bounds_bytes", "predicted_bytes"] {
        assert!(json[key].as_u64().unwrap() > 0, "{key}");
    }
    let text = folder.run("info map.png").expect(0).stderr;
    for word in ["32 x 32", "16 bit", "distinct levels", "seam in u", "tiles", "MiB"] {
        assert!(text.contains(word), "{word} in {text}");
    }
}

#[test]
fn info_and_check_of_a_scene() {
    let folder = Folder::new().with_scene();
    let info = folder.run("info scene.toml --json").expect(0).json();
    for (key, want) in [("reliefs", 1), ("quads", 1), ("spheres", 1), ("meshes", 0), ("lights", 1)]
    {
        assert_eq!(info[key].as_u64(), Some(want), "{key}");
    }
    assert_eq!(info["map_bytes"].as_u64(), Some(2048));
    let large = folder.run("info scene.toml --json --resolution 4000x4000").expect(0).json();
    assert!(large["predicted_bytes"].as_u64() > Some(13 * 16_000_000));
    let check = folder.run("check scene.toml --json").expect(0).json();
    assert_eq!(check["valid"].as_bool(), Some(true));
    std::fs::remove_file(folder.path("map.png")).unwrap();
    let run = folder.run("check scene.toml").expect(1);
    assert!(run.stderr.contains("map.png"), "{}", run.stderr);
}
