//! Models in scenes: what their files say of displacement, and what shapes say of uv and normals.

use std::fs;
use std::path::Path;

use rilievo::Ray;
use rilievo::glam::{DVec2, DVec3};
use rilievo::surface::Surface;
use rilievo_io::Error;
use rilievo_io::image::write_png_grey16;
use rilievo_io::scene::{LoadOptions, LoadedScene, SceneFile};

/// A square of side 2 with uv; its material lifts it by `0.5 H - 0.1`.
fn write_obj(folder: &Path) {
    let obj = "mtllib a.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
               usemtl stone\nf 1/1 2/2 3/3 4/4\n";
    fs::write(folder.join("a.obj"), obj).unwrap();
    fs::write(folder.join("a.mtl"), "newmtl stone\nKd 1 0 0\ndisp -mm -0.1 0.5 h.png\n").unwrap();
    write_png_grey16(&folder.join("h.png"), [2, 2], &[65535; 4]).unwrap();
}

fn load(folder: &Path, shape: &str) -> Result<LoadedScene, Error> {
    let text = format!(
        "[camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\n[maps.h]\nfile = \"h.png\"\n\
         [[shapes]]\ntype = \"mesh\"\n{shape}\n"
    );
    SceneFile::parse(&text, &folder.join("scene.toml")).unwrap().load(&LoadOptions::default())
}

/// Where a ray straight down meets the scene, and the uv there.
fn below(loaded: &LoadedScene, x: f64, y: f64) -> (f64, DVec2) {
    let ray = Ray::new(DVec3::new(x, y, 9.0), -DVec3::Z);
    let hit = loaded.scene.world().closest(&ray, &mut ()).expect("a hit");
    (hit.position.z, hit.uv)
}

#[test]
fn a_model_is_displaced_as_its_material_says() {
    let dir = tempfile::tempdir().unwrap();
    write_obj(dir.path());
    let loaded = load(dir.path(), "file = \"a.obj\"").unwrap();
    assert!(matches!(loaded.scene.world().surfaces(), [Surface::ReliefMesh(_)]));
    assert!((below(&loaded, 0.3, -0.2).0 - 0.4).abs() < 1e-5);
    // Its depth is in units of the file.
    let shape = "file = \"a.obj\"\ntransform = { scale = 3 }";
    assert!((below(&load(dir.path(), shape).unwrap(), 0.3, -0.2).0 - 1.2).abs() < 1e-5);
    // A material of the scene, or a displacement of its own, goes before the file's.
    let shape = "file = \"a.obj\"\ndisplacement = { map = \"h\", scale = 0.25 }";
    assert!((below(&load(dir.path(), shape).unwrap(), 0.3, -0.2).0 - 0.25).abs() < 1e-5);
    fs::remove_file(dir.path().join("h.png")).unwrap();
    let error = load(dir.path(), "file = \"a.obj\"").unwrap_err().to_string();
    assert!(error.contains("scene.toml:9:8: displacement") && error.contains("h.png"), "{error}");
}

#[test]
fn a_projection_stands_in_for_missing_uv() {
    let dir = tempfile::tempdir().unwrap();
    write_obj(dir.path());
    let text = fs::read_to_string(dir.path().join("a.obj")).unwrap();
    fs::write(dir.path().join("a.obj"), text.replace("1/1 2/2 3/3 4/4", "1 2 3 4")).unwrap();
    let error = load(dir.path(), "file = \"a.obj\"").unwrap_err().to_string();
    assert!(error.contains("displacement of \"stone\": triangle 0 has no texture"), "{error}");
    assert!(error.contains("or `projection` in the shape"), "{error}");
    for (projection, want) in [("z", DVec2::new(0.75, 0.25)), ("box", DVec2::new(0.75, 0.25))] {
        let shape = format!("file = \"a.obj\"\nprojection = \"{projection}\"");
        let (z, uv) = below(&load(dir.path(), &shape).unwrap(), 0.5, -0.5);
        assert!((z - 0.4).abs() < 1e-5 && (uv - want).length() < 1e-9, "{projection}: {z} {uv}");
    }
}

#[test]
fn faces_without_normals_are_smooth_where_asked() {
    let dir = tempfile::tempdir().unwrap();
    // A roof.
    let roof = "v -1 -1 0\nv 0 -1 1\nv 0 1 1\nv -1 1 0\nv 1 -1 0\nv 1 1 0\nf 1 2 3 4\nf 2 5 6 3\n";
    fs::write(dir.path().join("a.obj"), roof).unwrap();
    let normal = |shape: &str| {
        let loaded = load(dir.path(), &format!("file = \"a.obj\"\n{shape}")).unwrap();
        let ray = Ray::new(DVec3::new(-1e-6, 0.1, 9.0), -DVec3::Z);
        loaded.scene.world().closest(&ray, &mut ()).expect("a hit").shading_normal
    };
    assert!((normal("") - DVec3::new(-1.0, 0.0, 1.0).normalize()).length() < 1e-9);
    assert!((normal("smooth = true") - DVec3::Z).length() < 1e-5);
}

/// The cube `[-1, 1]^3`: the upper half of its sides of one material, the lower of another, top and bottom of a third.
fn write_cube(folder: &Path) {
    let mut obj = "mtllib a.mtl\n".to_owned();
    for z in [-1, 0, 1] {
        for (x, y) in [(-1, -1), (1, -1), (1, 1), (-1, 1)] {
            obj += &format!("v {x} {y} {z}\n");
        }
    }
    obj += "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    for (name, level) in [("lower", 0), ("upper", 4)] {
        obj += &format!("usemtl {name}\n");
        for k in 0..4 {
            let (a, b) = (level + k + 1, level + (k + 1) % 4 + 1);
            obj += &format!("f {a}/1 {b}/2 {}/3 {}/4\n", b + 4, a + 4);
        }
    }
    obj += "usemtl flat\nf 4/1 3/2 2/3 1/4\nf 9/1 10/2 11/3 12/4\n";
    fs::write(folder.join("a.obj"), obj).unwrap();
    let mtl = "newmtl lower\nKd 1 0 0\ndisp -mm 0 0.3 h.png\nnewmtl upper\nKd 0 1 0\ndisp -mm -0.1 0.2 g.png\n\
               newmtl flat\nKd 0 0 1\n";
    fs::write(folder.join("a.mtl"), mtl).unwrap();
    let noise = |seed: u32| -> Vec<u16> {
        (0..64u32).map(|k| ((k + seed).wrapping_mul(2_654_435_761) >> 16) as u16).collect()
    };
    write_png_grey16(&folder.join("h.png"), [8, 8], &noise(1)).unwrap();
    write_png_grey16(&folder.join("g.png"), [8, 8], &noise(2)).unwrap();
}

/// Rays from the middle to all edges and faces, and where they end.
fn escapes(loaded: &LoadedScene) -> usize {
    let world = loaded.scene.world();
    let mut count = 0;
    for i in 0..120 {
        for j in 0..120 {
            let at = |k: i32| f64::from(k) / 60.0 - 1.0 + if k % 2 == 0 { 0.0 } else { 0.3 / 60.0 };
            for (k, side) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)] {
                let mut direction = DVec3::new(at(i), at(j), 0.0);
                direction[2] = direction[k];
                direction[k] = side;
                count += usize::from(
                    world.closest(&Ray::new(DVec3::ZERO, direction), &mut ()).is_none(),
                );
            }
        }
    }
    count
}

#[test]
fn materials_with_displacements_of_their_own_leave_no_hole_between_them() {
    let dir = tempfile::tempdir().unwrap();
    write_cube(dir.path());
    let loaded = load(dir.path(), "file = \"a.obj\"").unwrap();
    let kinds = loaded.scene.world().surfaces().iter().map(|s| matches!(s, Surface::ReliefMesh(_)));
    assert_eq!(kinds.filter(|&displaced| displaced).count(), 2);
    assert_eq!(loaded.scene.world().surfaces().len(), 3);
    assert_eq!(escapes(&loaded), 0);
    // Each instance changes the displacement of all parts, and stays closed.
    let shape = "file = \"a.obj\"\ninstances = [{ displacement = { scale = 0.1 } }]";
    let text = load(dir.path(), shape).unwrap();
    assert_eq!(escapes(&text), 0);
}

#[test]
fn one_displacement_lies_under_several_materials() {
    let dir = tempfile::tempdir().unwrap();
    write_cube(dir.path());
    let shape = "file = \"a.obj\"\ndisplacement = { map = \"h\", scale = 0.2 }";
    let loaded = load(dir.path(), shape).unwrap();
    assert_eq!(loaded.scene.world().surfaces().len(), 3);
    assert_eq!(escapes(&loaded), 0);
    let colour = |direction: DVec3| {
        let hit = loaded.scene.world().closest(&Ray::new(DVec3::ZERO, direction), &mut ());
        let surface = hit.expect("closed").surface;
        loaded.scene.material(surface).diffuse.clone()
    };
    let far = |z: f64| colour(DVec3::new(0.9, 0.1, z));
    assert!(far(0.5) != far(-0.5) && far(0.5) != colour(DVec3::Z));
    // A material of the scene goes before those of the file: one surface.
    let shape = format!("{shape}\nmaterial = \"m\"\n[materials.m]\ndiffuse = [1, 1, 1]");
    assert_eq!(load(dir.path(), &shape).unwrap().scene.world().surfaces().len(), 1);
}
