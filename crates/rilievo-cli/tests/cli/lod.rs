//! `lod` and `--lod`: off unless asked for, told by `info`, and the CPU's alone.

use crate::support::Folder;

const RENDER: &str = "render scene.toml --samples 2 -o";

#[test]
fn the_flag_goes_before_the_scene_and_0_is_off() {
    let folder = Folder::new().with_scene();
    folder.run(&format!("{RENDER} plain.png")).expect(0);
    folder.run(&format!("{RENDER} off.png --lod=0")).expect(0);
    folder.run(&format!("{RENDER} flag.png --lod")).expect(0);
    let scene = std::fs::read_to_string(folder.path("scene.toml")).unwrap();
    folder.write("scene.toml", &scene.replace("[render]\n", "[render]\nlod = 1\n"));
    folder.run(&format!("{RENDER} key.png")).expect(0);
    folder.run(&format!("{RENDER} again.png --lod=0")).expect(0);
    assert!(folder.bytes("plain.png") == folder.bytes("off.png"));
    assert!(folder.bytes("plain.png") == folder.bytes("again.png"));
    assert!(folder.bytes("flag.png") == folder.bytes("key.png"));
    assert!(folder.bytes("plain.png") != folder.bytes("flag.png"));
}

#[test]
fn info_tells_what_levels_take() {
    let folder = Folder::new().with_scene();
    let plain = folder.run("info scene.toml --json").expect(0);
    let scene = std::fs::read_to_string(folder.path("scene.toml")).unwrap();
    folder.write("scene.toml", &scene.replace("[render]\n", "[render]\nlod = 1\n"));
    let coarse = folder.run("info scene.toml --json").expect(0);
    assert!(!plain.stderr.contains("levels of detail"), "{}", plain.stderr);
    assert!(coarse.stderr.contains("levels of detail"), "{}", coarse.stderr);
    let bytes = [&plain, &coarse].map(|run| run.json()["level_bytes"].as_u64().unwrap());
    assert!(bytes[0] == 0 && bytes[1] > 0);
}

#[test]
fn levels_are_traced_on_the_cpu_alone() {
    let folder = Folder::new().with_scene();
    let run = folder.run(&format!("{RENDER} gpu.png --lod --backend gpu")).expect(1);
    assert!(run.stderr.contains("level of detail"), "{}", run.stderr);
    let run = folder.run(&format!("{RENDER} auto.png --lod --backend auto")).expect(0);
    assert!(run.stderr.contains("the CPU takes over"), "{}", run.stderr);
    folder.run(&format!("{RENDER} cpu.png --lod")).expect(0);
    assert!(folder.bytes("auto.png") == folder.bytes("cpu.png"));
}

#[test]
fn widths_out_of_range_are_refused() {
    let folder = Folder::new().with_scene();
    for width in ["-1", "65", "nan", "wide"] {
        folder.run(&format!("{RENDER} a.png --lod={width}")).expect(2);
    }
    let scene = std::fs::read_to_string(folder.path("scene.toml")).unwrap();
    folder.write("scene.toml", &scene.replace("[render]\n", "[render]\nlod = 65\n"));
    let run = folder.run(&format!("{RENDER} a.png")).expect(1);
    assert!(run.stderr.contains("lod") && run.stderr.contains("64"), "{}", run.stderr);
}
