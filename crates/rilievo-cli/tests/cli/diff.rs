//! `rilievo diff`.

use rilievo_io::Limits;
use rilievo_io::image::{Channel, ChannelImage, write_png_rgb8};

use crate::support::Folder;

fn write(folder: &Folder, name: &str, x: [f32; 4]) {
    let channel = |name: &str, samples: [f32; 4]| Channel {
        name: name.to_owned(),
        samples: samples.to_vec(),
    };
    let image = ChannelImage {
        width: 2,
        height: 2,
        channels: vec![channel("P.X", x), channel("Z", [1.0; 4])],
        attributes: Vec::new(),
    };
    image.picture().write_exr(&folder.path(name)).unwrap();
}

#[test]
fn known_differences_are_measured() {
    let folder = Folder::new();
    write(&folder, "a.exr", [0.0, 1.0, 2.0, f32::NAN]);
    write(&folder, "b.exr", [0.0, 1.5, 2.0, f32::NAN]);
    folder.run("diff a.exr a.exr").expect(0);
    let json = folder.run("diff a.exr b.exr --json --quiet").expect(3).json();
    let number = |key: &str| json[key].as_f64().unwrap();
    assert_eq!((number("max"), number("pixels"), number("unmatched_pixels")), (0.5, 1.0, 0.0));
    assert!((number("mean") - 0.5 / 8.0).abs() < 1e-12);
    assert!((number("rmse") - (0.25f64 / 8.0).sqrt()).abs() < 1e-12);
    assert_eq!(json["channels"].as_array().unwrap().len(), 2);
    assert_eq!(json["exceeded"][0].as_str(), Some("pixels"));
    for (flags, code) in [
        ("--max 0.5", 0),
        ("--max 0.49", 3),
        ("--mean 0.07", 0),
        ("--mean 0.06", 3),
        ("--rmse 0.18", 0),
        ("--rmse 0.17", 3),
        ("--pixels 1", 0),
        ("--pixels 0", 3),
        ("--max 1 --pixels 0", 3),
        ("--tolerance 0.5", 0),
        ("--tolerance 0.49", 3),
        ("--tolerance 0.5 --max 0.4", 3),
        ("--layer Z", 0),
        ("--layer P", 3),
    ] {
        folder.run(&format!("diff a.exr b.exr {flags}")).expect(code);
    }
}

#[test]
fn a_number_against_nan_is_a_difference_that_no_size_allows() {
    let folder = Folder::new();
    write(&folder, "a.exr", [0.0; 4]);
    write(&folder, "b.exr", [0.0, 0.0, f32::NAN, 0.0]);
    folder.run("diff a.exr b.exr --max 1000").expect(3);
    folder.run("diff a.exr b.exr --max 1000 --pixels 1").expect(0);
    let json = folder.run("diff a.exr b.exr --json").expect(3).json();
    assert_eq!(json["unmatched_pixels"].as_u64(), Some(1));
    assert_eq!(json["max"].as_f64(), Some(0.0));
}

#[test]
fn the_heat_picture_is_bright_where_pixels_differ() {
    let folder = Folder::new();
    write(&folder, "a.exr", [0.0; 4]);
    write(&folder, "b.exr", [0.0, 1.0, 1e-9, 0.0]);
    folder.run("diff a.exr b.exr -o heat.png").expect(3);
    let heat = ChannelImage::read(&folder.path("heat.png"), &Limits::default()).unwrap();
    let green = &heat.channel("G").unwrap().samples;
    assert!(green[1] > green[2] && green[2] > green[0] && green[0] == green[3], "{green:?}");
}

#[test]
fn pictures_that_cannot_be_compared_are_bad_input() {
    let folder = Folder::new();
    write(&folder, "a.exr", [0.0; 4]);
    write_png_rgb8(&folder.path("b.png"), [2, 2], &[[0; 3]; 4]).unwrap();
    write_png_rgb8(&folder.path("c.png"), [4, 1], &[[0; 3]; 4]).unwrap();
    folder.write("d.png", "no picture");
    assert!(folder.run("diff a.exr b.png").expect(1).stderr.contains("--layer"));
    assert!(folder.run("diff b.png c.png").expect(1).stderr.contains("2 x 2 pixels against 4 x 1"));
    assert!(folder.run("diff a.exr a.exr --layer N").expect(1).stderr.contains("no layer \"N\""));
    folder.run("diff a.exr d.png").expect(1);
    folder.run("diff a.exr missing.exr").expect(1);
}
