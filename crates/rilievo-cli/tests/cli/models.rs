//! Models on the command line and in scenes.

use crate::support::Folder;

/// A square of two materials, one of them with an image that is not there.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write(
        "a.obj",
        "mtllib a.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 1\n\
         usemtl red\nf 1/1 2/1 3/2\nusemtl blue\nf 1/1 3/2 -1/1\n",
    );
    folder.write("a.mtl", "newmtl red\nKd 1 0 0\nmap_Kd gone.png\nnewmtl blue\nKd 0 0 1\nPr 0.5\n");
    folder
}

#[test]
fn a_model_is_told_and_rendered() {
    let folder = folder();
    let json = folder.run("info a.obj --json").expect(0).json();
    assert_eq!((json["kind"].as_str(), json["format"].as_str()), (Some("model"), Some("OBJ")));
    assert_eq!((json["triangles"].as_u64(), json["with_uvs"].as_u64()), (Some(2), Some(2)));
    let blue = &json["materials"][1];
    assert_eq!((blue["name"].as_str(), blue["triangles"].as_u64()), (Some("blue"), Some(1)));
    let run = folder.run("render a.obj -o a.exr --resolution 32x24 --samples 1").expect(0);
    assert!(run.stderr.contains("gone.png"), "{}", run.stderr);
    let run = folder.run("check a.obj --json").expect(0);
    // Two parts and the key light.
    assert_eq!(run.json()["surfaces"].as_u64(), Some(3));
}

#[test]
fn a_scene_takes_the_materials_of_a_model_or_its_own() {
    let folder = folder();
    let scene = |shape: &str| {
        format!(
            "[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\n\
             resolution = [32, 32]\n[materials.own]\ndiffuse = [0, 1, 0]\n[[shapes]]\n\
             type = \"mesh\"\nfile = \"a.obj\"\n{shape}"
        )
    };
    for (shape, surfaces) in [("", 2), ("material = \"own\"\n", 1)] {
        folder.write("scene.toml", &scene(shape));
        let check = folder.run("check scene.toml --json").expect(0).json();
        assert_eq!(check["surfaces"].as_u64(), Some(surfaces));
    }
}

#[test]
fn models_that_cannot_be_shown_say_why() {
    let folder = Folder::new();
    folder.write("points.obj", "v 1 2 3\n");
    let run = folder.run("render points.obj -o a.exr").expect(1);
    assert!(run.stderr.contains("the mesh has no triangles"), "{}", run.stderr);
    assert_eq!(
        folder.run("info points.obj --json").expect(0).json()["triangles"].as_u64(),
        Some(0)
    );
    folder.write(
        "bad.ply",
        "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\n\
                 property float y\nproperty float z\nend_header\n",
    );
    let run = folder.run("info bad.ply").expect(1);
    assert!(run.stderr.contains("no more than the file holds"), "{}", run.stderr);
}
