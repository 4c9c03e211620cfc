//! Every bad input: exit code 1, one message, no panic, no output file harmed.

use std::path::{Path, PathBuf};

use crate::support::Folder;

/// Files of a folder of `tests`, which must not be empty.
fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests").join(folder);
    let folder = folder.canonicalize().unwrap();
    let mut all: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    all.sort();
    assert!(!all.is_empty());
    all
}

/// Words that hold paths: given one by one, since a path may hold spaces.
fn refused(folder: &Folder, words: &str, file: &Path) {
    let mut command = folder.command(words);
    let run = crate::support::Run::from(command.arg(file).output().unwrap());
    assert_eq!(run.code, Some(1), "{words} {}: {}", file.display(), run.stderr);
    let run = run.expect(1);
    assert!(run.stdout.is_empty(), "{words} {}", file.display());
    let name = file.file_name().unwrap().to_str().unwrap();
    assert!(run.stderr.contains(name), "{words} {name}: {}", run.stderr);
}

#[test]
fn bad_scenes_are_refused_and_outputs_stay() {
    let folder = Folder::new();
    folder.write("a.png", "what was here before");
    for file in files("scenes/invalid") {
        if file.extension().is_some_and(|e| e == "toml") {
            refused(&folder, "render -o a.png", &file);
            refused(&folder, "check", &file);
        }
    }
    assert_eq!(folder.bytes("a.png"), b"what was here before");
    assert_eq!(folder.names(), ["a.png"]);
}

#[test]
fn damaged_images_are_refused_by_every_command() {
    let folder = Folder::new();
    for format in ["png", "tiff", "exr", "jpeg"] {
        for file in files(&format!("data/{format}/invalid")) {
            refused(&folder, "info", &file);
            refused(&folder, "bake bounds -o a.map", &file);
        }
    }
    assert!(folder.names().is_empty());
}

#[test]
fn a_scene_tells_which_of_its_files_is_damaged() {
    let folder = Folder::new().with_scene();
    let scene = String::from_utf8(folder.bytes("scene.toml")).unwrap();
    let damaged = &files("data/png/invalid")[0];
    std::fs::copy(damaged, folder.path("map.png")).unwrap();
    let run = folder.run("render scene.toml -o a.png").expect(1);
    let line = scene.lines().position(|line| line.contains("map.png")).unwrap() + 1;
    assert!(run.stderr.contains(&format!("scene.toml:{line}:")), "{}", run.stderr);
    assert!(run.stderr.contains("map.png"), "{}", run.stderr);
    assert_eq!(folder.names(), ["map.png", "scene.toml"]);
}
