//! Mesh files of others: what is sound is read as it is meant, the rest is refused.

use std::fs;
use std::path::{Path, PathBuf};

use rilievo::glam::DVec3;
use rilievo::mesh::Mesh;
use rilievo_io::Limits;
use rilievo_io::mesh::{Model, NO_MATERIAL, read_mesh};

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/mesh")
}

fn model(file: &str) -> Model {
    Model::read(&data().join(file), &Limits::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// Files, and the positions, triangles, whether corners have normals and uvs that they hold.
const CASES: &[(&str, usize, usize, bool, bool)] = &[
    ("cube_blender_uv.ply", 24, 12, true, true),
    ("cube_blender_uv_meshlab.ply", 24, 12, false, true),
    ("cube_compressed.obj", 8, 12, true, false),
    ("empty.obj", 0, 0, false, false),
    ("empty.ply", 0, 0, false, false),
    ("emptyIO/obj_empty.obj", 0, 0, false, false),
    ("emptyIO/obj_points.obj", 8, 0, false, false),
    ("emptyIO/obj_wireframe.obj", 8, 0, false, false),
    ("emptyIO/ply_empty_ascii.ply", 0, 0, false, false),
    ("emptyIO/ply_empty_bin.ply", 0, 0, false, false),
    ("emptyIO/ply_empty_header.ply", 0, 0, false, false),
    ("emptyIO/ply_points_ascii.ply", 8, 0, false, false),
    ("emptyIO/ply_points_bin.ply", 8, 0, false, false),
    ("face_in_group_name.obj", 1, 0, false, false),
    ("face_in_group_name_mid_file.obj", 5, 2, false, false),
    ("ico4uv.obj", 642, 1280, true, true),
    ("metadata.ply", 4, 2, false, false),
    ("nancolor.obj", 8, 12, false, false),
    ("negative_indices.obj", 8, 12, true, true),
    ("plane.ply", 4, 2, true, true),
    ("plane_tri.ply", 4, 2, true, true),
    ("points_ascii_with_lists.ply", 5, 0, false, false),
    ("points_emptyascii.ply", 12, 0, false, false),
    ("polygonfaces.obj", 5, 3, true, false),
    ("tet.ply", 4, 4, false, false),
    ("two_objects.obj", 12, 16, false, false),
    ("cornell-box/CornellBox-Original.obj", 72, 36, false, false),
];

#[test]
fn every_case_is_read_as_it_is_meant() {
    for &(file, positions, triangles, normals, uvs) in CASES {
        let found = model(file);
        let all = &found.mesh.triangles;
        assert_eq!((found.mesh.positions.len(), all.len()), (positions, triangles), "{file}");
        assert!(all.iter().all(|t| t.normals.is_some() == normals), "{file}");
        assert!(all.iter().all(|t| t.uvs.is_some() == uvs), "{file}");
        assert_eq!(found.material_of.len(), triangles);
        // What has no face cannot be traced, and says so.
        match read_mesh(&data().join(file), &Limits::default()) {
            Ok(mesh) => assert_eq!(mesh.data().triangles.len(), triangles),
            Err(e) => assert!(triangles == 0 && e.to_string().contains("no triangles"), "{e}"),
        }
    }
    let files = |folder: &Path| {
        let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        files.filter(|p| p.extension().is_some_and(|e| e == "obj" || e == "ply")).count()
    };
    let folders = ["", "emptyIO", "cornell-box"].map(|name| files(&data().join(name)));
    assert_eq!(folders.iter().sum::<usize>(), CASES.len(), "a file without a case");
}

/// Twice the area, and six times the volume, of a mesh.
fn measure(model: &Model) -> [f64; 2] {
    model.mesh.triangles.iter().fold([0.0; 2], |[area, volume], t| {
        let [a, b, c] = t.positions.map(|i| model.mesh.positions[i as usize]);
        [area + (b - a).cross(c - a).length(), volume + a.dot(b.cross(c))]
    })
}

#[test]
fn shapes_have_their_sizes() {
    for (file, area, volume) in [
        ("cube_blender_uv.ply", 6.0, 1.0),
        ("cube_compressed.obj", 24.0, 8.0),
        ("negative_indices.obj", 24.0, 8.0),
        ("nancolor.obj", 6.0, 1.0),
    ] {
        let [found_area, found_volume] = measure(&model(file));
        assert!((found_area / 2.0 / area - 1.0).abs() < 1e-5, "{file}: {found_area}");
        assert!((found_volume / 6.0 / volume - 1.0).abs() < 1e-5, "{file}: {found_volume}");
    }
    // An icosphere of radius 1: a little less than the ball.
    let [area, _] = measure(&model("ico4uv.obj"));
    let share = area / 2.0 / (4.0 * std::f64::consts::PI);
    assert!(share < 1.0 && share > 0.98, "{share}");
}

#[test]
fn materials_come_with_their_faces() {
    let found = model("cornell-box/CornellBox-Original.obj");
    let names: Vec<_> = found.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names[..3], ["leftWall", "rightWall", "floor"]);
    assert!(found.notes.is_empty() && !found.material_of.contains(&NO_MATERIAL));
    let light = found.materials.iter().position(|m| m.emitted != DVec3::ZERO).unwrap();
    let parts = found.by_material();
    let (lamp, _) = parts.iter().find(|(_, m)| *m == Some(light)).unwrap();
    assert_eq!((lamp.triangles.len(), lamp.positions.len()), (2, 4));
    assert_eq!(parts.iter().map(|(d, _)| d.triangles.len()).sum::<usize>(), 36);
    assert!(parts.into_iter().all(|(data, _)| Mesh::new(data).is_ok()));
    let lost = model("polygonfaces.obj");
    assert!(lost.notes.iter().any(|note| note.contains("surface.mtl")), "{:?}", lost.notes);
    // Its smoothing group makes it smooth.
    assert_eq!(lost.mesh.normals.len(), 5);
}

#[test]
fn no_damaged_file_panics() {
    let limits = Limits { max_bytes: 1 << 20 };
    for &(file, ..) in CASES.iter().filter(|case| case.0 != "ico4uv.obj") {
        let bytes = fs::read(data().join(file)).unwrap();
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1 << (at % 8);
            if let Ok(model) = Model::read_bytes(&damaged, Path::new(file), &limits) {
                let _ = (model.by_material(), Mesh::new(model.mesh));
            }
        }
    }
}
