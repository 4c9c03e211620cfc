//! `rilievo render`.

use rilievo::map::Procedural;
use rilievo_io::Limits;
use rilievo_io::image::{Attribute, ChannelImage};

use crate::support::Folder;

fn read(folder: &Folder, name: &str) -> ChannelImage {
    ChannelImage::read(&folder.path(name), &Limits::default()).unwrap()
}

fn channels(image: &ChannelImage) -> Vec<&str> {
    image.channels.iter().map(|c| c.name.as_str()).collect()
}

#[test]
fn pictures_are_written_in_both_formats() {
    let folder = Folder::new().with_scene();
    folder.run("render scene.toml -o a.png").expect(0);
    folder.run("render scene.toml -o a.exr").expect(0);
    let (png, exr) = (read(&folder, "a.png"), read(&folder, "a.exr"));
    assert_eq!((png.width, png.height), (48, 40));
    assert_eq!(channels(&png), ["R", "G", "B"]);
    let mut names = channels(&exr);
    names.sort_unstable();
    assert_eq!(names, ["B", "G", "R"]);
    let mean = |image: &ChannelImage, name| {
        let samples = &image.channel(name).unwrap().samples;
        samples.iter().sum::<f32>() / samples.len() as f32
    };
    // The clay is reddish and lit.
    assert!(mean(&exr, "R") > mean(&exr, "B") && mean(&exr, "B") > 0.005, "{}", mean(&exr, "B"));
    assert_eq!(exr.attribute("samplesPerPixel"), Some(&Attribute::Integer(4)));
    assert_eq!(exr.attribute("rilievo/complete"), Some(&Attribute::Integer(1)));
}

#[test]
fn a_denoised_picture_keeps_the_noisy_one_beside_it() {
    let folder = Folder::new().with_scene();
    folder.run("render scene.toml -o noisy.exr --aov P").expect(0);
    folder.run("render scene.toml -o a.exr --aov P --denoise --threads 1").expect(0);
    folder.run("render scene.toml -o b.exr --aov P --denoise=own --threads 3").expect(0);
    assert_eq!(folder.bytes("a.exr"), folder.bytes("b.exr"));
    let (noisy, both) = (read(&folder, "noisy.exr"), read(&folder, "a.exr"));
    let samples = |image: &ChannelImage, name: &str| image.channel(name).unwrap().samples.clone();
    for name in ["R", "G", "B"] {
        assert_eq!(samples(&both, &format!("Noisy.{name}")), samples(&noisy, name));
        assert_ne!(samples(&both, name), samples(&noisy, name));
    }
    assert!(both.channel("Albedo.R").is_some() && both.channel("Ns.X").is_some());
    assert_eq!(both.attribute("rilievo/denoiser"), Some(&Attribute::Text("own".to_owned())));
    folder.run("render scene.toml -o noisy.png").expect(0);
    folder.run("render scene.toml -o a.png --denoise").expect(0);
    assert_ne!(folder.bytes("a.png"), folder.bytes("noisy.png"));
}

#[test]
fn exr_files_hold_halves_tiles_and_the_camera() {
    let folder = Folder::new().with_scene();
    folder.run("render scene.toml -o float.exr --aov P,N").expect(0);
    folder.run("render scene.toml -o half.exr --aov P,N --exr half --tiles 16").expect(0);
    let (float, half) = (read(&folder, "float.exr"), read(&folder, "half.exr"));
    for (a, b) in float.channels.iter().zip(&half.channels) {
        assert_eq!(a.name, b.name);
        if a.name.starts_with('P') {
            let bits = |s: &[f32]| s.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&a.samples), bits(&b.samples));
        } else {
            let near = |(a, b): (&f32, &f32)| (a - b).abs() <= a.abs() / 2048.0 + 1e-7;
            assert!(a.samples.iter().zip(&b.samples).all(near), "{}", a.name);
        }
    }
    assert!(folder.bytes("half.exr").len() < folder.bytes("float.exr").len());
    assert!(matches!(half.attribute("worldToNDC"), Some(Attribute::Matrix(_))));
    let Some(Attribute::Matrix(rows)) = half.attribute("worldToCamera") else { panic!() };
    // Where the camera is becomes the origin: row vectors, so the last row is the translation.
    assert_eq!(rows[3][3], 1.0);
}

#[test]
fn flags_override_the_scene() {
    let folder = Folder::new().with_scene();
    let words = "render scene.toml -o a.exr --resolution 20x10 --samples 3 --seed 7 --json --quiet";
    let run = folder.run(words).expect(0);
    assert!(run.stderr.is_empty(), "{}", run.stderr);
    let json = run.json();
    assert_eq!((json["width"].as_u64(), json["height"].as_u64()), (Some(20), Some(10)));
    assert_eq!(json["rays"]["camera"].as_u64(), Some(20 * 10 * 3));
    let exr = read(&folder, "a.exr");
    assert_eq!(exr.attribute("rilievo/seed"), Some(&Attribute::Text("7".to_owned())));
    folder.run("render scene.toml -o b.exr --resolution 20x10 --samples 3 --seed 8").expect(0);
    assert_ne!(folder.bytes("a.exr"), folder.bytes("b.exr"));
}

#[test]
fn layouts_differ_in_memory_and_in_nothing_else() {
    let folder = Folder::new().with_scene();
    let run = |words: &str| folder.run(&format!("render {words} --json")).expect(0).json();
    let plain = run("scene.toml -o a.exr");
    let tiny = run("scene.toml -o b.exr --layout tiny");
    assert_eq!(folder.bytes("a.exr"), folder.bytes("b.exr"));
    let bytes = |json: &serde_json::Value| json["bounds_bytes"].as_u64().unwrap();
    assert_eq!(bytes(&plain) * 36, bytes(&tiny) * 64);
    let scene = String::from_utf8(folder.bytes("scene.toml")).unwrap();
    folder.write("tiny.toml", &scene.replace("[maps.noise]", "[maps.noise]\nlayout = \"tiny\""));
    assert_eq!(bytes(&run("tiny.toml -o b.exr")), bytes(&tiny));
    assert_eq!(bytes(&run("tiny.toml -o b.exr --layout default")), bytes(&plain));
    let info = folder.run("info tiny.toml --json").expect(0).json();
    assert_eq!(info["maps"][0]["layout"].as_str(), Some("tiny"));
    assert_eq!(bytes(&info), bytes(&tiny));
}

#[test]
fn the_json_object_has_every_key() {
    let folder = Folder::new().with_scene();
    let run = folder.run("render scene.toml -o a.png --json").expect(0);
    assert_eq!(run.stdout.lines().count(), 1);
    let json = run.json();
    let linux = cfg!(target_os = "linux");
    for (key, told) in [
        ("build_seconds", true),
        ("render_seconds", true),
        ("build_cpu_seconds", linux),
        ("render_cpu_seconds", linux),
    ] {
        assert!(json[key].as_f64().map_or(!told, |s| s >= 0.0), "{key}");
    }
    for key in ["map_bytes", "bounds_bytes", "predicted_bytes"] {
        assert!(json[key].as_u64().unwrap() > 0, "{key}");
    }
    assert_eq!(json["map_bytes"].as_u64(), Some(32 * 32 * 2));
    let rays = &json["rays"];
    let kinds =
        ["camera", "shadow", "reflection", "diffuse"].map(|kind| rays[kind].as_u64().unwrap());
    assert!(kinds.iter().all(|&n| n > 0), "{kinds:?}");
    assert_eq!(rays["total"].as_u64(), Some(kinds.iter().sum()));
    assert_eq!(json["complete"].as_bool(), Some(true));
    if cfg!(target_os = "linux") {
        let (peak, predicted) = (&json["peak_rss_bytes"], &json["predicted_bytes"]);
        assert!(peak.as_u64().unwrap() < 2 * predicted.as_u64().unwrap(), "{json}");
    } else {
        assert!(json.get("peak_rss_bytes").is_some());
    }
}

#[test]
fn layers_stand_beside_the_colour_or_alone() {
    let folder = Folder::new().with_scene();
    folder.run("render scene.toml -o a.exr --aov P,Ns,Z").expect(0);
    let mut names: Vec<_> = read(&folder, "a.exr").channels.into_iter().map(|c| c.name).collect();
    names.sort();
    assert_eq!(names, ["B", "G", "Ns.X", "Ns.Y", "Ns.Z", "P.X", "P.Y", "P.Z", "R", "Z"]);

    folder.run("render scene.toml -o p.exr --integrator aov --pixel-centers --aov P").expect(0);
    let p = read(&folder, "p.exr");
    assert_eq!(p.channels.len(), 3);
    let heights = &p.channel("P.Z").unwrap().samples;
    assert!(heights[0].is_nan(), "the corner of the picture shows nothing");
    assert!(heights.iter().filter(|z| z.is_finite()).count() > 100);

    folder.run("render scene.toml -o all.exr --integrator aov").expect(0);
    let all = read(&folder, "all.exr");
    for name in ["P.X", "N.Y", "Ns.Z", "u", "v", "Height.Y", "Steps.Y", "Z", "Albedo.R"] {
        assert!(all.channel(name).is_some(), "{name}");
    }
    assert!(all.channel("R").is_none());

    let aov = "render scene.toml --integrator aov --aov";
    for (layer, file) in [("Steps", "steps.png"), ("N", "n.png"), ("Height,P", "height.png")] {
        folder.run(&format!("{aov} {layer} -o {file}")).expect(0);
        let values = read(&folder, file).channels.remove(0).samples;
        assert!(values.iter().any(|&v| v != values[0]), "{file} is one colour");
    }
}

#[test]
fn every_exact_method_gives_the_same_picture() {
    let folder = Folder::new().with_scene();
    for method in ["pyramid", "dda", "distance", "distance-corrected"] {
        folder.run(&format!("render scene.toml -o {method}.exr --method {method}")).expect(0);
        assert_eq!(folder.bytes(&format!("{method}.exr")), folder.bytes("pyramid.exr"), "{method}");
    }
    for method in ["distance-published", "march"] {
        let words = format!("render scene.toml -o {method}.png --method {method}");
        let run = folder.run(&words).expect(0);
        assert_eq!(run.stderr.contains("distance map"), method == "distance-published");
    }
}

#[test]
fn renders_that_cannot_be_are_refused() {
    let folder = Folder::new().with_scene();
    let run = folder.run("render scene.toml -o a.png --max-memory 2M").expect(1);
    assert!(run.stderr.contains("--max-memory allows 2.0 MiB"), "{}", run.stderr);
    let run = folder.run("render nothing.toml -o a.png").expect(1);
    assert!(run.stderr.contains("nothing.toml"), "{}", run.stderr);
    let run = folder.run("render scene.toml -o no/such/folder/a.png --samples 1").expect(1);
    assert!(run.stderr.contains("no/such/folder/a.png"), "{}", run.stderr);
    assert_eq!(folder.names(), ["map.png", "scene.toml"]);
}

#[test]
fn a_failed_run_leaves_an_existing_picture_alone() {
    let folder = Folder::new().with_scene();
    folder.write("a.png", "what was here before");
    let text = String::from_utf8(folder.bytes("scene.toml")).unwrap();
    folder.write("bad.toml", &text.replace("fov        = 40.0", "fov = 190"));
    folder.run("render bad.toml -o a.png").expect(1);
    folder.run("render scene.toml -o a.png --max-memory 1M").expect(1);
    folder.run("render scene.toml -o a.png --aov P").expect(2);
    assert_eq!(folder.bytes("a.png"), b"what was here before");
    folder.run("render scene.toml -o a.png --samples 1").expect(0);
    assert_eq!(read(&folder, "a.png").width, 48);
    assert_eq!(folder.names(), ["a.png", "bad.toml", "map.png", "scene.toml"]);
}

#[test]
fn the_picture_shows_the_relief_from_its_own_formula() {
    // A flat map at 0.25 of scale 0.4 lies 0.1 above the quad.
    let folder = Folder::new().with_scene();
    let text = String::from_utf8(folder.bytes("scene.toml")).unwrap();
    let flat = text
        .replace("file = \"map.png\"", "procedural = \"flat\"\nvalue = 0.25\nsize = [4, 4]")
        .replace("scale = 0.2, zero = 0.5", "scale = 0.4, zero = 0.0");
    folder.write("flat.toml", &flat);
    folder.run("render flat.toml -o p.exr --integrator aov --pixel-centers --aov P").expect(0);
    let height = Procedural::Flat { value: 0.25 }.height(0.5, 0.5);
    let p = read(&folder, "p.exr");
    let on_relief = p.channel("P.Z").unwrap().samples.iter().filter(|&&z| z < 0.2);
    let code = (height * 65535.0).round() / 65535.0;
    assert!(on_relief.clone().count() > 100);
    assert!(on_relief.into_iter().all(|&z| (f64::from(z) - 0.4 * code).abs() < 1e-6));
}
