//! Folders of maps on the command line and in scenes.

use std::fs;

use rilievo::map::{Lattice, Metric, NormalConvention, NormalKind, NormalMap};
use rilievo::map::{Procedural, Samples, Wrap};
use rilievo_io::image::{write_png_grey16, write_png_rgb8, write_png_rgb16};

use crate::support::Folder;

const SIZE: [u32; 2] = [32, 16];

/// A folder `set` with albedo, heights (black is high if `turned`) and DirectX normals of depth 0.1.
fn folder(turned: bool) -> Folder {
    let folder = Folder::new();
    fs::create_dir(folder.path("set")).unwrap();
    let noise = Procedural::Fbm { octaves: 3, seed: 1 };
    let map = noise.height_map(SIZE, Lattice::Texel, Wrap::Repeat).unwrap();
    let Samples::U16(codes) = map.samples() else { panic!("codes were asked for") };
    let stored: Vec<u16> = codes.iter().map(|c| if turned { 65535 - c } else { *c }).collect();
    // Files begin with their top row.
    let top_first = |v: Vec<u16>| v.chunks(32).rev().flatten().copied().collect::<Vec<_>>();
    let path = |name: &str| folder.path("set").join(name);
    write_png_grey16(&path("Rock001_1K_Displacement.png"), SIZE, &top_first(stored)).unwrap();
    let metric = Metric::of_face(&map, [1.0, 0.5], 0.1);
    let normals = NormalMap::from_height(&map, NormalKind::Smooth, metric);
    let texels = normals.to_texels(NormalConvention::DirectX);
    let rows: Vec<_> = texels.chunks(32).rev().flatten().copied().collect();
    write_png_rgb16(&path("Rock001_1K_NormalDX.png"), SIZE, &rows).unwrap();
    write_png_rgb8(&path("Rock001_1K_Color.png"), SIZE, &[[200, 90, 40]; 512]).unwrap();
    folder
}

#[test]
fn info_says_what_is_what_and_how_normals_agree() {
    for turned in [false, true] {
        let json = folder(turned).run("info set --json").expect(0).json();
        let roles: Vec<_> = json["maps"].as_array().unwrap().iter().collect();
        let roles: Vec<_> = roles.iter().map(|m| m["role"].as_str().unwrap()).collect();
        assert_eq!(roles, ["albedo", "displacement", "normal"]);
        let (assumed, agreement) = (&json["assumed"], &json["agreement"]);
        assert_eq!(assumed["invert"].as_bool(), Some(turned));
        assert_eq!(agreement["convention"].as_str(), Some("directx"));
        assert!((assumed["scale"].as_f64().unwrap() - 0.1).abs() < 1e-3);
        assert!(agreement["mean_degrees"].as_f64().unwrap() < 0.1);
    }
}

#[test]
fn info_compares_a_map_with_normals() {
    let folder = folder(false);
    let words = "set/Rock001_1K_Displacement.png --normals set/Rock001_1K_NormalDX.png";
    let run = folder.run(&format!("info {words} --json")).expect(0);
    assert_eq!(run.json()["agreement"]["convention"].as_str(), Some("directx"));
    assert!(run.stderr.contains("DirectX, green points down"), "{}", run.stderr);
}

#[test]
fn a_folder_is_rendered_and_what_was_assumed_is_said() {
    let folder = folder(false);
    let run = folder.run("render set -o a.exr --resolution 32x24 --samples 1").expect(0);
    for word in ["albedo: Rock001_1K_Color.png", "normal map fits", "zero 0.5"] {
        assert!(run.stderr.contains(word), "{word} in {}", run.stderr);
    }
    let run = Folder::new().run("render . -o a.exr").expect(1);
    assert!(run.stderr.contains("no map among 0 images"), "{}", run.stderr);
}

/// What a scene leaves to a set is what the same scene with files says.
#[test]
fn scenes_name_folders_where_they_name_files() {
    let folder = folder(true);
    let scene = |extra: &str, shape: &str| {
        format!(
            "[camera]\nposition = [1, -2, 2]\nlook_at = [1, 0.5, 0]\nresolution = [40, 30]\n\
             [render]\nambient = [1, 1, 1]\nsamples = 1\n{extra}[[shapes]]\ntype = \"quad\"\n\
             corners = [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]\n{shape}\n"
        )
    };
    folder.write(
        "files.toml",
        &scene(
            "[maps.a]\nfile = \"set/Rock001_1K_Displacement.png\"\ninvert = true\n\
             [materials.a]\ntexture = \"set/Rock001_1K_Color.png\"\n",
            "material = \"a\"\ndisplacement = { map = \"a\", scale = 0.1, zero = 0.5, normals = \
             { file = \"set/Rock001_1K_NormalDX.png\", convention = \"directx\" } }",
        ),
    );
    folder.run("render files.toml -o files.exr").expect(0);
    for (name, extra, shape) in [
        (
            "bare",
            "",
            "displacement = { map = \"set/\", scale = 0.1, normals = { file = \"set/\" } }",
        ),
        (
            "named",
            "[maps.a]\nfile = \"set/\"\n[materials.a]\ntexture = \"set/\"\n",
            "material = \"a\"\ndisplacement = { map = \"a\", scale = 0.1, normals = { file = \"set/\" } }",
        ),
    ] {
        folder.write(&format!("{name}.toml"), &scene(extra, shape));
        folder.run(&format!("render {name}.toml -o {name}.exr")).expect(0);
        folder.run(&format!("diff files.exr {name}.exr")).expect(0);
        let check = folder.run(&format!("check {name}.toml --json")).expect(0).json();
        assert_eq!(check["valid"].as_bool(), Some(true));
    }
    for (shape, want) in [
        ("displacement = { map = \"none/\" }", "none/"),
        (
            "displacement = { map = \"set/\", normals = { file = \"x.png\" } }",
            "the key `convention` is missing",
        ),
    ] {
        folder.write("bad.toml", &scene("", shape));
        let run = folder.run("check bad.toml").expect(1);
        assert!(run.stderr.contains(want) && run.stderr.contains("bad.toml:"), "{}", run.stderr);
    }
}

/// Two tiles side by side are what their numbers say: uv from 0 to 2.
#[test]
fn tiles_lie_on_their_own_squares_of_uv() {
    let folder = Folder::new();
    let codes = |high: u16| [[high; 8], [0; 8]].concat();
    write_png_grey16(&folder.path("a_1001.png"), [4, 4], &codes(60000)).unwrap();
    write_png_grey16(&folder.path("a_1002.png"), [4, 4], &codes(20000)).unwrap();
    let both: Vec<u16> = codes(60000)
        .chunks(4)
        .zip(codes(20000).chunks(4))
        .flat_map(|(a, b)| [a, b].concat())
        .collect();
    write_png_grey16(&folder.path("both.png"), [8, 4], &both).unwrap();
    let scene = |file: &str, tile: f64| {
        format!(
            "[camera]\nposition = [1, -2, 3]\nlook_at = [1, 0.5, 0]\nresolution = [48, 36]\n\
             [render]\nambient = [1, 1, 1]\nsamples = 1\n[maps.a]\nfile = \"{file}\"\n[materials.a]\n\
             texture = {{ file = \"{file}\", tile = [{tile}, 1] }}\n[[shapes]]\ntype = \"quad\"\n\
             corners = [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]\nmaterial = \"a\"\n\
             displacement = {{ map = \"a\", scale = 0.3, tile = [{tile}, 1] }}\n"
        )
    };
    folder.write("tiles.toml", &scene("a_<UDIM>.png", 2.0));
    folder.write("both.toml", &scene("both.png", 1.0));
    for name in ["tiles", "both"] {
        folder.run(&format!("render {name}.toml -o {name}.exr")).expect(0);
    }
    folder.run("diff tiles.exr both.exr").expect(0);
    let check = folder.run("check tiles.toml --json").expect(0).json();
    assert_eq!(check["files"].as_u64(), Some(2));
    let run = folder.run("info a_<UDIM>.png --json").expect(0).json();
    assert_eq!((run["width"].as_u64(), run["height"].as_u64()), (Some(8), Some(4)));
}
