//! Renders that are stopped and continued, split and merged: the same file as one run writes.

use rilievo_io::Limits;
use rilievo_io::image::{Attribute, ChannelImage};

use crate::support::Folder;

const RENDER: &str = "render scene.toml --integrator path --samples 6";

#[test]
fn parts_merge_to_the_file_of_one_run() {
    let folder = Folder::new().with_scene();
    for layers in ["", "--aov P,Steps,Albedo"] {
        let render = |flags: &str| folder.run(&format!("{RENDER} {layers} {flags}")).expect(0);
        render("-o whole.exr");
        render("-o a.exr --sample-range 0..2");
        render("-o b.exr --sample-range 2..3 --threads 1");
        render("-o c.exr --sample-range 3..6 --threads 3");
        folder.run("merge c.exr a.exr b.exr -o merged.exr").expect(0);
        assert!(folder.bytes("merged.exr") == folder.bytes("whole.exr"), "samples {layers}");
        render("-o left.exr --crop 0,0,21,40");
        render("-o right.exr --crop 21,0,48,40");
        let run = folder.run("merge left.exr right.exr -o merged.exr --json").expect(0);
        assert_eq!(run.json()["complete"].as_bool(), Some(true));
        assert!(folder.bytes("merged.exr") == folder.bytes("whole.exr"), "windows {layers}");
        // A part of parts is a part.
        let run = folder.run("merge a.exr b.exr -o ab.exr --json").expect(0);
        assert_eq!(run.json()["complete"].as_bool(), Some(false));
        folder.run("merge ab.exr c.exr -o merged.exr").expect(0);
        assert!(folder.bytes("merged.exr") == folder.bytes("whole.exr"), "twice {layers}");
    }
    // The paper's integrator, by windows.
    folder.run("render scene.toml -o whole.exr").expect(0);
    folder.run("render scene.toml -o up.exr --crop 0,0,48,9").expect(0);
    folder.run("render scene.toml -o down.exr --crop 0,9,48,40").expect(0);
    folder.run("merge down.exr up.exr -o merged.exr").expect(0);
    assert!(folder.bytes("merged.exr") == folder.bytes("whole.exr"));
}

#[test]
fn the_flags_of_a_stopped_render_need_not_be_repeated() {
    let folder = Folder::new().with_scene();
    let flags = "--integrator path --samples 300 --resolution 96x80 --aov N --exr half --denoise";
    folder.run(&format!("render scene.toml {flags} -o whole.exr")).expect(0);
    let begin = format!("render scene.toml {flags} -o a.exr --time-limit 0.3");
    folder.run(&begin).expect(4);
    let other = folder.run("render scene.toml -o a.exr --resume --samples 200").expect(1).stderr;
    assert!(other.contains("begun with --samples 300, and --samples 200"), "{other}");
    let other = folder.run("render scene.toml -o a.exr --resume --seed 3").expect(1).stderr;
    assert!(other.contains("other settings or another seed"), "{other}");
    folder.run("render scene.toml -o a.exr --resume").expect(0);
    assert!(folder.bytes("a.exr") == folder.bytes("whole.exr"));
}

#[test]
fn the_noise_of_joined_parts_is_taken_off_as_that_of_one_run() {
    let folder = Folder::new().with_scene();
    folder.run(&format!("{RENDER} --denoise -o whole.exr")).expect(0);
    folder.run(&format!("{RENDER} --denoise -o a.exr --sample-range 0..2")).expect(0);
    folder.run(&format!("{RENDER} --denoise -o b.exr --sample-range 2..6")).expect(0);
    folder.run("merge a.exr b.exr -o merged.exr --denoise").expect(0);
    assert!(folder.bytes("merged.exr") == folder.bytes("whole.exr"));
    folder.run("merge a.exr b.exr -o noisy.exr").expect(0);
    let read = |name| ChannelImage::read(&folder.path(name), &Limits::default()).unwrap();
    let (whole, noisy) = (read("whole.exr"), read("noisy.exr"));
    assert_eq!(whole.channel("Noisy.G").unwrap().samples, noisy.channel("G").unwrap().samples);
    assert_eq!(noisy.attribute("rilievo/denoiser"), None);
    folder.run(&format!("{RENDER} -o c.exr --sample-range 0..2")).expect(0);
    let error = folder.run("merge c.exr -o d.exr --denoise").expect(1).stderr;
    assert!(error.contains("needs the layer Albedo"), "{error}");
}

#[test]
fn what_is_kept_to_go_on_with_takes_no_memory_of_its_own() {
    let folder = Folder::new().with_scene();
    for flags in ["", "--resume"] {
        let part = format!("--resolution 640x512 --sample-range 0..1 -o part.exr {flags} --json");
        let json = folder.run(&format!("{RENDER} {part}")).expect(0).json();
        let Some(peak) = json["peak_rss_bytes"].as_u64() else { return };
        // A plane of one digit has 1.3 MB, and there are twenty.
        let predicted = json["predicted_bytes"].as_u64().unwrap();
        assert!(peak < predicted + predicted / 10 + 6_000_000, "{flags}: {peak}, {predicted}");
    }
}

#[test]
fn parts_are_pictures() {
    let folder = Folder::new().with_scene();
    folder.run(&format!("{RENDER} -o whole.exr")).expect(0);
    folder.run(&format!("{RENDER} -o part.exr --crop 5,6,37,38")).expect(0);
    let read = |name| ChannelImage::read(&folder.path(name), &Limits::default()).unwrap();
    let (whole, part) = (read("whole.exr"), read("part.exr"));
    assert_eq!((part.width, part.height), (32, 32));
    let [all, some] = [&whole, &part].map(|image| &image.channel("G").unwrap().samples);
    for (at, value) in some.iter().enumerate() {
        assert_eq!(*value, all[(6 + at / 32) * 48 + 5 + at % 32]);
    }
    let names: Vec<_> = whole.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names.len(), 3, "{names:?}");
    folder.run(&format!("{RENDER} -o part.png --crop 5,6,37,38")).expect(0);
    assert_eq!(read("part.png").width, 32);
}

#[test]
fn a_stopped_render_goes_on() {
    let folder = Folder::new().with_scene();
    for flags in ["--integrator path --samples 300 --aov N", "--samples 60"] {
        let render = format!("render scene.toml {flags} --resolution 96x80");
        folder.run(&format!("{render} -o whole.exr")).expect(0);
        let mut stops = 0;
        let run = loop {
            let limited = format!("{render} -o a.exr --resume --time-limit 0.05 --json");
            let run = folder.run(&limited);
            if run.code == Some(0) {
                break run;
            }
            run.expect(4);
            stops += 1;
            if stops == 3 {
                let image = ChannelImage::read(&folder.path("a.exr"), &Limits::default()).unwrap();
                assert_eq!(image.attribute("rilievo/complete"), Some(&Attribute::Integer(0)));
                break folder.run(&format!("{render} -o a.exr --resume --json")).expect(0);
            }
        };
        assert_eq!(run.json()["resumed"].as_bool(), Some(stops > 0));
        assert!(folder.bytes("a.exr") == folder.bytes("whole.exr"), "{flags}");
        // There is nothing left to do.
        let run = folder.run(&format!("{render} -o a.exr --resume")).expect(0);
        assert!(run.stderr.contains("is finished"), "{}", run.stderr);
        std::fs::remove_file(folder.path("a.exr")).unwrap();
    }
}

#[test]
fn parts_that_do_not_fit_are_named() {
    let folder = Folder::new().with_scene();
    let render = |flags: &str| folder.run(&format!("{RENDER} {flags}")).expect(0);
    render("-o a.exr --sample-range 0..2");
    render("-o b.exr --sample-range 1..4");
    render("-o c.exr --sample-range 4..6");
    render("-o seed.exr --sample-range 2..6 --seed 1");
    render("-o left.exr --crop 0,0,21,40");
    render("-o right.exr --crop 23,0,48,40");
    folder.run("render scene.toml -o whole.exr --samples 1").expect(0);
    let error = |words: &str, what: &str| {
        let run = folder.run(words).expect(1);
        assert!(run.stderr.contains(what), "{words}: {}", run.stderr);
    };
    error("merge a.exr b.exr -o m.exr", "a.exr and b.exr overlap: both have sample 1");
    error("merge a.exr c.exr -o m.exr", "a gap: none has sample 2 of pixel (0, 0)");
    error("merge a.exr seed.exr -o m.exr", "a.exr and seed.exr are of different renders");
    error("merge left.exr right.exr -o m.exr", "a gap: none has sample 0 of pixel (21, 0)");
    error("merge a.exr whole.exr -o m.exr", "whole.exr: no part of a render");
    error("merge a.exr map.png -o m.exr", "map.png: no part of a render");
    error("merge a.exr none.exr -o m.exr", "none.exr");
    // What stands under the name of the output is not gone on with if it is of another render.
    let before = folder.bytes("a.exr");
    error(&format!("{RENDER} -o a.exr --resume --seed 1"), "another scene");
    error(&format!("{RENDER} -o a.exr --resume --sample-range 0..3"), "begun with --sample-range");
    error(&format!("{RENDER} -o whole.exr --resume"), "no unfinished picture");
    error("render scene.toml -o x.exr --sample-range 0..2", "distributed takes all samples");
    error(&format!("{RENDER} -o x.exr --sample-range 2..7"), "not among the 6");
    error(&format!("{RENDER} -o x.exr --crop 0,0,49,40"), "does not lie in");
    assert!(folder.bytes("a.exr") == before);
    for name in ["m.exr", "x.exr"] {
        assert!(!folder.path(name).exists(), "{name}");
    }
    // The scene has changed.
    let text = String::from_utf8(folder.bytes("scene.toml")).unwrap();
    folder.write("scene.toml", &text.replace("0.6, 0.5, 0.4", "0.6, 0.5, 0.3"));
    error(&format!("{RENDER} -o a.exr --resume --sample-range 0..2"), "another scene");
}

#[test]
fn images_of_models_and_sets_of_displacements_belong_to_a_render() {
    let folder = Folder::new().with_scene();
    folder.write("a.mtl", "newmtl m\nmap_Kd paint.png\n");
    folder.write(
        "a.obj",
        "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n",
    );
    let camera = "[camera]\nposition = [0.6, 0.4, 3]\nlook_at = [0.6, 0.4, 0]\nresolution = [8, 8]\n\
        up = [0, 1, 0]\n[[shapes]]\n";
    folder.write("model.toml", &format!("{camera}type = \"mesh\"\nfile = \"a.obj\"\n"));
    std::fs::create_dir(folder.path("set")).unwrap();
    let quad = "type = \"quad\"\ncorners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]\n";
    folder.write("set.toml", &format!("{camera}{quad}displacement = {{ map = \"set/\" }}\n"));
    let image = folder.bytes("map.png");
    // Another image of the same size: one colour, told by its own program.
    folder.run("render scene.toml -o other.png --resolution 32x32 --samples 1").expect(0);
    let other = folder.bytes("other.png");
    for (scene, file, changed) in [
        ("model.toml", "paint.png", &other[..]),
        ("model.toml", "a.mtl", b"newmtl m\nKd 1 0 0\nmap_Kd paint.png\n"),
        ("set.toml", "set/rock_disp.png", &other[..]),
    ] {
        std::fs::write(folder.path("paint.png"), &image).unwrap();
        std::fs::write(folder.path("set/rock_disp.png"), &image).unwrap();
        let render = format!("render {scene} --integrator path --samples 2 -o part.exr");
        folder.run(&format!("{render} --sample-range 0..1")).expect(0);
        folder.run(&format!("{render} --resume")).expect(0);
        std::fs::write(folder.path(file), changed).unwrap();
        let error = folder.run(&format!("{render} --resume")).expect(1).stderr;
        assert!(error.contains("another scene"), "{file}: {error}");
    }
}

#[test]
fn a_maximal_error_saves_samples() {
    let folder = Folder::new().with_scene();
    let render = "render scene.toml --integrator path --samples 512 --resolution 40x32";
    let whole = folder.run(&format!("{render} -o a.exr --max-error 0.1 --json")).expect(0).json();
    let taken = whole["mean_samples"].as_f64().unwrap();
    assert!((64.0..400.0).contains(&taken), "{taken}");
    assert_eq!(whole["complete"].as_bool(), Some(true));
    assert_eq!(whole["refused_samples"].as_u64(), Some(0));
    folder.run(&format!("{render} -o b.exr --max-error 0.1 --crop 0,0,16,32")).expect(0);
    folder.run(&format!("{render} -o c.exr --max-error 0.1 --crop 16,0,40,32")).expect(0);
    folder.run("merge b.exr c.exr -o m.exr").expect(0);
    assert!(folder.bytes("m.exr") == folder.bytes("a.exr"));
    let run = folder.run(&format!("{render} -o d.exr --max-error 0.1 --crop 8,0,40,32")).expect(1);
    assert!(run.stderr.contains("multiples of 16 pixels"), "{}", run.stderr);
}
